"""Tie signals of the harness to an FMU's variables: other names, units and signs, checked once.

The table of a scenario reads

    [vehicle.map]
    pressure_command = "cylinder[{i}].demand"        # an array by pattern, {i} counts from 1
    wheelset_speed = ["front.n", "axle3.n", "axle4.n", "rear.n"]
    acceleration = "-retardation"                    # a sign flip
    mu0 = { variable = "rail[{i}].grip", scale = 0.01 }
    cylinder_pressure = { variable = "p[{i}]", unit = "bar" }   # the FMU does not say its unit

A signal that the table omits has the same name in the FMU. Elements of an array may be named `n[1]`, `n_1` or `n1`
there, and a single one `n`. Units are converted from those that the FMU declares; `scale` multiplies the rest (value =
scale · FMU value, both in SI). A `unit` is given only if the FMU declares none, one that neither it nor railgrip
defines, or omits the unit of rotation: `1/min` of a speed may be `rev/min` or `rad/min`.
"""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final, cast

import numpy as np
from numpy.typing import NDArray

from railgrip.base.errors import FmuError, UnitError
from railgrip.base.names import did_you_mean
from railgrip.base.units import Unit, conversion, turning_of, unit
from railgrip.fmi.description import Causality, Description, FmuVariable


@dataclass(frozen=True, slots=True, kw_only=True)
class Port:
    """A quantity at the interface between the harness and a plant, as the harness defines it.

    Attributes:
        name: Name in the harness.
        unit: SI unit in Modelica's syntax.
        size: Number of elements, 0 for a scalar.
        needed: Whether the FMU must have it.
    """

    name: str
    unit: str
    size: int
    needed: bool

    @property
    def elements(self) -> tuple[str, ...]:
        """Scalar names, `slip[1]` to `slip[4]`, or the name itself."""
        if self.size == 0:
            return (self.name,)
        return tuple(f"{self.name}[{i + 1}]" for i in range(self.size))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Channel:
    """The variables of one FMI type on one side, ready for a single call.

    Attributes:
        carrier: FMI type in the names of fmi2Get…/fmi2Set…, or of FMI 3.0's; enumerations travel as integers.
        references: Value references, shape (n,), uint32.
        elements: Position of each in its array of FMI 3.0, shape (n,); 0 for scalars.
        positions: Position of each in the harness's vector, shape (n,).
        gain: Factor of the conversion in the direction of travel, shape (n,).
        shift: Offset, added after the gain, shape (n,).
        variables: Names in the FMU, for messages.
    """

    carrier: str
    references: NDArray[np.uint32]
    elements: NDArray[np.intp]
    positions: NDArray[np.intp]
    gain: NDArray[np.float64]
    shift: NDArray[np.float64]
    variables: tuple[str, ...]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SignalVector:
    """All signals of one direction in one vector.

    The layout does not depend on the FMU: outputs that an FMU lacks are NaN, and inputs that it lacks are ignored.

    Attributes:
        layout: Position of each signal in the vector.
        elements: Scalar names in the harness, in the order of the vector.
        absent: Optional signals that the FMU lacks.
        channels: One per FMI type in use.
    """

    layout: Mapping[str, slice]
    elements: tuple[str, ...]
    absent: tuple[str, ...]
    channels: tuple[Channel, ...]

    @property
    def size(self) -> int:
        """Length of the vector."""
        return len(self.elements)

    def ties(self) -> dict[str, tuple[str, float, float]]:
        """Return, by element name in the harness, the FMU's variable with gain and shift."""
        return {
            self.elements[position]: (variable, float(gain), float(shift))
            for channel in self.channels
            for variable, position, gain, shift in zip(
                channel.variables, channel.positions, channel.gain, channel.shift, strict=True
            )
        }


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Binding:
    """An FMU tied to the signals of the harness.

    Attributes:
        inputs: Signals that the harness sends, converted to the FMU's units.
        outputs: Signals that the harness reads, converted from the FMU's units.
        unused: Inputs of the FMU without a source; they keep their start values.
        parameters: Parameter name in the harness → FMU variable, gain and shift towards it.
    """

    inputs: SignalVector
    outputs: SignalVector
    unused: tuple[str, ...]
    parameters: Mapping[str, tuple[str, float, float]]

    def translate(self, values: Mapping[str, float]) -> dict[str, float]:
        """Return parameter values under the FMU's names and in its units.

        Args:
            values: Values by scalar name in the harness, SI; all names are in `parameters`.
        """
        result: dict[str, float] = {}
        for name, value in values.items():
            theirs, gain, shift = self.parameters[name]
            result[theirs] = gain * value + shift
        return result


@dataclass(frozen=True, slots=True, kw_only=True)
class _MappedElement:
    """One element of a mapping entry: the variable, and how it differs."""

    variable: str
    scale: float
    stated_unit: str | None
    text: str = ""


def bind(
    description: Description,
    *,
    inputs: Sequence[Port],
    outputs: Sequence[Port],
    parameters: Sequence[Port] = (),
    table: Mapping[str, object] | None = None,
    where: str = "mapping",
) -> Binding:
    """Tie signals of the harness to the variables of an FMU.

    Args:
        inputs: Signals that can be sent, in the order of the input vector.
        outputs: Signals that can be read, in the order of the output vector.
        parameters: Parameters set before initialisation under their names in the harness.
        table: Name in the harness → FMU variable, as above.
        where: File and table, the opening words of messages: 'city.toml: [vehicle.map]'.

    Raises:
        FmuError: The table has an unknown signal or variable, a variable is of the wrong kind, a unit has the wrong
            dimension, or a needed signal is missing.
    """
    entries = dict(table or {})
    our_names = {s.name for s in (*inputs, *outputs, *parameters)}
    for name in entries:
        if name not in our_names:
            raise FmuError(f"{where} has no signal '{name}'{_near(name, sorted(our_names))}")
    for group in (inputs, outputs):
        names = [s.name for s in group]
        if len(set(names)) != len(names):
            raise FmuError(f"{where}: a signal is listed twice among {', '.join(names)}.")
    sources = _side(description, inputs, entries, where, "input")
    sinks = _side(description, outputs, entries, where, "output")
    driven = Counter(v for channel in sources.channels for v in channel.variables)
    if again := sorted(v for v, count in driven.items() if count > 1):
        raise FmuError(f"{where}: two signals drive the same input of {description.file.name}: {', '.join(again)}.")
    return Binding(
        inputs=sources,
        outputs=sinks,
        unused=tuple(v for v in description.names("input") if v not in driven),
        parameters=_side(description, parameters, entries, where, "parameter").ties(),
    )


def _side(
    description: Description, signals: Sequence[Port], entries: Mapping[str, object], where: str, causality: Causality
) -> SignalVector:
    layout: dict[str, slice] = {}
    elements: list[str] = []
    absent: list[str] = []
    missing: list[str] = []
    ties: list[_Tie] = []
    for signal in signals:
        targets = tuple(
            _require_one_meaning(description, target, f"{where} {signal.name}")
            for target in _targets(signal, entries, where)
        )
        lack = [t.variable for t in targets if t.variable not in description.variables]
        if lack and signal.name not in entries:
            spelled = next((names for names in _spellings(signal) if description.variables.keys() >= set(names)), None)
            if spelled is not None:
                targets, lack = _unchanged(spelled), []
        if lack and signal.name not in entries:
            # An array of which only some elements exist is a mistake, not an absence.
            if signal.needed or len(lack) < len(targets):
                missing += lack
            else:
                absent.append(signal.name)
            targets = ()
        first = len(elements)
        elements += signal.elements
        layout[signal.name] = slice(first, len(elements))
        for position, (element, target) in enumerate(zip(signal.elements, targets, strict=False), start=first):
            ties.append((position, *_tie(description, signal, element, target, where, causality)))
    if missing:
        raise FmuError(_all_missing(description, missing, causality, where))
    return SignalVector(layout=layout, elements=tuple(elements), absent=tuple(absent), channels=_channels(ties))


def _spellings(signal: Port) -> Iterator[tuple[str, ...]]:
    # Tools without arrays write `demand_1` or `demand1`.
    if signal.size == 1:
        yield (signal.name,)
    if signal.size:
        numbers = range(1, signal.size + 1)
        yield tuple(f"{signal.name}_{i}" for i in numbers)
        yield tuple(f"{signal.name}{i}" for i in numbers)


def side_of(variables: Sequence[FmuVariable]) -> SignalVector:
    """Return variables of an FMU as a side with their names and units in the FMU."""
    layout = {v.name: slice(i, i + 1) for i, v in enumerate(variables)}
    ties = [(position, variable, 1.0, 0.0) for position, variable in enumerate(variables)]
    return SignalVector(layout=layout, elements=tuple(layout), absent=(), channels=_channels(ties))


_Tie = tuple[int, FmuVariable, float, float]
"""Position in the vector of the harness, variable, gain and shift."""


def _channels(every: Sequence[_Tie]) -> tuple[Channel, ...]:
    carriers = dict.fromkeys(variable.carrier for _, variable, _, _ in every)
    return tuple(_channel(carrier, [tie for tie in every if tie[1].carrier == carrier]) for carrier in carriers)


def _channel(carrier: str, ties: Sequence[_Tie]) -> Channel:
    return Channel(
        carrier=carrier,
        references=np.array([v.reference for _, v, _, _ in ties], dtype=np.uint32),
        elements=np.array([v.element for _, v, _, _ in ties], dtype=np.intp),
        positions=np.array([position for position, _, _, _ in ties], dtype=np.intp),
        gain=np.array([gain for _, _, gain, _ in ties]),
        shift=np.array([shift for _, _, _, shift in ties]),
        variables=tuple(v.name for _, v, _, _ in ties),
    )


def _tie(
    description: Description, signal: Port, element: str, target: _MappedElement, where: str, causality: Causality
) -> tuple[FmuVariable, float, float]:
    variable = description.variable(target.variable, f"{where} {element}")
    file = description.file.name
    readable = causality == "output" and variable.causality in ("output", "local", "input", "calculatedParameter")
    changeable = causality == "parameter" and variable.settable and variable.causality != "input"
    if not (variable.causality == causality or readable or changeable):
        raise FmuError(
            f"{where} {element}: '{variable.name}' of {file} is {_article(variable.causality)}, "
            f"but must be {_article(causality)}; map '{signal.name}' to another variable."
        )
    if variable.kind in ("String", "Binary"):
        raise FmuError(f"{where} {element}: '{variable.name}' of {file} is a {variable.kind}, not a number.")
    ours = unit(signal.unit)
    theirs = _unit_of(variable, target, ours, file, f"{where} {element}")
    try:
        # value = scale · (FMU value in the harness's unit) + shift; into the FMU the equation is solved for the FMU
        # value.
        gain, shift = conversion(theirs, ours, difference=variable.relative)
    except UnitError as error:
        way = "reads" if causality == "output" else "sends"
        turning = turning_of(theirs, ours)
        remedy = (
            f'say in {where} what turns: {{ variable = "{variable.name}", unit = "rev/{turning}" }}, or rad/{turning}'
            if turning
            else f"correct the FMU or {where}"
        )
        raise FmuError(
            f"{file}: {causality} '{variable.name}' is in '{theirs.name}', the harness {way} '{signal.name}' in "
            f"'{signal.unit}'; {theirs.dimension} is not {ours.dimension}; {remedy}."
        ) from error
    gain, shift = target.scale * gain, target.scale * shift
    return (variable, gain, shift) if causality == "output" else (variable, 1.0 / gain, -shift / gain)


def _unit_of(variable: FmuVariable, target: _MappedElement, ours: Unit, file: str, who: str) -> Unit:
    unit_of_variable = variable.defined_unit
    if target.stated_unit is not None:
        try:
            stated_unit = unit(target.stated_unit)
        except UnitError as error:
            raise FmuError(f"{who}: {error}") from error
        known = known_unit(variable)
        if known is not None and not known.leaves_the_angle_out_of(stated_unit):
            raise FmuError(
                f"{who}: unit = '{target.stated_unit}' is stated for '{variable.name}', but {file} already "
                f"gives '{variable.unit}'; leave it out, or use scale if the FMU is wrong."
            )
        return stated_unit
    if unit_of_variable is not None:
        return unit_of_variable
    if variable.unit:
        try:
            return unit(variable.unit)
        except UnitError as error:
            if variable.unit in _NO_UNIT and ours.dimension == "1":
                return unit("1")
            raise FmuError(
                f"{who}: {file} gives '{variable.name}' the unit '{variable.unit}' without defining it, and {error} "
                f'State the unit in the mapping, {{ variable = "{target.variable}", unit = "{ours.name}" }}.'
            ) from error
    if ours.dimension == "1":  # a number, an index or a boolean needs no unit
        return unit("1")
    raise FmuError(
        f"{who}: {file} does not say the unit of '{variable.name}'; state it in the mapping, "
        f'{{ variable = "{target.variable}", unit = "{ours.name}" }}.'
    )


_NO_UNIT: Final = ("-", "none", "null")
"""Units that tools write for a variable without a unit."""


def known_unit(variable: FmuVariable) -> Unit | None:
    """Return the unit of a variable, if the FMU gives one that it or railgrip defines."""
    if variable.defined_unit is not None or not variable.unit:
        return variable.defined_unit
    try:
        return unit(variable.unit)
    except UnitError:
        return None


def _targets(signal: Port, entries: Mapping[str, object], where: str) -> tuple[_MappedElement, ...]:
    who = f"{where} {signal.name}"
    entry = entries.get(signal.name)
    if entry is None:
        return _unchanged(signal.elements)
    count = max(signal.size, 1)
    if isinstance(entry, Sequence) and not isinstance(entry, str):
        items = cast(Sequence[object], entry)
        if signal.size == 0 or len(items) != count:
            has = f"{signal.size} elements" if signal.size else "one value, not a list"
            remedy = (
                "; for a value per group or wheelset, give [vehicle.formation] wheelsets_per_group, "
                "without which a plant has those of the two-part train"
            )
            raise FmuError(
                f"{who}: the list names {len(items)} variables, the signal has {has}{remedy if signal.size else ''}."
            )
        return tuple(_target(item, i + 1, signal, who) for i, item in enumerate(items))
    return tuple(_target(entry, i + 1, signal, who, pattern=signal.size > 0) for i in range(count))


def _unchanged(names: Sequence[str]) -> tuple[_MappedElement, ...]:
    return tuple(_MappedElement(variable=name, scale=1.0, stated_unit=None) for name in names)


def _target(item: object, index: int, signal: Port, who: str, *, pattern: bool = False) -> _MappedElement:
    scale: object = 1.0
    unit_entry: object = None
    name: object = item
    if isinstance(item, Mapping):
        fields = dict(cast(Mapping[str, object], item))
        name, scale, unit_entry = fields.pop("variable", None), fields.pop("scale", 1.0), fields.pop("unit", None)
        if fields:
            raise FmuError(f"{who} has no key '{next(iter(fields))}'; it has variable, scale and unit.")
    if not isinstance(name, str) or not name.strip("- "):
        raise FmuError(f"{who}: expected is the name of an FMU variable, got {name!r}.")
    if isinstance(scale, bool) or not isinstance(scale, int | float) or not np.isfinite(scale) or scale == 0:
        raise FmuError(f"{who}: scale is a finite number other than 0, got {scale!r}.")
    if unit_entry is not None and not isinstance(unit_entry, str):
        raise FmuError(f"{who}: unit is a text as 'bar', got {unit_entry!r}.")
    if pattern and "{i}" not in name:
        raise FmuError(
            f"{who} has {signal.size} elements; name them by a pattern, '{name}[{{i}}]', or by a list of {signal.size}."
        )
    sign = -1.0 if name.startswith("-") else 1.0
    return _MappedElement(
        variable=name.removeprefix("-").strip().replace("{i}", str(index)),
        scale=sign * float(scale),
        stated_unit=unit_entry,
        text=name.strip().replace("{i}", str(index)),
    )


def _require_one_meaning(description: Description, target: _MappedElement, who: str) -> _MappedElement:
    """Return a target; a variable whose own name begins with '-' is that variable, not a negation.

    Raises:
        FmuError: The FMU has that variable, and the one without '-'.
    """
    if target.text == target.variable or target.text not in description.variables:
        return target
    if target.variable in description.variables:
        raise FmuError(
            f"{who}: {description.file.name} has '{target.text}' as well as '{target.variable}', so '{target.text}' "
            f'is ambiguous; write {{ variable = "{target.variable}", scale = -1 }} for the latter with its sign '
            "changed, or rename the former in the FMU."
        )
    return replace(target, variable=target.text, scale=-target.scale)


def _all_missing(description: Description, missing: Sequence[str], causality: Causality, where: str) -> str:
    # All at once, so that one correction suffices.
    candidates = description.names(causality)
    lines = [f"'{name}'{_near(name, candidates, end='')}" for name in missing[:8]]
    rest = f", and {len(missing) - 8} more" if len(missing) > 8 else ""
    has = f"it has {', '.join(candidates[:12])}{', …' if len(candidates) > 12 else ''}" if candidates else "it has none"
    return (
        f"{description.file}: no {causality} {', '.join(lines)}{rest}; {has}. "
        f"Name the variables it uses instead under {where}; `railgrip map {description.file.name}` drafts the table."
    )


def _near(name: str, candidates: Sequence[str], end: str = ".") -> str:
    if question := did_you_mean(name, candidates):
        return f"; {question}" if end else f" ({question})"
    return f"; it has {', '.join(candidates)}." if end else ""


def _article(causality: Causality) -> str:
    names = {
        "parameter": "a parameter",
        "calculatedParameter": "a calculated parameter",
        "structuralParameter": "a structural parameter",
        "input": "an input",
        "output": "an output",
        "local": "a local variable",
        "independent": "the independent variable",
    }
    return names[causality]
