"""All figures of a stop as one value, each with its unit and definition."""

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from functools import cache
from typing import Annotated, Any, Self, cast, get_type_hints

import numpy as np
import xarray
from pydantic import BaseModel, ConfigDict, create_model

from railgrip.estimators.consistency import FAR
from railgrip.scenario.outcome import Outcome
from railgrip.trace import estimation, measures

Each = tuple[float, ...]

OVERCONFIDENT = 2.0
"""Median of NIS over its expected one from which a filter is called too sure: its deviations are off by 40 %."""

MOSTLY = 0.5
"""Share of a stop outside ±2σ from which a filter is called too sure. Slow states err in long stretches, so that a
share of 20 % is within the luck of one stop; a consistent filter has most of one stop in twenty outside."""


_FULL = 1.002
"""Utilisation of adhesion above which a stop states what exceeds the ideal bound."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Metrics:
    """The figures of a stop, each with its unit and definition; tuples are lead to trail, of wheelsets or groups.

    A figure that does not exist (no estimator, no motion) is NaN or None; `meanings` says what each is.
    """

    distance: Annotated[float, "m", "braking distance, from the brake demand to standstill; none without standstill"]
    distance_travelled: Annotated[float, "m", "distance from the brake demand to the end, however the stop ended"]
    duration: Annotated[float, "s", "time from the brake demand to the end of the stop"]
    mean_deceleration: Annotated[float, "m/s2", "mean over the distance travelled, (v0^2 - v1^2)/(2 s)"]
    jerk_mean: Annotated[float, "m/s3", "mean magnitude of the change of acceleration over 0.1 s"]
    jerk_rms: Annotated[float, "m/s3", "root mean square of the change of acceleration over 0.1 s"]
    energy_residual: Annotated[float, "1", "energy the plant left unexplained over kinetic energy at the start"]
    utilisation: Annotated[
        float,
        "1",
        "contact impulse of the train over that of the ideal bound, weighted by time: the mean deceleration over time "
        "as a share of the bound's, whose differences are not those of distances",
    ]
    adhesion_allowed: Annotated[
        float,
        "1",
        "highest adhesion that the creep curve allows, a mean over the speeds of the stop: v^2/(2 g adhesion_allowed) "
        "is the distance with this adhesion alone, without limits of brakes and without running resistance",
    ] = float("nan")  # results of the first release do not have it
    adhesion_at_slide: Annotated[
        float,
        "1",
        f"adhesion of the first group that slides, when its slip first exceeds {100 * measures.SLIDE:g} % above "
        "15 km/h; none without a slide",
    ] = float("nan")  # results of the first release do not have it
    utilisation_wheelset: Annotated[
        Each,
        "1",
        "contact impulse of each wheelset over its share in the ideal bound; NaN for isolated brakes; may exceed 1 "
        "where the brakes set the bound, which leaves out the inertia of a wheelset that regains speed, where more "
        "than alpha_max was used, and where a group is not at its best slip, at which the shares are taken",
    ]
    adhesion_peak: Annotated[Each, "1", "greatest adhesion of each group"]
    time_over_alpha_max: Annotated[Each, "s", "time of each group above the adhesion limit"]
    slip_histogram: Annotated[
        tuple[Each, ...], "s", f"time of each group in the slip classes with inner edges {measures.SLIP_EDGES}"
    ]
    time_in_deep_slide: Annotated[Each, "s", "time of each group above 30 % slip"]
    longest_lock: Annotated[Each, "s", "longest uninterrupted lock of each group"]
    longest_lock_fast: Annotated[Each, "s", "longest uninterrupted lock of each group above 15 km/h"]
    locked_distance: Annotated[Each, "m", "distance each group was dragged without turning"]
    tread_energy: Annotated[Each, "J", "energy each wheelset dissipated in its contacts"]
    tread_power_peak: Annotated[Each, "W", "greatest power of each wheelset in its contacts"]
    disc_temperature_peak: Annotated[Each, "K", "greatest disc temperature of each group"]
    air_used: Annotated[float, "m3", "free air taken from the reservoir"]
    actuations: Annotated[Each, "1", "valve strokes of each group; turns of the pressure command with ideal actuation"]
    adhesion_rmse: Annotated[Each | None, "1", "RMS error of the estimated adhesion above 10 km/h, each group"]
    adhesion_bias: Annotated[Each | None, "1", "mean error of the estimated adhesion above 10 km/h, each group"]
    adhesion_error_95: Annotated[Each | None, "1", "bound of 95 % of the adhesion errors above 10 km/h, each group"]
    adhesion_sd: Annotated[
        Each | None, "1", "mean claimed standard deviation of the adhesion above 10 km/h, each group"
    ]
    adhesion_nees: Annotated[Each | None, "1", "mean squared error over variance, above 10 km/h, each group"]
    adhesion_delay: Annotated[Each | None, "s", "shift of the estimated adhesion that fits best, each group"]
    pad_friction_rmse: Annotated[Each | None, "1", "RMS error of the estimated pad friction above 10 km/h, each group"]
    adhesion_outside: Annotated[
        Each | None, "1", "share of time above 10 km/h with the true adhesion outside ±2σ, each group"
    ]
    pad_friction_outside: Annotated[
        Each | None, "1", "share of time above 10 km/h with the true pad friction outside ±2σ, each group"
    ]
    nis_ratio: Annotated[
        float | None, "1", "median squared innovation of the estimator over its expected median; 1 if consistent"
    ]
    estimator_lost: Annotated[float | None, "s", "from when on, by its innovations, the estimate has no meaning"]
    speed_rmse: Annotated[Each | None, "m/s", "RMS error of the estimated speed above 10 km/h"]
    speed_error: Annotated[float, "1", "RMS error of the reading of the speed over the RMS of its true value"] = (
        math.nan
    )
    wheelset_speed_error: Annotated[
        float, "1", "RMS error of the reading of the rotational speed over the RMS of its true value"
    ] = math.nan
    deflection_error: Annotated[
        float, "1", "RMS error of the reading of the deflection over the RMS of its true value"
    ] = math.nan
    acceleration_error: Annotated[
        float, "1", "RMS error of the reading of the acceleration over the RMS of its true value"
    ] = math.nan
    cylinder_pressure_error: Annotated[
        float, "1", "RMS error of the reading of the cylinder pressure over the RMS of its true value"
    ] = math.nan

    def doubts(self) -> tuple[str, ...]:
        """Return one sentence for each reason to doubt the estimator's claimed accuracy; empty without reasons.

        A stop under a filter that errs is still a stop, with its distance: the train did brake so. So this is no
        outcome; `diverged` is the outcome of a belief with which no controller can go on.
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
        share = f"{100 * self.utilisation:.1f} % of the possible adhesion used{allowed}"
        if self.utilisation <= _FULL:
            return share
        return (
            f"{share}; more than 100 %, because the bound has the friction brakes and the resistance of each group: "
            "wheelsets that regain speed after a slide exceed it, and so does any other brake on the wheelsets, such "
            "as an electrodynamic or a rotating eddy-current brake"
        )

    def other_figures(self) -> dict[str, float]:
        """Return the figures that a regression compares in addition to the distance.

        Errors of the estimator are means over the groups; the lock is the longest of any group, strokes are the sum.
        Figures that do not exist are left out.
        """
        values = {
            "energy_residual": self.energy_residual,
            "longest_lock": max(self.longest_lock),
            "actuations": float(sum(self.actuations)),
            "air_used": self.air_used,
            "adhesion_rmse": _mean(self.adhesion_rmse),
            "adhesion_sd": _mean(self.adhesion_sd),
            "adhesion_nees": _mean(self.adhesion_nees),
            "nis_ratio": self.nis_ratio,
            **{name: getattr(self, name) for name in estimation.READING_ERRORS},
        }
        return {name: value for name, value in values.items() if value is not None and np.isfinite(value)}

    def to_plain(self) -> dict[str, Any]:
        """Return the figures as JSON values."""
        return {name: _to_lists(value) for name, value in asdict(self).items()}

    @classmethod
    def from_plain(cls, plain: Mapping[str, Any]) -> Self:
        """Return the figures that `to_plain` gave, null being NaN for a single figure.

        Raises:
            ValueError: A figure is missing, unknown or has another type or number of values.
        """
        hints = get_type_hints(cls)
        values: dict[str, Any] = {
            name: None if value is None and hints.get(name) is not float else _to_tuples(value)
            for name, value in plain.items()
        }
        metrics = cls(**dict(_table().model_validate(values)))
        each = metrics.longest_lock
        counts = {len(of) for of in (metrics.adhesion_outside, metrics.pad_friction_outside, each) if of is not None}
        if not each or len(counts) > 1:
            raise ValueError("figures of groups: one value for each group is expected")
        return metrics


@cache
def _table() -> type[BaseModel]:
    fields: dict[str, Any] = {name: (hint, ...) for name, hint in get_type_hints(Metrics).items()}
    return create_model("StoredMetrics", __config__=ConfigDict(strict=True, extra="forbid"), **fields)


def meanings() -> dict[str, tuple[str, str]]:
    """Return figure name → unit and definition."""
    return {name: hint.__metadata__ for name, hint in get_type_hints(Metrics, include_extras=True).items()}


def measure(trace: xarray.Dataset, *, outcome: Outcome, alpha_max: float, actuation: str) -> Metrics:
    """Return the figures of a stop.

    Args:
        trace: All samples of the stop, one or more, as `with_bound` returns them; figures are of those from the first
            brake demand on.
        outcome: How the stop ended.
        alpha_max: Greatest adhesion that may be used.
        actuation: "ideal" or "pneumatic": what the commands in the trace mean.
    """
    trace = measures.since_brake_demand(trace)
    travelled = measures.distance_travelled(trace)
    jerk_mean, jerk_rms = measures.jerk(trace)
    share, share_each = measures.utilisation(trace)
    nis_ratio, divergence = estimation.innovations(trace)
    errors = estimation.reading_errors(trace)
    return Metrics(
        distance=travelled if outcome is Outcome.STANDSTILL else float("nan"),
        distance_travelled=travelled,
        duration=measures.duration(trace),
        mean_deceleration=measures.mean_deceleration(trace),
        jerk_mean=jerk_mean,
        jerk_rms=jerk_rms,
        energy_residual=measures.energy_residual(trace),
        utilisation=share,
        utilisation_wheelset=share_each,
        adhesion_allowed=measures.adhesion_allowed(trace),
        adhesion_peak=tuple(map(float, trace["group_adhesion"].values.max(axis=0))),
        adhesion_at_slide=measures.adhesion_at_slide(trace),
        time_over_alpha_max=measures.time_over_limit(trace, alpha_max),
        slip_histogram=measures.slip_histogram(trace),
        time_in_deep_slide=measures.time_in_deep_slide(trace),
        longest_lock=measures.longest_lock(trace),
        longest_lock_fast=measures.longest_lock(trace, above=measures.FAST),
        locked_distance=measures.locked_distance(trace),
        tread_energy=measures.tread_energy(trace),
        tread_power_peak=tuple(map(float, measures.tread_power(trace).max(axis=0))),
        disc_temperature_peak=tuple(map(float, trace["disc_temperature"].values.max(axis=0))),
        air_used=air_used(trace),
        actuations=actuations(trace, actuation),
        pad_friction_rmse=estimation.rmse(trace, "estimate_pad_friction", "pad_friction"),
        pad_friction_outside=estimation.outside(trace, "estimate_pad_friction", "pad_friction"),
        nis_ratio=nis_ratio,
        estimator_lost=divergence,
        speed_rmse=estimation.rmse(trace, "estimate_speed", "speed"),
        speed_error=errors["speed_error"],
        wheelset_speed_error=errors["wheelset_speed_error"],
        deflection_error=errors["deflection_error"],
        acceleration_error=errors["acceleration_error"],
        cylinder_pressure_error=errors["cylinder_pressure_error"],
        **estimation.adhesion_errors(trace),
    )


def _mean(values: Each | None) -> float | None:
    return None if values is None else float(np.mean(values))


def _to_lists(value: Any) -> Any:
    if not isinstance(value, tuple):
        return value
    return [_to_lists(element) for element in cast("tuple[Any, ...]", value)]


def _to_tuples(value: Any) -> Any:
    if not isinstance(value, list):
        return float("nan") if value is None else value
    return tuple(_to_tuples(element) for element in cast("list[Any]", value))


def air_used(trace: xarray.Dataset) -> float:
    """Return the free air taken from the reservoir since the brake demand [m3]."""
    air = trace["air_used"].values
    return float(air[-1] - air[0])


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
