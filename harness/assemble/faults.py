"""The faults of a scenario, between the plant and those who meet them."""

from collections.abc import Sequence

from railgrip.faults.site import Site
from railgrip.loop.faults import Faults
from railgrip.scenario.schema import Scenario
from railgrip.signals import Layout
from railgrip.vehicle.brake import Brake


def faults_of(
    scenario: Scenario, layout: Layout, brakes: Sequence[Brake], *, outputs: frozenset[str], valves: bool
) -> Faults | None:
    """Return what is broken on the way to and from the plant; None where nothing is.

    Raises:
        ScenarioError: A fault is none of this vehicle.
    """
    sites = [
        Site(
            scenario=scenario, layout=layout, brakes=brakes, outputs=outputs, valves=valves, number=number,
            where=f"{scenario.name}: [faults[{number + 1}]]",
        )
        for number in range(len(scenario.faults))
    ]  # fmt: skip
    pairs = list(zip(scenario.faults, sites, strict=True))
    readings = [one for fault, site in pairs for one in fault.of_readings(site)]
    commands = [one for fault, site in pairs for one in fault.of_commands(site)]
    if not readings and not commands:
        return None
    every = max(round(1e-3 / scenario.periods.communication), 1)
    return Faults(layout, readings, commands, valves=valves, noise_every=every)
