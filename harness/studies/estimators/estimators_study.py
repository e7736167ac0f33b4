"""How well adhesion can be known: the options, page, tables and headline numbers of the study."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Final

import numpy as np
import pandas
from typer import Option

from railgrip.base.errors import InputError
from railgrip.base.names import did_you_mean
from railgrip.base.registry import shelf
from railgrip.base.tables import JsonObject
from railgrip.campaign.work import Work
from railgrip.report.baseline import Finding, mean
from railgrip.report.page import Page
from railgrip.report.table import ReportTable
from railgrip.scenario.file import is_file, locate
from railgrip.studies.estimators.case_errors import (
    SearchCase,
    bounds_of,
    errors_of,
    search,
    search_cases,
    truths_of,
    write_factors,
)
from railgrip.studies.estimators.loop import BEST, compare, compare_table_1, stops_of_table_1, stops_of_type_test
from railgrip.studies.estimators.recordings import (
    COUNT,
    FAMILIES,
    SEEDS,
    TRAINING,
    RecordingCase,
    family_of,
    is_class,
    is_fmu,
    name_of,
    recording_cases,
    require_file,
    require_one_of_each_name,
)  # fmt: skip
from railgrip.studies.estimators.replay import (
    ESTIMATORS,
    FACTORS,
    REFERENCES,
    SEARCHED,
    model_of_estimator,
    read_factors,
)
from railgrip.studies.estimators.tables import (
    ESTIMATIONS,
    available,
    by_family,
    consistency,
    errors_of_estimation,
    errors_of_lateral,
    leaderboard,
    others,
    pads_by_group,
    rank_estimators,
    targets,
    vehicles,
)
from railgrip.studies.study import Study
from railgrip.studies.type_test.case_set import VERSIONS

FACTORS_FILE: Final = Path("harness/studies/estimators/library/noises.toml")
"""From the folder of the project, where the command runs."""


@dataclass(frozen=True)
class Estimators(Study, quick="2 recordings, and no slow estimators", sizes={"cases": 2}):
    """Compare estimators of adhesion, pad friction and speed on the same recordings of simulated stops."""

    documentation = Path("docs/estimators_compared.md")

    estimator: Annotated[
        list[str] | None,
        Option(help="An estimator of the tables, FILE.py:CLASS, or a prediction FILE.fmu; all without it."),
    ] = None
    train: Annotated[
        str | None, Option(help="A train of the library or a train file; the two-part train without it.")
    ] = None
    sealed: Annotated[bool, Option(help="Other cases, for a finished estimator: do not tune on them.")] = False
    cases: Annotated[int | None, Option(min=2, max=1000, help="Number of cases.")] = None
    loop: Annotated[bool, Option("--loop", help="Stop under laws of the type test with other estimates instead.")] = (
        False
    )
    write: Annotated[bool, Option("--write", help="Write the tables into docs/estimators_compared.md.")] = False
    tune: Annotated[
        bool, Option("--tune", help="Search the noises on training cases instead, and write them into this package.")
    ] = False

    def page(self, work: Work) -> Page:
        """Run the estimators over the recordings; the small form has fewer cases and no slow filters."""
        if self.train is not None and (self.write or self.tune):
            raise InputError("--write and --tune are for the two-part train; leave out --train.")
        if self.loop:
            return self._in_loop(work)
        if self.tune:
            return self._tuned(work)
        names = self._names()
        if self.write and self.estimator:
            raise InputError("--write is for all estimators; leave out --estimator.")
        count, train = self.cases or COUNT, self._train()
        design = recording_cases(count, SEEDS["sealed" if self.sealed else "test"], train)
        results = judge(work, design, recording_cases(count, SEEDS["training"], train), names)
        bounds = work.map(bounds_of, design)
        bound, frame = float(np.median([adhesion for adhesion, _ in bounds])), pandas.json_normalize(results)
        ranked = rank_estimators(frame)
        tables = {
            "leaderboard": leaderboard(ranked),
            "claims": consistency(frame),
            "families": by_family(frame),
            "coverage": by_family(frame, "coverage"),
            "available": available(frame),
            "pads": pads_by_group(frame, bounds),
            "others": others(frame),
        }
        if not (self.estimator or train):  # of this project, for its own estimators on its own train
            tables["targets"] = targets(frame, ranked, bound)
        if not (self.estimator or self.quick or train):
            tables["vehicles"] = vehicles_of(work)
        best = ranked.iloc[0]
        return Page(
            title="How well adhesion can be known",
            question="Which estimator has the smallest error of adhesion, and is its claimed error true?",
            answer=(
                f"The smallest median RMSE of adhesion over {count} recordings"
                f"{', too few to rank estimators,' if math.isnan(best['low']) else ''} is {best['median']:.4f}, "
                f"of {best['estimator']}. The prediction, if it were true, would permit {bound:.4f}."
            ),
            template="studies/estimators/estimators.md.jinja",
            values={"vehicles": "", "targets": ""}
            | tables
            | {"count": count, "bound": f"{bound:.4f}", "train": Path(train).stem if train else ""}
            | {"limits": model_of_estimator("fmu", train).limits},
            tables={f"{name}.csv": table for name, table in tables.items()},
            data={"estimators.json": results},
            documented=tables,
            screen=tuple(tables.values()),
        )

    @property
    def place(self) -> str:
        """Folder of results, a different one for each train and for stops with other estimates."""
        return "loop" if self.loop else "" if self.train is None else Path(self.train).stem

    def _train(self) -> str:
        """Return the name of the train in the library, or the path of its file; '' for the two-part train."""
        if self.train is None:
            return ""
        path = locate(self.train, "trains", where="--train: ")
        return str(path.resolve()) if is_file(path) and self.train not in shelf("trains") else self.train

    def _in_loop(self, work: Work) -> Page:
        """Compare stops of the type test and of Table 1 with other estimates."""
        if self.estimator or self.train is not None or self.sealed or self.tune:
            raise InputError("--loop compares the same estimates in the same cases; leave out other options.")
        count = self.cases or VERSIONS[2].small
        tables = {
            "loop": compare(stops_of_type_test(work, count)),
            "loop_table_1": compare_table_1(stops_of_table_1(work)),
        }
        disturbed = [f"{row['median']} with {row['law']}" for row in tables["loop"].rows if row["estimates"] == BEST]
        return Page(
            title="Estimators in the loop",
            question="Does a better estimate shorten the stop?",
            answer=f"Median distance over that with the present estimates: {', '.join(disturbed)}, for {BEST}.",
            template="studies/estimators/loop.md.jinja",
            values=tables | {"count": count},
            tables={f"{name}.csv": table for name, table in tables.items()},
            documented=tables,
            screen=tuple(tables.values()),
        )

    def _tuned(self, work: Work) -> Page:
        """Search the noises of estimators on the training cases, and write them."""
        cases = self._searches()
        pairs = [(name, sensors) for name, sensors, _ in cases]
        found = dict(zip(pairs, work.map(search, cases), strict=True))
        write_factors(FACTORS_FILE, read_factors(FACTORS_FILE) | found)
        rows = [{"estimator": name, "sensors": sensors} | factors for (name, sensors), factors in found.items()]
        table = ReportTable(rows, dict.fromkeys(FACTORS, "{:.4g}"), title="Factors of standard deviations")
        return Page(
            title="Noises of the estimators",
            question="Which noises give the narrowest intervals of 95 % on the training cases?",
            answer=f"The factors are in {FACTORS_FILE}.",
            template="studies/estimators/factors.md.jinja",
            values={"factors": table},
            screen=(table,),
        )

    def _searches(self) -> list[SearchCase]:
        """Return the searches of `--tune`.

        Raises:
            InputError: Options contradict each other, a class of sensors has no case, or the file of noises is missing.
        """
        if self.write or self.quick or self.sealed:
            raise InputError("--tune searches on the training cases; leave out --write, --quick and --sealed.")
        unknown = [name for name in self.estimator or () if name not in SEARCHED]
        if unknown:
            raise InputError(f"--estimator {unknown[0]}: --tune searches the noises of {', '.join(SEARCHED)}.")
        cases = search_cases(recording_cases(self.cases or TRAINING, SEEDS["training"]), self.estimator or SEARCHED)
        empty = sorted({sensors for _, sensors, of_sensors in cases if not of_sensors})
        if empty:
            raise InputError(f"--cases {self.cases}: no training case has {empty[0]} sensors; --tune needs more cases.")
        if not FACTORS_FILE.is_file():
            raise InputError(f"--tune writes {FACTORS_FILE}, which is not here; run it in the folder of the project.")
        return cases

    def _names(self) -> tuple[str, ...]:
        """Return the estimators to run, the references first.

        Raises:
            InputError: An estimator does not exist.
        """
        known = [name for name, entry in ESTIMATORS.items() if self.train is None or entry.of_train is not None]
        for name in self.estimator or ():
            if is_class(name) or is_fmu(name):
                require_file(name)
            elif name not in known:
                hint = did_you_mean(name, known) or f"there are {', '.join(known)}."
                raise InputError(f"--estimator {name}: is unknown; {hint}")
        require_one_of_each_name(self.estimator or ())
        chosen = self.estimator or [name for name in known if ESTIMATORS[name].is_fast or not self.quick]
        return tuple(dict.fromkeys((*REFERENCES, *chosen)))

    def headlines(self, work: Work) -> list[Finding]:
        """Return errors of adhesion of references and fast filters in two recordings, and the coverage of the EKF."""
        names = (*REFERENCES, "fmu", "interacting", "disturbance_observer", "disturbed")
        design = recording_cases(2, SEEDS["test"])
        frame = pandas.json_normalize(judge(work, design, recording_cases(2, SEEDS["training"]), names))
        errors = frame.groupby("estimator", sort=False).agg({"rmse.adhesion": "mean", "coverage.adhesion": "mean"})
        return [
            *(
                mean(f"{name}: adhesion RMSE", rmse)
                for name, rmse in zip(errors.index, errors["rmse.adhesion"], strict=True)
            ),
            mean("fmu: adhesion coverage", float(errors["coverage.adhesion"].loc["fmu"])),
        ]


def vehicles_of(work: Work) -> ReportTable:
    """Return the table of the filters of wagon, roller rig and lateral wheelset."""
    found = [*work.map(errors_of_estimation, ESTIMATIONS), *work.map(errors_of_lateral, [SEEDS["test"]])]
    return vehicles(pandas.concat(found))


def judge(
    work: Work, design: Sequence[RecordingCase], training: Sequence[RecordingCase], names: Sequence[str]
) -> list[JsonObject]:
    """Return for each estimator and case their names, its families, and the errors; see `errors_of`.

    The best constants are those of the training set.

    Raises:
        InputError: Two estimators did not get the same readings.
    """
    sums = work.map(truths_of, training)
    constants = tuple(
        (target, sum(one[target][0] for one in sums) / sum(one[target][1] for one in sums)) for target in sums[0]
    )
    cases = [(case, name, constants) for case in design for name in names]
    own = [case for case in cases if is_class(case[1]) or is_fmu(case[1])]
    built_in = [case for case in cases if case not in own]
    # Code of a user may change between two runs.
    errors = [*work.map(errors_of, built_in), *work.map(errors_of, own, keep=False)]
    found = dict(zip([(case, name) for case, name, _ in (*built_in, *own)], errors, strict=True))
    for case in design:
        if len({found[case, name]["digest"] for name in names}) > 1:
            raise InputError(f"case {case.stop.name}: the estimators did not get the same readings.")
    return [
        {"case": case.stop.name, "over": case.over}
        | {field: family_of(case, field) for field in FAMILIES}
        | {"estimator": name_of(name)}
        | found[case, name]
        for name in names
        for case in design
    ]


STUDY = Estimators
