"""All figures of a stop as one value; each is declared once, here: unit, definition, formula and use.

A new figure is one field of `Metrics`. Result files, tables, the Python interface, comparisons and the reference page
follow from its declaration.
"""

import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cache
from typing import Annotated, Any, Final, Literal, Self, cast, get_args, get_type_hints

import numpy as np
import xarray
from pydantic import BaseModel, ConfigDict, create_model

from railgrip.base.tables import JsonObject
from railgrip.estimators.consistency import FAR
from railgrip.scenario.outcome import Outcome
from railgrip.trace import measures

Each = tuple[float, ...]

OVERCONFIDENT = 2.0
"""Median of NIS over the expected median above which a filter is overconfident: its errors are 40 % larger than its
standard deviations."""

MOSTLY = 0.5
"""Share of a stop outside ±2σ above which a filter is overconfident.

Errors of slow states last long, so that a share of 20 % in one stop is chance. In one stop of twenty a consistent
filter is outside most of the time."""


_FULL = 1.002
"""Utilisation of adhesion above which a remark on a stop states what can exceed the ideal bound."""


@dataclass(frozen=True, slots=True, kw_only=True)
class MeasuredStop:
    """A stop to measure.

    Attributes:
        trace: Samples from the first brake demand on, one or more, as `with_bound` returns them.
        outcome: How the stop ended.
        alpha_max: Greatest adhesion that may be used.
        actuation: "ideal" or "pneumatic": what the commands in the trace mean.
        target: Distance of the target from the start [m]; NaN without one.
    """

    trace: xarray.Dataset
    outcome: Outcome
    alpha_max: float
    actuation: str
    target: float = math.nan

    def maximum(self, signal: str) -> Each:
        """Return the maximum of a signal for each group or wheelset."""
        return tuple(map(float, self.trace[signal].values.max(axis=0)))


Value = float | Each | tuple[Each, ...] | None


@dataclass(frozen=True, slots=True)
class Figure:
    """Declaration of a figure of a stop.

    Attributes:
        unit: SI unit; "1" for a number.
        meaning: Definition.
        formula: Function that returns the figure of a stop; None if one of `TOGETHER` returns it with others.
        extent: What has a value: the train, or each group or wheelset, from lead to trail.
        combined: How the values of groups or wheelsets become one of the train; empty if that has no meaning.
        title: Name for readers, as in labels of axes; that of the field without one.
        column: Heading of the column in tables of many stops; empty if they have none.
        factor: Factor to the unit of this column.
        form: Format of this column.
        over_draws: Statistic over draws in the table of distributions; empty if that has none.
        better: The better one of two values; empty if neither is.
        clause: Clause of `railgrip.report.limits` that limits it; empty without one.
        is_compared: Whether a regression compares it in addition to the distance.
    """

    unit: str
    meaning: str
    formula: Callable[[MeasuredStop], Value] | None = None
    extent: Literal["train", "group", "wheelset"] = "train"
    combined: Literal["maximum", "sum", "mean", ""] = ""
    title: str = ""
    column: str = ""
    factor: float = 1.0
    form: str = "{:.4g}"
    over_draws: Literal["median", ""] = ""
    better: Literal["less", "more", ""] = ""
    clause: str = ""
    is_compared: bool = False

    def text(self, value: float) -> str:
        """Return a value of the train for its column in tables."""
        return self.form.format(self.factor * value).replace("-", "−")

    def combine(self, value: Value) -> float:
        """Return one value for the train; NaN without a value."""
        if not isinstance(value, tuple):
            return math.nan if value is None else float(value)
        values = np.array(value, dtype=np.float64)
        match self.combined:
            case "maximum":
                return math.nan if np.isnan(values).all() else float(np.nanmax(values))
            case "sum":
                return float(values.sum())
            case "mean":
                return float(values.mean())
            case _:
                return math.nan

    @property
    def unit_text(self) -> str:
        """The unit for readers; empty for a number."""
        return "" if self.unit == "1" else self.unit

    @property
    def axis(self) -> str:
        """Label of an axis."""
        return f"{self.title} [{self.unit_text}]" if self.unit_text else self.title


@dataclass(frozen=True, slots=True, kw_only=True)
class Metrics:
    """The figures of a stop; tuples are lead to trail, of wheelsets or groups.

    A figure that does not exist, as without an estimator or motion, is NaN or None; `FIGURES` has the declarations.
    """

    # fmt: off
    distance: Annotated[float, Figure("m",
        "braking distance, from the brake demand to standstill; none without standstill",
        lambda stop: measures.distance_travelled(stop.trace) if stop.outcome is Outcome.STANDSTILL else math.nan,
        title="braking distance", column="distance", form="{:.1f} m", better="less")]
    distance_travelled: Annotated[float, Figure("m",
        "distance from the brake demand to the end, however the stop ended",
        lambda stop: measures.distance_travelled(stop.trace))]
    target_error: Annotated[float, Figure("m",
        "place of standstill behind the target of the driver or of the law; negative before it, none without a target",
        lambda stop: float(stop.trace["distance"].values[-1]) - stop.target
        if stop.outcome is Outcome.STANDSTILL else math.nan, title="error of the stopping point")]
    duration: Annotated[float, Figure("s", "time from the brake demand to the end of the stop",
        lambda stop: measures.duration(stop.trace), column="duration", form="{:.1f} s", better="less")]
    mean_deceleration: Annotated[float, Figure("m/s2", "mean over the distance travelled, (v0^2 - v1^2)/(2 s)",
        lambda stop: measures.mean_deceleration(stop.trace), better="more")]
    jerk_mean: Annotated[float, Figure("m/s3", "mean magnitude of the change of acceleration over 0.1 s",
        better="less")]
    jerk_rms: Annotated[float, Figure("m/s3", "root mean square of the change of acceleration over 0.1 s",
        better="less")]
    energy_residual: Annotated[float, Figure("1", "energy the plant left unexplained over kinetic energy at the start",
        lambda stop: measures.energy_residual(stop.trace), is_compared=True)]
    utilisation: Annotated[float, Figure("1",
        "contact impulse of the train over that of the ideal bound, weighted by time: the mean deceleration over "
        "time as a share of the bound's, whose differences are not those of distances; the bound has constant slip, "
        "and wheelsets that give back rotation when friction rises exceed it, as in the stop of the ideal bound",
        column="adhesion used", factor=100, form="{:.1f} %", better="more", clause="utilisation")]
    adhesion_allowed: Annotated[float, Figure("1",
        "highest adhesion that the creep curve allows, a mean over the speeds of the stop: v^2/(2 g adhesion_allowed) "
        "is the distance with this adhesion alone, without limits of brakes and without running resistance",
        lambda stop: measures.adhesion_allowed(stop.trace))]
    adhesion_at_slide: Annotated[float, Figure("1",
        f"adhesion of the first group that slides, when its slip first exceeds {100 * measures.SLIDE:g} % above "
        "15 km/h; none without a slide", lambda stop: measures.adhesion_at_slide(stop.trace))]
    utilisation_wheelset: Annotated[Each, Figure("1",
        "contact impulse of each wheelset over its share in the ideal bound; NaN for isolated brakes; may exceed 1 "
        "where the brakes set the bound, which leaves out the inertia of a wheelset that regains speed, where more "
        "than alpha_max was used, and where a group is not at its best slip, at which the shares are taken",
        better="more", extent="wheelset")]
    adhesion_peak: Annotated[Each, Figure("1", "greatest adhesion of each group",
        lambda stop: stop.maximum("group_adhesion"), extent="group", combined="maximum", column="greatest adhesion",
        form="{:.3f}")]
    time_over_alpha_max: Annotated[Each, Figure("s", "time of each group above the adhesion limit",
        lambda stop: measures.time_over_limit(stop.trace, stop.alpha_max), better="less", extent="group")]
    slip_histogram: Annotated[tuple[Each, ...], Figure("s",
        f"time of each group in the slip classes with inner edges {measures.SLIP_EDGES}",
        lambda stop: measures.slip_histogram(stop.trace), extent="group")]
    time_in_deep_slide: Annotated[Each, Figure("s", "time of each group above 30 % slip",
        lambda stop: measures.time_in_deep_slide(stop.trace), better="less", extent="group")]
    longest_lock: Annotated[Each, Figure("s", "longest uninterrupted lock of each group",
        lambda stop: measures.longest_lock(stop.trace), extent="group", combined="maximum", column="longest lock",
        form="{:.2f} s", over_draws="median", better="less", is_compared=True)]
    longest_lock_fast: Annotated[Each, Figure("s", "longest uninterrupted lock of each group above 15 km/h",
        lambda stop: measures.longest_lock(stop.trace, above=measures.FAST), extent="group", combined="maximum",
        better="less", clause="lock")]
    locked_distance: Annotated[Each, Figure("m", "distance each group was dragged without turning",
        lambda stop: measures.locked_distance(stop.trace), extent="group", combined="maximum", better="less",
        clause="locked_distance")]
    flat_length: Annotated[Each, Figure("m",
        "estimated length of the longest wheel flat of each wheelset, from the energy of its slide in one lock; 0 "
        "without a lock", lambda stop: measures.flat_length(stop.trace), extent="wheelset", combined="maximum",
        title="length of wheel flat", column="wheel flat", factor=1000, form="{:.0f} mm", over_draws="median",
        better="less")]
    tread_energy: Annotated[Each, Figure("J", "energy each wheelset dissipated in its contacts",
        lambda stop: measures.tread_energy(stop.trace), extent="wheelset", combined="maximum", better="less")]
    tread_power_peak: Annotated[Each, Figure("W", "greatest power of each wheelset in its contacts",
        lambda stop: tuple(map(float, measures.tread_power(stop.trace).max(axis=0))), better="less", extent="wheelset",
        combined="maximum")]
    disc_temperature_peak: Annotated[Each, Figure("K", "greatest disc temperature of each group",
        lambda stop: stop.maximum("disc_temperature"), extent="group", combined="maximum", better="less")]
    air_used: Annotated[float, Figure("m3", "free air taken from the reservoir",
        lambda stop: measures.change(stop.trace, "air_used"),
        column="air", factor=1000, form="{:.0f} l", better="less", clause="reservoir", is_compared=True)]
    actuations: Annotated[Each, Figure("1",
        "valve strokes of each group; turns of the pressure command with ideal actuation",
        lambda stop: actuations(stop.trace, stop.actuation), extent="group", combined="sum", column="valve strokes",
        form="{:.0f}", better="less", is_compared=True)]
    adhesion_rmse: Annotated[Each | None, Figure("1", "RMS error of the estimated adhesion above 10 km/h, each group",
        extent="group", combined="mean", better="less", is_compared=True)]
    adhesion_bias: Annotated[Each | None, Figure("1", "mean error of the estimated adhesion above 10 km/h, each group",
        extent="group", combined="mean")]
    adhesion_error_95: Annotated[Each | None, Figure("1",
        "bound of 95 % of the adhesion errors above 10 km/h, each group",
        extent="group", combined="mean", better="less")]
    adhesion_sd: Annotated[Each | None, Figure("1",
        "mean claimed standard deviation of the adhesion above 10 km/h, each group",
        extent="group", combined="mean", is_compared=True)]
    adhesion_nees: Annotated[Each | None, Figure("1", "mean squared error over variance, above 10 km/h, each group",
        extent="group", combined="mean", is_compared=True)]
    adhesion_delay: Annotated[Each | None, Figure("s", "shift of the estimated adhesion that fits best, each group",
        extent="group", combined="mean", better="less")]
    pad_friction_rmse: Annotated[Each | None, Figure("1",
        "RMS error of the estimated pad friction above 10 km/h, each group",
        lambda stop: measures.rmse(stop.trace, "estimate_pad_friction", "pad_friction"), better="less",
        extent="group", combined="mean")]
    adhesion_outside: Annotated[Each | None, Figure("1",
        "share of time above 10 km/h with the true adhesion outside ±2σ, each group",
        extent="group", combined="maximum")]
    pad_friction_outside: Annotated[Each | None, Figure("1",
        "share of time above 10 km/h with the true pad friction outside ±2σ, each group",
        lambda stop: measures.outside(stop.trace, "estimate_pad_friction", "pad_friction"), extent="group",
        combined="maximum")]
    nis_ratio: Annotated[float | None, Figure("1",
        "median squared innovation of the estimator over its expected median; 1 if consistent",
        column="NIS", form="{:.2g}", is_compared=True)]
    estimator_lost: Annotated[float | None, Figure("s",
        "from when on, by its innovations, the estimate has no meaning")]
    speed_rmse: Annotated[Each | None, Figure("m/s", "RMS error of the estimated speed above 10 km/h",
        lambda stop: measures.rmse(stop.trace, "estimate_speed", "speed"), combined="mean", better="less")]
    speed_error: Annotated[float, Figure("1", "RMS error of the reading of the speed over the RMS of its true value",
        is_compared=True)]
    wheelset_speed_error: Annotated[float, Figure("1",
        "RMS error of the reading of the rotational speed over the RMS of its true value", is_compared=True)]
    deflection_error: Annotated[float, Figure("1",
        "RMS error of the reading of the deflection over the RMS of its true value", is_compared=True)]
    acceleration_error: Annotated[float, Figure("1",
        "RMS error of the reading of the acceleration over the RMS of its true value", is_compared=True)]
    cylinder_pressure_error: Annotated[float, Figure("1",
        "RMS error of the reading of the cylinder pressure over the RMS of its true value", is_compared=True)]
    # fmt: on

    def doubts(self) -> tuple[str, ...]:
        """Return one sentence for each reason to doubt the estimator's claimed accuracy; empty without reasons.

        They do not change the outcome, because the train stopped in this distance although its filter erred. A filter
        with whose estimate no controller can go on ends the stop as `diverged`.
        """
        sentences: list[str] = []
        if self.estimator_lost is not None:
            sentences.append(
                f"The estimator is lost from {self.estimator_lost:.2f} s on: its innovations are more than "
                f"{FAR:g} times what it claims."
            )
        elif self.nis_ratio is not None and self.nis_ratio > OVERCONFIDENT:
            sentences.append(
                "The estimator is overconfident: its median squared innovation is "
                f"{self.nis_ratio:.1f} times the expected one."
            )
        offsets = " Offsets of the pressure transducers, which the readings do not reveal, are not part of σ."
        for what, shares, cause in (
            ("adhesion", self.adhesion_outside, ""),
            ("pad friction", self.pad_friction_outside, offsets),
        ):
            groups = [f"{g + 1} ({100 * share:.0f} %)" for g, share in enumerate(shares or ()) if share > MOSTLY]
            if groups:
                sentences.append(
                    f"The estimator is overconfident: the true {what} is outside ±2σ most of the time in group "
                    f"{', '.join(groups)}; 5 % is expected.{cause}"
                )
        return tuple(sentences)

    def use_of_adhesion(self) -> str:
        """Return the utilisation, and the adhesion that the creep curve allows; empty without a bound."""
        if not np.isfinite(self.utilisation):
            return ""
        allowed = f" (creep curve: at most {self.adhesion_allowed:.4f})" if np.isfinite(self.adhesion_allowed) else ""
        return f"{100 * self.utilisation:.1f} % of the possible adhesion used{allowed}"

    def excess_over_bound(self) -> str:
        """Return a sentence on how a stop can use more adhesion than its ideal bound; empty if it does not."""
        if not self.utilisation > _FULL:
            return ""
        limit = "[limits] alpha_max, which groups exceeded, and " if max(self.time_over_alpha_max) > 0.0 else ""
        return (
            f"The stop uses more than 100 % of the possible adhesion: its ideal bound has {limit}the brakes and the "
            "resistance of each group at constant slip. Wheelsets that regain speed after a slide exceed that, and so "
            "does a brake on the wheelsets whose torque the plant does not include in brake_torque."
        )

    def of_train(self, name: str) -> float:
        """Return a figure as one number of the train; NaN if it does not exist."""
        return FIGURES[name].combine(getattr(self, name))

    def flat(self) -> dict[str, float]:
        """Return figure → value, as `longest_lock[2]` for the second group; NaN if it does not exist."""
        values: dict[str, float] = {}

        def add(name: str, value: Any) -> None:
            if isinstance(value, tuple):
                for number, each in enumerate(cast("tuple[Any, ...]", value), start=1):
                    add(f"{name}[{number}]", each)
            else:
                values[name] = math.nan if value is None else value

        for name in FIGURES:
            add(name, getattr(self, name))
        return values

    def compared(self) -> dict[str, float]:
        """Return the figures that a regression compares in addition to the distance, each as one number of the train.

        Figures that do not exist are left out.
        """
        values = {name: self.of_train(name) for name, figure in FIGURES.items() if figure.is_compared}
        return {name: value for name, value in values.items() if math.isfinite(value)}

    def to_plain(self) -> JsonObject:
        """Return the figures as JSON values."""
        return json.loads(json.dumps(asdict(self)))

    @classmethod
    def from_plain(cls, plain: Mapping[str, Any]) -> Self:
        """Return the figures that `to_plain` gave; null, and a figure that an earlier version did not have, is missing.

        A missing figure is NaN, for each group or wheelset if the figure has values of these, or None where `Metrics`
        has None without an estimator.

        Raises:
            ValueError: A figure is unknown, or has another type or number of values.
        """
        lengths: dict[str, int] = {
            figure.extent: len(cast("list[Any]", each))
            for name, figure in FIGURES.items()
            if figure.extent != "train" and isinstance(each := plain.get(name), list)
        }
        values = dict(plain)
        for name, hint in get_type_hints(cls).items():
            value = plain.get(name)
            if value is not None or type(None) in get_args(hint):
                values[name] = None if value is None else _to_tuples(value)
            else:
                values[name] = math.nan if hint is float else (math.nan,) * lengths.get(FIGURES[name].extent, 0)
        metrics = cls(**dict(_table().model_validate(values)))
        each = metrics.longest_lock
        counts = {len(of) for of in (metrics.adhesion_outside, metrics.pad_friction_outside, each) if of is not None}
        if not each or len(counts) > 1:
            raise ValueError("figures of groups: one value for each group is expected")
        return metrics


FIGURES: Final[Mapping[str, Figure]] = {
    name: replace(figure, title=figure.title or name.replace("_", " "))
    for name, hint in get_type_hints(Metrics, include_extras=True).items()
    for figure in getattr(hint, "__metadata__", ())  # a test names a field without Figure
}
"""Declarations of all figures by name."""


@cache
def _table() -> type[BaseModel]:
    fields: dict[str, Any] = {name: (hint, ...) for name, hint in get_type_hints(Metrics).items()}
    return create_model("StoredMetrics", __config__=ConfigDict(strict=True, extra="forbid"), **fields)


TOGETHER: Final[Sequence[Callable[[xarray.Dataset], Mapping[str, Value]]]] = (
    measures.jerk, measures.utilisation, measures.adhesion_errors, measures.innovations, measures.reading_errors,
)  # fmt: skip
"""Functions of a trace that return several figures by name; a figure that none of them returns is None."""


def measure(
    trace: xarray.Dataset, *, outcome: Outcome, alpha_max: float, actuation: str, target: float = math.nan
) -> Metrics:
    """Return the figures of a stop.

    Args:
        trace: All samples of the stop, one or more, as `with_bound` returns them; figures are of those from the first
            brake demand on.
        outcome: How the stop ended.
        alpha_max: Greatest adhesion that may be used.
        actuation: "ideal" or "pneumatic": what the commands in the trace mean.
        target: Distance of the target from the start [m]; NaN without one.
    """
    braking = measures.since_brake_demand(trace)
    stop = MeasuredStop(trace=braking, outcome=outcome, alpha_max=alpha_max, actuation=actuation, target=target)
    together: dict[str, Value] = {}
    for function in TOGETHER:
        together |= function(braking)
    figures: Any = {
        name: figure.formula(stop) if figure.formula else together.get(name) for name, figure in FIGURES.items()
    }
    return Metrics(**figures)


def _to_tuples(value: Any) -> Any:
    if not isinstance(value, list):
        return float("nan") if value is None else value
    return tuple(_to_tuples(element) for element in cast("list[Any]", value))


def actuations(trace: xarray.Dataset, actuation: str) -> tuple[int, ...]:
    """Return how often the brake of each group was switched.

    Pneumatic: changes of the commanded valve position (dump, hold, fill; thresholds at ±0.5). Ideal: turns of
    the commanded pressure from rising to falling or back, holds between them left out.
    """
    command = trace["command"].values
    if actuation == "pneumatic":
        position = np.where(command > 0.5, 1, np.where(command < -0.5, -1, 0))
        return tuple(int(np.count_nonzero(np.diff(column))) for column in position.T)
    return tuple(_turns(np.diff(column)) for column in command.T)


def _turns(change: np.ndarray[tuple[int], np.dtype[np.float64]]) -> int:
    directions = np.sign(change[change != 0])
    return int(np.count_nonzero(np.diff(directions)))
