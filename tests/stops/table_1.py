"""Stops of the campaign of Table 1, by name."""

from synthetic import LIBRARY

from railgrip.scenario.campaign import load_campaign
from railgrip.scenario.schema import Scenario

CAMPAIGN = LIBRARY.parent / "campaigns" / "table1.toml"


def table_1_scenario(name: str, *overrides: str) -> Scenario:
    """Return the scenario of a stop such as `random-service-slip_two_state`, changed by overrides."""
    (scenario,) = (stop.scenario for stop in load_campaign(CAMPAIGN, overrides).stops if stop.name == name)
    return scenario
