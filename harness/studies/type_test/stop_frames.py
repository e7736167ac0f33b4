"""Stops of a type test as frames: figures and verdicts of each stop, the rank of each controller, and packaged stops.

The package has the stops of built-in controllers, so that a single controller is ranked among them. A file has the
stops of one set of cases, after a line with the digest of these cases and the version of railgrip. `railgrip study
type_test --write` writes it. Results of cases that differ from the present ones are rejected.
"""

import csv
import hashlib
import json
import math
import re
from collections.abc import Iterable, Mapping, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any, Final, cast

import numpy as np
import pandas

from railgrip.base.files import write_text
from railgrip.base.groups import gather
from railgrip.base.tables import JsonObject, TomlTable
from railgrip.report.frame import Frame, plain
from railgrip.report.limits import AssessmentLimits
from railgrip.report.statistics import finite, quantile, quantile_interval
from railgrip.report.stop import Stop
from railgrip.studies.type_test.case_set import VERSIONS, AnyCase, CaseSet
from railgrip.studies.type_test.entrants import LIBRARY, Entrant
from railgrip.trace.k_wet import k_wet_of_distances

JUDGED: Final = ("stops", "extension", "lock", "locked_distance", "reservoir", "utilisation")
"""Clauses, in the order in which they are shown."""

EQUAL: Final = 0.002
"""Relative difference up to which distances are equal: the effect of perturbed plant parameters on a stop."""

_FIGURES: Final = {
    "longest_lock_s": ("longest_lock_fast", 1.0),
    "locked_distance_m": ("locked_distance", 1.0),
    "air_l": ("air_used", 1e3),
    "strokes": ("actuations", 1.0),
    "tread_energy_mj": ("tread_energy", 1e-6),
    "utilisation": ("utilisation", 1.0),
    "nees": ("adhesion_nees", 1.0),
    "adhesion_at_slide": ("adhesion_at_slide", 1.0),
}
"""Column → figure of the stop, and factor to the unit of the column."""

SHIPPED: Final = ("case", "controller", "outcome", "distance_m", "duration_s", *_FIGURES)
"""Columns of the packaged stops; all others follow from the name of the case."""


def measure(stops: Iterable[Stop]) -> Frame:
    """Return a row for each stop, with the figures from which it is judged; numbers that do not exist are NaN.

    Columns: `case`, its name; `variants`, axis → value of the case as text; `speed` at the brake demand [m/s];
    `controller`, name of the entrant; `outcome`; `distance_m`, NaN without a standstill; `duration_s`; and `_FIGURES`,
    each as one number of the train: the lock is above 15 km/h, `strokes` of all valves, and `nees` of all groups.
    """
    rows = [
        {
            "case": stop.variants["case"],
            "variants": {name: each for name, each in stop.variants.items() if name not in ("case", "controller")},
            "speed": float(stop.inputs["start"]["speed"]),
            "controller": stop.variants["controller"],
            "outcome": stop.outcome.value,
            "distance_m": math.nan if stop.braking_distance is None else stop.braking_distance,
            "duration_s": stop.metrics.duration,
            **{name: factor * stop.figures.of_train(figure) for name, (figure, factor) in _FIGURES.items()},
        }
        for stop in stops
    ]
    return frame_of_rows(rows)


def frame_of_rows(rows: Any) -> Frame:
    """Return rows, or a frame, with the columns of `measure`; a column that it lacks is NaN."""
    return pandas.DataFrame(rows).reindex(columns=["case", "variants", "speed", *SHIPPED[1:]])


def plain_rows(stops: Frame) -> list[JsonObject]:
    """Return stops as JSON values, None for numbers that do not exist."""
    rows = plain(stops)
    for row in rows:
        row["strokes"] = None if row["strokes"] is None else round(row["strokes"])
    return rows


def judgements(
    stops: Frame, taking_part: Mapping[str, Entrant], limits: AssessmentLimits, *, only_tuned: bool = True
) -> Frame:
    """Return the stops with verdicts, without references, by cases; values that depend on a missing one are NaN.

    Further columns:

    - `tuned`: whether the parameters of the controller were searched
    - `dry_m`, `bound_m`, `best_m`: distances in the same case of full brake on a dry rail, of the ideal bound, and of
      the best tuned baseline that keeps the lock clause
    - `first_adhesion`: median adhesion at the first slide of all controllers in the case, by which clauses are
      selected: the same for all, and known for a controller that never slides
    - `extension`: relative extension over the dry distance
    - `over_bound`, `over_best`: distance over `bound_m` and over `best_m`
    - `k_wet`: dry over wet deceleration distance, at most 1, and 0 without standstill; SUBSET-040 §4.4.1
    - `reservoir_bar`: gauge pressure of the reservoir at the end
    - `verdicts`: clause → whether it is kept; None if it is not judged

    Args:
        stops: Stops of all controllers, as `measure` returns them.
        taking_part: Entrants by name.
        limits: Limits of the clauses.
        only_tuned: Whether only tuned baselines are compared with, as in version 1 of the type test; else all.
    """
    stops = stops.sort_values("case", key=lambda case: pandas.factorize(case)[0], kind="stable", ignore_index=True)
    case, distance = stops["case"], stops["distance_m"]
    role, tuned = (stops["controller"].map({name: getattr(one, of) for name, one in taking_part.items()})
                   for of in ("role", "tuned"))  # fmt: skip
    is_admissible = (role == "baseline") & (tuned.astype(bool) | (not only_tuned))
    is_admissible &= np.array([keeps_lock(longest, limits) for longest in stops["longest_lock_s"]], dtype=bool)
    slides = stops["adhesion_at_slide"].where(role.isin(["baseline", "entrant"])).groupby(case)
    first = slides.agg(lambda values: quantile(values.dropna(), 0.5))
    dry, bound = (case.map(distance[stops["controller"] == name].set_axis(case[stops["controller"] == name]))
                  for name in ("dry", "ideal_bound"))  # fmt: skip
    best = distance.where(is_admissible).groupby(case).transform("min")
    k_wet = cast("Frame", k_wet_of_distances(dry, distance, stops["speed"], limits.build_up.time))
    reservoir = stops.apply(lambda one: limits.supply.remaining(1e-3 * one["air_l"], one["duration_s"]), axis=1)
    judged = stops.assign(
        tuned=tuned,
        dry_m=dry,
        bound_m=bound,
        best_m=best,
        first_adhesion=case.map(first),
        extension=distance / dry - 1.0,
        over_bound=distance / bound,
        over_best=distance / best,
        k_wet=k_wet.clip(upper=1.0).where(distance.notna(), 0.0).where(dry.notna()),
        reservoir_bar=1e-5 * reservoir if len(stops) else math.nan,
    )
    judged["verdicts"] = [_verdicts(one, limits) for one in judged.itertuples()]
    return judged[(role != "reference").to_numpy()]


def _verdicts(stop: Any, limits: AssessmentLimits) -> dict[str, bool | None]:
    stands = not math.isnan(stop.distance_m)
    # A train that does not stop has an endless extension.
    values = {
        "extension": stop.extension if stands or math.isnan(stop.dry_m) else math.inf,
        "lock": stop.longest_lock_s,
        "locked_distance": stop.locked_distance_m,
        "reservoir": limits.supply.remaining(1e-3 * stop.air_l, stop.duration_s),
        "utilisation": stop.utilisation,
    }
    known = {name: None if math.isnan(value) else value for name, value in values.items()}
    return {"stops": stands} | limits.verdicts(known, finite(stop.first_adhesion))


def keeps_lock(longest: float, limits: AssessmentLimits) -> bool:
    """Return whether no lock lasts longer [s] than the clause allows; True without a limit."""
    return limits.lock.limit is None or longest <= limits.lock.limit


_THREE_STATE: Final = "slip_three_state"


Interval = tuple[float | None, float | None]
"""Ends of a bootstrap interval; None for one that is infinite or unknown."""


STATISTICS: Final = (
    "cases", "compared", "stops", "median", "median_interval", "p95", "p95_interval", "over_bound",
)  # fmt: skip
"""Names of `statistics_of`."""

BOARD: Final = (
    "controller", "description", "role", "tuned", *STATISTICS, "worst", "k_wet", "k_wet_low", "k_wet_high",
    "longest_lock_s", "air", "strokes", "utilisation", "nees_low", "nees", "nees_high", "kept",
)  # fmt: skip
"""Columns of the leaderboard."""


def summaries(stops: Frame, taking_part: Mapping[str, Entrant]) -> Frame:
    """Return the leaderboard: a row for each controller, shortest median first, those without a baseline last.

    A stop without standstill counts as infinite, and a statistic that is not finite is None. Columns are `BOARD`:
    those of `statistics_of`, and

    - `description`, `role`, `tuned` of the entrant, and `worst`, the maximum of distance over `best_m`
    - `k_wet`, `k_wet_low`, `k_wet_high`: 10 % quantile of K_wet in the cases in which the extension is judged, and its
      95 % bootstrap interval over the cases; None without such a case
    - `longest_lock_s`: longest lock in any case
    - `air`, `strokes`: medians relative to three-state slip control with the published levels in the same case
    - `utilisation`: median utilisation of adhesion
    - `nees_low`, `nees`, `nees_high`: 10 % quantile, mean and 90 % quantile over the cases. The mean is 1 for a
      consistent filter; single cases differ by unobservable constants.
    - `kept`: clause → share of the cases in which it is judged that keep it
    """
    frugal = stops[stops["controller"] == _THREE_STATE].set_index("case")
    rows: list[dict[str, object]] = []
    for name, entrant in taking_part.items():
        own = stops[stops["controller"] == name]
        if own.empty:
            continue
        verdicts = pandas.DataFrame(list(own["verdicts"]), index=own.index)
        wet, nees = own["k_wet"][verdicts["extension"].notna()].dropna(), own["nees"].dropna()
        (low, high), kept = interval_of(wet, 0.1), {clause: verdicts[clause].dropna() for clause in JUDGED}
        rows.append(
            {
                "controller": name,
                **{key: getattr(entrant, key) for key in ("description", "role", "tuned")},
                **statistics_of(own),
                "worst": _quantile(over_best(own), 1.0),
                "k_wet": _quantile(wet, 0.1),
                "k_wet_low": low,
                "k_wet_high": high,
                "longest_lock_s": finite(own["longest_lock_s"].max()),
                "air": _relative(own, frugal, "air_l"),
                "strokes": _relative(own, frugal, "strokes"),
                "utilisation": _quantile(own["utilisation"].dropna(), 0.5),
                "nees_low": _quantile(nees, 0.1),
                "nees": finite(nees.mean()),
                "nees_high": _quantile(nees, 0.9),
                "kept": {clause: finite(float(np.mean(of))) if len(of) else None for clause, of in kept.items()},
            }
        )
    board = pandas.DataFrame(rows, columns=list(BOARD), dtype=object)
    return board.sort_values("median", key=lambda of: of.astype(float), kind="stable", ignore_index=True)


def statistics_of(stops: Frame) -> dict[str, Any]:
    """Return statistics of one controller over cases; one that is not finite is None.

    Returns:
        cases: Number of cases.
        compared: Number of those with a `best_m`, from which median and p95 are computed.
        stops: Share of cases with a standstill.
        median: Median of distance over `best_m` of the same case.
        median_interval: Its interval.
        p95: 95 % quantile of that.
        p95_interval: Its interval.
        over_bound: Median of distance over that of the bound.
    """
    ratios, bounds = over_best(stops), stops["over_bound"][stops["bound_m"].notna()].fillna(math.inf)
    levels = {"median": 0.5, "p95": 0.95}
    return {
        "cases": len(stops),
        "compared": len(ratios),
        "stops": float(stops["distance_m"].notna().mean()),
        **{name: _quantile(ratios, level) for name, level in levels.items()},
        **{f"{name}_interval": interval_of(ratios, level) for name, level in levels.items()},
        "over_bound": _quantile(bounds, 0.5),
    }


def over_best(stops: Frame) -> Frame:
    """Return distance over `best_m` in the cases that have one, infinite without standstill."""
    return stops["over_best"][stops["best_m"].notna()].fillna(math.inf)


def _quantile(values: Frame, share: float) -> float | None:
    return finite(quantile(values, share))


def interval_of(values: Frame, share: float) -> Interval:
    """Return the bootstrap interval of a quantile; None for an end that is infinite or unknown."""
    low, high = quantile_interval(values.tolist(), share) or (math.nan, math.nan)
    return finite(low), finite(high)


def _relative(stops: Frame, others: Frame, column: str) -> float | None:
    other = stops["case"].map(others[column].replace(0.0, np.nan))
    return _quantile((stops[column] / other).dropna(), 0.5)


def digest_of(design: Iterable[AnyCase], train: TomlTable) -> str:
    """Return a SHA-256 of everything that defines the stops of a test except the controllers and their task."""
    two_groups = [[case.name, case.tables(2), case.fault_tables(2), *filter(None, [case.train])] for case in design]
    return hashlib.sha256(json.dumps([train, two_groups], sort_keys=True, default=str).encode()).hexdigest()


def write_shipped(stops: Frame, design: Sequence[AnyCase], train: TomlTable, folder: Path) -> list[Path]:
    """Write the stops of each set of cases into its file in a folder; return the files."""
    shipped = stops[list(SHIPPED)].sort_values(["case", "controller"]).astype({"strokes": "Int64"})
    paths: list[Path] = []
    for case_set, of_the_set in _by_set(design).items():
        header = f"# cases {digest_of(of_the_set, train)}, railgrip {version('railgrip')}\n"
        own = shipped[shipped["case"].isin([case.name for case in of_the_set])]
        paths.append(folder / _file_of(case_set))
        write_text(paths[-1], header + own.to_csv(index=False, lineterminator="\n"))
    return paths


def read_shipped(design: Iterable[AnyCase], train: TomlTable, folder: Path = LIBRARY) -> tuple[Frame, list[str]]:
    """Return the packaged stops for some cases, and a sentence about each set of cases.

    Args:
        design: The cases.
        train: Tables of the train, `train_of`.
        folder: Folder of the files.
    """
    frames: list[Frame] = []
    sentences: list[str] = []
    for case_set, of_the_set in _by_set(design).items():
        file = _file_of(case_set)
        if not (folder / file).exists():
            sentences.append(
                f"No results of railgrip's controllers come with these {case_set.count} cases; "
                f"they come with --cases {VERSIONS[case_set.version].small}."
            )
            continue
        header, *lines = (folder / file).read_text(encoding="utf-8").splitlines()
        digest, release = re.findall(r"# cases (\w+), railgrip (.+)", header)[0]
        if digest != digest_of(case_set.cases(), train):
            sentences.append(
                f"The results of railgrip's controllers in {file} are not shown: they are of other cases or of another "
                "train. `railgrip study type_test --write` writes those of the present cases on the train of railgrip."
            )
            continue
        by_name = {case.name: case for case in of_the_set}
        found = pandas.DataFrame([row for row in csv.DictReader(lines) if row["case"] in by_name])
        numbers = found.columns.difference(["case", "controller", "outcome"])
        found[numbers] = found[numbers].replace("", math.nan).astype(float)
        variants = (
            {n: value for n, value in by_name[case].variants().items() if n != "case"} for case in found["case"]
        )
        found["variants"] = pandas.Series([*variants], dtype=object)
        found["speed"] = [by_name[case].speed for case in found["case"]]
        frames.append(frame_of_rows(found))
        sentences.append(f"Shipped results come with the package and are of railgrip {release}.")
    return pandas.concat(frames, ignore_index=True) if frames else frame_of_rows([]), sentences


def _by_set(design: Iterable[AnyCase]) -> dict[CaseSet, list[AnyCase]]:
    return gather((_set_of(case), case) for case in design)


def _file_of(case_set: CaseSet) -> str:
    version = "" if case_set.version == 1 else f"v{case_set.version}{case_set.part}_"
    return f"results_{version}{case_set.count}_{case_set.seed}.csv"


def _set_of(case: AnyCase) -> CaseSet:
    found = CaseSet.of(case.name)
    assert found is not None, case.name
    return found
