"""The type test: its options, the stops that it runs, its documentation, and headline numbers."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import Annotated, Any, Final

import numpy as np
import pandas
from typer import Option

from railgrip.base.errors import ScenarioError
from railgrip.base.names import did_you_mean
from railgrip.campaign.run import CampaignRun, write_description
from railgrip.campaign.work import Work
from railgrip.report.baseline import Finding, mean
from railgrip.report.frame import Frame
from railgrip.report.index import write_report as write_panels
from railgrip.report.limits import limits_of
from railgrip.report.page import Page
from railgrip.report.results import read_results
from railgrip.report.statistics import endless
from railgrip.report.table import ReportTable, write_tables
from railgrip.scenario.schema import Scenario
from railgrip.scenario.table import Custom
from railgrip.simulate.run import run_stop
from railgrip.simulate.user_parts import CustomParts, class_of
from railgrip.studies.study import Study
from railgrip.studies.type_test.case_set import (
    SEALED,
    VERSIONS,
    AnyCase,
    CaseSet,
    case_named,
    count_look,
    table_of_looks,
)  # fmt: skip
from railgrip.studies.type_test.entrants import (
    LIBRARY,
    Entrant,
    campaign_of,
    controller_digest,
    entrants,
    entrants_named,
    task_of,
    train_of,
    training_cases,
    trains_of,
)
from railgrip.studies.type_test.page import page_of
from railgrip.studies.type_test.stop_frames import (
    frame_of_rows,
    keeps_lock,
    measure,
    read_shipped,
    write_shipped,
)
from railgrip.studies.type_test.track_case import HEADLINES, TrackCase

PAGE: Final = Path("docs/type_test.md")
"""Folder relative to that of the project, in which the command runs."""


@dataclass(frozen=True)
class TypeTest(Study, quick="2 cases", sizes={"cases": 2}, whole=("case",)):
    """Stop a train in hundreds of cases under each controller, judge every stop, and rank them."""

    controller: Annotated[
        list[str] | None,
        Option(help="A packaged entrant, a scenario, an .fmu or module:Class; all packaged ones unless given."),
    ] = None
    train: Annotated[
        str | None, Option(help="A scenario whose train it is, a train, an .fmu or a recipe; ours without it.")
    ] = None
    task: Annotated[
        Path | None, Option(help="A scenario whose demand and [adhesion.conditioning] hold in every case.")
    ] = None
    against: Annotated[
        str | None, Option(help="A controller of the test: distances of the others over its own, case by case.")
    ] = None
    validation: Annotated[bool, Option(help="Other cases, for a finished controller: do not tune on them.")] = False
    cases: Annotated[int | None, Option(min=1, max=10000, help="Number of cases.")] = None
    version: Annotated[
        int | None,
        Option(min=1, max=2, help="Version of the cases, 1 by default; 2: rails over distance."),
    ] = None
    sealed: Annotated[
        bool, Option("--sealed", help="Cases drawn from the digest of one controller, which nobody has tuned on.")
    ] = False
    case: Annotated[list[str] | None, Option(help="Only this one, with trace and panels. Repeatable.")] = None
    shipped: Annotated[bool, Option("--shipped", help="Judge the stops that come with the package, and run none.")] = (
        False
    )
    limits: Annotated[Path | None, Option(help="File of limits instead of the package's.")] = None
    write: Annotated[
        bool,
        Option(
            "--write", help="Write the leaderboard into docs/type_test.md, and stops that were run into the package."
        ),
    ] = False
    import_from: list[Path] | None = None

    @property
    def place(self) -> str:
        """Folder of results: a different one for each version after the first, train, task, and for single cases."""
        names = [Path(file).stem for file in (self.train, self.task) if file is not None]
        if self._version > 1:
            names.insert(0, f"version_{self._version}")
        return "/".join([*names, "cases"] if self.case else names)

    @property
    def _version(self) -> int:
        return max(self.version or 1, *(found.version for name in self.case or () if (found := CaseSet.of(name))), 1)

    def page(self, work: Work) -> Page:
        """Run missing stops, judge all stops, and rank the controllers."""
        self._require_consistent()
        judging, ours = limits_of(self.limits), entrants(self._version)
        known = entrants(max(VERSIONS)) | ours
        candidates = ours if self.controller is None else entrants_named(self.controller, known)
        taking_part = ours | candidates
        if self.against is not None and self.against not in taking_part:
            raise ScenarioError(
                f"--against {self.against}: is not one of {', '.join(taking_part)}"
                + did_you_mean(self.against, taking_part, before="; ")
            )
        for kind in (str(one.tables["controller"]["kind"]) for one in candidates.values()):
            if ":" in kind:
                class_of(Custom(kind=kind), "controllers", self.import_from or ())
        digests = {name: controller_digest(one, self.import_from or ()) for name, one in candidates.items()}
        design = self._design(digests)
        named = candidates if self.controller is not None else {}
        campaign = campaign_of(
            design,
            named if self.shipped else taking_part,
            train_of(self.train),
            trains=trains_of(design),
            task=None if self.task is None else task_of(self.task),
            keep_traces=bool(self.case),
        )
        running = set(named) if self.shipped else self._running(ours, candidates)
        stops = campaign.only(lambda stop: stop.variants["controller"] in running)
        runner = partial(run_stop, objects=CustomParts(folders=tuple(self.import_from or ())))
        exit_code = work.stops(
            [CampaignRun(stops, work.folder)], runner, import_from=self.import_from or (), is_any_outcome=True
        )
        write_description(campaign, work.folder)
        results = read_results(work.folder)
        found = measure(results.stops)
        is_compared = (self.controller is not None or self.shipped) and not self.task
        packaged, notes = read_shipped(design, train_of(self.train)) if is_compared else (frame_of_rows([]), [])
        page = page_of(
            found,
            taking_part,
            judging,
            packaged=packaged,
            notes=notes,
            candidates=[] if self.shipped else list(named),
            missing=[name for name in results.missing if name.rpartition("-")[2] in set(found["controller"])],
            against=self.against,
            again=self._again(candidates),
            looks=self._looks(design, digests),
            version=self._version,
        )
        if self.write:
            # A bound that is not found leaves its case without a bound.
            # Others than the baselines are not run in a sealed set.
            required = {name for name in running if taking_part[name].role != "bound"}
            missing = [name for name in results.missing if name.rpartition("-")[2] in required]
            if missing:
                raise ScenarioError(f"--write: {len(missing)} stops have no result; nothing was written.")
            kept = packaged[~packaged["controller"].isin(running)] if self.shipped else packaged.head(0)
            self._write(page, pandas.concat([kept, found], ignore_index=True) if len(kept) else found, design)
        panels = [
            str(write_panels(work.folder / stop.name))
            for stop in (stops.stops if self.case else ())
            if stop.variants["controller"] in candidates and (work.folder / stop.name / "trace.nc").exists()
        ]
        page = _without_cases(page) if self.sealed else page
        return replace(page, screen=(*page.screen, *panels), exit_code=exit_code)

    def _require_consistent(self) -> None:
        _require_one_of({"--case": self.case, "--cases": self.cases})
        _require_one_of({"--case": self.case, "--sealed": self.sealed, "--validation": self.validation})
        if self.shipped and (self.sealed or self.train or self.task or self.case):
            raise ScenarioError("--shipped is for sets of cases of the package on its train; leave out other options.")
        one = self.controller and not self.sealed and not self.shipped
        if self.write and (one or self.train or self.task or self.case or self.limits):
            raise ScenarioError("--write is for all controllers of railgrip on its train; leave out other options.")
        if self.sealed and len(self.controller or ()) != 1:
            raise ScenarioError("--sealed is for one --controller; name one.")

    def _design(self, digests: Mapping[str, str]) -> tuple[AnyCase, ...]:
        """Return the cases; those with --train have its train in place of the trains of the library."""
        version = VERSIONS[self._version]
        count = self.cases or (SEALED if self.sealed else version.count)
        if self.case:
            design = tuple(case_named(name) for name in self.case)
        elif self.sealed:
            design = version.design(count, CaseSet.sealed(self._version, *digests.values(), count=count).seed)
        else:
            design = version.design(count, version.validation if self.validation else version.test)
        if self.train is None:
            return design
        return tuple(replace(case, train="") if isinstance(case, TrackCase) else case for case in design)

    def _running(self, ours: Mapping[str, Entrant], candidates: Mapping[str, Entrant]) -> set[str]:
        """Return the names of those who are run; stops of other controllers come from earlier runs.

        References are run, too, and in a sealed set, which nobody has run, the baselines.
        """
        roles = {"reference", "bound", *(["baseline"] if self.sealed else [])}
        return {name for name, entrant in ours.items() if entrant.role in roles} | candidates.keys()

    def _looks(self, design: Sequence[AnyCase], digests: Mapping[str, str]) -> ReportTable | None:
        """Count a look at the set of the cases, and return the table of looks; None in version 1."""
        case_set = CaseSet.of(design[0].name)
        if self._version == 1 or case_set is None:
            return None
        return table_of_looks(count_look(case_set.label, digests.values()), case_set.label)

    def _write(self, page: Page, found: Frame, design: Sequence[AnyCase]) -> None:
        """Write tables of the documentation, and stops that were run into the package; of a sealed set one table."""
        kind = "sealed" if self.sealed else "validation" if self.validation else "test"
        of = f"{len(design)} cases of the {kind} set, railgrip {version('railgrip')}:\n\n"
        if self.sealed:
            results = {name: page.values["of_controller"][name] for name in self.controller or ()}
            write_tables(PAGE, {f"sealed set of {name}": f"{of}{table}" for name, table in results.items()})
            return
        if not self.shipped:  # else the stops of an earlier release would bear the name of this one
            write_shipped(found, design, train_of(None), LIBRARY)
        is_small = self.cases == VERSIONS[self._version].small
        values, suffix = page.values, "" if self._version == 1 else f" of version {self._version}"
        leaders = values["leaders"].without(["K_wet (10 %)", *(["compared"] if self._version == 1 else [])])
        tables: dict[str, ReportTable | str] = {"leaderboard": f"{of}{leaders}"}
        if self._version > 1:
            tables |= {name: f"{of}{values[name]}" for name in ("verdict", "recommendation")}
        if self._version > 1 and not is_small:
            best = values["losses"].rows[0]["controller"]
            tables |= {
                "run": " ".join(values["unranked"]) or "All laws were run in at least half of the cases.",
                "losses": f"{of}{values['losses']}",
                "looks": values["looks"],
                "families": f"{of}{best}:\n\n{values['of_controller'][best]}",
            }
        if self._version == 1 or not is_small:
            tables["controllers"] = values["controllers"].without(("results",))
        else:
            suffix += ", small set"
        write_tables(PAGE, {f"{name}{suffix}": table for name, table in tables.items()})

    def _again(self, candidates: Iterable[str]) -> dict[str, str]:
        options = [
            ("train", self.train),
            ("task", self.task),
            *(("import-from", one) for one in self.import_from or ()),
        ]
        rest = "".join(f" --{name} {value}" for name, value in options if value is not None)
        arguments = dict(zip(candidates, dict.fromkeys(self.controller or ()), strict=False))
        return {
            name: f"railgrip study type_test --controller {arguments.get(name, name)}{rest} --case"
            for name in (*entrants(max(VERSIONS)), *candidates)
        }

    def headlines(self, work: Work) -> list[Finding]:
        """Return quantiles of the distance over the best tuned baseline's, in six short cases of the training set.

        As in the leaderboard, a baseline that does not stop or does not keep the lock clause does not count. Of version
        2 there are the distances of three laws in single training cases.
        """
        taking_part = {name: entrants()[name] for name in ("constant_slip", "extremum_seeking", "slope_seeking")}
        stops = campaign_of(training_cases(6), taking_part, train_of(None)).stops
        results = work.map(_distance_and_lock, [stop.scenario for stop in stops])
        distances, keeps_lock_clause = np.array(results).reshape(-1, len(taking_part), 2).transpose(2, 0, 1)
        baselines = np.where(keeps_lock_clause, distances, math.inf)[:, :-1].min(axis=1)
        is_compared = np.isfinite(baselines)
        ratios, count = distances[is_compared, -1] / baselines[is_compared], int(is_compared.sum())
        who = "slope seeking, distance over that of the better tuned baseline"
        return [
            mean(f"{who}: median of {count}", float(np.median(ratios))),
            mean(f"{who}: worst of {count}", float(max(ratios))),
            *self._distances_of_version_2(work),
        ]

    def _distances_of_version_2(self, work: Work) -> list[Finding]:
        """Return the distances of three laws in `HEADLINES`."""
        taking_part = {name: entrants(2)[name] for name in ("slope_seeking", "slip_three_state_deep", "two_maxima")}
        stops = campaign_of(HEADLINES, taking_part, train_of(None)).stops
        results = work.map(_distance_and_lock, [stop.scenario for stop in stops])
        return [
            mean(f"version 2, {stop.variants['case']}: {stop.variants['controller']}", distance, "m")
            for stop, (distance, _) in zip(stops, results, strict=True)
        ]


STUDY = TypeTest


def _require_one_of(options: Mapping[str, Any]) -> None:
    given = [option for option, value in options.items() if value]
    if len(given) > 1:
        raise ScenarioError(f"{' and '.join(given)}: each of them chooses the cases; leave out all but one.")


def _distance_and_lock(scenario: Scenario) -> tuple[float, bool]:
    stop = run_stop(scenario)
    return endless(stop.braking_distance), keeps_lock(stop.metrics.of_train("longest_lock_fast"), limits_of())


def _without_cases(page: Page) -> Page:
    """Return the page of a sealed set, on which no single case can be tuned on."""
    data = {
        name: {key: value for key, value in content.items() if key != "cases"} for name, content in page.data.items()
    }
    tables = {name: table for name, table in page.tables.items() if name != "cases.csv"}
    return replace(page, values={**page.values, "worst": [], "rankings": {}}, tables=tables, data=data)
