"""The Kalman filter of a scenario, with a prediction from nominal data, a Modelica class or a user's FMU.

Brakes on the rail itself and the linear part of the running resistance brake a train without its wheelsets. A filter
that does not know them takes the train for faster than it is as soon as no sensor reads the speed over ground, and
slide protection then releases wheelsets that roll.
"""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from math import ceil, inf
from typing import Any

import numpy as np
from numpy.typing import NDArray

from railgrip.base import registry
from railgrip.base.arrays import Vector
from railgrip.base.errors import ScenarioError
from railgrip.base.names import ElementName, did_you_mean, state_name
from railgrip.controllers.free_wheel import FreeWheel
from railgrip.controllers.sampled import Expression, FormulaBuilder, Sampled, choose, either, every, within
from railgrip.estimators.design import NOISE_SETS, FilterContext, FilterKind, Gate, NoiseSet, pad_gate
from railgrip.estimators.filters.decentralised import Consist
from railgrip.estimators.prediction import CasadiPrediction
from railgrip.fmi import Description, FmuPrediction, SteppedFmuPrediction, foreign_code
from railgrip.fmus.native import Model
from railgrip.fmus.recipe import FmiType
from railgrip.rolling_stock.schema import Train
from railgrip.scenario.file import NamedFile
from railgrip.scenario.onboard import KalmanFilter
from railgrip.scenario.quantity import in_units
from railgrip.simulate.loop.interfaces import StateEstimator
from railgrip.simulate.named_models import (
    COMPILED_IN,
    consist_description,
    description_of_file,
    prediction_description,
    prediction_model,
    require_role,
    units_of,
)
from railgrip.simulate.train_prediction import (
    central_of,
    consist_of,
    data_of,
    radius_of,
    release_pressure,
    start_of,
    units_of_predictions,
)
from railgrip.simulate.vehicle_data import Opening
from railgrip.vehicle.signals import BODY_FORCE_INPUTS, Layout

_Central = CasadiPrediction | FmuPrediction

RELEASED_PADS = 1500.0
"""Normal force of both pads of a unit [N] below which the filter does not update pad friction; see `pad_gate`."""

_TRIAL_INPUT = 1e5
"""Cylinder pressures [Pa] and track force [N] at which Jacobians of a user's FMU are compared with differences."""
_PREDICTION_DATA = ("r_wheel", "A_piston", "i_rigging", "eta_rigging", "F_spring")
_NOISE_PREFIX = {
    "TrainPrediction": "train",
    "TrainPredictionDisturbed": "disturbed",
    "TrainPredictionLoaded": "loaded",
    "TrainPredictionReduced": "reduced",
    "TrainPredictionReducedDisturbed": "reduced_disturbed",
}


def state_estimator(stop: Opening, table: KalmanFilter) -> StateEstimator:
    """Return the estimator of a scenario in its initial state; an FMU without directional derivatives is reported.

    Raises:
        ScenarioError: The noise set or a parameter does not exist, or the prediction is for another vehicle.
    """
    vehicle, layout, period = stop.vehicle, stop.vehicle.layout, stop.vehicle.scenario.periods.estimator
    noise = _noise(table, has_ideal_sensors=vehicle.scenario.sensors.kind == "ideal")
    groups = range(1, layout.formation.groups + 1)
    if table.model is None:
        prediction, readings, gate, mean, radius = _of_nominal_data(stop, table)
    else:
        prediction, gate, mean, radius = _of_class(stop, table, table.model)
        readings = prediction.outputs
    if isinstance(prediction, FmuPrediction) and not prediction.has_directional_derivatives:
        name = prediction.file.name
        stop.notify(f"[estimator]: {name} offers no directional derivatives; the filter takes central differences")
    train = vehicle.train
    body_force = None if train is None else body_force_of(train, period)
    known = [
        *(["the brakes on the rail itself"] if train is not None and train.rail_brakes else []),
        *(["the traction"] if vehicle.scenario.has_traction else []),
    ]
    has_track_force = "track_force" in prediction.inputs
    if known and not has_track_force:
        stop.notify(
            "[estimator]: the prediction has no input track_force, so the filter does not know the force of "
            f"{' and of '.join(known)}; its speed is wrong while no radar reads it"
        )
    states = prediction.states
    filter_ = _kind_of(table).of_context(
        FilterContext(
            prediction=prediction,
            process_noise=noise.process_noise(states),
            reading_noise=noise.reading_noise(readings),
            period=period,
            gate=gate,
            outlier_limit=_outlier_limits(table, prediction),
            mean=mean,
            covariance=np.diag(noise.start_covariance(states)),
        )
    )

    def places(name: str) -> NDArray[np.intp]:
        return np.array([states.index(f"{name}[{g}]") for g in groups])

    reading_places = [
        layout.reading[ElementName.of(name).array].start + ElementName.of(name).place for name in readings
    ]
    return StateEstimator(
        filter=filter_,
        reading_places=np.array(reading_places, dtype=np.intp),
        speed=states.index("speed"),
        wheelset_speed=places("wheelset_speed"),
        adhesion=places("group_adhesion"),
        pad_friction=places("pad_friction"),
        wheel_radius=radius,
        free_wheel=FreeWheel(layout.formation.brakes, period) if table.free_wheels else None,
        body_force=body_force,
        track_force=prediction.inputs.index("track_force") if has_track_force else -1,
        load_deviation=table.load_deviation,
    )


def _kind_of(table: KalmanFilter) -> type[FilterKind]:
    return registry.part(registry.FILTERS, table.kind, FilterKind)


def _of_nominal_data(
    stop: Opening, table: KalmanFilter
) -> tuple[Consist | _Central, Sequence[str], Gate, Vector, tuple[float, ...]]:
    vehicle, formation = stop.vehicle, stop.vehicle.nominal.formation
    groups, wheelsets = range(formation.groups), range(1, formation.wheelsets + 1)
    data = data_of(vehicle.declared, formation)
    if table.file is None:
        units = units_of_predictions()
        each = {f"{name}[{i}]": unit for name, unit in units.items() for i in wheelsets}
        values = in_units("[estimator.parameters]", table.parameters, units | each)
        data = {name: value for name, value in data.items() if ElementName.of(name).array not in values} | values
    if _kind_of(table).form == "parts":
        prediction = consist_of(formation, data)
        readings = prediction.outputs
    elif table.file is not None:
        prediction = _of_file(stop, table, table.file)
        readings = prediction.outputs
    else:
        train = central_of(formation, data)
        describe = partial(consist_description, train.source)
        prediction = _prepare_model(stop, table, train.model, train.parameters, describe)
        readings = train.readings
    gate = pad_gate(max(release_pressure(data, g, RELEASED_PADS) for g in groups), formation.groups)
    mean = start_of(prediction.states, formation, data, vehicle.scenario.start.speed)
    if table.file is not None and isinstance(prediction, FmuPrediction):
        prediction.require_true_jacobians(mean, np.full(len(prediction.inputs), _TRIAL_INPUT))
    return prediction, readings, gate, mean, tuple(radius_of(data, g) for g in groups)


def _of_file(stop: Opening, table: KalmanFilter, file: NamedFile) -> FmuPrediction:
    """Return the prediction of a user's FMU.

    Raises:
        ScenarioError: The FMU lacks a state or an input, or has an input that the loop does not provide.
        FmuError: It is not a prediction.
    """
    layout, scenario = stop.vehicle.layout, stop.vehicle.scenario
    description = description_of_file(file.path, scenario.limits.fmu)
    require_role(description, "prediction", f"{scenario.name}: [estimator] file")
    if table.interface == "model_exchange" and description.model_exchange is None and description.fmi == 2:
        raise ScenarioError(
            f"[estimator] file {file.entry} offers only Co-Simulation; set interface = 'co_simulation', or export it "
            "as Model Exchange"
        )
    groups, where = range(1, layout.formation.groups + 1), f"[estimator] file {file.entry}"
    pressures = [f"cylinder_pressure[{g}]" for g in groups]
    inputs, others = description.names("input"), {"track_force"}
    states = tuple(map(state_name, description.states))
    _require_names(where, {"state": (_required_states(layout), states), "input": (pressures, inputs)})
    if unknown := [name for name in inputs if name not in others.union(pressures)]:
        raise ScenarioError(f"{where} has an input {unknown[0]}; a prediction takes cylinder_pressure and track_force")
    outputs = [name for name in description.names("output") if ElementName.of(name).array in layout.reading]
    if not outputs:
        raise ScenarioError(f"{where} has no output that sensors read; they read {', '.join(sorted(layout.reading))}")
    _require_read(where, outputs, layout)
    stop.stack.enter_context(foreign_code(description.file.name))
    return _open_prediction(
        stop,
        table,
        description,
        parameters=in_units("[estimator.parameters]", table.parameters, units_of(description)),
        states=states,
        inputs=[*pressures, *(name for name in inputs if name in others)],
        outputs=outputs,
    )


def _open_prediction(stop: Opening, table: KalmanFilter, description: Description, **names: Any) -> FmuPrediction:
    stop.add_fmu(description, "prediction")
    if table.interface == "co_simulation":
        period = stop.vehicle.scenario.periods.estimator
        return stop.stack.enter_context(SteppedFmuPrediction(description, period=period, **names))
    return stop.stack.enter_context(FmuPrediction(description, **names))


def _required_states(layout: Layout) -> list[str]:
    groups = range(1, layout.formation.groups + 1)
    return ["speed", *(f"{n}[{g}]" for n in ("wheelset_speed", "pad_friction", "group_adhesion") for g in groups)]


def _require_names(where: str, needs: Mapping[str, tuple[Sequence[str], Sequence[str]]]) -> None:
    for kind, (names, available) in needs.items():
        if missing := [name for name in names if name not in available]:
            raise ScenarioError(f"{where} has no {kind} {', '.join(missing[:4])}; it has {', '.join(available)}")


def _of_class(stop: Opening, table: KalmanFilter, name: str) -> tuple[_Central, Gate, Vector, tuple[float, ...]]:
    layout, groups = stop.vehicle.layout, stop.vehicle.layout.formation.groups
    model = _prediction_model(table, name, layout)
    units, others = {v.name: v.unit for v in model.parameters}, COMPILED_IN if table.library else ""
    values = in_units("[estimator.parameters]", table.parameters, units, others=others)
    parameters = {v.name: v.start for v in model.parameters} | values
    prediction = _prepare_model(stop, table, model, parameters, partial(prediction_description, name, table.library))
    gate = pad_gate(release_pressure(parameters, 0, RELEASED_PADS), groups)
    radius, speed = parameters["r_wheel"], stop.vehicle.scenario.start.speed
    start = {"speed": speed} | {f"wheelset_speed[{g + 1}]": speed / radius for g in range(groups)}
    start |= {
        state_name(f"{symbol}[{g + 1}]"): parameters[f"{symbol}_start[{g + 1}]"]
        for symbol in ("mu_b", "alpha")
        for g in range(groups)
    }
    mean = np.array([start.get(state, 0.0) for state in prediction.states])
    return prediction, gate, mean, (radius,) * groups


def _prepare_model(
    stop: Opening,
    table: KalmanFilter,
    model: Model,
    parameters: Mapping[str, float],
    describe: Callable[[FmiType], Description],
) -> _Central:
    """Return a model with its parameters, as an FMU if the estimator requires one, else in CasADi."""
    if _kind_of(table).form != "fmu":
        return CasadiPrediction(model, parameters)
    groups = {group: [v.name for v in getattr(model, group)] for group in ("states", "inputs", "outputs")}
    description = describe("me_cs" if table.interface == "co_simulation" else "me")
    return _open_prediction(stop, table, description, parameters=parameters, **groups)


def _prediction_model(table: KalmanFilter, name: str, layout: Layout) -> Model:
    """Return the prediction model of a filter, from the built-in library or from the user's.

    Raises:
        ScenarioError: The model is for another vehicle, or lacks variables that the loop requires of every prediction.
    """
    model = prediction_model(name, table.library)
    where = f"[estimator] model '{name}'"
    states, groups = [variable.name for variable in model.states], layout.formation.groups
    prediction_groups = sum(name.startswith("wheelset_speed[") for name in states)
    if prediction_groups != groups:
        raise ScenarioError(
            f"{where} is for {prediction_groups} groups, the vehicle has {groups}; choose a model for as many"
        )
    needs = {
        "state": (_required_states(layout), states),
        "parameter": (
            [*_PREDICTION_DATA, *(f"{name}_start[{g + 1}]" for name in ("mu_b", "alpha") for g in range(groups))],
            [variable.name for variable in model.parameters],
        ),
    }
    _require_names(where, needs)
    pressures, inputs = [f"cylinder_pressure[{g + 1}]" for g in range(groups)], [v.name for v in model.inputs]
    if inputs[:groups] != pressures:
        raise ScenarioError(f"{where} must have {', '.join(pressures)} as first inputs; it has {', '.join(inputs)}")
    _require_read(where, [variable.name for variable in model.outputs], layout)
    return model


def _require_read(where: str, outputs: Sequence[str], layout: Layout) -> None:
    """Raise an error for outputs that are not elements of a reading, such as those of arrays that begin with 0."""
    elements = [name.removeprefix("reading_") for name in layout.elements("reading")]
    if unread := [name for name in outputs if name not in elements]:
        array = ElementName.of(unread[0]).array
        known = [name for name in elements if ElementName.of(name).array == array] or sorted(layout.reading)
        raise ScenarioError(f"{where} has an output {unread[0]}, which no sensor reads; they read {', '.join(known)}")


def _outlier_limits(table: KalmanFilter, prediction: Consist | _Central) -> list[float] | None:
    """Return the outlier limit of each reading, in standard deviations; inf for no limit.

    Raises:
        ScenarioError: The filter lacks such a reading, or its kind uses every reading.
    """
    if isinstance(prediction, Consist):
        if table.outlier_limit:
            raise ScenarioError(
                f"[estimator] outlier_limit is for kind compiled, python or fmu; {table.kind} uses every reading"
            )
        return None
    readings = [ElementName.of(name).array for name in prediction.outputs]
    if other := sorted(table.outlier_limit.keys() - readings):
        choice = ", ".join(dict.fromkeys(readings))
        raise ScenarioError(f"[estimator] outlier_limit: the filter has no reading '{other[0]}'; it has {choice}")
    return [table.outlier_limit.get(name, inf) for name in readings]


def _noise(table: KalmanFilter, *, has_ideal_sensors: bool) -> NoiseSet:
    noise = table.noise or ("ideal" if has_ideal_sensors else "service")
    model = table.model or "TrainPrediction"
    prefix = "" if table.library is not None else f"{_NOISE_PREFIX.get(model, model)}_"
    full_name = f"{prefix}{noise}"
    if full_name not in NOISE_SETS:
        known = [name.removeprefix(prefix) for name in NOISE_SETS if name.startswith(prefix)]
        raise ScenarioError(
            f"[estimator] has no noise set '{noise}' for model '{model}'; there are "
            + ", ".join(sorted(NOISE_SETS))
            + " (model_noise)"
            + (did_you_mean(noise, known, before="; ") or did_you_mean(model, _NOISE_PREFIX, before="; "))
        )
    return NOISE_SETS[full_name]


_STANDING = 0.1  # m/s, below which friction falls to 0 linearly, as in RailBraking.Components.MagneticTrackBrake
_DELAY_PERIOD = 0.01  # s, of its RailBraking.Pneumatics.DelayLine


def body_force_of(train: Train, period: float) -> Sampled | None:
    """Return the braking force on the body of a train [N], called every `period` [s]; None without any.

    Inputs are `BODY_FORCE_INPUTS`. The forces are those of the component of each `RailBrake`, and of the plant's
    linear resistance, with the data of the train file, which is what an onboard computer can know.
    """
    if not train.rail_brakes and not train.linear_resistance:
        return None
    draft = FormulaBuilder()
    ((speed,), (braking,), (emergency,), (magnets,)) = draft.vector(BODY_FORCE_INPUTS, 1)
    speed = choose(speed > 0.0, speed, 0.0)
    conditions: dict[str, Expression] = {}
    commands: dict[tuple[str, float, float], Expression] = {}
    force: Expression = 0.0
    if train.rail_brakes:
        before = draft.state("applied", "1", "1 once the brakes have been applied")
        applied = either(before > 0.5, braking > 0.5)
        draft.keep(before, choose(applied, 1.0, 0.0))
        conditions = {"magnets": every(applied, magnets > 0.5), "emergency": every(applied, emergency > 0.5)}
    for number, (*_, brake) in enumerate(train.rail_brakes, start=1):
        lagged = draft.state(f"lagged[{number}]", "1", "field over the full one, or force [N]")
        key = brake.condition, brake.speed_max, brake.dead_time
        if key not in commands:
            is_on = every(conditions[brake.condition], speed <= brake.speed_max)
            commands[key] = _delay(draft, len(commands) + 1, choose(is_on, 1.0, 0.0), brake.dead_time, period)
        full = brake.force_at(speed, within=within)
        now = lagged + period / (brake.time_constant + period) * (brake.lag_input(commands[key], full) - lagged)
        draft.keep(lagged, now)
        force += brake.force_of_lag(now, full, within=within)
    force = train.linear_resistance * speed + force * within(speed / _STANDING, 0.0, 1.0)
    draft.output("force", "N", "braking force on the body", force)
    return Sampled(draft.formula("BodyForce", "Force of brakes on the rail itself and of linear resistance"), {})


def _delay(draft: FormulaBuilder, number: int, command: Expression, delay: float, period: float) -> Expression:
    """Return a numbered command after a delay [s], sampled and interpolated as by RailBraking.Pneumatics.DelayLine."""
    if not delay:
        return command
    step = max(period, _DELAY_PERIOD)
    clock = draft.state(f"clock[{number}]", "s", "since the command was sampled", start=step)
    is_due = clock > step - 0.5 * period
    draft.keep(clock, choose(is_due, clock - step, clock) + period)
    result: Expression = 0.0
    newer = command
    for place in range(ceil(delay / step) + 1):
        sample = draft.state(f"command[{number},{place + 1}]", "1", "sampled command, the newest first")
        now = choose(is_due, newer, sample)
        draft.keep(sample, now)
        result += max(0.0, 1.0 - abs(delay / step - place)) * now
        newer = sample
    return result
