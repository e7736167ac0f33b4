"""Results on disk for every report."""

import pytest
import written_campaigns

from railgrip.report.results import read_results


@pytest.fixture(scope="session")
def write_campaign():
    return written_campaigns.write_campaign


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
