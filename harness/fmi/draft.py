"""Draft [vehicle.map] for a foreign plant by names, units, causality and sizes of arrays."""

import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from difflib import SequenceMatcher

import numpy as np

from railgrip.base.errors import FmuError
from railgrip.base.units import unit
from railgrip.fmi.description import Causality, Description, FmuVariable
from railgrip.fmi.mapping import Port, known_unit

OTHER_NAMES = {
    "pressure_command": "demand brake_demand cylinder_demand pressure_demand pressure_setpoint brake_command p_set "
    "bcp_cmd bcp_set",
    "mu0": "rail_grip grip friction rail_friction mu mu_rail friction_coefficient",
    "track_force": "drag resistance gradient_force",
    "start_speed": "v0 v_0 v_start v_init speed_start initial_speed initial_velocity",
    "distance": "odometer position travelled travel way x s",
    "speed": "velocity v train_speed v_train vehicle_speed",
    "acceleration": "retardation deceleration a a_train",
    "wheelset_speed": "axle_speed wheel_speed omega w n axle_omega wheel_omega rotational_speed",
    "slip": "creep slide",
    "adhesion": "used_grip used_adhesion",
    "wheelset_load": "axle_load wheel_load",
    "cylinder_pressure": "cylinder brake_pressure pressure p_cyl p_cylinder brake_cylinder bcp",
    "brake_torque": "brake_moment moment",
    "locked": "blocked",
    "demand": "pressure_demand demanded_pressure p_demand brake_demand pressure_command brake_command p_set bcp_cmd",
    "command": "valve_command valve_position valves",
    "valve_command": "valve_position valves",
    "pressure": "cylinder_pressure brake_pressure p_cyl p_cylinder bcp",
    "driver_demand": "driver driver_pressure driver_brake_demand",
    "pad_friction": "mu_b mu_pad pad_mu",
}
"""Other words for signals of the harness."""
_OPPOSITE = ("retardation", "deceleration", "drag", "resistance")
"""Names of quantities with the opposite sign."""
_LEAST = 0.6
_PLACES = (
    ("front", "lead", "leading", "first", "head"), ("middle", "mid", "centre", "center"),
    ("rear", "trail", "trailing", "last", "tail", "back"),
)  # fmt: skip
"""Words for places along a train, from the leading one."""
_RANK = {word: rank for rank, words in enumerate(_PLACES) for word in words}


@dataclass(frozen=True, slots=True)
class Array:
    """Variables of an FMU that form one quantity.

    Attributes:
        variables: Variables in the order of groups or wheelsets; one for a scalar.
        entry: Their entry in a mapping: a pattern with {i}, a name, or a list.
        name: Their common name.
        is_scalar: Whether it is a variable without an index.
    """

    variables: tuple[FmuVariable, ...]
    entry: str | tuple[str, ...]
    name: str
    is_scalar: bool = False


def draft_mapping(
    description: Description, signals: Mapping[str, tuple[Port, Causality]]
) -> dict[str, str | tuple[str, ...]]:
    """Return signal → variable, pattern or list of an FMU, each of which is used once; signals without a match are
    omitted.

    Args:
        description: Description of the FMU.
        signals: Signals of the harness, and the causality of such variables in the FMU.
    """
    from scipy.optimize import linear_sum_assignment  # a fifth of the start of a stop, which needs it for no plant

    arrays = list(arrays_of(description))
    names = list(signals)
    score = np.array([[_score(*signals[name], array) for array in arrays] for name in names])
    pairs = zip(*linear_sum_assignment(score, maximize=True), strict=True) if score.size else ()
    table: dict[str, str | tuple[str, ...]] = {}
    used: set[str] = set()
    for i, j in sorted(pairs, key=lambda pair: -score[pair]):
        present = {variable.name for variable in arrays[j].variables}
        if score[i, j] >= _LEAST and not present & used:
            used |= present
            table[names[i]] = _add_sign(arrays[j], names[i])
    return {name: table[name] for name in names if name in table}


def sizes_of(description: Description, causality: Causality) -> tuple[int, ...]:
    """Return the sizes of the arrays of an FMU in descending order of frequency."""
    sizes = [
        len(a.variables) for a in arrays_of(description) if not a.is_scalar and a.variables[0].causality == causality
    ]
    return tuple(sorted(set(sizes), key=lambda size: -sizes.count(size)))


def _add_sign(array: Array, signal: str) -> str | tuple[str, ...]:
    sign = "-" if any(word in array.name and word not in signal for word in _OPPOSITE) else ""
    return f"{sign}{array.entry}" if isinstance(array.entry, str) else tuple(f"{sign}{name}" for name in array.entry)


def arrays_of(description: Description) -> Iterator[Array]:
    """Yield scalars and arrays: `name[1]`, `name_1`, `name1`, `axle1.name`, also counted from 0, and `front.name`."""
    numbered: dict[str, dict[int, FmuVariable]] = {}
    placed: dict[str, list[tuple[str, FmuVariable]]] = {}
    for variable in description.variables.values():
        name = variable.name
        yield Array((variable,), name, bare_name(name), is_scalar=True)
        for digits in re.finditer(r"\d+", name):
            if len(digits[0]) <= 3:
                pattern = f"{name[: digits.start()]}{{i}}{name[digits.end() :]}"
                numbered.setdefault(pattern, {})[int(digits[0])] = variable
        first, dot, rest = name.partition(".")
        if dot:
            placed.setdefault(f"{{place}}.{rest}", []).append((first, variable))
        for word in re.finditer("|".join(sorted(_RANK, key=len, reverse=True)), name.lower()):
            key = f"{name[: word.start()]}{{place}}{name[word.end() :]}"
            if key != f"{{place}}.{rest}":
                placed.setdefault(key, []).append((name[word.start() : word.end()], variable))
    for pattern, elements in numbered.items():
        yield from _split_array(pattern, elements)
    for key, elements in placed.items():
        if len(elements) > 1:
            ranks = [_RANK.get(word.lower()) for word, _ in elements]
            order = [v for _, v in elements]
            known = [rank for rank in ranks if rank is not None]
            if len(set(known)) == len(elements):
                order = [elements[i][1] for i in np.argsort(known)]
            yield Array(tuple(order), tuple(v.name for v in order), bare_name(key.replace("{place}", "")))


def _split_array(pattern: str, elements: Mapping[int, FmuVariable]) -> Iterator[Array]:
    indices = sorted(elements)
    variables = tuple(elements[index] for index in indices)
    if indices == list(range(1, len(indices) + 1)) and (len(indices) > 1 or "[{i}]" in pattern):
        yield Array(variables, pattern, bare_name(pattern.replace("{i}", "")))
    elif len(indices) > 1 and indices == list(range(len(indices))):
        yield Array(variables, tuple(variable.name for variable in variables), bare_name(pattern.replace("{i}", "")))


def bare_name(name: str) -> str:
    """Return a name in lower case without brackets and with single underscores."""
    snake = re.sub(r"(?<=[a-z])(?=[A-Z])", "_", name).lower()
    return re.sub(r"_+", "_", re.sub(r"[^a-z0-9.]", "_", snake)).strip("_.")


def _score(signal: Port, causality: Causality, array: Array) -> float:
    # 0 to 1; 0 if size, causality or dimension differ.
    first, count = array.variables[0], len(array.variables)
    fits = first.settable and first.causality != "input" if causality == "parameter" else first.causality == causality
    is_uniform = all(variable.causality == first.causality for variable in array.variables)
    is_size = count == signal.size and not array.is_scalar
    if signal.size < 2:
        is_size = array.is_scalar or (count == 1 == signal.size)
    if not (fits and is_size and is_uniform) or first.kind == "String":
        return 0.0
    with suppress(FmuError):
        theirs = known_unit(first)
        if theirs is not None and theirs.exponents != unit(signal.unit).exponents:
            return 0.0
    words = (signal.name, *OTHER_NAMES.get(signal.name, "").split())
    parts = {array.name: 1.0, array.name.rpartition(".")[2]: 0.95}
    return max(weight * likeness(part, words) for part, weight in parts.items())


def likeness(name: str, words: Sequence[str]) -> float:
    """Return the similarity of a name and the nearest of some words, 0 to 1."""
    return max(SequenceMatcher(None, name, word).ratio() for word in words)
