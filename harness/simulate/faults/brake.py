"""Faults of brakes: isolated brakes, faulty valves, an insufficient supply of air."""

from collections.abc import Mapping, Sequence
from typing import Annotated, Literal

from pydantic import Field

from railgrip.base.errors import ScenarioError
from railgrip.scenario.faults import Fault, Place, amount_of
from railgrip.scenario.quantity import Magnitude, UnitRange
from railgrip.scenario.table import optional
from railgrip.simulate.faults.site import Site, iterate_faults, places
from railgrip.vehicle.formation import Formation


class BrakeIsolation(Fault):
    """The cylinders of a group are vented; if only some of its units are isolated, the others keep their pad force."""

    part: Literal["brake"]
    kind: Literal["isolated"]
    group: Place | None = optional("from 1 on; without it all groups")
    value: Magnitude | None = optional("units of the group, without it all")

    def act_on(self, site: Site) -> None:
        """Vent each group that is isolated as a whole."""
        if self.value is None:
            for group in site.groups(self.group):
                site.change_command("fixed", group, value=-1.0 if site.valves else 0.0)


def isolated_units(faults: Sequence[Fault], formation: Formation, units: Mapping[str, float]) -> dict[str, float]:
    """Return the plant parameters `n_units[g]`, reduced by the brake units that are isolated.

    Args:
        faults: Faults of the scenario.
        formation: Formation with the groups.
        units: All numeric parameters of the plant.

    Raises:
        ScenarioError: The plant has no such parameter or fewer units, or units are isolated for a while only.
    """
    counts: dict[str, float] = {}
    for where, fault in iterate_faults(faults, BrakeIsolation):
        if fault.value is None:
            continue
        if not fault.lasts:
            raise ScenarioError(
                f"{where} isolates some units of a group, which holds for the whole stop: leave out begin and end, or "
                "value, to isolate the group"
            )
        for group in places(fault.group, formation.groups, where, "group"):
            name = f"n_units[{group + 1}]"
            if name not in units:
                raise ScenarioError(
                    f"{where} isolates units of a group, but the plant has no parameter {name}; "
                    "leave out value to isolate the group"
                )
            counts[name] = counts.get(name, units[name]) - amount_of(fault.value, "1", where, fault.kind)
            if counts[name] <= 0.0:
                raise ScenarioError(
                    f"{where} isolates all units of group {group + 1}, which has {units[name]:g}, or more; leave out "
                    "value to isolate the group"
                )
    return counts


def isolated_groups(faults: Sequence[Fault], formation: Formation) -> list[int]:
    """Return the zero-based groups whose brake is isolated for the whole stop."""
    return [
        group
        for where, fault in iterate_faults(faults, BrakeIsolation)
        if fault.value is None and fault.lasts
        for group in places(fault.group, formation.groups, where, "group")
    ]


_SLOWEST = 10.0  # s
_VENT, _HOLD, _FILL = -1.0, 0.0, 1.0


class _ValveFault(Fault):
    part: Literal["valve"]
    group: Place | None = optional("from 1 on; without it all groups")


class StuckValve(_ValveFault):
    """The valve keeps its position, whatever the command.

    With ideal actuation a valve stuck at filling gives full pressure, one stuck at dumping 0, and one stuck at holding
    the pressure demanded before.
    """

    kind: Literal["filled", "dumped", "held"]

    def act_on(self, site: Site) -> None:
        """Fix the command to a value, or to the last one."""
        for group in site.groups(self.group):
            if self.kind == "held" and not site.valves:
                site.change_command("kept", group)
            else:
                pressures = {"filled": site.layout.formation.brakes[group].pressure_max, "dumped": 0.0}
                positions = {"filled": _FILL, "dumped": _VENT, "held": _HOLD}
                site.change_command("fixed", group, value=(positions if site.valves else pressures)[self.kind])


class SlowValve(_ValveFault):
    """The valve reacts late."""

    kind: Literal["slow"]
    value: Magnitude = Field(description="added dead time")

    def act_on(self, site: Site) -> None:
        """Delay the command to each group.

        Raises:
            ScenarioError: The delay is so long that the valve should be described as held.
        """
        amount = amount_of(self.value, "s", site.where, self.kind)
        if amount > _SLOWEST:
            raise ScenarioError(
                f"{site.where} delays a valve by {amount:g} s; at most {_SLOWEST:g} s are possible; use 'held'"
            )
        delay = round(amount / site.scenario.periods.communication)
        for group in site.groups(self.group):
            site.change_command("late", group, delay=delay)


class SupplyLoss(Fault):
    """The reservoir is emptied by the air consumption of the plant."""

    part: Literal["supply"]
    kind: Literal["sagging"]
    value: Magnitude = Field(description="volume of the reservoir")
    pressure: Annotated[float, UnitRange("Pa", above=0, at_most=1e8)] = Field(description="of the full reservoir")
    refill: (
        Annotated[float, UnitRange("m3/s", above=0, at_most=1, because="compressors deliver some m3 a minute")] | None
    ) = optional("free air that its compressor delivers; without it, none")

    def act_on(self, site: Site) -> None:
        """Limit the command to each group to the reservoir's pressure.

        Raises:
            ScenarioError: The plant lacks the output for its air consumption.
        """
        if "air_used" not in site.outputs:
            raise ScenarioError(
                f"{site.where} empties a reservoir, but the plant has no output air_used; "
                "take a plant with it, or leave out this fault"
            )
        volume = amount_of(self.value, "m3", site.where, self.kind)
        refill = (self.refill or 0.0) * site.scenario.periods.communication
        for group in site.groups(None):
            site.change_command("limited", group, value=volume, pressure=self.pressure, refill=refill)
