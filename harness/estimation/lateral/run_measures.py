"""Measures of one run: errors of the filters, observability of friction, detection of the condition."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any, Final

import casadi as ca
import numpy as np

from railgrip.base.units import GRAVITY
from railgrip.estimation.judgement import rms
from railgrip.estimation.lateral.run import EVERY, Beliefs, Name, Trace, prediction
from railgrip.estimation.lateral.wheelset import CONDITIONS, PAPER_SENSORS, READINGS, SERVICE_SENSORS, Condition
from railgrip.estimators.belief import Array
from railgrip.estimators.consistency import delay, loss_step, nis_ratio
from railgrip.estimators.observability import along
from railgrip.estimators.rail import ConditionDetector, confusion
from railgrip.fmus.native import lower

QUANTITIES: Final[Mapping[str, str]] = {
    "lateral_velocity": "m/s",
    "yaw_rate": "rad/s",
    "creep": "1",
    "creep_force": "N",
    "friction": "1",
}
"""Quantities of the judgement, and their units."""

FRICTION_TOLERANCE: Final = 0.02
"""Largest error of a settled friction: the accuracy of adhesion in Schwarz and Keck (2020)."""

SHARE_TOLERANCE: Final = 0.10
"""Largest error of other settled quantities, relative to the rms of their true values in the run."""

WINDOW: Final = 0.5
"""Time of readings that should determine the friction [s]."""

SPIKE: Final = 0.1
"""Time before and after the first change of the surface in which the largest error of the creep force is sought [s]."""

DETECTOR: Final = ConditionDetector(
    levels={condition.name: condition.mu0 for condition in CONDITIONS}, confidence=0.9, hold=0.05, model_deviation=0.01
)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Belief:
    """Estimate of one quantity at every instant: mean and standard deviation, each of shape (k,)."""

    mean: Array
    deviation: Array


def beliefs_about(trace: Trace, name: Name) -> dict[str, Belief]:
    """Return a filter's estimate of each of `QUANTITIES`, and of mu0 if it estimates it.

    In the well-posed filters creep, force and friction are functions of the states; their variances follow from the
    derivatives at the mean.
    """
    belief = trace.beliefs[name]
    deviation = np.sqrt(np.diagonal(belief.covariance, axis1=1, axis2=2))
    if name == "reconstruction":
        # Its equations also hold when creep and force both change sign, and at zero creep the filter changes to that
        # branch. Total creep and force are magnitudes, so magnitudes are judged.
        place = {"lateral_velocity": 0, "yaw_rate": 1, "creep": 2, "friction": 3, "creep_force": 4}
        mean = {quantity: belief.mean[:, i] for quantity, i in place.items()}
        mean |= {quantity: np.abs(mean[quantity]) for quantity in ("creep", "creep_force")}
        return {
            quantity: Belief(mean=mean[quantity], deviation=deviation[:, place[quantity]]) for quantity in QUANTITIES
        }
    states = list(prediction(name).states)
    at = {state: column for column, state in enumerate(states)}
    # From states to the inputs of LateralContact: displacement, dy, psi, dpsi, log_mu0, log_stiffness; speed is known.
    select = np.zeros((7, len(states)))
    for row, state in enumerate(("y", "dy", "psi", "dpsi", "log_mu0", "log_stiffness")):
        if state in at:
            select[row, at[state]] = 1.0
    if "track" in at:
        select[0, at["track"]] = -1.0
    contact_states = belief.mean @ select.T
    contact_states[:, 6] = trace.truth["speed"]
    if "track" not in at:
        contact_states[:, 0] -= trace.track
    values, slopes = _contact(contact_states)
    mu0 = np.exp(belief.mean[:, at["log_mu0"]])
    with np.errstate(over="ignore", invalid="ignore"):  # estimates of a lost filter may have any size
        variance = np.einsum("kqi,ij,kjl,ml,kqm->kq", slopes, select, belief.covariance, select, slopes, optimize=True)
    beliefs = {
        "lateral_velocity": Belief(mean=belief.mean[:, at["dy"]], deviation=deviation[:, at["dy"]]),
        "yaw_rate": Belief(mean=belief.mean[:, at["dpsi"]], deviation=deviation[:, at["dpsi"]]),
        "mu0": Belief(mean=mu0, deviation=mu0 * deviation[:, at["log_mu0"]]),
    }
    for column, quantity in enumerate(("creep", "creep_force", "friction")):
        beliefs[quantity] = Belief(mean=values[:, column], deviation=np.sqrt(variance[:, column]))
    return beliefs


def _contact(states: Array) -> tuple[Array, Array]:
    """Return creep, force and friction at each sample, shape (k, 3), and their derivatives, (k, 3, 7).

    `states` holds displacement, lateral velocity, yaw angle, yaw rate, logarithms of mu0 and of the creep stiffness,
    and speed, shape (k, 7).
    """
    value, slope = _contact_functions()
    k = len(states)
    values = np.asarray(value.map(k)(states.T), dtype=np.float64).T
    slopes = np.asarray(slope.map(k)(states.T), dtype=np.float64).reshape(3, k, 7).transpose(1, 0, 2)
    return values, slopes


@cache
def _contact_functions() -> tuple[ca.Function, ca.Function]:
    model = lower("RailBraking.FMUs.LateralContact")
    names = [variable.name for variable in model.inputs]
    state_names = ["displacement", "lateral_velocity", "yaw_angle", "yaw_rate", "mu0", "stiffness", "speed"]
    inputs = ca.SX.sym("given", 7)
    values = [*ca.vertsplit(inputs[:4]), ca.exp(inputs[4]), ca.exp(inputs[5]), inputs[6]]
    u = ca.vertcat(*(values[state_names.index(name)] for name in names))
    result = model.output(0, ca.SX.zeros(0), u, [parameter.start for parameter in model.parameters])
    return ca.Function("value", [inputs], [result]), ca.Function(
        "slope", [inputs], [ca.densify(ca.jacobian(result, inputs))]
    )


def adhesion(condition: Condition, creep: Array, speed: float) -> Array:
    """Return the creep force over the wheel load by Polach's formula at a speed [m/s], of the shape of `creep`."""
    model = lower("RailBraking.FMUs.LateralContact")
    values = {parameter.name: parameter.start for parameter in model.parameters}
    values |= {"A_falling": condition.A, "B_falling": condition.B}
    # The lateral creep of a yawed wheelset without lateral motion is its yaw angle.
    given = {"yaw_angle": creep, "mu0": condition.mu0, "stiffness": 1.0, "speed": speed}
    inputs = np.zeros((len(model.inputs), creep.size))
    for row, variable in enumerate(model.inputs):
        inputs[row] = given.get(variable.name, 0.0)
    u = ca.SX.sym("u", len(model.inputs))
    outputs = model.output(0, ca.SX.zeros(0), u, list(values.values()))
    names = [variable.name for variable in model.outputs]
    force = ca.Function("force", [u], [outputs[names.index("creep_force")]])
    load = values["m_wheelset"] * GRAVITY / 2
    return np.asarray(force.map(creep.size)(inputs), dtype=np.float64)[0] / load


def measure(trace: Trace, *, observe: bool = True) -> dict[str, Any]:
    """Return all measures of one run for JSON; infinity and NaN become null.

    errors[filter][quantity]: rmse, bias, peak, nees (mean of e²/σ², one for a consistent filter), settling [s] (worst
    over the changes of condition, null if any never settled). detection[filter]: confusion, delays [s] after the start
    and each change. levels[filter][condition]: mean and rms error of mu0 from `WINDOW` after each change on.
    observability: standard deviation of mu0 from each window. constant[quantity]: rms error of the best constant, its
    mean. size[quantity]: rms of the truth. spike[filter]: largest error of the creep force [N] in `SPIKE` before and
    after the first change of the surface, null without a change. lost[filter]: instant [s] at which the filter diverged
    or its innovations showed it to be lost, or null. nis[filter]: median over the expected one, null without readings.

    Args:
        observe: Whether to compute observability, which takes longer than the rest.
    """
    beliefs = {name: beliefs_about(trace, name) for name in trace.beliefs}
    return {
        "errors": {
            name: {quantity: _error(trace, quantity, about[quantity]) for quantity in QUANTITIES}
            for name, about in beliefs.items()
        },
        "detection": {name: _detection(trace, about["mu0"]) for name, about in beliefs.items() if "mu0" in about},
        "levels": {name: _levels(trace, about["mu0"]) for name, about in beliefs.items() if "mu0" in about},
        "observability": _observability(trace) if observe else None,
        "constant": {name: float(np.std(trace.truth[name])) for name in QUANTITIES},
        "size": {name: rms(trace.truth[name]) for name in QUANTITIES},
        "spike": {name: _spike(trace, about["creep_force"].mean) for name, about in beliefs.items()},
        "lost": {name: _loss(trace, belief) for name, belief in trace.beliefs.items()},
        "nis": {
            name: nis_ratio(nis, np.where(np.isfinite(nis), len(READINGS), 0))
            for name, nis in ((name, belief.squared_innovation) for name, belief in trace.beliefs.items())
        },
        "wall": trace.wall,
    }


def _loss(trace: Trace, belief: Beliefs) -> float | None:
    row = loss_step(belief.squared_innovation, np.full(len(trace.time), len(READINGS)))
    instants = [] if row is None else [float(trace.time[row])]
    if belief.failure_sample is not None:
        instants.append(belief.failure_sample * trace.period / EVERY)
    return min(instants, default=None)


def _spike(trace: Trace, force: Array) -> tuple[float | None, float | None] | None:
    if len(trace.changes) < 2:
        return None
    since = trace.time - trace.changes[1]
    error = np.abs(force - trace.truth["creep_force"])
    parts = (since > -SPIKE) & (since <= 0), (since > 0) & (since <= SPIKE)
    before, after = (_finite(float(np.max(error[part]))) for part in parts)
    return before, after


def _error(trace: Trace, quantity: str, belief: Belief) -> dict[str, float | None]:
    truth = trace.truth[quantity]
    error = belief.mean - truth
    tolerance = FRICTION_TOLERANCE if quantity == "friction" else SHARE_TOLERANCE * math.sqrt(np.mean(truth**2))
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        numbers = {
            "rmse": rms(error),
            "bias": float(np.mean(error)),
            "peak": float(np.max(np.abs(error))),
            "nees": float(np.mean((error / belief.deviation) ** 2)),
            "settling": _settling(trace, truth, belief.mean, tolerance),
        }
    return {key: _finite(value) for key, value in numbers.items()}


def _finite(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


def _settling(trace: Trace, truth: Array, mean: Array, tolerance: float) -> float:
    ends = [*trace.changes[1:], math.inf]
    worst = 0.0
    for begin, end in zip(trace.changes, ends, strict=True):
        part = (trace.time > begin) & (trace.time <= end)
        # NaN counts as outside.
        off = np.where(np.isnan(mean[part]), math.inf, mean[part])
        worst = max(worst, delay(trace.time[part], truth[part], off, begin, tolerance))
    return worst


def _detection(trace: Trace, mu0: Belief) -> dict[str, Any]:
    labels = DETECTOR.labels(mu0.mean, mu0.deviation, trace.period)
    ends = [*trace.changes[1:], math.inf]
    delays: list[float | None] = []
    for begin, end in zip(trace.changes, ends, strict=True):
        part = (trace.time > begin) & (trace.time <= end)
        right = np.flatnonzero(labels[part] == trace.condition[part])
        delays.append(float(trace.time[part][right[0]] - begin) if right.size else None)
    return {"confusion": confusion(trace.condition, labels, len(CONDITIONS)).tolist(), "delays": delays}


def time_since_change(trace: Trace) -> Array:
    """Return the time since the start or the last change of the surface at every instant, shape (k,) [s]."""
    return trace.time - np.array(trace.changes)[np.searchsorted(trace.changes, trace.time, side="left") - 1]


def _levels(trace: Trace, mu0: Belief) -> dict[str, tuple[float | None, float | None]]:
    since = time_since_change(trace)
    levels: dict[str, tuple[float | None, float | None]] = {}
    for number, condition in enumerate(CONDITIONS):
        part = (trace.condition == number) & (since >= WINDOW)
        if part.any():
            with np.errstate(over="ignore", invalid="ignore"):
                numbers = float(np.mean(mu0.mean[part])), rms(mu0.mean[part] - trace.mu0[part])
            levels[condition.name] = (_finite(numbers[0]), _finite(numbers[1]))
    return levels


def _observability(trace: Trace) -> dict[str, Any]:
    model = prediction("known_track")
    truth = trace.truth
    x = np.column_stack(
        [truth["lateral_position"], truth["lateral_velocity"], truth["yaw_angle"], truth["yaw_rate"], np.log(trace.mu0)]
    )
    columns = {"speed": trace.truth["speed"], "track": trace.track}
    u = np.column_stack([columns[name] for name in model.inputs])
    window = round(WINDOW / trace.period)
    measures: dict[str, Any] = {}
    # y, dy, psi, dpsi, log mu0: sizes of a normal run.
    scale = (3e-3, 3e-2, 1e-3, 2e-2, 0.5)
    for sensors, noise in (("paper", PAPER_SENSORS), ("service", SERVICE_SENSORS)):
        # One recorded instant represents `EVERY` readings, whose mean has `EVERY` times less variance. The model is
        # taken as exact (no process noise), so this is a lower bound for every filter with these sensors.
        begins, _, deviation = along(model, x, u, trace.period, np.square(noise) / EVERY, scale, window, window)
        deviations = deviation[:, 4] * trace.mu0[begins]
        measures[sensors] = [_finite(value) for value in deviations]
    starts = np.arange(0, len(x) - window + 1, window)
    measures["condition"] = trace.condition[starts].tolist()
    measures["creep"] = [float(np.max(truth["creep"][first : first + window])) for first in starts]
    return measures
