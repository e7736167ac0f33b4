"""Isolated brakes."""

from collections.abc import Mapping
from typing import Literal

from railgrip.base.errors import ScenarioError
from railgrip.scenario.faults import Fault, Place, amount_of
from railgrip.scenario.quantity import Magnitude
from railgrip.scenario.schema import Scenario
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
            vented, samples = -1.0 if site.valves else 0.0, self.samples(site.scenario)
            for group in site.groups(self.group):
                site.faults.add_command("fixed", group, value=vented, **samples)


def isolated_units(scenario: Scenario, formation: Formation, units: Mapping[str, float]) -> dict[str, float]:
    """Return the plant parameters `n_units[g]`, reduced by the brake units that are isolated.

    Args:
        scenario: Scenario with the faults.
        formation: Formation with the groups.
        units: All numeric parameters of the plant.

    Raises:
        ScenarioError: The plant has no such parameter or fewer units, or units are isolated for a while only.
    """
    counts: dict[str, float] = {}
    for where, fault in iterate_faults(scenario, BrakeIsolation):
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
                raise ScenarioError(f"{where} isolates units of a group, but the plant has no parameter {name}")
            counts[name] = counts.get(name, units[name]) - amount_of(fault.value, "1", where, fault.kind)
            if counts[name] <= 0.0:
                raise ScenarioError(
                    f"{where} isolates all units of group {group + 1}, which has {units[name]:g}, or more; leave out "
                    "value to isolate the group"
                )
    return counts


def isolated_groups(scenario: Scenario, formation: Formation) -> list[int]:
    """Return the zero-based groups whose brake is isolated for the whole stop."""
    faults = (
        (where, fault)
        for where, fault in iterate_faults(scenario, BrakeIsolation)
        if fault.value is None and fault.lasts
    )
    return [group for where, fault in faults for group in places(fault.group, formation.groups, where, "group")]
