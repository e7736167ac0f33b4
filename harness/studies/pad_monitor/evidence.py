"""Friction of each brake group, estimated from the readings of one stop."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from types import MappingProxyType
from typing import Any

import casadi as ca
import numpy as np
import xarray
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter1d

from railgrip.base.errors import EstimationError, FilterDiverged
from railgrip.base.names import ElementName
from railgrip.estimation.models import model_of, of_class, units_of
from railgrip.estimators.belief import Matrix, Vector, advance
from railgrip.estimators.compiled import CompiledFilter
from railgrip.estimators.prediction import CasadiPrediction
from railgrip.fmus.native import lower
from railgrip.recording.samples import period_of, samples
from railgrip.simulate.vehicle_data import catalogue_counts
from railgrip.vehicle.brake import air_resistance, pad_force, piston_force, pressure_of, rolling_resistance, slip_of
from railgrip.vehicle.formation import Formation

NOMINAL = 0.35
"""Friction at nominal conditions, `mu_nominal` of RailBraking.Friction.PadFriction."""

PRESSURE_OFFSET = 5e3
"""1σ of the offset of a cylinder's pressure transducer [Pa]: 0.5 % of 10 bar full scale, the class of the sensors in
`table1.toml`. It belongs to the transducer, so it is taken to be the same in every stop."""

_STATES = ("pad.mu", "disc.T_bulk", "disc.T_surface")


def nominal_friction(
    pad_force: Vector, wheelset_speed: Vector, speed: Vector, period: float, friction_radius: float, temperature: float
) -> Vector:
    """Return the friction of healthy pads in the same stop, shape (k,).

    Args:
        pad_force: Force of both pads of one unit [N], shape (k,).
        wheelset_speed: Angular velocity [rad/s], shape (k,).
        speed: Train speed, for the cooling of the disc [m/s], shape (k,).
        period: Time between samples [s].
        friction_radius: Friction radius [m].
        temperature: Temperature of the disc at the first sample [K].
    """
    start, step = _stepper(friction_radius, period)
    first = np.array([start, temperature, temperature])
    inputs = np.stack([pad_force, np.maximum(wheelset_speed, 0.0), speed])
    run = step.mapaccum(pad_force.size - 1)
    states = np.asarray(run(first, inputs[:, :-1]), dtype=np.float64)
    return np.concatenate([[start], states[0]])


@cache
def _stepper(friction_radius: float, period: float) -> tuple[float, ca.Function]:
    model = lower("RailBraking.Components.GroupBrake")
    names = [v.name for v in model.states]
    assert tuple(names) == _STATES, names
    values = [friction_radius if v.name == "r_friction" else v.start for v in model.parameters]
    start = next(v.start for v in model.parameters if v.name == "pad.mu_start")
    x, u = ca.SX.sym("x", len(names)), ca.SX.sym("u", len(model.inputs))
    slope = ca.Function("slope", [x, u], [model.derivative(0.0, x, u, ca.DM(values))])
    symbols: Any = x  # the formula of arrays is also one of symbols

    def derivative(state: Any) -> Any:
        return slope(state, u)

    return float(start), ca.Function("step", [x, u], [advance(derivative, symbols, period)])


MODEL = "TrainPredictionReduced"


@cache
def formation() -> Formation:
    """Return the formation of the train of `MODEL`, which is also simulated in lives."""
    return Formation(catalogue_counts())


PRIOR = 0.10
"""Standard deviation of friction before a stop: large, and removed from the evidence afterwards."""

_PROCESS = {"speed": 3e-3, "wheelset_speed": 1e-2, "pad_friction": 5e-4, "group_adhesion": 0.3}
"""Deviations in unit/√s. The nominal law describes the course of friction within a stop: the residual is constant;
adhesion must follow a group that is released within 0.2 s."""
_READINGS = {"speed": 0.1, "wheelset_speed": 0.2, "acceleration": 0.04}
"""As [readings.service] of estimators/noises.toml, except the accelerometer, whose bias is removed before."""
_START = {"speed": 0.1, "wheelset_speed": 0.3, "group_adhesion": 0.02}

_LOCKED = 0.8
"""Slip above which a wheelset counts as locked: its pads no longer slide on the disc at full friction then, or soon."""
_AROUND = 0.3  # s before and after, in which encoders and pressures lag
_FREE = 1e4  # (rad/s)²/s: process noise of a locked wheelset, whose equation is not valid

_SLOWEST = 3.0  # m/s; below, encoders lose pulses
_COASTING = 2.0  # s without brake before the stop, from which drag is estimated
_RELEASED = 2e4  # Pa; below, a cylinder counts as empty
_PRESSED = 1500.0  # N on both pads of a unit; below, their torque is within the errors of the other torques


@dataclass(frozen=True, slots=True, kw_only=True)
class Evidence:
    """Friction of each group in one stop, over that of healthy pads in the same conditions.

    Attributes:
        health: Shape (groups,); 1 is nominal.
        covariance: Of `health` without any prior, shape (groups, groups); large where the stop does not distinguish
            groups. Noise of the readings only, new in every stop.
        offset: 1σ that the transducers' `PRESSURE_OFFSET` puts on `health`, shape (groups,). Readings give the torque;
            a pressure that reads too high makes the pads look worse. The offset does not average out over stops, and it
            does not reduce the weight of a stop: charts compare a group with its own reference, by the same transducer.
        drag: Deceleration with released brakes that resistance does not explain [m/s²]; NaN without coasting.
    """

    health: Vector
    covariance: Matrix
    offset: Vector
    drag: float

    @property
    def deviation(self) -> Vector:
        """Standard deviations of `health`, shape (groups,)."""
        return np.sqrt(np.diag(self.covariance))


def evidence_of(
    recording: xarray.Dataset, temperature: Vector, parameters: Mapping[str, float] = MappingProxyType({})
) -> Evidence:
    """Return the friction of each group from the readings of a stop.

    Args:
        recording: Recording with the inputs and outputs of `MODEL`.
        temperature: Temperature of the discs of each group at its first sample [K], shape (groups,).
        parameters: Parameters of `MODEL` that differ from the nominal train, in SI units.

    Raises:
        EstimationError: A signal is missing, nothing was braked, or the filter diverged.
    """
    period, groups = period_of(recording), formation().groups
    prediction, filter_ = _filter(period, tuple(sorted(parameters.items())))
    names = [f"cylinder_pressure[{g + 1}]" for g in range(groups)]
    pressure = samples(recording, names, ["Pa"] * groups)
    units = units_of(MODEL)
    readings = samples(recording, prediction.outputs, [units[name] for name in prediction.outputs])
    at = prediction.outputs.index
    speed = _without_gaps(readings[:, at("speed")], "speed")
    wheels = np.stack(
        [_without_gaps(readings[:, at(f"wheelset_speed[{g + 1}]")], "wheelset_speed") for g in range(groups)], 1
    )
    moving = np.flatnonzero(speed < _SLOWEST)
    count = int(moving[0]) if moving.size else speed.size
    acceleration = readings[:, at("acceleration")]
    acceleration -= _bias(acceleration[:count], readings[:count, at("speed")], period)
    values = {v.name: float(p) for v, p in zip(model_of(MODEL).parameters, prediction.parameters, strict=True)}
    piston = {"piston_area": values["A_piston"], "spring_force": values["F_spring"]}
    rigging = values["i_rigging"] * values["eta_rigging"]  # force of both pads over force of the piston
    force = pad_force(pressure, **piston, rigging=rigging)
    braking = np.flatnonzero(pressure.max(axis=1) > _RELEASED)
    if not braking.size or count - braking[0] < 5.0 / period:
        raise EstimationError(f"recording '{recording.attrs.get('name', '')}': has no five seconds of braking.")
    onset = int(braking[0])
    drag = _drag(acceleration[:onset], speed[:onset], values) if onset * period >= _COASTING else float("nan")
    # The pressures that brake with constant nominal friction as healthy pads do: the filter estimates the rest, health.
    reduced = pressure.copy()
    for g in range(groups):
        radius = values[f"r_friction[{g + 1}]"]
        mu = nominal_friction(force[:, g], wheels[:, g], speed, period, radius, float(temperature[g]))
        equivalent = pressure_of(mu / NOMINAL * force[:, g], **piston, rigging=rigging)
        reduced[:, g] = np.where(force[:, g] > 0.0, equivalent, pressure[:, g])
    inputs = np.column_stack([reduced, np.full(speed.size, 0.0 if np.isnan(drag) else -_mass(values) * drag)])
    locked = locked_samples(wheels, speed, values["r_wheel"], round(_AROUND / period))
    for g in range(groups):
        readings[locked[:, g], at(f"wheelset_speed[{g + 1}]")] = np.nan
    mean, covariance = _run_filter(
        filter_, prediction.states, inputs, readings, locked, wheels[0], float(speed[0]), count
    )
    health, likelihood_covariance = _without_prior(mean, covariance)
    offset = pressure_deviation(
        pad_friction=health / NOMINAL,
        pressure=np.array([_braking_pressure(pressure[:count, g], force[:count, g]) for g in range(groups)]),
        offset=PRESSURE_OFFSET,
        **piston,
    )
    return Evidence(health=health / NOMINAL, covariance=likelihood_covariance / NOMINAL**2, offset=offset, drag=drag)


def _without_prior(mean: Vector, covariance: Matrix) -> tuple[Vector, Matrix]:
    # The prior would count once in each of several stops.
    identity, nominal = np.eye(mean.size), np.full(mean.size, NOMINAL)
    information = np.linalg.inv(covariance) - identity / PRIOR**2
    # Without information in the stop only rounding errors remain: the result is limited to 100 prior deviations.
    information += identity / (100.0 * PRIOR) ** 2
    likelihood_covariance = np.asarray(np.linalg.inv(0.5 * (information + information.T)), dtype=np.float64)
    moment = np.linalg.solve(covariance, mean) - nominal / PRIOR**2 + nominal / (100.0 * PRIOR) ** 2
    return likelihood_covariance @ moment, likelihood_covariance


def pressure_deviation(
    *, pad_friction: Vector, pressure: Vector, offset: float, piston_area: float, spring_force: float
) -> Vector:
    """Return the 1σ error that a pressure transducer's offset adds to an estimated pad friction, in its shape.

    The filter cannot know it (see train_service in noises.toml); a comparison of pad friction with a law, as the brake
    monitor does, adds it to the filter's own deviation, root of the sum of squares. It is the same error in every stop.

    Args:
        pad_friction: Estimated pad friction.
        pressure: Cylinder pressure [Pa]; the result is infinite if it does not overcome the spring.
        offset: 1σ of the transducer's offset [Pa].
        piston_area: Area of the piston [m²].
        spring_force: Force of return spring and slack adjuster [N].
    """
    pressing = piston_force(np.asarray(pressure), piston_area=piston_area, spring_force=spring_force)
    with np.errstate(divide="ignore"):
        return np.asarray(pad_friction) * offset * piston_area / pressing


def _braking_pressure(pressure: Vector, force: Vector) -> float:
    # Infinite if the group never braked: no offset of its transducer matters then.
    under_pads = pressure[force > _PRESSED]
    return float(np.median(under_pads)) if under_pads.size else float("inf")


def locked_samples(wheels: Matrix, speed: Vector, radius: float, around: int) -> NDArray[np.bool_]:
    """Return where wheelsets are locked or nearly so, and `around` samples to both sides, shape (k, groups).

    A locked wheelset has no information on its pads, which hold it with less than their maximum torque.
    """
    slides = slip_of(speed[:, None], radius * wheels) > _LOCKED
    return np.asarray(maximum_filter1d(slides, 2 * around + 1, axis=0, mode="nearest"), dtype=np.bool_)


@cache
def _filter(period: float, parameters: tuple[tuple[str, float], ...]) -> tuple[CasadiPrediction, CompiledFilter]:
    prediction = of_class(MODEL).equations(dict(parameters))

    def squares(deviations: dict[str, float], names: tuple[str, ...]) -> Vector:
        return np.array([deviations[ElementName.of(name).array] for name in names]) ** 2

    noises = squares(_PROCESS, prediction.states), squares(_READINGS, prediction.outputs)
    return prediction, CompiledFilter(prediction, *noises, period)


def _run_filter(
    filter_: CompiledFilter,
    states: tuple[str, ...],
    inputs: Matrix,
    readings: Matrix,
    locked: NDArray[np.bool_],
    wheels: Vector,
    speed: float,
    count: int,
) -> tuple[Vector, Matrix]:
    """Return mean (groups,) and covariance (groups, groups) of reduced pad friction after `count` samples.

    Args:
        inputs: Inputs at every sample, shape (k, nu).
        readings: Readings, shape (k, m); those of a locked wheelset are not used.
        locked: Which wheelsets are locked, shape (k, groups).
        wheels: Wheelset speeds at the first sample [rad/s], shape (groups,).
        speed: Train speed at the first sample [m/s].
    """
    groups = formation().groups
    place = [states.index(f"pad_friction[{g + 1}]") for g in range(groups)]
    mean, deviation = np.zeros(len(states)), np.array([_START.get(ElementName.of(n).array, PRIOR) for n in states])
    mean[place] = NOMINAL
    mean[states.index("speed")] = speed
    mean[[states.index(f"wheelset_speed[{g + 1}]") for g in range(groups)]] = wheels
    filter_.start(mean, deviation**2)
    # Pressures at the start of each period, from where the filter holds the adhesion, too. With those in its middle,
    # force and torque are half a period apart while pressures change, and inner groups seem better by up to 3 %.
    held = inputs[:-1]
    usual = np.array([_PROCESS[ElementName.of(name).array] for name in states]) ** 2
    turning = np.array([states.index(f"wheelset_speed[{g + 1}]") for g in range(groups)])
    filter_.retune(usual)
    try:
        for k in range(1, count):
            if (locked[k] != locked[k - 1]).any() or k == 1:
                noise = usual.copy()
                noise[turning[locked[k]]] = _FREE
                filter_.retune(noise)
            filter_.inputs[:] = held[k - 1]
            filter_.readings[:] = readings[k]
            filter_.advance()
    except FilterDiverged as problem:
        raise EstimationError(f"monitor: {problem}") from problem
    return filter_.mean[place].copy(), filter_.covariance[np.ix_(place, place)].copy()


def _bias(acceleration: Vector, speed: Vector, period: float) -> float:
    """Return the bias of an accelerometer [m/s²]: the drift of its integral from the speed reading.

    It includes the gradient of the track, which an accelerometer cannot distinguish from a bias.
    """
    finite = np.isfinite(acceleration)
    if finite.mean() < 0.5:
        return 0.0
    complete = np.where(finite, acceleration, np.nanmean(acceleration))
    distance = np.concatenate([[0.0], np.cumsum(0.5 * (complete[1:] + complete[:-1]) * period)])
    present = np.isfinite(speed)
    time = np.arange(speed.size) * period
    return -float(np.polyfit(time[present], speed[present] - distance[present], 1)[0])


def _drag(acceleration: Vector, speed: Vector, values: dict[str, float]) -> float:
    mass, radius = _mass(values), values["r_wheel"]
    air = air_resistance(values) * float(np.mean(speed**2))
    rolling = rolling_resistance(values, mass, radius)
    rotating = sum(values[f"J[{g + 1}]"] for g in range(formation().groups)) / radius**2
    return -float(np.nanmean(acceleration)) * (1.0 + rotating / mass) - (air + rolling) / mass


def _mass(values: dict[str, float]) -> float:
    return sum(values[f"m_wheelset[{i + 1}]"] for i in range(formation().wheelsets))


def _without_gaps(values: Vector, name: str) -> Vector:
    finite = np.flatnonzero(np.isfinite(values))
    if finite.size < 2:
        raise EstimationError(f"recording: {name} has no samples.")
    return np.asarray(np.interp(np.arange(values.size), finite, values[finite]), dtype=np.float64)
