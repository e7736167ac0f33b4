"""Check an estimation against its model and train, before anything is simulated, read or compiled."""

from collections.abc import Callable, Collection
from functools import partial
from pathlib import Path

from railgrip.base.errors import EstimationError, InputError, UnitError
from railgrip.base.names import ElementName
from railgrip.base.units import unit
from railgrip.estimation.run import by_name, select_outputs, start_by_reading, units_of
from railgrip.estimation.spec import Specification, elements_of, parameters_for, settings_for
from railgrip.fmus.native import Model
from railgrip.recording.read import require_signals
from railgrip.recording.samples import dimension_of
from railgrip.recording.table import TRUTH
from railgrip.rolling_stock.schema import load_train
from railgrip.scenario.load import load
from railgrip.scenario.quantity import in_units
from railgrip.scenario.vehicle_table import TrainFile

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
