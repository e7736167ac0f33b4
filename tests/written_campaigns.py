"""Results of campaigns, written as if their stops had been run."""

from collections.abc import Callable, Sequence
from pathlib import Path

from synthetic import COARSE, LIBRARY
from synthetic_runner import run_stop

from railgrip.campaign.run import write_description
from railgrip.report.stop import write_stop
from railgrip.scenario.campaign import Campaign, PlannedStop, load_campaign

CAMPAIGNS = LIBRARY.parent / "campaigns"


def write_campaign(
    directory: Path,
    keep: Callable[[PlannedStop], bool] = lambda stop: True,
    overrides: Sequence[str] = (),
    text: str = "",
) -> Campaign:
    """Write results of some stops of a campaign; return the campaign with only these stops.

    The campaign is Table 1, or that of a text, in which `{library}` is the folder of the scenarios of the package.
    """
    file = directory / "written.toml" if text else CAMPAIGNS / "table1.toml"
    if text:
        file.write_text(text.format(library=LIBRARY.as_posix()), encoding="utf-8")
    campaign = load_campaign(file, [*COARSE, *overrides]).only(keep)
    write_description(campaign, directory)
    for stop in campaign.stops:
        write_stop(run_stop(stop.scenario), directory / stop.name)
    return campaign
