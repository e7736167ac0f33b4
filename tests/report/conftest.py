"""Results on disk for every report."""

from pathlib import Path

import pytest
from synthetic_runner import run_stop

import railgrip.scenario
from railgrip.campaign.run import write_description
from railgrip.report.stop import write_stop
from railgrip.scenario.campaign import load_campaign

TABLE1 = Path(railgrip.scenario.__file__).parent / "campaigns" / "table1.toml"
COARSE = [f"periods.{name}=10 ms" for name in ("communication", "estimator", "controller")]


@pytest.fixture(scope="session")
def write_campaign():
    """Write results of some stops of a campaign as if they had been run; return the campaign with only these stops."""

    def write(directory, keep, overrides=(), file=TABLE1):
        whole = load_campaign(file, [*COARSE, *overrides])
        campaign = whole.only(keep)
        write_description(campaign, directory)
        for stop in campaign.stops:
            write_stop(run_stop(stop.scenario), directory / stop.name)
        return campaign

    return write
