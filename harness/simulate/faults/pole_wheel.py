"""Missing teeth of pole wheels."""

from typing import Literal

from pydantic import Field

from railgrip.base.errors import ScenarioError
from railgrip.scenario.faults import Fault, Place, amount_of
from railgrip.scenario.quantity import Magnitude
from railgrip.scenario.schema import Scenario
from railgrip.scenario.table import optional
from railgrip.simulate.faults.site import Site, iterate_faults, places
from railgrip.vehicle.formation import Formation


class ToothFault(Fault):
    """Adjacent teeth are missing, and the electronics is unaware of it."""

    part: Literal["speed_sensor"]
    kind: Literal["missing_teeth"]
    group: Place | None = optional("from 1 on; without it all groups")
    value: Magnitude = Field(description="how many")

    def act_on(self, site: Site) -> None:
        """Check the fault; the sensors model their pole wheels themselves.

        Raises:
            ScenarioError: The sensors have no pole wheels.
        """
        missing_teeth(site.scenario, site.layout.formation, site.scenario.periods.communication)


def missing_teeth(scenario: Scenario, formation: Formation, period: float) -> list[dict[str, int]]:
    """Return the missing teeth of each group's pole wheel, as fields of `Encoder` in sensors.h.

    They are adjacent, and missing from sample `begin` to before sample `end`; the sensor samples every `period` [s].

    Raises:
        ScenarioError: The sensors have no pole wheels, or more teeth are missing than a wheel has.
    """
    pulses = scenario.sensors.pulses
    missing: list[dict[str, int]] = [{} for _ in range(formation.groups)]
    for where, fault in iterate_faults(scenario, ToothFault):
        if not pulses:
            kind = scenario.sensors.kind
            raise ScenarioError(f"{where} needs pole wheels, [sensors] kind 'service', and it is '{kind}'")
        count = amount_of(fault.value, "1", where, fault.kind)
        if count != round(count):
            raise ScenarioError(f"{where} value is a number of teeth, got {count:g}")
        if count >= pulses:
            raise ScenarioError(f"{where} takes {count:g} teeth of {pulses}; for all of them, kind 'dead'")
        for group in places(fault.group, formation.groups, where, "group"):
            if missing[group]:
                raise ScenarioError(f"{where}: the pole wheel of group {group + 1} misses teeth twice; keep one fault")
            missing[group] = {"missing": round(count), **fault.samples(scenario, period)}
    return missing
