"""Which wheelsets a vehicle has, which of them turn as one, and where they run: what everything is dimensioned by."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

Extent = Literal["train", "group", "wheelset"]


@dataclass(frozen=True, slots=True)
class Formation:
    """The wheelsets of a vehicle, lead to trail, in groups that turn as one and share a brake.

    Attributes:
        wheelsets_per_group: Number of wheelsets of each group, leading group first.
    """

    wheelsets_per_group: tuple[int, ...]

    def __post_init__(self) -> None:
        """Refuse what no vehicle is.

        Raises:
            ValueError: There is no group, or one without a wheelset.
        """
        if not self.wheelsets_per_group or min(self.wheelsets_per_group) < 1:
            raise ValueError(
                "a formation has one wheelset or more in each of its groups, as in [2, 1, 1, 2]; "
                f"got {list(self.wheelsets_per_group)}"
            )

    @property
    def groups(self) -> int:
        """Number of groups."""
        return len(self.wheelsets_per_group)

    @property
    def wheelsets(self) -> int:
        """Number of wheelsets."""
        return sum(self.wheelsets_per_group)

    @property
    def group_of_wheelset(self) -> NDArray[np.intp]:
        """Zero-based group of each wheelset, shape (wheelsets,)."""
        return np.repeat(np.arange(self.groups), self.wheelsets_per_group)

    def width(self, extent: Extent) -> int:
        """Return how many values a quantity has that there is one of for each `extent`."""
        return {"train": 1, "group": self.groups, "wheelset": self.wheelsets}[extent]

    def members(self) -> Iterator[slice]:
        """Yield the wheelsets of each group."""
        first = 0
        for count in self.wheelsets_per_group:
            yield slice(first, first + count)
            first += count

    def summed(self, values: Array) -> Array:
        """Return the sums over the wheelsets of each group: shape (..., wheelsets) → (..., groups)."""
        return np.stack([values[..., members].sum(axis=-1) for members in self.members()], axis=-1)


def formation_of(group_of_wheelset: Sequence[int]) -> Formation:
    """Return the formation whose wheelsets belong to these groups, numbered without gaps from the leading one on.

    Raises:
        ValueError: The groups do not stand side by side, lead to trail.
    """
    groups, counts = np.unique(np.asarray(group_of_wheelset, dtype=np.intp), return_counts=True)
    formation = Formation(tuple(counts.tolist()))
    if not np.array_equal(groups[0] + formation.group_of_wheelset, group_of_wheelset):
        raise ValueError(f"wheelsets of a group stand side by side, lead to trail; got {list(group_of_wheelset)}")
    return formation
