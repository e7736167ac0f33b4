"""Braking curves and supervision limits of ETCS: a figure, a table, and a CSV file."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

from typer import Argument, Option

from railgrip.base.files import write_text
from railgrip.campaign.work import Work
from railgrip.report.baseline import Finding
from railgrip.report.page import Page
from railgrip.report.stop import value_text
from railgrip.report.table import ReportTable, bulleted, yes_no
from railgrip.studies.study import Study
from railgrip.supervision.results import BrakingCurves, braking_curves

_CSV: Mapping[str, Any] = {"index": False, "float_format": "%.4f", "lineterminator": "\n"}


@dataclass(frozen=True)
class Etcs(Study, quick="the whole study"):
    """Draw the braking curves that ETCS supervises for a train, and its stops beneath."""

    documentation = Path("docs/etcs.md")

    train: Annotated[
        Path, Argument(metavar="TRAIN", help="A train file or its name, or a file of brake curves or percentage.")
    ] = Path("emu387")
    line: Annotated[Path | None, Option(help="Line with gradients and targets; level unless given.")] = None
    national: Annotated[Path | None, Option(help="National values; the defaults of SUBSET-026 unless given.")] = None
    write: Annotated[bool, Option("--write", help="Write its tables into docs/etcs.md.")] = False

    def page(self, work: Work) -> Page:
        """Return the curves.

        Raises:
            InputError: A file is wrong, or the brake does not slow the train down on the line.
        """
        curves = braking_curves(self.train, self.national, self.line, work.notify)
        name = curves.case.model.name
        return Page(
            title=f"Braking curves of {name}",
            question="Where does ETCS warn and brake, and where does the train stop?",
            answer=_answer(curves),
            template="studies/etcs.md.jinja",
            values={
                "decelerations": curves.decelerations,
                "limits": curves.table,
                "sentences": list(curves.sentences),
                "national": _given(curves),
            },
            figures={"etcs.png": curves.figure()},
            files={"etcs.csv": lambda path: write_text(path, curves.limits.to_csv(**_CSV))},
            tables={"limits.csv": curves.table, "decelerations.csv": curves.decelerations},
            documented={
                "decelerations": curves.decelerations,
                "limits": curves.table,
                "sentences": bulleted(curves.sentences),
            },
            screen=(curves.decelerations, curves.table, *curves.sentences),
        )

    def headlines(self, work: Work) -> list[Finding]:
        """Return curves and limits of a train file at the highest speed of each."""
        curves = braking_curves(Path("vt642"))
        frame = curves.limits
        last = dict(zip(zip(frame["target"], frame["limit"], strict=True), frame["location_m"], strict=True))
        # Draws are seeded: a thousandth is enough for the arithmetic of another machine.
        return [
            Finding(f"vt642: {limit} of the {target}", -float(last[target, limit]), "m")
            for target, limit in (("EoA", "I"), ("SvL", "EBI"), ("SvL", "EBD"))
        ]


STUDY = Etcs


def _answer(curves: BrakingCurves) -> str:
    last: Mapping[str, Any] = curves.table.rows[-1]
    intervention = last["SBI1" if last["target"] == "EoA" else "EBI"]
    return (
        f"From {last['from']:.0f} km/h, {last['target']}: indication {last['I']:.0f} m, permitted speed "
        f"{last['P']:.0f} m and intervention {intervention:.0f} m before the target."
    )


def _given(curves: BrakingCurves) -> ReportTable:
    rows = [
        {"national value": name, "value": value_text(yes_no(value) if isinstance(value, bool) else value, digits=6)}
        for name, value in curves.case.national.model_dump().items()
    ]
    return ReportTable(rows, left=("national value", "value"))
