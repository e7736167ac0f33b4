"""The type test: its options, its page, JSON and CSV, and headline numbers."""

import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import Annotated, Any, Final

import numpy as np
import pandas
from matplotlib.figure import Figure
from scipy.ndimage import median_filter
from typer import Option

from railgrip.base import registry
from railgrip.base.errors import ScenarioError
from railgrip.base.names import did_you_mean
from railgrip.campaign.run import CampaignRun, write_description
from railgrip.campaign.work import Work
from railgrip.report import palette, style
from railgrip.report.baseline import Finding, mean
from railgrip.report.frame import Frame
from railgrip.report.index import write_report as write_panels
from railgrip.report.limits import AssessmentLimits, limits_of
from railgrip.report.marked import write_tables
from railgrip.report.page import Page
from railgrip.report.results import Results, read_results
from railgrip.report.table import ReportTable, names, percent, share
from railgrip.scenario.campaign import Campaign
from railgrip.scenario.outcome import Outcome
from railgrip.scenario.schema import Scenario
from railgrip.simulate.run import run_stop
from railgrip.simulate.user_parts import CustomParts
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
from railgrip.studies.type_test.design import VALIDATION_SEED
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
from railgrip.studies.type_test.family import (
    by_axis,
    families,
    losses,
    recommendation,
    table_of_controller,
    table_of_families,
    verdict,
)
from railgrip.studies.type_test.judge import (
    EQUAL,
    JUDGED,
    frame_of_rows,
    judgements,
    keeps_lock,
    measure,
    over_best,
    plain_rows,
    read_shipped,
    summaries,
    write_shipped,
)
from railgrip.studies.type_test.track_case import HEADLINES, TrackCase

PAGE: Final = Path("docs/type_test.md")
"""Folder relative to that of the project, in which the command runs."""

_ON_PAGE_ONLY: Final = ("compared", "K_wet (10 %)")
"""Columns of the leaderboard that are omitted there and on the screen."""
_NOT_OF_STOPS: Final = ("NEES (10 – 90 %)", "K_wet (10 %)")
"""Columns of the leaderboard that are in a separate table on the page."""

_WORST: Final = 10
_JSON: Final = ("case", "controller", "tuned", "outcome", "distance_m", "bound_m", "longest_lock_s", "air_l", "strokes")
"""Columns that come first in the table of cases."""


@dataclass(frozen=True)
class TypeTest(Study):
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
    quick: Annotated[bool, Option(help="A tenth of the cases, for a first result.")] = False
    validation: Annotated[bool, Option(help="Other cases, for a finished controller: do not tune on them.")] = False
    count: Annotated[int | None, Option("--cases", min=1, max=10000, help="Number of cases.")] = None
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
        bool, Option("--write", help="Write the leaderboard into docs/type_test.md, and the stops into the package.")
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
        known = entrants(max(VERSIONS))
        candidates = ours if self.controller is None else entrants_named(self.controller, known)
        taking_part = ours | candidates
        if self.against is not None and self.against not in taking_part:
            raise ScenarioError(
                f"--against {self.against}: is not one of {', '.join(taking_part)}"
                + did_you_mean(self.against, taking_part, before="; ")
            )
        digests = {name: controller_digest(one, self.import_from or ()) for name, one in candidates.items()}
        design = self._design(digests)
        named = candidates if self.controller is not None else {}
        campaign = self._campaign(design, named if self.shipped else taking_part)
        running = set(named) if self.shipped else self._running(ours, candidates)
        stops = campaign.only(lambda stop: stop.variants["controller"] in running)
        runner = partial(run_stop, objects=CustomParts(folders=tuple(self.import_from or ())))
        exit_code = work.stops([CampaignRun(stops, work.folder)], runner, is_any_outcome=True)
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
            missing=_missing(results),
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
        _require_one_of({"--case": self.case, "--cases": self.count, "--quick": self.quick})
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
        count = self.count or (version.quick if self.quick else SEALED if self.sealed else version.count)
        if self.case:
            design = tuple(case_named(name) for name in self.case)
        elif self.sealed:
            design = version.design(count, CaseSet.sealed(self._version, *digests.values(), count=count).seed)
        else:
            design = version.design(count, version.validation if self.validation else version.test)
        if self.train is None:
            return design
        return tuple(replace(case, train="") if isinstance(case, TrackCase) else case for case in design)

    def _campaign(self, design: Sequence[AnyCase], taking_part: Mapping[str, Entrant]) -> Campaign:
        """Return the stops of all who take part in the cases."""
        return campaign_of(
            design,
            taking_part,
            train_of(self.train),
            trains=trains_of(design),
            task=None if self.task is None else task_of(self.task),
            keep_traces=bool(self.case),
        )

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
        """Write the tables of the page of documentation, and the stops into the package; of a sealed set one table."""
        kind = "sealed" if self.sealed else "validation" if self.validation else "test"
        of = f"{len(design)} cases of the {kind} set, railgrip {version('railgrip')}:\n\n"
        if self.sealed:
            results = {name: page.values["of_controller"][name] for name in self.controller or ()}
            write_tables(PAGE, {f"sealed set of {name}": f"{of}{table}" for name, table in results.items()})
            return
        write_shipped(found, design, train_of(None), LIBRARY)
        controllers = page.values["controllers"].without(("results",))
        leaders = page.values["leaders"].without(["K_wet (10 %)", *(["compared"] if self._version == 1 else [])])
        tables: dict[str, ReportTable | str] = {"controllers": controllers, "leaderboard": f"{of}{leaders}"}
        suffix = "" if self._version == 1 else f" of version {self._version}"
        if self._version > 1:
            of_laws = page.values["of_controller"]
            run = " ".join(page.values["unranked"]) or "All laws were run in at least half of the cases."
            best = page.values["losses"].rows[0]["controller"]
            by_rail: dict[str, ReportTable | str] = {
                "verdict": f"{of}{page.values['verdict']}",
                "recommendation": f"{of}{page.values['recommendation']}",
                "leaderboard": tables["leaderboard"],
            }
            if self.quick:
                tables, suffix = by_rail, f"{suffix}, quick set"
            else:
                tables |= by_rail | {
                    "run": run,
                    "losses": f"{of}{page.values['losses']}",
                    "looks": page.values["looks"],
                }
                tables["families"] = f"{of}{best}:\n\n{of_laws[best]}"
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
    distance = stop.metrics.distance if stop.outcome is Outcome.STANDSTILL else math.inf
    return distance, keeps_lock(stop.metrics.of_train("longest_lock_fast"), limits_of())


def _missing(results: Results) -> list[str]:
    present = {result.variants["controller"] for result in results.stops}
    return [name for name in results.missing if name.rpartition("-")[2] in present]


def _without_cases(page: Page) -> Page:
    """Return the page of a sealed set, on which no single case can be tuned on."""
    data = {
        name: {key: value for key, value in content.items() if key != "cases"} for name, content in page.data.items()
    }
    tables = {name: table for name, table in page.tables.items() if name != "cases.csv"}
    return replace(page, values={**page.values, "worst": [], "rankings": {}}, tables=tables, data=data)


def page_of(
    found: Frame,
    taking_part: Mapping[str, Entrant],
    limits: AssessmentLimits,
    *,
    packaged: Frame | None = None,
    notes: Sequence[str] = (),
    candidates: Sequence[str] = (),
    missing: Sequence[str] = (),
    against: str | None = None,
    again: Mapping[str, str],
    looks: ReportTable | None = None,
    version: int = 1,
) -> Page:
    """Return the page of a type test.

    Args:
        found: Stops that were run; a controller without a stop is omitted.
        taking_part: Entrants by name.
        limits: Limits of the clauses.
        packaged: Packaged stops of controllers that were not run.
        notes: Sentences on the packaged stops.
        candidates: Controllers that the page is about; all if empty.
        missing: Names of stops without a result.
        against: Controller with which the others are compared case by case on the screen.
        again: Controller → command line that runs a case of it again, without the name of the case.
        looks: How often sets of cases were looked at.
        version: Version of the type test.
    """
    stops, shipped = found, set[str]()
    if packaged is not None and len(packaged):
        run = set(zip(found["case"], found["controller"], strict=True))
        is_run = [pair in run for pair in zip(packaged["case"], packaged["controller"], strict=True)]
        others = packaged[~np.array(is_run)]
        stops, shipped = pandas.concat([found, others] if len(found) else [others]), set(others["controller"])
    stops = judgements(stops, taking_part, limits, only_tuned=version == 1)
    board, unranked = ranked(summaries(stops, taking_part), candidates)
    notes = [*notes, *unranked]
    of_ranked = stops[stops["controller"].isin(board["controller"] if len(board) else [])]
    plain = [{name: row[name] for name in _JSON} | row for row in plain_rows(stops)]
    drawings = _drawings(stops, _lines(board, candidates))
    rows = families(stops) if version > 1 else board.head(0)
    return Page(
        title="Type test of wheel-slide protection",
        question=f"{f'How does {names(candidates)} compare with' if candidates else 'Which is the shortest of'} the "
        "stops of railgrip's controllers in cases that none was tuned on, and which clauses of a type test are kept?",
        answer=answer(board, stops["case"].nunique(), limits, candidates),
        template="studies/type_test/type_test.md.jinja",
        values={
            **_values(stops, board, limits),
            **_values_of_families(rows, board),
            "verdict": verdict(of_ranked) if version > 1 else "",
            "recommendation": recommendation(of_ranked) if version > 1 else None,
            "version": version,
            "looks": looks,
            "controllers": _controllers(board, shipped, taking_part, version),
            "captions": {f"figures/{name}.png": caption for name, caption, _ in drawings},
            "worst": [
                (summary, worst(stops, summary.controller, again[summary.controller]))
                for summary in board.itertuples()
                if not candidates or summary.controller in candidates
            ],
            "missing": names(missing),
            "notes": notes,
            "unranked": unranked,
        },
        figures={f"figures/{name}.png": drawing for name, _, drawing in drawings if len(stops) and drawing},
        tables={"cases.csv": table_of(stops)} | ({"families.csv": table_of_families(rows)} if len(rows) else {}),
        data={
            "type_test.json": {
                "cases": plain,
                "summary": {row["controller"]: row for row in board.to_dict("records")},
                "limits": limits.model_dump(mode="json"),
            }
        },
        screen=(
            leaderboard(board).without(_ON_PAGE_ONLY),
            *notes,
            *([compare_controllers(plain, against)] if against else ()),
        ),
    )


def ranked(board: Frame, candidates: Collection[str]) -> tuple[Frame, list[str]]:
    """Return the controllers to rank, and a sentence on each that was run in fewer than half of the cases.

    Quantiles over different cases are not comparable. Candidates and controllers that know the true state, which have
    no stop in many cases, are listed in any case.
    """
    if board.empty:
        return board, []
    most = board["cases"].max()
    is_kept = (2 * board["cases"] >= most) | board["controller"].isin([*candidates, *registry.ANALYSES])
    sentences = [
        f"{one.controller} was run in {one.cases} of {most} cases and is not ranked."
        for one in board[~is_kept].itertuples()
    ]
    return board[is_kept], sentences


def _drawings(stops: Frame, lines: Mapping[str, Mapping[str, Any]]) -> tuple[tuple[str, str, Figure | None], ...]:
    return (
        (
            "ratios",
            "Distance over that of the best tuned baseline in the same case that keeps the lock clause",
            _ratios(stops, lines),
        ),
        ("utilisation", "Use of the adhesion there was, by creep curve", _by_curve(stops, list(lines))),
        ("friction", "Distance over the ideal bound against friction", _over_friction(stops, lines)),
    )


def _values(stops: Frame, board: Frame, limits: AssessmentLimits) -> dict[str, object]:
    leaders, variants_of = leaderboard(board), dict(zip(stops["case"], stops["variants"], strict=True))
    return {
        "leaders": leaders,
        "board": leaders.without(_NOT_OF_STOPS),
        "estimates": leaders.without([name for name in leaders.columns[1:] if name not in _NOT_OF_STOPS]),
        "clauses": clauses(board, limits),
        "failed_by_bound": failed_by_bound(board, limits),
        "texts": {_heading(clause, limits): getattr(limits, clause).clause for clause in JUDGED},
        "count": len(variants_of),
        "is_validation": any(case.endswith(f"-{VALIDATION_SEED}") for case in variants_of),
        "rankings": {case: (variants, ranking(stops, case)) for case, variants in variants_of.items()},
        "supply": limits.supply,
    }


def _values_of_families(rows: Frame, board: Frame) -> dict[str, object]:
    """Return the variables of the template for families of cases."""
    of_controller = {summary.controller: table_of_controller(rows, summary) for summary in board.itertuples()}
    laws = board[~board["controller"].isin(list(registry.ANALYSES))] if len(board) else board
    return {"losses": losses(rows, laws), "families": by_axis(rows, board), "of_controller": of_controller}


def table_of(stops: Frame) -> ReportTable:
    """Return every stop as a row of a table."""
    rows: list[dict[str, object]] = []
    for plain in plain_rows(stops):
        verdicts, variants = plain.pop("verdicts"), plain.pop("variants")
        rows.append(plain | variants | {f"keeps_{clause}": verdict for clause, verdict in verdicts.items()})
    return ReportTable(rows)


def compare_controllers(cases: Sequence[Mapping[str, Any]], against: str) -> ReportTable:
    """Return the additional distance of the others in comparison with one controller in the same cases, as in
    type_test.json.

    Only cases in which both stop are compared; differences are positive if a stop is longer.
    """
    distances: dict[str, dict[str, float | None]] = {}
    for row in cases:
        distances.setdefault(row["controller"], {})[row["case"]] = row["distance_m"]
    rows: list[dict[str, object]] = []
    reference = distances.pop(against, {})
    for name, others in distances.items():
        pairs = np.array([(d, reference[case]) for case, d in others.items() if d and reference.get(case)])
        if not pairs.size:
            continue
        ratios, metres = pairs[:, 0] / pairs[:, 1], pairs[:, 0] - pairs[:, 1]
        rows.append(
            {
                "controller": name,
                "both stop": len(pairs),
                "shorter": int(np.sum(ratios < 1 - EQUAL)),
                "longer": int(np.sum(ratios > 1 + EQUAL)),
                "least": ratios.min(),
                "median": np.median(ratios),
                "mean": ratios.mean(),
                "most": ratios.max(),
                "shortened most": metres.min(),
                "in the mean": metres.mean(),
                "lengthened most": metres.max(),
            }
        )
    relative, metric = ("least", "median", "mean", "most"), ("shortened most", "in the mean", "lengthened most")
    forms = {column: "{:.3f}" if column in relative else "{:+.1f} m" for column in (*relative, *metric)}
    return ReportTable(rows, forms, ("controller",), f"Distance over that of {against}, case by case")


def leaderboard(board: Frame) -> ReportTable:
    """Return the controllers, shortest first."""
    rows = [
        {
            "controller": summary.controller,
            "stops": summary.stops,
            "compared": f"{summary.compared} of {summary.cases}",
            "median": _with_interval(summary.median, summary.median_interval),
            "95 %": _with_interval(_or_endless(summary.p95, summary.median), summary.p95_interval),
            "worst": _or_endless(summary.worst, summary.median),
            "over bound": summary.over_bound,
            "utilisation": summary.utilisation,
            "longest lock": summary.longest_lock_s,
            "air": summary.air,
            "strokes": summary.strokes,
            "NEES (10 – 90 %)": ""
            if summary.nees is None
            else f"{summary.nees:.2g} ({summary.nees_low:.2g} – {summary.nees_high:.2g})",
            "K_wet (10 %)": ""
            if summary.k_wet is None
            else f"{summary.k_wet:.2f}"
            + ("" if summary.k_wet_low is None else f" [{summary.k_wet_low:.2f}, {summary.k_wet_high:.2f}]"),
        }
        for summary in board.itertuples()
    ]
    forms = dict.fromkeys(("worst", "over bound", "air", "strokes"), "{:.3f}")
    return ReportTable(
        rows, forms | {"stops": share, "utilisation": "{:.2f}", "longest lock": "{:.2f} s"}, ("controller",)
    )


def _controllers(
    board: Frame, from_package: Collection[str], taking_part: Mapping[str, Entrant], version: int
) -> ReportTable:
    """Return a description of each controller, and whether its stops were run or come with the package."""

    def trials(name: str) -> dict[str, object]:
        count = taking_part[name].hand_trials
        is_law = name not in registry.ANALYSES
        return {"sets tried by hand": count if count is not None else "not counted" if is_law else ""}

    rows = [
        {
            "controller": summary.controller,
            "description": summary.description,
            "parameters searched": "yes" if summary.tuned else "",
            **(trials(summary.controller) if version > 1 else {}),
            "results": "shipped" if summary.controller in from_package else "run here",
        }
        for summary in board.itertuples()
    ]
    return ReportTable(rows, left=("controller", "description", "parameters searched", "results"))


def _or_endless(value: float | None, median: float | None) -> float | str | None:
    return "no stop" if value is None and median is not None else value


def _with_interval(value: float | str | None, interval: tuple[float | None, float | None]) -> str:
    text = "" if value is None else value if isinstance(value, str) else f"{value:.3f}"
    low, high = interval
    if low is None:
        return text
    return f"{text} [{low:.3f}, {'no stop' if high is None else f'{high:.3f}'}]"


def clauses(board: Frame, limits: AssessmentLimits) -> ReportTable:
    """Return the share of cases in which each controller keeps each clause."""
    rows = [
        {"controller": summary.controller} | {_heading(clause, limits): summary.kept[clause] for clause in JUDGED}
        for summary in board.itertuples()
    ]
    return ReportTable(rows, {_heading(clause, limits): share for clause in JUDGED})


_LIMITS: Final[Mapping[str, tuple[str, float, str]]] = {
    "extension": ("≤", 100, "%"),
    "lock": ("≤", 1, "s"),
    "locked_distance": ("≤", 1, "m"),
    "reservoir": ("≥", 1e-5, "bar"),
    "utilisation": ("≥", 100, "%"),
}
"""Clause → direction of its limit, and factor and unit of its representation."""


def _heading(clause: str, limits: AssessmentLimits) -> str:
    name, limit = clause.replace("_", " "), getattr(limits, clause).limit
    if clause not in _LIMITS:
        return name
    if limit is None:
        return f"{name}, not judged"
    sense, factor, unit = _LIMITS[clause]
    return f"{name} {sense} {factor * limit:g} {unit}"


def failed_by_bound(board: Frame, limits: AssessmentLimits) -> list[str]:
    """Return a sentence for each clause that the ideal bound does not keep in all cases."""
    return [
        f"“{getattr(limits, clause).clause}” is kept by {summary.controller} in {share(kept)} of the cases in which it "
        "is judged. In the others adhesion, gradient and brakes leave no controller enough deceleration to keep it."
        for summary in board.itertuples()
        if summary.role == "bound"
        for clause in JUDGED
        if (kept := summary.kept[clause]) is not None and kept < 1
    ]


def answer(board: Frame, count: int, limits: AssessmentLimits, candidates: Sequence[str] = ()) -> str:
    """Return a sentence comparing the best candidate with the others and the ideal bound, with its weakest clause.

    Without candidates all controllers are compared, except those that know the true state.
    """
    laws = [one for one in board.itertuples() if one.controller not in registry.ANALYSES and one.median is not None]
    best = next((one for one in laws if not candidates or one.controller in candidates), None)
    if best is None:
        return f"In {count} cases no distance can be compared with that of a tuned baseline."
    place = laws.index(best) + 1
    stands = "stops shortest" if place == 1 else f"is number {place}"
    over = "" if best.over_bound is None else f" and {best.over_bound:.3f} of the ideal bound"
    return (
        f"{best.controller} ({best.description}) {stands} of {len(laws)} controllers in {count} cases: its median "
        f"distance is {best.median:.3f} of that of the best tuned baseline{over}. {_weakest(best, board, limits)}"
    )


def _weakest(summary: Any, board: Frame, limits: AssessmentLimits) -> str:
    bound: Mapping[str, float | None] = next((one.kept for one in board.itertuples() if one.role == "bound"), {})
    possible = {clause: 1.0 if kept is None else kept for clause, kept in bound.items()}
    behind = {clause: possible.get(clause, 1.0) - kept for clause, kept in summary.kept.items() if kept is not None}
    weakest = max(behind, key=lambda clause: behind[clause])
    if behind[weakest] <= 0:
        return "It keeps each clause wherever the ideal bound keeps it."
    clause = getattr(limits, weakest).clause
    return f"Its weakest clause is “{clause}”, kept in {share(summary.kept[weakest] or 0.0)} of the cases."


def ranking(stops: Frame, case: str) -> ReportTable:
    """Return the distance of each controller in a case, shortest first."""
    own = stops[stops["case"] == case].sort_values("distance_m", kind="stable")
    columns = {
        "controller": "controller", "distance": "distance_m", "over bound": "over_bound", "extension": "extension",
        "lock": "longest_lock_s", "locked": "locked_distance_m", "air": "air_l", "reservoir": "reservoir_bar",
        "strokes": "strokes", "tread": "tread_energy_mj", "utilisation": "utilisation",
    }  # fmt: skip
    table = pandas.DataFrame({name: own[column] for name, column in columns.items()}).assign(
        **{"distance": _distance_or_outcome(own), "over bound": own["over_bound"] - 1},
        fails=[", ".join(clause for clause in JUDGED if verdicts[clause] is False) for verdicts in own["verdicts"]],
    )
    forms = {
        "distance": "{:.1f} m", "over bound": percent, "extension": percent, "lock": "{:.2f} s", "locked": "{:.1f} m",
        "air": "{:.0f} l", "reservoir": "{:.1f} bar", "strokes": "{:.0f}", "tread": "{:.2f} MJ",
        "utilisation": "{:.2f}",
    }  # fmt: skip
    return ReportTable.of_frame(table, forms, ("controller", "fails"))


def worst(stops: Frame, controller: str, again: str) -> ReportTable:
    """Return the cases in which a controller is worst relative to the best tuned baseline, with a command for each."""
    own = stops[stops["controller"] == controller]
    # Without a standstill it is worst of all; without a baseline last.
    ratio = own["over_best"].fillna(math.inf).where(own["best_m"].notna() | own["distance_m"].isna(), 0.0)
    own = own.loc[ratio.sort_values(ascending=False, kind="stable").index].head(_WORST)
    rows = [
        {
            "case": stop.case,
            "distance": distance,
            "over best": stop.over_best - 1,
            **stop.variants,
            "again": f"{again} {stop.case}",
        }
        for stop, distance in zip(own.itertuples(), _distance_or_outcome(own), strict=True)
    ]
    return ReportTable(
        rows, {"distance": "{:.1f} m", "over best": percent}, ("case", *own["variants"].iloc[0], "again")
    )


def _distance_or_outcome(stops: Frame) -> Frame:
    return stops["distance_m"].astype(object).where(stops["distance_m"].notna(), stops["outcome"])


def _lines(board: Frame, candidates: Sequence[str]) -> dict[str, dict[str, Any]]:
    colours = [colour for colour in palette.LINES if colour != palette.BLACK]
    return {
        summary.controller: {"color": palette.BLACK, "linestyle": "-", "linewidth": 3.0, "label": summary.controller}
        if summary.controller in candidates
        else {
            "color": colours[n % len(colours)],
            "linestyle": ("-", "--", ":")[n // len(colours) % 3],
            "linewidth": 1.2,
            "label": summary.controller,
        }
        for n, summary in enumerate(board.itertuples())
    }


def _ratios(stops: Frame, lines: Mapping[str, Mapping[str, Any]]) -> Figure | None:
    if not stops["over_best"].count():
        return None
    figure = style.figure(9.5, 4.5)
    axes = figure.subplots()
    for name, line in lines.items():
        of_controller = over_best(stops[stops["controller"] == name])
        ratios = np.sort(of_controller[np.isfinite(of_controller)])
        if ratios.size:
            axes.step(ratios, (1 + np.arange(ratios.size)) / len(of_controller), where="post", **line)
    axes.axvline(1.0, color=palette.GREY, linewidth=0.8)
    axes.set_xscale("log")
    axes.set_xticks([0.8, 0.9, 1.0, 1.2, 1.5, 2.0, 3.0], ["0.8", "0.9", "1", "1.2", "1.5", "2", "3"])
    axes.set_xticks([], minor=True)
    style.dress(axes, x="distance over that of the best tuned baseline", y="share of the cases")
    style.legend(axes, loc="center left", bbox_to_anchor=(1.0, 0.5))
    return figure


def _by_curve(stops: Frame, controllers: Sequence[str]) -> Figure:
    curve = pandas.Series([variants["curve"] for variants in stops["variants"]], stops.index, dtype=object)
    medians = stops.groupby([stops["controller"], curve])["utilisation"].median().unstack()
    medians = medians.reindex(controllers)
    curves, values = list(medians.columns), medians.to_numpy()
    figure = style.figure(8.0, 1.2 + 0.32 * len(controllers))
    axes = figure.subplots()
    axes.imshow(values, vmin=0.4, vmax=1.0, cmap="viridis", aspect="auto")
    for row, line in enumerate(values):
        for column, value in enumerate(line):
            if np.isfinite(value):
                colour = "white" if value < 0.7 else "black"
                axes.text(column, row, f"{value:.2f}", ha="center", va="center", fontsize=8, color=colour)
    axes.set_xticks(range(len(curves)), [curve.replace("_", "\n") for curve in curves], fontsize=8)
    axes.set_yticks(range(len(controllers)), controllers, fontsize=8)
    return figure


def _over_friction(stops: Frame, lines: Mapping[str, Mapping[str, Any]]) -> Figure | None:
    # Distances over the ideal bound against mean friction, and their median over a tenth of the cases.
    compared = stops[stops["over_bound"].notna() & (stops["controller"] != "ideal_bound")]
    if compared.empty:
        return None
    figure = style.figure(9.5, 4.5)
    axes = figure.subplots()
    for name, line in lines.items():
        own = compared[compared["controller"] == name]
        points = [(float(one.variants["friction"]), one.over_bound) for one in own.itertuples()]
        if points:
            friction, ratios = zip(*sorted(points), strict=True)
            axes.plot(friction, ratios, "o", color=line["color"], markersize=2.5, alpha=0.25)
            axes.plot(friction, median_filter(ratios, size=1 + len(points) // 10, mode="nearest"), **line)
    axes.set_xscale("log")
    axes.set_xticks([0.02, 0.03, 0.05, 0.08, 0.15], ["0.02", "0.03", "0.05", "0.08", "0.15"])
    axes.set_xticks([], minor=True)
    axes.set_ylim(0.95, 2.5)
    style.dress(axes, x="mean of the maximum friction", y="distance over the ideal bound")
    style.legend(axes, loc="center left", bbox_to_anchor=(1.0, 0.5))
    return figure
