"""Evaluation of a type test: figures and verdicts of each stop, and the rank of each controller."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, fields
from typing import Any, Final, Literal

import numpy as np

from railgrip.report.limits import AssessmentLimits
from railgrip.report.statistics import endless, finite, quantile, quantile_interval
from railgrip.report.stop import Stop
from railgrip.studies.type_test.entrants import Entrant
from railgrip.trace.k_wet import k_wet_of_distances

JUDGED: Final = ("stops", "extension", "lock", "locked_distance", "reservoir", "utilisation")
"""Clauses, in the order in which they are shown."""

EQUAL: Final = 0.002
"""Relative difference up to which distances are equal: the effect of perturbed plant parameters on a stop."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CaseMeasurement:
    """Figures of one stop, from which it is judged; None for a missing value.

    Attributes:
        case: Name of the case.
        variants: Axis → value of the case, as text.
        speed: Speed at the brake demand [m/s].
        controller: Name of the entrant.
        outcome: How the stop ended.
        distance_m: Braking distance; None without a standstill.
        duration_s: Time until the end of the stop.
        longest_lock_s: Longest lock of any group above 15 km/h.
        locked_distance_m: Longest locked distance of any group.
        air_l: Free air used.
        strokes: Number of strokes of all valves.
        tread_energy_mj: Largest energy dissipated in the contacts of a wheelset, which causes flats.
        utilisation: Utilisation of the available adhesion [1].
        adhesion_at_slide: Adhesion of the first group that slides, when it begins to [1]; None without a slide, and in
            results of earlier versions.
        nees: Mean squared error of the estimated adhesion over its variance, above 10 km/h, mean of the groups; None
            without an estimator that outputs a variance.
    """

    case: str
    variants: Mapping[str, str]
    speed: float
    controller: str
    outcome: str
    distance_m: float | None
    duration_s: float
    longest_lock_s: float | None
    locked_distance_m: float | None
    air_l: float | None
    strokes: int | None
    tread_energy_mj: float | None
    utilisation: float | None
    nees: float | None
    adhesion_at_slide: float | None = None


def measure_stop(stop: Stop) -> CaseMeasurement:
    """Return the figures of a stop."""
    metrics = stop.figures
    air = finite(metrics.air_used)
    return CaseMeasurement(
        case=stop.variants["case"],
        variants={name: value for name, value in stop.variants.items() if name not in ("case", "controller")},
        speed=float(stop.inputs["start"]["speed"]),
        controller=stop.variants["controller"],
        outcome=stop.outcome.value,
        distance_m=stop.braking_distance,
        duration_s=metrics.duration,
        longest_lock_s=finite(max(metrics.longest_lock_fast)),
        locked_distance_m=finite(max(metrics.locked_distance)),
        air_l=None if air is None else 1e3 * air,
        strokes=round(sum(metrics.actuations)),
        tread_energy_mj=finite(1e-6 * max(metrics.tread_energy)),
        utilisation=finite(metrics.utilisation),
        adhesion_at_slide=finite(metrics.adhesion_at_slide),
        nees=None if metrics.adhesion_nees is None else finite(float(np.mean(metrics.adhesion_nees))),
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class CaseJudgement(CaseMeasurement):
    """Verdict on one case with one controller; values that depend on its distance are None without a standstill.

    Attributes:
        tuned: Whether the parameters of the controller were searched.
        dry_m, bound_m, best_m: Distances in the same case of full brake on a dry rail, of the ideal bound, and of the
            best tuned baseline that keeps the lock clause; None if unknown.
        first_adhesion: Median adhesion at the first slide of all controllers in the case [1], by which clauses are
            selected: the same for all, and known for a controller that never slides. None if no controller slides.
        extension: Relative extension over the dry distance [1].
        over_bound, over_best: Distance over `bound_m` and over `best_m`.
        k_wet: Dry over wet deceleration distance, at most 1 [1]; SUBSET-040 §4.4.1.
        reservoir_bar: Gauge pressure of the reservoir at the end.
        verdicts: Clause → whether it is kept; None if it is not judged.
    """

    tuned: bool
    dry_m: float | None
    bound_m: float | None
    best_m: float | None
    first_adhesion: float | None
    extension: float | None
    over_bound: float | None
    over_best: float | None
    k_wet: float | None
    reservoir_bar: float | None
    verdicts: Mapping[str, bool | None]

    def to_plain(self) -> dict[str, Any]:
        """Return it as JSON values."""
        return asdict(self)


def judgements(
    stops: Iterable[CaseMeasurement],
    taking_part: Mapping[str, Entrant],
    limits: AssessmentLimits,
    *,
    only_tuned: bool = True,
) -> list[CaseJudgement]:
    """Return the verdict on each stop, without references, by cases.

    Args:
        stops: Stops of all controllers.
        taking_part: Entrants by name.
        limits: Limits of the clauses.
        only_tuned: Whether only tuned baselines are compared with, as in version 1 of the type test; else all.
    """
    by_case: dict[str, dict[str, CaseMeasurement]] = {}
    for stop in stops:
        by_case.setdefault(stop.case, {})[stop.controller] = stop
    rows: list[CaseJudgement] = []
    for stops_of_case in by_case.values():
        distances = {name: stop.distance_m for name, stop in stops_of_case.items()}
        best = min(
            (
                distance
                for name, distance in distances.items()
                if distance
                and (taking_part[name].tuned or not only_tuned)
                and taking_part[name].role == "baseline"
                and keeps_lock(stops_of_case[name].longest_lock_s, limits)
            ),
            default=None,
        )
        dry, bound = distances.get("dry"), distances.get("ideal_bound")
        adhesion = _quantile(
            [
                stop.adhesion_at_slide
                for name, stop in stops_of_case.items()
                if stop.adhesion_at_slide is not None and taking_part[name].role in ("baseline", "entrant")
            ],
            0.5,
        )
        rows += [
            _judge(stop, taking_part[name].tuned, limits, dry=dry, bound=bound, best=best, adhesion=adhesion)
            for name, stop in stops_of_case.items()
            if taking_part[name].role != "reference"
        ]
    return rows


def keeps_lock(longest: float | None, limits: AssessmentLimits) -> bool:
    """Return whether no lock lasts longer [s] than the clause allows; True without a limit."""
    return limits.lock.limit is None or (longest is not None and longest <= limits.lock.limit)


def _judge(
    stop: CaseMeasurement,
    tuned: bool,
    limits: AssessmentLimits,
    *,
    dry: float | None,
    bound: float | None,
    best: float | None,
    adhesion: float | None,
) -> CaseJudgement:
    distance = stop.distance_m
    extension = None if distance is None or dry is None else distance / dry - 1.0
    remaining = None if stop.air_l is None else limits.supply.remaining(1e-3 * stop.air_l, stop.duration_s)
    values = {
        # A train that does not stop has an endless extension.
        "extension": math.inf if dry is not None and distance is None else extension,
        "lock": stop.longest_lock_s,
        "locked_distance": stop.locked_distance_m,
        "reservoir": remaining,
        "utilisation": stop.utilisation,
    }
    return CaseJudgement(
        **{field.name: getattr(stop, field.name) for field in fields(CaseMeasurement)},
        tuned=tuned,
        dry_m=dry,
        bound_m=bound,
        best_m=best,
        first_adhesion=adhesion,
        extension=extension,
        over_bound=_ratio(distance, bound),
        over_best=_ratio(distance, best),
        k_wet=None
        if dry is None
        else 0.0
        if distance is None
        else min(1.0, k_wet_of_distances(dry, distance, stop.speed, limits.build_up.time)),
        reservoir_bar=None if remaining is None else 1e-5 * remaining,
        verdicts={"stops": distance is not None} | limits.verdicts(values, adhesion),
    )


def _ratio(distance: float | None, other: float | None) -> float | None:
    return None if distance is None or other is None else distance / other


@dataclass(frozen=True, slots=True, kw_only=True)
class Summary:
    """Statistics of a controller over all its cases; a stop without standstill counts as infinite, None below.

    Attributes:
        cases: Number of its cases.
        stops: Share of cases with a standstill.
        compared: Number of cases with a `best_m`, from which median, p95 and worst are computed.
        median, p95, worst: Median, 95 % quantile and maximum of distance over `best_m` of the same case.
        median_interval, p95_interval: 95 % bootstrap intervals over the cases; an infinite limit is None.
        over_bound: Median of distance over that of the ideal bound.
        k_wet, k_wet_low, k_wet_high: 10 % quantile of K_wet in the cases in which the extension is judged, and its
            95 % bootstrap interval over the cases; None without such a case.
        longest_lock_s: Longest lock in any case.
        air, strokes: Medians relative to three-state slip control with the published levels in the same case.
        utilisation: Median utilisation of adhesion.
        nees_low, nees, nees_high: 10 % quantile, mean and 90 % quantile over the cases. The mean is 1 for a consistent
            filter; single cases differ by unobservable constants.
        kept: Clause → share of the cases in which it is judged that keep it.
    """

    controller: str
    description: str
    role: Literal["reference", "bound", "baseline", "entrant"]
    tuned: bool
    cases: int
    stops: float
    compared: int
    median: float | None
    median_interval: tuple[float | None, float | None]
    p95: float | None
    p95_interval: tuple[float | None, float | None]
    worst: float | None
    over_bound: float | None
    k_wet: float | None
    k_wet_low: float | None
    k_wet_high: float | None
    longest_lock_s: float | None
    air: float | None
    strokes: float | None
    utilisation: float | None
    nees_low: float | None
    nees: float | None
    nees_high: float | None
    kept: Mapping[str, float | None]


_THREE_STATE: Final = "slip_three_state"


def summaries(stops: Sequence[CaseJudgement], taking_part: Mapping[str, Entrant]) -> list[Summary]:
    """Return the leaderboard: shortest median first, controllers without a baseline last."""
    frugal = {stop.case: stop for stop in stops if stop.controller == _THREE_STATE}
    board: list[Summary] = []
    for name, entrant in taking_part.items():
        stops_of = [stop for stop in stops if stop.controller == name]
        if not stops_of:
            continue
        over_best = [endless(stop.over_best) for stop in stops_of if stop.best_m]
        wet = [stop.k_wet for stop in stops_of if stop.k_wet is not None and stop.verdicts["extension"] is not None]
        low, high = _interval(wet, 0.1)
        sure = [stop.nees for stop in stops_of if stop.nees is not None]
        board.append(
            Summary(
                controller=name,
                description=entrant.description,
                role=entrant.role,
                tuned=entrant.tuned,
                cases=len(stops_of),
                stops=float(np.mean([stop.distance_m is not None for stop in stops_of])),
                compared=len(over_best),
                median=_quantile(over_best, 0.5),
                median_interval=_interval(over_best, 0.5),
                p95=_quantile(over_best, 0.95),
                p95_interval=_interval(over_best, 0.95),
                worst=_quantile(over_best, 1.0),
                over_bound=_quantile([endless(stop.over_bound) for stop in stops_of if stop.bound_m], 0.5),
                k_wet=_quantile(wet, 0.1),
                k_wet_low=low,
                k_wet_high=high,
                longest_lock_s=max(
                    (stop.longest_lock_s for stop in stops_of if stop.longest_lock_s is not None), default=None
                ),
                air=_relative(stops_of, frugal, "air_l"),
                strokes=_relative(stops_of, frugal, "strokes"),
                utilisation=_quantile([stop.utilisation for stop in stops_of if stop.utilisation is not None], 0.5),
                nees_low=_quantile(sure, 0.1),
                nees=finite(float(np.mean(sure))) if sure else None,
                nees_high=_quantile(sure, 0.9),
                kept={clause: _share_kept(stops_of, clause) for clause in JUDGED},
            )
        )
    return sorted(board, key=lambda summary: math.inf if summary.median is None else summary.median)


def _share_kept(stops: Sequence[CaseJudgement], clause: str) -> float | None:
    verdicts = [verdict for stop in stops if (verdict := stop.verdicts[clause]) is not None]
    return float(np.mean(verdicts)) if verdicts else None


def _quantile(values: Sequence[float], share: float) -> float | None:
    return finite(quantile(values, share))


def _interval(values: Sequence[float], share: float) -> tuple[float | None, float | None]:
    low, high = quantile_interval(values, share) or (math.nan, math.nan)
    return finite(low), finite(high)


def _relative(stops: Sequence[CaseJudgement], others: Mapping[str, CaseJudgement], figure: str) -> float | None:
    pairs = [(getattr(stop, figure), getattr(others.get(stop.case), figure, None)) for stop in stops]
    return _quantile([stop / other for stop, other in pairs if stop is not None and other], 0.5)
