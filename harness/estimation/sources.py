"""Recordings for an estimation: a stop of its scenario or a user's file, with the track force computed by [course].

To compute the track force, [course] requires a run with `speed` (optical or radar), `acceleration_along[1]` … (any
number, each including g sin β), `latitude`, `longitude`, `height` (NaN between the samples of the receiver), wheelset
speeds, cylinder pressures, `driving` (0 or 1: the filter does not model traction and starts after it) and, optionally,
`braking`; without it braking begins when a cylinder fills. The trace of a stop has `traction` and `driver_demand`
instead. The result begins with the coasting before the brake and has `track_force` in addition to the readings.

An estimation is checked against its model and train before anything is simulated, read or compiled.
"""

from collections.abc import Callable, Collection, Mapping, Sequence
from functools import partial
from pathlib import Path

import numpy as np
import xarray

from railgrip.base.arrays import generator
from railgrip.base.errors import EstimationError, InputError, UnitError
from railgrip.base.names import ElementName
from railgrip.base.units import cut, unit
from railgrip.estimation.agreement import require_agreement
from railgrip.estimation.models import select_outputs, units_of
from railgrip.estimation.motion import braking_of
from railgrip.estimation.run import by_name, start_by_reading
from railgrip.estimation.spec import Specification, elements_of, parameters_for, settings_for
from railgrip.estimators.belief import Vector
from railgrip.fmus.native import Model
from railgrip.recording.files import require_format
from railgrip.recording.read import FileRecording, read_recording, require_signals
from railgrip.recording.samples import dimension_of, evenly, readings_in, recording_of, with_signals
from railgrip.recording.table import TRUTH
from railgrip.rolling_stock.schema import load_train
from railgrip.scenario.load import load
from railgrip.scenario.quantity import Magnitude, in_units
from railgrip.scenario.schema import Scenario
from railgrip.scenario.vehicle_table import TrainFile
from railgrip.simulate.run import trace_of
from railgrip.simulate.user_parts import CustomParts
from railgrip.trace.recorder import FILE_NAME, read_trace, thin

_ALWAYS = {"driving": "1", "braking": "1"}
"""Signals of a run that must be complete if a file has them."""
UNITS_OF_RUN = {"latitude": "deg", "longitude": "deg", "height": "m"} | _ALWAYS
"""Signals besides those of the model that [course] uses."""
ACCELERATION = "acceleration_along"
"""Further signal for [course], with any number of elements."""


def require_consistent(specification: Specification, scenario: str | None = None) -> None:
    """Raise an error for an estimation whose tables do not fit its model.

    Args:
        scenario: Scenario whose stop will be the recording; None for another recording.

    Raises:
        EstimationError: There are unknown classes, parameters, outputs or columns, states without noise or start, units
            of another dimension, or masses and formations of different trains; one line per problem.
    """
    name, table = specification.name, specification.model
    problems = _problems(name, lambda: table.prediction)
    if not problems:
        model, outputs = table.prediction.model, table.outputs or [v.name for v in table.prediction.model.outputs]
        select = partial(select_outputs, model, table.prediction.name, tuple(outputs))
        problems = _problems(name, select)
        model = model if problems else select()
        problems += [line for check in _checks(specification, scenario, model) for line in _problems(name, check)]
    if problems:
        raise EstimationError("\n".join(dict.fromkeys(problems)))


def _problems(name: str, check: Callable[[], object]) -> list[str]:
    try:
        check()
    except InputError as problem:
        return [line if line.startswith(f"{name}: ") else f"{name}: {line}" for line in str(problem).splitlines()]
    return []


def _checks(specification: Specification, scenario: str | None, model: Model) -> list[Callable[[], object]]:
    states, outputs = ([variable.name for variable in part] for part in (model.states, model.outputs))
    inputs = {variable.name: variable.unit for variable in model.inputs}
    # Errors of gate and parameters must not hide those of noises and start.
    table = specification.model.model_copy(update={"parameters": {}})
    plain = specification.model_copy(update={"model": table})
    settings = settings_for(plain.model_copy(update={"gate": None}), 1.0)
    start = dict.fromkeys(start_by_reading(states, outputs), 0.0) | dict(settings.start)
    checks: list[Callable[[], object]] = [
        partial(parameters_for, specification),
        partial(by_name, "[noise] process", settings.process, states),
        partial(by_name, "[noise] readings", settings.readings, outputs),
        partial(by_name, "[start] mean", start, states),
        partial(by_name, "[start] deviation", settings.start_deviation, states),
        partial(in_units, "[inputs]", specification.inputs, inputs),
        partial(_check_gate, specification, states, list(inputs)),
        partial(settings_for, plain, 1.0),
        partial(check_mass, specification),
        partial(_check_formation, specification, scenario, [*inputs, *outputs]),
        partial(_check_data, specification),
    ]
    if specification.observability is not None:
        checks.append(partial(by_name, "[observability] scale", specification.observability.scale, states))
    return checks


def _check_gate(specification: Specification, states: list[str], inputs: list[str]) -> None:
    gate = specification.gate
    if gate is None:
        return
    for key, names, there in (("states", gate.states, states), ("inputs", gate.inputs, inputs)):
        strange = [name for name in names if not set(elements_of(name, there)) <= set(there)]
        if strange:
            raise EstimationError(f"[gate] {key} has {', '.join(strange)}, the model has {', '.join(there)}.")


def check_mass(specification: Specification) -> None:
    """Compare the mass in [course] with that of the model, if both describe a train.

    Raises:
        EstimationError: The masses differ.
    """
    model = specification.model.prediction
    values = model.values(parameters_for(specification))
    masses = [value for name, value in values.items() if ElementName.of(name).array == "m_wheelset"]
    if specification.course is None or not masses:
        return
    mass, total = specification.course.mass, sum(masses)
    if abs(mass - total) > 1e-3 * total:
        raise EstimationError(
            f"[course] mass is {mass:g} kg, m_wheelset of {model.name} add up to {total:g} kg; track force "
            "and filter belong to one train, change [course] or [model.parameters]."
        )


def _check_formation(specification: Specification, scenario: str | None, signals: list[str]) -> None:
    if scenario is None:
        return
    vehicle = load(Path(scenario)).vehicle
    counts: tuple[int, ...] = ()
    if isinstance(vehicle.source, TrainFile):
        counts = tuple(len(group) for group in load_train(vehicle.source.file.path).groups)
    elif vehicle.formation is not None:
        counts = vehicle.formation.wheelsets_per_group
    sizes = {"group": len(counts), "wheelset": sum(counts)}
    for base in dict.fromkeys(ElementName.of(name).array for name in signals if "[" in name):
        elements = sum(ElementName.of(name).array == base for name in signals)
        extent = dimension_of(base)
        if counts and elements != sizes.get(extent, elements):
            raise EstimationError(
                f"{specification.model.prediction.name} has {elements} of {base}, one for each {extent}; the train of "
                f"scenario '{scenario}' has {sizes[extent]}; name a scenario of the train of the model."
            )


def _check_data(specification: Specification) -> None:
    data = specification.data
    if data is None:
        return
    units, inputs, outputs = signals_of(specification)
    problems: list[str] = []
    known = dict(data.columns)
    for base, elements in _by_group(specification.model.prediction.model).items():
        strange = [name for name in data.columns if name.startswith(f"{base}[") and name not in elements]
        if strange:
            problems.append(
                f"[data.columns] has {', '.join(strange)}, and {specification.model.prediction.name} has "
                f"{len(elements)} groups; name the train of the recording in [model], or remove these lines."
            )
            known = {name: column for name, column in known.items() if name not in strange}
    rest = data.model_copy(update={"columns": known})
    problems += _problems(
        specification.name, partial(require_signals, specification.name, rest, units, inputs, outputs)
    )
    for name, column in data.columns.items():
        target = units.get(name.removeprefix(TRUTH))
        if target is not None and column.unit is not None:
            try:
                column.conversion(unit(column.unit), target)
            except UnitError as problem:
                problems.append(f"[data.columns] {name}: {problem}")
    if problems:
        raise EstimationError("\n".join(problems))


def require_groups(specification: Specification, names: Collection[str]) -> None:
    """Compare the groups of a trace with those of the model.

    Args:
        specification: The estimation.
        names: Names of the signals of the trace, elements of arrays as `wheelset_speed[1]`.

    Raises:
        EstimationError: Signals have other numbers of groups than in the model; one line per signal.
    """
    model = specification.model.prediction
    counts = [
        (base, sum(name.startswith(f"{base}[") for name in names), len(elements))
        for base, elements in _by_group(model.model).items()
    ]
    problems = [
        f"{specification.name}: the recording has {count} groups of {base}, and {model.name} has {expected}; name the "
        "train of the recording in [model]."
        for base, count, expected in counts
        if count not in (0, expected)  # a signal that is missing altogether is named with all that are there
    ]
    if problems:
        raise EstimationError("\n".join(problems))


def _by_group(model: Model) -> dict[str, list[str]]:
    """Return the inputs and readings that each group of a train has, by their name without index."""
    signals = [variable.name for variable in (*model.inputs, *model.outputs) if "[" in variable.name]
    bases = dict.fromkeys(ElementName.of(name).array for name in signals)
    return {
        base: [name for name in signals if name.startswith(f"{base}[")]
        for base in bases
        if dimension_of(base) == "group"
    }


def signals_of(specification: Specification) -> tuple[dict[str, str], list[str], list[str]]:
    """Return the units of all signals that [data] of an estimation may map, and the names of inputs and readings.

    With [course] these include the signals for the motion, in place of the track force.
    """
    model = specification.model.prediction.model
    units = units_of(model)
    inputs = [variable.name for variable in model.inputs if variable.name not in specification.inputs]
    outputs = [variable.name for variable in model.outputs]
    if specification.course is not None:
        columns = list(specification.data.columns) if specification.data else []
        of_run = {name: "m/s2" for name in columns if ElementName.of(name).array == ACCELERATION}
        of_run |= {name: unit for name, unit in UNITS_OF_RUN.items() if name in columns}
        units = {name: unit for name, unit in units.items() if name != "track_force"} | of_run
        inputs = [name for name in inputs if name != "track_force"] + [name for name in of_run if name in _ALWAYS]
        outputs += [name for name in of_run if name not in _ALWAYS]
    return units, inputs, outputs


def recording_of_estimation(
    specification: Specification,
    *,
    data: Path | None = None,
    scenario: str | None = None,
    seed: int | None = None,
    import_from: Sequence[Path] = (),
) -> xarray.Dataset:
    """Return the recording of an estimation.

    Its attribute `flags` has a sentence for each repair of a user's file, `warnings` one for each failed comparison of
    its signals (`railgrip.estimation.agreement`).

    Args:
        data: A trace, or a file read by [data]; None for a stop of the scenario of [source].
        scenario: Replaces that of [source].
        seed: Replaces that of [source].
        import_from: Folders of classes that the scenario names.

    Raises:
        EstimationError: The scenario or file is missing or not suitable, or its signals contradict each other more than
            on any vehicle.
        ScenarioError: The scenario does not exist, or its stop fails.
    """
    if data is not None:
        if data.suffix and data.suffix != ".nc":  # the model, which is compiled next, takes seconds
            require_format(data)
        require_consistent(specification)
        recording = recording_for(specification, data).recording
    else:
        source = specification.source_scenario()
        scenario = scenario or source.scenario
        require_consistent(specification, scenario)
        recording = recording_of_stop(scenario, source.seed if seed is None else seed, source.noise, import_from)
    run, recording = recording_of_trace(specification, recording)
    if data is None or data.suffix == ".nc":  # a trace has its units and one clock
        return recording
    return recording.assign_attrs(warnings=require_agreement(specification, run, recording, data.name))


def recording_of_trace(specification: Specification, trace: xarray.Dataset) -> tuple[xarray.Dataset, xarray.Dataset]:
    """Return a trace completed by the estimation, and the part of it that the filter uses.

    Errors are those of `complete_trace` and, with [course], of `railgrip.estimation.motion.braking_of`.
    """
    run = complete_trace(specification, trace)
    return run, run if specification.course is None else braking_of(run, specification.course).recording


def complete_trace(specification: Specification, trace: xarray.Dataset) -> xarray.Dataset:
    """Return a trace on its even grid, with the constant inputs of the estimation.

    Raises:
        EstimationError: The grid is uneven, a constant belongs to no input or has another dimension, or the trace has
            groups that the model does not have.
    """
    units = {variable.name: variable.unit for variable in specification.model.prediction.model.inputs}
    values = in_units(f"{specification.name}: [inputs]", specification.inputs, units)
    require_groups(specification, readings_in(trace))
    trace = evenly(trace)
    count = trace.sizes["time"]
    return with_signals(trace, {name: (np.full(count, value), units[name]) for name, value in values.items()})


def recording_for(specification: Specification, path: Path) -> FileRecording:
    """Return the recording in a file and its repairs: a trace unchanged, other files by [data] of the estimation.

    Raises:
        EstimationError: The estimation has no [data], or the file cannot be used.
        RecordError: The trace cannot be read.
    """
    if path.suffix == ".nc":
        trace = read_trace(path)
        # The trace of a stop is named after its folder.
        return FileRecording(
            recording=evenly(trace, path.parent.name if path.name == FILE_NAME else path.stem), flags=()
        )
    if specification.data is None:
        raise EstimationError(
            f"{specification.name}: has no [data], which maps the columns of {cut(path.name)}; "
            f"`railgrip inspect {cut(path.name)} --for {specification.name}` proposes it."
        )
    units, inputs, outputs = signals_of(specification)
    return read_recording(path, specification.data, units, inputs, outputs)


def stop_read(
    scenario: Scenario, name: str = "", import_from: Sequence[Path] = (), *, objects: CustomParts | None = None
) -> xarray.Dataset:
    """Return the trace of a stop on the grid of [periods] trace as a recording, by default named after the scenario.

    Classes that the scenario names are imported from the folders `import_from`, unless `objects` replace parts.

    Raises:
        ScenarioError: The stop fails.
    """
    trace = trace_of(scenario, import_from, objects=objects)
    return evenly(thin(trace, int(scenario.periods.steps_of("trace"))), name or scenario.name)


def recording_of_stop(
    scenario: str, seed: int | None, noise: Mapping[str, Magnitude], import_from: Sequence[Path] = ()
) -> xarray.Dataset:
    """Return the recording of a stop.

    It has the signals of the plant under their names, elements of arrays as `name[i]`, and `wheel_torque`, the known
    resistance of bearings and rolling, negative because it opposes the rotation. The true adhesion is that of the whole
    train, ΣF_x/ΣF_z.

    Args:
        scenario: Name or file of the scenario.
        seed: Seed of the scenario and the noise; None for the scenario's own.
        noise: Signal → standard deviation of its reading, white from sample to sample; other signals are not read. If
            empty, the sensors of the scenario are used: the trace of the stop is the recording.
        import_from: Folders of classes that the scenario names.

    Raises:
        ScenarioError: The scenario does not exist, its stop fails, or its plant lacks a signal to be read.
    """
    stop_scenario = load(Path(scenario), [] if seed is None else [f"seed={seed}"])
    trace = stop_read(stop_scenario, import_from=import_from)
    if not noise:
        return trace
    unit_of_signal = {
        str(name): str(trace[name].attrs.get("units", "")) for name in trace if not trace[name].isnull().any()
    }
    deviations = in_units(f"{stop_scenario.name}: [source.noise]", noise, unit_of_signal)
    columns: dict[str, tuple[Vector, str]] = {}
    for name, deviation in deviations.items():
        for key, (values, text) in _elements(trace, name, name).items():
            # One stream for each signal: its noise does not depend on which others are read.
            white = generator(stop_scenario.seed, f"instruments.{key}").standard_normal(values.size)
            columns[key] = values + deviation * white, text
    columns |= _elements(trace, "track_force", "track_force")
    if "resistance_torque" in unit_of_signal:
        torques = _elements(trace, "resistance_torque", "wheel_torque")
        columns |= {key: (-values, unit) for key, (values, unit) in torques.items()}
    loads, forces = trace["wheelset_load"].values, (trace["adhesion"] * trace["wheelset_load"]).values
    truth = {"group_adhesion": (forces.sum(axis=1) / loads.sum(axis=1), "1")}
    for name in ("speed", "wheelset_speed", "pad_friction"):
        truth |= _elements(trace, name, name)
    return recording_of(columns, period=stop_scenario.periods.trace, truth=truth, name=stop_scenario.name)


def _elements(trace: xarray.Dataset, name: str, other: str) -> dict[str, tuple[Vector, str]]:
    samples, unit = trace[name].values, str(trace[name].attrs["units"])
    if samples.ndim == 1:
        return {other: (samples, unit)}
    return {f"{other}[{i}]": (column, unit) for i, column in enumerate(samples.T, start=1)}
