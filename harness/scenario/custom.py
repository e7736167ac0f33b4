"""A class named in place of a kind, and its arguments."""

from collections.abc import Callable, Collection, Mapping
from typing import Any, cast

from pydantic import Field

from railgrip.registry import Role, installed_names
from railgrip.scenario.table import Table

OURS, CUSTOM = "of this project", "of one's own"
"""Tags of the two sorts of table; no key of a file has such a name."""


class Custom(Table):
    """A class of the user's own; see `railgrip.custom` for what it is asked.

    `railgrip.assemble.importing` says from where it is imported.
    """

    kind: str = Field(description="module:Class, or the name of an entry point in the group railgrip.<table>s")
    parameters: dict[str, Any] = Field(default={}, description="arguments of the class, by keyword")


def whose(role: Role, ours: Callable[[], Collection[str]], tagged: Collection[str] = ()) -> Callable[[Any], str]:
    """Return what tells the tables of this project, of the kinds `ours`, from those of a class of one's own.

    A kind of `tagged` has a table for itself, whose tag it is.
    """

    def tag(entry: Any) -> str:
        if isinstance(entry, Mapping):
            kind: object = cast("Mapping[str, object]", entry).get("kind")
        else:
            kind = getattr(entry, "kind", None)
        if isinstance(kind, str) and kind in tagged:
            return kind
        if not isinstance(kind, str) or kind in ours():
            return OURS
        return CUSTOM if ":" in kind or kind in installed_names(role) else OURS

    return tag
