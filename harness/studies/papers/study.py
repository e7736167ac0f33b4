"""Figures and tables of published papers next to those of railgrip."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Annotated, Any

from typer import Option

from railgrip.campaign.work import Work, call
from railgrip.report.marked import write_tables
from railgrip.report.page import Page
from railgrip.report.table import ReportTable
from railgrip.studies.papers import adhesion_based, printed
from railgrip.studies.papers.adhesion_based import FITS, IDENTIFIED
from railgrip.studies.papers.courses import (
    offset_table,
    used_by_wheelset,
    used_table,
    violations_table,
    wheelset_figure,
)
from railgrip.studies.papers.creep_curves import causes, figure_1, rails
from railgrip.studies.papers.pages import comparison, write_results
from railgrip.studies.papers.printed import deflection_table, deflections
from railgrip.studies.papers.table1 import (
    BOUNDS,
    FINAL,
    SCENARIOS,
    CandidateFit,
    read_fits,
    refine,
    repeat,
    search,
    write_fits,
)
from railgrip.studies.study import Study

PAGE = "adhesion_based.md"
VALIDATION = Path("docs/validation.md")
"""Page with the table of braking distances, and with `validation_tables`."""


def tables_of(
    fits: Sequence[CandidateFit], identified: CandidateFit, found: Mapping[str, Any]
) -> dict[str, ReportTable]:
    """Return the tables of the page on adhesion-based control by name; `found` are `measures` of the figures."""
    return {
        "published": comparison(adhesion_based.compare_with_paper(identified, found)),
        "sentences": adhesion_based.sentences(identified, found),
        "distances": adhesion_based.distances(identified, found),
        "parameters": adhesion_based.parameters(identified),
        "choices": adhesion_based.choices(identified),
        "alternatives": adhesion_based.alternatives(fits),
        "lyapunov": violations_table(found["violations"]),
        "offset": offset_table(found["offsets"]),
        "wheelsets": used_table(found["used_by_wheelset"]),
        "deflections": deflection_table(found["deflections"]),
    }


def validation_tables(found: Mapping[str, Any]) -> dict[str, ReportTable]:
    """Return the tables of the validation page by name; `found` are `measures`, with guards and excesses."""
    return {"guards": printed.guards_table(found["guards"]), "limit": printed.limit_table(found["excesses"])}


@dataclass(frozen=True)
class Papers(Study):
    """Draw figures and tables of the paper on adhesion-based control, with its Table 1 identified."""

    fit: Annotated[
        bool, Option("--fit", help="Go on with the search for the fit of Table 1 (a quarter of an hour of a core).")
    ] = False
    write: Annotated[
        bool,
        Option("--write", help="Keep the fit in the study's library, and write its numbers into docs/papers and docs."),
    ] = False

    def page(self, work: Work) -> Page:
        """Return figures and tables of the paper."""
        known = read_fits(FITS)
        fits = search(work, known[:KNOWN]) if self.fit else known
        identified = refine(work, fits) if self.fit else read_fits(IDENTIFIED)[0]
        work.notify("guards of the law")
        guards, excesses = printed.guards(work), printed.excesses(work)
        work.notify("figures")
        repeats = repeats_of(work, identified)
        of_causes, of_rails = causes(), rails()
        stops = adhesion_based.stops_of(identified, adhesion_based.median_seed(repeats["trapezoid"]))
        found = adhesion_based.measures(stops, of_rails) | {"guards": guards, "excesses": excesses}
        found["repeats"] = repeats
        law_as_printed, limit = adhesion_based.LAWS[0], adhesion_based.LIMIT
        drawn = {"SBC": stops["trapezoid"], **{law: stops[law] for law in adhesion_based.LAWS}}
        found["used_by_wheelset"] = {law: used_by_wheelset(stop, limit) for law, stop in drawn.items()}
        work.notify("filters with and without deflections")
        found["deflections"] = deflections(work)
        tables = tables_of(fits, identified, found)
        figures = {
            "adhesion_based_4.png": adhesion_based.adhesion_figure(stops),
            "adhesion_based_4_others.png": wheelset_figure(
                stops["trapezoid"], stops[law_as_printed], law_as_printed, limit
            ),
            "adhesion_based_1.svg": figure_1(of_causes, of_rails),
            "adhesion_based_3.png": adhesion_based.rail_figure(stops),
            "adhesion_based_curve.svg": adhesion_based.curve_figure(identified),
        }
        if self.write:
            write_fits(FITS, fits)
            write_fits(IDENTIFIED, [identified])
            diagram = {"adhesion_based_2.svg": adhesion_based.block_diagram()}
            write_results(PAGE, tables, figures | diagram, found)
            write_tables(VALIDATION, validation_tables(found))
        return Page(
            title="Adhesion-based control: published figures and those of railgrip",
            question="Which creep curve, friction and parameters of the printed law reproduce Table 1 of the paper?",
            answer=f"The numbers below reproduce all six distances within {100 * identified.largest:.1f} %; they are "
            f"the best of {len(fits)} fits. Other values do so within a few percent: six distances do not determine "
            f"{len(BOUNDS) + len(SCENARIOS)} numbers.",
            template="studies/papers/papers.md.jinja",
            values=tables | validation_tables(found),
            figures=figures,
            screen=(tables["published"], tables["sentences"], tables["lyapunov"], tables["alternatives"]),
        )


def repeats_of(work: Work, identified: CandidateFit) -> dict[str, list[dict[str, float]]]:
    """Return the numbers of the repeated stops with the law as printed, by scenario and seed; see `repeat`."""
    cases = [partial(repeat, name, identified.candidate, identified.levels[name], FINAL["abc"]) for name in SCENARIOS]
    return dict(zip(SCENARIOS, work.map(call, cases), strict=True))


KNOWN = 8
"""Best fits of the last search, from which a new one continues."""

STUDY = Papers
