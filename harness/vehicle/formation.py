"""The wheelsets of a vehicle: their groups, positions, loads and brakes.

It determines the size of all vectors.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from railgrip.base.arrays import Array
from railgrip.base.units import GRAVITY
from railgrip.vehicle.brake import Brake, Values

Extent = Literal["train", "car", "group", "wheelset", "coupler"]


@dataclass(frozen=True, slots=True)
class Formation:
    """The wheelsets of a vehicle, leading one first, in groups that turn as one and have a common brake.

    All attributes except `wheelsets_per_group` are empty if they are not given.

    Attributes:
        wheelsets_per_group: Number of wheelsets of each group, leading group first.
        wheelsets_per_car: Number of wheelsets of each car, leading car first; the wheelsets of a bogie under two cars
            are divided between them.
        wheelset_position: Distance of each wheelset behind the leading one [m].
        wheelset_load: Nominal static force of each wheelset on the rail [N].
        brakes: Nominal brake of each group.
        groups_per_valve: Number of groups that each brake valve fills and vents, leading valve first; by default each
            group has its own valve.
    """

    wheelsets_per_group: tuple[int, ...]
    wheelsets_per_car: tuple[int, ...] = ()
    wheelset_position: tuple[float, ...] = ()
    wheelset_load: tuple[float, ...] = ()
    brakes: tuple[Brake, ...] = ()
    groups_per_valve: tuple[int, ...] = ()

    def __post_init__(self) -> None:
        """Check the attributes.

        Raises:
            ValueError: The formation has no groups, or a group has no wheelset; an array has another number of
                wheelsets or groups; positions do not rise from 0, or a load is not positive.
        """
        if not self.wheelsets_per_group or min(self.wheelsets_per_group) < 1:
            raise ValueError(
                "a formation has one wheelset or more in each of its groups, as in [2, 1, 1, 2]; "
                f"got {list(self.wheelsets_per_group)}"
            )
        count = f"wheelsets_per_group has {self.wheelsets}, {list(self.wheelsets_per_group)}"
        if self.wheelsets_per_car and (
            min(self.wheelsets_per_car) < 1 or sum(self.wheelsets_per_car) != self.wheelsets
        ):
            raise ValueError(
                f"wheelsets_per_car has {sum(self.wheelsets_per_car)} wheelsets, {list(self.wheelsets_per_car)}, at "
                f"least one to a car; {count}"
            )
        for name in ("wheelset_position", "wheelset_load"):
            values: tuple[float, ...] = getattr(self, name)
            if values and len(values) != self.wheelsets:
                raise ValueError(f"{name} is for {len(values)} wheelsets; {count}")
        if self.brakes and len(self.brakes) != self.groups:
            raise ValueError(f"brakes are for {len(self.brakes)} groups, there are {self.groups}")
        if self.groups_per_valve and (min(self.groups_per_valve) < 1 or sum(self.groups_per_valve) != self.groups):
            raise ValueError(
                f"groups_per_valve has {sum(self.groups_per_valve)} groups, {list(self.groups_per_valve)}, at least "
                f"one to a valve; there are {self.groups}"
            )
        places = self.wheelset_position
        if places and (places[0] != 0 or any(a >= b for a, b in pairwise(places))):
            raise ValueError(f"wheelset_position must be rising distances [m] that start with 0, got {list(places)}")
        if any(not load > 0 for load in self.wheelset_load):
            raise ValueError(f"wheelset_load must be positive [N], got {list(self.wheelset_load)}")

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

    @property
    def cars(self) -> int:
        """Number of cars; one if it is not given."""
        return len(self.wheelsets_per_car) or 1

    @property
    def car_of_wheelset(self) -> NDArray[np.intp]:
        """Zero-based car of each wheelset, shape (wheelsets,)."""
        return np.repeat(np.arange(self.cars), self.wheelsets_per_car or (self.wheelsets,))

    @property
    def position(self) -> Array | None:
        """Distance of each wheelset behind the leading one, shape (wheelsets,) [m]; None if it is not given."""
        return np.array(self.wheelset_position) if self.wheelset_position else None

    @property
    def load(self) -> Array | None:
        """Static force of each wheelset on the rail, shape (wheelsets,) [N]; None if it is not given."""
        return np.array(self.wheelset_load) if self.wheelset_load else None

    @property
    def pressure_max(self) -> Array:
        """Highest brake cylinder pressure, shape (groups,) [Pa]."""
        return np.array([brake.pressure_max for brake in self.brakes])

    @property
    def wheel_radius(self) -> Array:
        """Nominal rolling radius, shape (groups,) [m]."""
        return np.array([brake.wheel_radius for brake in self.brakes])

    def width(self, extent: Extent) -> int:
        """Return the number of values of a quantity with one value for each `extent`."""
        widths = {"train": 1, "car": self.cars, "group": self.groups, "wheelset": self.wheelsets}
        return (widths | {"coupler": self.cars - 1})[extent]

    def members(self) -> Iterator[slice]:
        """Yield the wheelsets of each group."""
        first = 0
        for count in self.wheelsets_per_group:
            yield slice(first, first + count)
            first += count

    def sum_by_group(self, values: Array) -> Array:
        """Return the sums over the wheelsets of each group: shape (..., wheelsets) → (..., groups)."""
        return np.stack([values[..., members].sum(axis=-1) for members in self.members()], axis=-1)


def formation_of(group_of_wheelset: Sequence[int]) -> Formation:
    """Return the formation from the group of each wheelset, numbered without gaps from the leading one on.

    Raises:
        ValueError: The groups are not contiguous, or not in ascending order.
    """
    groups, counts = np.unique(np.asarray(group_of_wheelset, dtype=np.intp), return_counts=True)
    formation = Formation(tuple(counts.tolist()))
    if not np.array_equal(groups[0] + formation.group_of_wheelset, group_of_wheelset):
        raise ValueError(f"wheelsets of a group must be adjacent, leading group first; got {list(group_of_wheelset)}")
    return formation


def axle_load(mass: Values) -> Values:
    """Return the static force on the rail [N] of a mass carried by wheelsets [kg]."""
    return mass * GRAVITY


def carried_mass(load: Values) -> Values:
    """Return the mass carried by wheelsets [kg] from their static force on the rail [N]; inverse of `axle_load`."""
    return load / GRAVITY
