"""Figures and tables of published papers, ours beside theirs."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

from typer import Option

from railgrip.campaign.work import Work
from railgrip.report.page import Page
from railgrip.report.table import Table
from railgrip.studies.papers import adhesion_based
from railgrip.studies.papers.adhesion_based import FITS, IDENTIFIED
from railgrip.studies.papers.pages import write_results
from railgrip.studies.papers.table1 import Fitted, read_fits, refined, search, write_fits
from railgrip.studies.study import Study

PAGE = "adhesion_based.md"


def tables_of(fits: Sequence[Fitted], identified: Fitted) -> dict[str, Table]:
    """Return the tables of the page on adhesion-based control by name."""
    return {
        "distances": adhesion_based.distances(identified),
        "parameters": adhesion_based.parameters(identified),
        "profile": adhesion_based.profile(fits),
        "alternatives": adhesion_based.alternatives(fits),
    }


@dataclass(frozen=True)
class Papers(Study):
    """Draw figures and tables of the paper on adhesion-based control with its Table 1 identified, ours beside."""

    fit: Annotated[bool, Option("--fit", help="Search the fit of Table 1 anew (20 minutes of two cores).")] = False
    write: Annotated[
        bool, Option("--write", help="Keep the fit in the study's library, and write its numbers into docs/papers.")
    ] = False

    def page(self, work: Work) -> Page:
        """Return the tables of the fit, and figure 4."""
        fits = search(work) if self.fit else read_fits(FITS)
        identified = refined(work, fits) if self.fit else read_fits(IDENTIFIED)[0]
        tables = tables_of(fits, identified)
        if self.write:
            write_fits(FITS, fits)
            write_fits(IDENTIFIED, [identified])
            write_results(PAGE, self.name, tables)
        work.notify("figure 4")
        return Page(
            template="studies/papers/papers.md.jinja",
            values=dict(tables),
            figures={
                "figure_4.png": adhesion_based.adhesion_figure(adhesion_based.stops_of(identified)),
                "profile.png": adhesion_based.profile_figure(fits),
            },
            screen=(tables["distances"], tables["alternatives"]),
        )


STUDY = Papers
