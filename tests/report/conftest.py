"""Results on disk for every report."""

import pytest
from synthetic import COARSE, LIBRARY
from synthetic_runner import run_stop

from railgrip.campaign.run import write_description
from railgrip.report.results import read_results
from railgrip.report.stop import write_stop
from railgrip.scenario.campaign import load_campaign

TABLE1 = LIBRARY.parent / "campaigns" / "table1.toml"


@pytest.fixture(scope="session")
def write_campaign():
    """Write results of some stops of a campaign as if they had been run; return the campaign with only these stops.

    The campaign is Table 1, or that of a text, in which `{library}` is the folder of the scenarios of the package.
    """

    def write(directory, keep=lambda stop: True, overrides=(), text=""):
        file = directory / "written.toml" if text else TABLE1
        if text:
            file.write_text(text.format(library=LIBRARY.as_posix()), encoding="utf-8")
        whole = load_campaign(file, [*COARSE, *overrides])
        campaign = whole.only(keep)
        write_description(campaign, directory)
        for stop in campaign.stops:
            write_stop(run_stop(stop.scenario), directory / stop.name)
        return campaign

    return write


@pytest.fixture(scope="module")
def folder(request, tmp_path_factory, write_campaign):
    """The folder of a campaign: `kept` of the module selects its stops, `CAMPAIGN` is its text."""
    folder = tmp_path_factory.mktemp("campaign")
    write_campaign(
        folder, getattr(request.module, "kept", lambda stop: True), text=getattr(request.module, "CAMPAIGN", "")
    )
    return folder


@pytest.fixture(scope="module")
def stops(folder):
    return {stop.name: stop for stop in read_results(folder).stops}
