"""How well adhesion can be known: the options, page, tables and headline numbers of the study."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated, Any, Final

import numpy as np
from typer import Option

from railgrip.base.errors import InputError
from railgrip.base.names import did_you_mean
from railgrip.campaign.work import Work
from railgrip.report.baseline import Finding, mean
from railgrip.report.marked import write_tables
from railgrip.report.page import Page
from railgrip.report.statistics import finite
from railgrip.studies.estimators.judge import (
    CONSTANT,
    FORCE_BALANCE,
    Results,
    bounds_of,
    by_family,
    consistency,
    errors_of,
    leaderboard,
    others,
    truths_of,
)
from railgrip.studies.estimators.recordings import COUNT, QUICK, SEEDS, RecordingCase, recording_cases
from railgrip.studies.estimators.replay import LAGS, OTHER_MODELS
from railgrip.studies.study import Study

PAGE: Final = Path("docs/estimators_compared.md")
"""From the folder of the project, where the command runs."""

REFERENCES: Final = (CONSTANT, FORCE_BALANCE)
ESTIMATORS: Final = (
    "fmu", "iterated", "unscented", "cubature", "sage_husa", "interacting", "disturbance_observer", *OTHER_MODELS,
    *LAGS,
)  # fmt: skip
"""Estimators besides the references: kinds of a scenario, other predictions, and smoothers."""

FAST: Final = ("fmu", "sage_husa", "interacting", "disturbance_observer", *OTHER_MODELS, *LAGS)
"""Estimators of a quick run: a step of sigma-point filters takes ten times as long."""


@dataclass(frozen=True)
class Estimators(Study):
    """Compare estimators of adhesion, pad friction and speed on the same recordings of simulated stops."""

    estimator: Annotated[
        list[str] | None, Option(help="Kind of estimator, or a smoother; all without it. Repeatable.")
    ] = None
    sealed: Annotated[bool, Option(help="Other cases, for a finished estimator: do not tune on them.")] = False
    count: Annotated[int | None, Option("--cases", min=2, max=1000, help="Number of cases.")] = None
    quick: Annotated[bool, Option(help="Fewer cases, and no slow estimators.")] = False
    write: Annotated[bool, Option("--write", help="Write the tables into docs/estimators_compared.md.")] = False

    def page(self, work: Work) -> Page:
        """Run the estimators over the recordings; the small form has fewer cases and no slow filters."""
        names = self._names()
        if self.write and self.estimator:
            raise InputError("--write is for all estimators; leave out --estimator.")
        count = self.count or (QUICK if self.quick else COUNT)
        design = recording_cases(count, SEEDS["sealed" if self.sealed else "test"])
        results = results_of(work, design, recording_cases(count, SEEDS["training"]), names)
        bound = float(np.median(work.map(bounds_of, design)))
        tables = {
            "leaderboard": leaderboard(results),
            "claims": consistency(results),
            "families": by_family(results, design),
            "others": others(results),
        }
        if self.write:
            write_tables(PAGE, tables)
        best = tables["leaderboard"].rows[0]
        return Page(
            title="How well adhesion can be known",
            question="Which estimator has the smallest error of adhesion, and is its claimed error true?",
            answer=(
                f"The smallest median RMSE of adhesion over {count} recordings is {best['median RMSE']:.4f}, of "
                f"{best['estimator']}. The prediction, if it were true, would permit {bound:.4f}."
            ),
            template="studies/estimators/estimators.md.jinja",
            values=tables | {"count": count, "bound": f"{bound:.4f}"},
            tables={f"{name}.csv": table for name, table in tables.items()},
            data={"estimators.json": _data(results, design)},
            screen=tuple(tables.values()),
        )

    def _names(self) -> tuple[str, ...]:
        """Return the estimators to run, the references first.

        Raises:
            InputError: An estimator does not exist.
        """
        known = (*REFERENCES, *ESTIMATORS)
        for name in self.estimator or ():
            if name not in known:
                hint = did_you_mean(name, known) or f"there are {', '.join(known)}."
                raise InputError(f"--estimator {name}: is unknown; {hint}")
        chosen = self.estimator or (FAST if self.quick else ESTIMATORS)
        return tuple(dict.fromkeys((*REFERENCES, *chosen)))

    def headlines(self, work: Work) -> list[Finding]:
        """Return the errors of adhesion of references and fast filters in two recordings."""
        names = (*REFERENCES, "fmu", "interacting", "disturbance_observer", "disturbed")
        design = recording_cases(2, SEEDS["test"])
        results = results_of(work, design, recording_cases(2, SEEDS["training"]), names)
        return [
            mean(f"{name}: adhesion RMSE", float(np.mean([one.rmse["adhesion"] for one in cases])))
            for name, cases in results.items()
        ]


def results_of(
    work: Work, design: Sequence[RecordingCase], training: Sequence[RecordingCase], names: Sequence[str]
) -> Results:
    """Return the errors of each estimator in each case; the best constants are those of the training set.

    Raises:
        InputError: Two estimators did not get the same readings.
    """
    sums = work.map(truths_of, training)
    constants = tuple(
        (target, sum(one[target][0] for one in sums) / sum(one[target][1] for one in sums)) for target in sums[0]
    )
    cases = [(case, name, constants) for case in design for name in names]
    found = dict(zip([(case, name) for case, name, _ in cases], work.map(errors_of, cases), strict=True))
    for case in design:
        if len({found[case, name].digest for name in names}) > 1:
            raise InputError(f"case {case.stop.name}: the estimators did not get the same readings.")
    return {name: [found[case, name] for case in design] for name in names}


def _data(results: Results, design: Sequence[RecordingCase]) -> list[dict[str, Any]]:
    """Return a row for each case and estimator."""
    rows: list[dict[str, Any]] = []
    for name, cases in results.items():
        for case, errors in zip(design, cases, strict=True):
            about = {"case": case.stop.name, "sensors": case.sensors, "demand": case.demand, "over": case.over}
            values = {
                key: finite(value) if isinstance(value, float) else value for key, value in asdict(errors).items()
            }
            for key in ("rmse", "coverage"):
                values[key] = {target: finite(each) for target, each in getattr(errors, key).items()}
            rows.append(about | {"estimator": name} | values)
    return rows


STUDY = Estimators
