"""Names of states and of elements of arrays, suggestions for mistyped names, and texts for XML."""

import re
from collections.abc import Iterable, Mapping
from difflib import get_close_matches
from types import MappingProxyType
from typing import Final, NamedTuple

STATE_NAMES: Final[Mapping[str, str]] = MappingProxyType(
    {"v": "speed", "w": "wheelset_speed", "mu_b": "pad_friction", "alpha": "group_adhesion"}
)
"""Symbol of a state in the equations of `RailBraking.Predictions` → its name, that of the signal that it estimates.

Adhesion is a state of each group, as the signal `group_adhesion`; the signal `adhesion` belongs to wheelsets.
"""


class ElementName(NamedTuple):
    """Name of an element of an array, such as `slip[2]`, or of a scalar.

    Attributes:
        array: Name of the array, or of the scalar.
        bracket: Index in its brackets, such as `[2]`; empty for a scalar.
    """

    array: str
    bracket: str = ""

    @classmethod
    def of(cls, name: str) -> "ElementName":
        """Return the parts of a name."""
        array, bracket, index = name.partition("[")
        return cls(array, bracket + index)

    @property
    def label(self) -> str:
        """The index without brackets; empty for a scalar."""
        return self.bracket[1:].removesuffix("]")

    @property
    def place(self) -> int:
        """Place in the array, counted from 0; also 0 for a scalar.

        Raises:
            ValueError: The index is not a number.
        """
        return int(self.label) - 1 if self.bracket else 0


def state_name(name: str) -> str:
    """Return the name of a state, `wheelset_speed[1]` for the symbol `w[1]`; others are returned as they are."""
    element = ElementName.of(name)
    return f"{STATE_NAMES.get(element.array, element.array)}{element.bracket}"


_MAX_LENGTH = 200
"""Maximum length of a compared text [characters]: difflib takes seconds for a million, and such texts match no name."""


def nearest(name: str, names: Iterable[str], *, count: int = 1, cutoff: float = 0.6) -> list[str]:
    """Return the names that are most similar to a name that does not exist; empty if none is similar.

    Case and the difference between - and _ are ignored.

    Args:
        name: Name as typed.
        names: Known names.
        count: Maximum number of names returned.
        cutoff: Minimum similarity, 0 to 1; see `difflib.get_close_matches`.
    """
    if len(name) > _MAX_LENGTH:
        return []
    plain = {_plain(each): each for each in names}
    return [plain[each] for each in get_close_matches(_plain(name), plain, n=count, cutoff=cutoff)]


def did_you_mean(
    name: str, names: Iterable[str], *, count: int = 1, cutoff: float = 0.6, quote: str = "'", before: str = ""
) -> str:
    """Return a question with the nearest names, "did you mean 'speed' or 'speeds'?"; empty if none is near.

    Args:
        name: Name as typed.
        names: Known names.
        count: As for `nearest`.
        cutoff: As for `nearest`.
        quote: Quotation mark around each name.
        before: Words before the question, if there is one.
    """
    near = nearest(name, names, count=count, cutoff=cutoff)
    return f"{before}did you mean {' or '.join(f'{quote}{each}{quote}' for each in near)}?" if near else ""


def known_names(names: Iterable[str], name: str) -> str:
    """Return the known names for a message on an unknown one, and a question if one is near: "a, b; did you mean 'b'?".

    Args:
        names: Known names.
        name: Name as typed.
    """
    choice = list(names)
    return ", ".join(choice) + did_you_mean(name, choice, before="; ")


def _plain(name: str) -> str:
    return name.casefold().replace("-", "_")


_NOT_IN_XML = re.compile("[^\t\n\r -\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def xml_text(text: str) -> str:
    """Return a text with codes, such as #x1B, of characters that XML 1.0 has no form for, escaped or not."""
    return _NOT_IN_XML.sub(lambda found: f"#x{ord(found[0]):02X}", text)
