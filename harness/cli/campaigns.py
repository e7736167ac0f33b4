"""Commands for many stops: campaigns, their reports, and comparisons."""

import textwrap
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer

from railgrip.base.errors import ScenarioError
from railgrip.base.files import read_text
from railgrip.campaign.run import CampaignRun
from railgrip.campaign.sweep import csv_of, load_results, write_table
from railgrip.campaign.work import work
from railgrip.cli.app import (
    BASELINES,
    AsJson,
    Campaigns,
    Formats,
    Fresh,
    ImportFrom,
    Overrides,
    Scheduler,
    Workers,
    print_json,
)
from railgrip.cli.runs import runner
from railgrip.report.baseline import baseline_deviations
from railgrip.report.comparison import compare as compared
from railgrip.report.console import complain, progress, remark, say, show_all
from railgrip.report.distances import (
    caveats_of,
    documentation_tables,
    headline,
    meaning_of,
    overview_of,
    overview_table,
    reader_tables,
)
from railgrip.report.distribution import change_table, changes_against
from railgrip.report.frame import Frame, frame_of
from railgrip.report.index import reference_of, write_report
from railgrip.report.page import formats_of
from railgrip.report.results import Results, by_compiler, read_results, remarks_on
from railgrip.report.stop import require_no_result
from railgrip.report.table import names_in, write_tables
from railgrip.scenario.campaign import Panels, load_campaign, selection_of

Against = Annotated[
    str | None,
    typer.Option(
        metavar="VARIANT",
        help="Compare the other variants of its axis with this one, in pairs of stops that are otherwise equal: a "
        "name, or AXIS=VARIANT.",
    ),
]


def campaign(
    files: Campaigns,
    overrides: Overrides = None,
    only: Annotated[
        list[str] | None,
        typer.Option(metavar="AXIS=VARIANT,...", help="Run only the stops of these variants of an axis; repeatable."),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(help="Folder for results, DIR/NAME for several campaigns; build/NAME unless given."),
    ] = None,
    workers: Workers = 2,
    fresh: Fresh = False,
    panels: Annotated[
        Panels | None, typer.Option(help="Stops that get a page, instead of those named by the campaigns.")
    ] = None,
    figure_formats: Formats = "png",
    import_from: ImportFrom = None,
    scheduler: Scheduler = None,
    against: Against = None,
) -> None:
    """Run the stops of campaigns and write tables and a report.

    Stops that are complete are kept and not run again.
    """
    formats = formats_of(figure_formats)
    campaigns = [selection_of(load_campaign(file, overrides or []), only or []) for file in files]
    for loaded in campaigns:
        reference_of(loaded.stops, against)  # refuse it before stops run for hours
    # Accepted distances apply to the campaign as its file defines it.
    baselines = [None if overrides else BASELINES / file.name for file in files]
    folder = out if out is not None and len(files) == 1 else None
    runs = [CampaignRun(loaded, folder or (out or Path("build")) / loaded.name) for loaded in campaigns]
    twice = next((run for run in runs if [a.directory for a in runs].count(run.directory) > 1), None)
    if twice is not None:
        raise ScenarioError(f"two campaigns are named '{twice.campaign.name}' and would share {twice.directory}")
    problem = run_campaigns(runs, workers=workers, scheduler=scheduler, fresh=fresh, import_from=import_from or ())
    for run, baseline in zip(runs, baselines, strict=True):
        results = read_results(run.directory)
        frame = frame_of(results)
        overview = overview_of(frame)
        if overview is None:
            show_all(reader_tables(frame, hidden=_NOT_ON_SCREEN) or ["no results"])
        else:
            show_all([overview_table(overview)])
        _show_result(results, frame, against)
        about = [] if overview is None else [*caveats_of(overview, results.published), meaning_of(overview)]
        for sentence in (*about, *by_compiler(results.stops)):
            say(textwrap.fill(sentence, _SCREEN))
        for sentence in remarks_on(results.stops):
            remark(sentence)
        for sentence in [] if baseline is None else baseline_deviations(results, baseline):
            complain(sentence)
    # Drawing takes as long as many stops: the distances do not wait for it.
    for run, baseline in zip(runs, baselines, strict=True):
        with progress(run.campaign.name, "reading results") as bar:
            page = write_report(
                run.directory,
                panels=panels or run.campaign.panels,
                notify=lambda what, bar=bar: bar.update(phase=f"drawing {what}"),
                baseline=baseline,
                formats=formats,
                against=against,
            )
        say(str(page))
    if problem:
        raise typer.Exit(problem)


def report(
    directory: Annotated[Path, typer.Argument(metavar="DIR", help="Folder of a run or of a campaign.")],
    panels: Annotated[Panels, typer.Option(help="Stops of a campaign that get a page.")] = "all",
    figure_formats: Formats = "png",
    against: Against = None,
    write: Annotated[
        Path | None, typer.Option(help="Markdown page in which the tables of a campaign are written between its marks.")
    ] = None,
) -> None:
    """Make the page of the results in a folder.

    For a campaign also the pages of its stops.
    """
    formats = formats_of(figure_formats)
    if write is not None:
        frame = frame_of(read_results(directory))
        tables = {f"{directory.name}, {name}": table for name, table in documentation_tables(frame).items()}
        marked = names_in(read_text(write))
        chosen = {name: table for name, table in tables.items() if name in marked} or tables
        write_tables(write, chosen)
        say(f"{write}: {'; '.join(chosen)}")
        return
    with progress("report", "reading results") as bar:

        def draw(what: str) -> None:
            bar.update(phase=f"drawing {what}")

        page = write_report(directory, panels=panels, notify=draw, formats=formats, against=against)
    if against is not None:
        results = read_results(directory)
        _show_result(results, frame_of(results), against)
    say(str(page))


def _show_result(results: Results, frame: Frame, against: str | None) -> None:
    reference = reference_of(results.stops, against)
    changes = () if reference is None else changes_against(reference, results.stops, frame)
    if reference is not None:
        show_all([change_table(reference, changes)])
    say(textwrap.fill(headline(frame, reference, changes), _SCREEN))


def table(
    folder: Annotated[
        Path, typer.Argument(metavar="DIR", help="Folder of a run, of a stop in a campaign, or of a campaign.")
    ],
    out: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="File to write, *.csv or *.parquet; CSV is printed unless given."),
    ] = None,
) -> None:
    """Print or write the results in a folder as a table.

    For a run its samples over time, for a campaign one row of metrics per stop; in SI units.
    """
    frame = load_results(folder).to_pandas()
    if out is None:
        say(csv_of(frame).rstrip("\n"))
    else:
        write_table(frame, out)
        say(str(out))


def compare(
    results: Annotated[
        list[Path],
        typer.Argument(metavar="A B ...", help="Folders of runs, of stops in a campaign, or of campaigns."),
    ],
    out: Annotated[
        Path | None,
        typer.Option(help="Folder for the page; build/compare/A-B, from the names of the results, unless given."),
    ] = None,
    as_json: AsJson = False,
    figure_formats: Formats = "png",
) -> None:
    """Show how results differ, and where along the track."""
    formats = formats_of(figure_formats)
    comparison = compared(*results)
    names = [path.resolve().name for path in results]
    folder = out or Path("build/compare") / (
        "-".join(names) if len(names) < 4 else f"{names[0]}-{len(names) - 1}-others"
    )
    require_no_result(folder)
    page = comparison.page()
    path = page.write(folder, formats)
    if as_json:
        print_json(comparison.to_plain())
        return
    show_all(page.screen)
    say(str(path))


def run_campaigns(
    runs: Sequence[CampaignRun],
    *,
    workers: int,
    fresh: bool,
    scheduler: str | None = None,
    import_from: Sequence[Path] = (),
) -> int:
    """Run campaigns with progress; return the exit code."""
    with work(", ".join(run.campaign.name for run in runs), workers=workers, scheduler=scheduler, fresh=fresh) as job:
        return job.stops(runs, runner(import_from), import_from=import_from)


_SCREEN = 100
"""Length of a line of text on a screen [characters]."""

_NOT_ON_SCREEN = frozenset(
    {"estimator", "repeated", "duration", "longest lock", "wheel flat", "valve strokes", "air", "NIS", "outside ±2σ"}
)
"""Columns of the table that are omitted on a screen."""
