"""The description of an FMU file, read once, checked, and returned as a frozen value."""

import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final, Literal, cast, get_args

import fmpy
import numpy as np
from fmpy.model_description import ModelDescription, ValidationError, read_model_description

from railgrip.base.errors import FmuError, InputError, UnitError
from railgrip.base.files import require_regular, scratch
from railgrip.base.interrupted import postpone_interrupts
from railgrip.base.limits import FMU_LIMITS, MIB, FmuLimits
from railgrip.base.names import did_you_mean
from railgrip.base.system import Variable
from railgrip.base.units import BASE, Exponents, Unit, unit
from railgrip.fmi.archive import DESCRIPTION, Outline, digest, extract, members, outline

PLATFORM: Final[str] = fmpy.platform
"""Name of this platform in FMI 2.0: the folder of the binaries that this machine loads."""
PLATFORMS: Final[dict[int, str]] = {2: PLATFORM, 3: fmpy.platform_tuple}
"""Folder of the binaries by FMI version."""

Version = Literal[2, 3]
Kind = Literal["Real", "Integer", "Boolean", "String", "Enumeration", "Binary"]
Causality = Literal[
    "parameter", "calculatedParameter", "structuralParameter", "input", "output", "local", "independent"
]
_KINDS: Final[dict[str, Kind]] = {
    "Real": "Real", "Float32": "Real", "Float64": "Real", "Boolean": "Boolean", "String": "String",
    "Enumeration": "Enumeration", "Binary": "Binary",
}  # fmt: skip
"""Kinds of the FMI types; all others are integers."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FmuVariable(Variable):
    """One scalar variable of an FMU, or one element of an array of FMI 3.0.

    Its name is that in the FMU, `stiffness[1,3]` of an element. Its start value is NaN if it is not a number.

    Attributes:
        reference: FMI value reference, the same for all elements of an array.
        kind: Kind of value.
        carrier: Type in the names of its get and set functions: Real, or Float64.
        element: Position in its array, row by row, from 0; 0 for a scalar.
        elements: Size of its array; 1 for a scalar.
        causality: Causality by FMI.
        settable: Whether a value may be set before initialisation.
        defined_unit: Definition of its unit, or None if the FMU does not define it.
        relative: Whether it is a difference, to which a unit's offset does not apply.
        start_text: Start value as written in the FMU, or None.
        nominal: Magnitude of a Real variable, positive; 1 unless the FMU declares one.
    """

    reference: int
    kind: Kind
    carrier: str
    element: int = 0
    elements: int = 1
    causality: Causality
    settable: bool
    defined_unit: Unit | None
    relative: bool
    start_text: str | None
    nominal: float = 1.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Interface:
    """One of the two interfaces of an FMU, and its capabilities.

    Attributes:
        identifier: Name of its library.
        directional_derivatives: Whether it provides them by FMI 2.0.
        completed_steps: Whether a solver has to call completedIntegratorStep after each of its steps.
        fixed_step: Internal step of a co-simulation of FMI 3.0 [s], of which a communication step is a whole multiple,
            or None.
        only_step: The one communication step that it declares [s]: DefaultExperiment stepSize of a co-simulation that
            cannot handle a variable step and has no internal step; else None.
        once: Whether only one instance may exist in a process.
        needs_tool: Whether it runs only if the tool that made it is installed.
        saves_state: Whether its whole state can be saved and restored (FMI 2.0).
    """

    identifier: str
    directional_derivatives: bool
    completed_steps: bool
    fixed_step: float | None
    only_step: float | None = None
    once: bool = False
    needs_tool: bool
    saves_state: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class Description:
    """The description of an FMU.

    Attributes:
        file: Path of the FMU.
        fmi: Major version of FMI.
        digest: SHA-256 of the file, hexadecimal.
        model: Name of the model inside.
        guid: Identifier of the model, which the binary checks.
        generator: Tool that made the FMU.
        variables: Variables by name, in the FMU's order.
        states: Continuous states, in the order of fmi2GetContinuousStates.
        derivatives: Their derivatives, in the same order.
        dependencies: The states and inputs on which a derivative or output depends, as far as ModelStructure of FMI 2.0
            declares them.
        event_indicators: Number of event indicators.
        log_categories: Names of its log categories.
        co_simulation: Interface for Co-Simulation, or None.
        model_exchange: Interface for Model Exchange, or None.
        blemishes: Violations of FMI that do not affect results, as a clause, or ''.
    """

    file: Path
    fmi: Version
    digest: str
    model: str
    guid: str
    generator: str
    variables: Mapping[str, FmuVariable]
    states: tuple[str, ...]
    derivatives: tuple[str, ...]
    dependencies: Mapping[str, frozenset[str]]
    event_indicators: int
    log_categories: tuple[str, ...]
    co_simulation: Interface | None
    model_exchange: Interface | None
    blemishes: str

    def names(self, causality: Causality) -> tuple[str, ...]:
        """Return the names of all variables of one causality, in the FMU's order."""
        return tuple(v.name for v in self.variables.values() if v.causality == causality)

    def variable(self, name: str, wanted_by: str) -> FmuVariable:
        """Return the variable with a name.

        Args:
            name: Name in the FMU.
            wanted_by: Opening words of the message: who requires the variable.

        Raises:
            FmuError: The FMU lacks it; the message suggests similar names.
        """
        variable = self.variables.get(name)
        if variable is not None:
            return variable
        hint = did_you_mean(name, self.variables, count=3, cutoff=0.5, before="; ") or "."
        raise FmuError(f"{wanted_by}: {self.file.name} has no variable '{name}'{hint}")

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle the fields: the read-only view of the variables cannot be pickled."""
        content = {field.name: getattr(self, field.name) for field in fields(self)}
        return _restore, (content | {"variables": dict(self.variables)},)


def _restore(content: dict[str, Any]) -> Description:
    content["variables"] = MappingProxyType(content["variables"])
    return Description(**content)


def describe(file: Path, limits: FmuLimits = FMU_LIMITS) -> Description:
    """Read the description of an FMU.

    Raises:
        FmuError: The file is missing, not an FMU, beyond the limits, neither FMI 2.0 nor 3.0, uses clocks, lacks a
            binary for this platform, or its description is ambiguous or invalid.
    """
    path = Path(file)
    try:
        require_regular(path, limits.unpacked_mib * MIB, if_missing=", or build it (railgrip build)")
        content = digest(path)
    except InputError as error:
        raise FmuError(f"{error}.") from error
    inside = members(path, limits)
    first = outline(path, limits)
    fmi = _version(path, first)
    _require_known_unknowns(path, fmi, first)
    blemishes, read = _read(path, fmi)
    try:
        description = _description(path, fmi, content, read, first, blemishes, limits)
    except FmuError as error:
        raise FmuError(f"{path}: {error}") from error
    except (AttributeError, KeyError, TypeError, ValueError, OverflowError) as error:
        # Variables that the schema would have rejected, in an FMU that is accepted nevertheless.
        raise FmuError(f"{path}: {blemishes or f'{DESCRIPTION} cannot be understood'}: {error}.") from error
    return _with_binaries(description, inside)


def _version(path: Path, first: Outline) -> Version:
    if first.version == "2.0":
        return 2
    if first.version and re.fullmatch(r"3\.0(\.\d+)?", first.version):
        return 3
    version = f"FMI {first.version}" if first.version else "no fmiVersion"
    raise FmuError(f"{path}: railgrip runs FMI 2.0 and 3.0, this is {version}; export it again as one of these.")


def _require_known_unknowns(path: Path, fmi: Version, first: Outline) -> None:
    # FMPy would resolve an unknown reference to another variable, or crash.
    for number, line in first.indices:
        if fmi == 2 and not (number.isdecimal() and 1 <= int(number[:9]) <= first.variables):
            raise FmuError(
                f"{path}: ModelStructure (line {line} of {DESCRIPTION}) names variable number '{number}', but "
                f"there are {first.variables}, from 1; ask the tool that made the FMU."
            )
        if fmi == 3 and number not in first.references:
            raise FmuError(
                f"{path}: ModelStructure (line {line} of {DESCRIPTION}) names value reference '{number}', which no "
                "variable has; ask the tool that made the FMU."
            )


def _read(path: Path, fmi: Version) -> tuple[str, ModelDescription]:
    # FMPy gets the description alone: from an archive it would read further XML that has not been checked.
    with scratch("fmu") as folder, postpone_interrupts():
        extract(path, folder, lambda name: name == DESCRIPTION)
        file = str(folder / DESCRIPTION)
        try:
            return "", read_model_description(file, validate=True)
        except ValidationError as error:
            return _leniently(path, fmi, file, [str(p) for p in cast(list[object], error.problems)])
        except Exception as error:  # FMPy raises bare Exception for what its schema does not catch
            raise FmuError(f"{path}: {DESCRIPTION} cannot be understood: {error}") from error


def _leniently(path: Path, fmi: Version, file: str, problems: list[str]) -> tuple[str, ModelDescription]:
    # FMUs of other tools often run well in spite of a missing start value or an attribute that FMI does not define. A
    # violation that concerns a unit is reported when the variable is bound.
    more = f" (and {len(problems) - 3} more)" if len(problems) > 3 else ""
    clause = f"{DESCRIPTION} is not valid FMI {fmi}.0: {'; '.join(p.rstrip('.') for p in problems[:3])}{more}"
    refusal = f"{path}: {clause}. Correct it or ask the tool that made the FMU."
    try:
        read = read_model_description(file, validate=False)
        xml: Any = read
        names = [v.name for v in xml.modelVariables]
        complete = xml.guid and all(names) and len(set(names)) == len(names)
    except Exception as error:  # without its schema FMPy fails in as many ways as there are mistakes
        raise FmuError(refusal) from error
    if not complete:
        raise FmuError(refusal)
    return clause, read


def _with_binaries(description: Description, inside: frozenset[str]) -> Description:
    """Return the description with the interfaces whose binary the archive has."""
    folder, suffix = f"binaries/{PLATFORMS[description.fmi]}/", fmpy.sharedLibraryExtension
    interfaces = {"Co-Simulation": description.co_simulation, "Model Exchange": description.model_exchange}
    binaries = {way: f"{folder}{each.identifier}{suffix}" for way, each in interfaces.items() if each is not None}
    missing = {way: binary for way, binary in binaries.items() if binary not in inside}
    if not missing:
        return description
    if len(missing) < len(binaries):
        ((way, binary),) = missing.items()
        clause = f"it offers {way}, but its library {binary} is missing"
        return replace(
            description,
            co_simulation=None if way == "Co-Simulation" else description.co_simulation,
            model_exchange=None if way == "Model Exchange" else description.model_exchange,
            blemishes=f"{description.blemishes}; {clause}" if description.blemishes else clause,
        )
    binary = next(iter(missing.values()))
    # Only files are listed: folders, which may be empty, do not count.
    here = sorted(member for member in inside if member.startswith(folder))
    if here:
        raise FmuError(
            f"{description.file}: no binary for this platform, {binary} is missing; the archive has {', '.join(here)}. "
            f"The file must have the name of modelIdentifier in {DESCRIPTION}, in the same case."
        )
    others = sorted({m.split("/")[1] for m in inside if m.startswith("binaries/") and m.count("/") > 1})
    platforms = f"it has binaries for {', '.join(others)}" if others else "it has no binaries at all"
    raise FmuError(
        f"{description.file}: no binary for this platform, {binary} is missing; {platforms}. "
        f"Export it for {PLATFORMS[description.fmi]}."
    )


def _description(
    path: Path, fmi: Version, digest: str, read: ModelDescription, first: Outline, blemishes: str, limits: FmuLimits
) -> Description:
    xml: Any = read  # FMPy's classes annotate their fields loosely
    units = {u.name: _unit(u) for u in xml.unitDefinitions}
    _require_steppable(xml)
    count = sum(math.prod(entry.shape) for entry in xml.modelVariables)
    if count > limits.variables or any(size < 0 for entry in xml.modelVariables for size in entry.shape):
        raise FmuError(
            f"{DESCRIPTION} has {count} variables, elements of arrays counted; allowed are {limits.variables}, "
            "variables under [limits.fmu]."
        )
    elements = {v.name: [*_variables(fmi, v, units, first.relative)] for v in xml.modelVariables}
    variables = {variable.name: variable for array in elements.values() for variable in array}
    derivatives = tuple(unknown.variable for unknown in xml.derivatives)
    for d in derivatives:
        if d.derivative is None:
            raise FmuError(f"ModelStructure lists '{d.name}' as a derivative, but it does not declare the state.")
    event_indicators = int(xml.numberOfEventIndicators or 0)
    if not 0 <= event_indicators <= limits.variables:
        raise FmuError(
            f"numberOfEventIndicators is {event_indicators} in {DESCRIPTION}; allowed are 0 to "
            f"{limits.variables}, variables under [limits.fmu]."
        )
    tools = [e for e in (xml.coSimulation, xml.modelExchange) if e is not None and e.needsExecutionTool]
    if tools:
        blemishes = f"{blemishes}; " if blemishes else ""
        blemishes += f"it needs {xml.generationTool or 'the tool that made it'} on this machine (needsExecutionTool)"
    return Description(
        file=path,
        fmi=fmi,
        digest=digest,
        model=xml.modelName,
        guid=xml.guid,
        generator=xml.generationTool or "an unnamed tool",
        variables=MappingProxyType(variables),
        states=tuple(v.name for d in derivatives for v in elements[d.derivative.name]),
        derivatives=tuple(v.name for d in derivatives for v in elements[d.name]),
        dependencies={
            unknown.variable.name: frozenset(known.name for known in unknown.dependencies)
            for unknown in (*xml.derivatives, *xml.outputs)
            if unknown.dependencies is not None and fmi == 2
        },
        event_indicators=event_indicators,
        log_categories=tuple(c.name for c in xml.logCategories),
        co_simulation=_interface(xml.coSimulation, first.step),
        model_exchange=_interface(xml.modelExchange),
        blemishes=blemishes,
    )


def _require_steppable(xml: Any) -> None:
    clocks = [entry.name for entry in xml.modelVariables if entry.type == "Clock"]
    if clocks:
        raise FmuError(
            f"'{clocks[0]}' is a clock ({len(clocks)} in all), and railgrip steps FMUs without clocks; export "
            "it without them."
        )
    if xml.coSimulation is None and xml.modelExchange is None:
        raise FmuError("it offers neither Co-Simulation nor Model Exchange; export it with one of these interfaces.")


def _unit(element: Any) -> Unit | None:
    base = element.baseUnit
    if base is None:
        return None
    kg, m, s, a, k, mol, cd, rad = (int(getattr(base, b) or 0) for b in BASE)
    exponents: Exponents = (kg, m, s, a, k, mol, cd, rad)
    factor = 1.0 if base.factor is None else float(base.factor)
    offset = 0.0 if base.offset is None else float(base.offset)
    try:
        return _with_angle(Unit(name=element.name, exponents=exponents, factor=factor, offset=offset))
    except UnitError as error:
        raise FmuError(f"UnitDefinitions: {error}") from error


def _with_angle(angle_unit: Unit) -> Unit:
    # The radian is a base unit in FMI, but dimensionless in SI: OpenModelica declares "rad/s" as one over the second.
    # The name is used if it differs from the definition only in that, so that a frequency does not become an angular
    # velocity. A name in revolutions or degrees is used if the definition has the factor of the radian or of that
    # count.
    try:
        registry_unit = unit(angle_unit.name)
    except UnitError:
        return angle_unit
    return registry_unit if not angle_unit.offset and angle_unit.leaves_the_angle_out_of(registry_unit) else angle_unit


_REFERENCES = 1 << 32
"""Value references are unsigned integers of 32 bits (FMI 2.0.4, §2.1.2)."""
_REAL = re.compile(r"\s*([+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?|[+-]?INF)\s*", re.ASCII)
"""A number in the format of XML Schema, except NaN, which is not valid as a bound."""


def _value_of(element: Any, attribute: str, text: str | None) -> float | None:
    kind = _KINDS.get(element.type, "Integer")
    if text is None or kind in ("String", "Binary"):
        return None
    kind = "Integer" if kind == "Enumeration" else kind
    value = {"true": 1.0, "false": 0.0, "1": 1.0, "0": 0.0}.get(text.strip()) if kind == "Boolean" else None
    if attribute == "start" and kind == "Real" and text.strip() in ("NaN", "INF", "-INF"):
        # The start value of a variable that nothing here reads or sets; XML Schema has these three.
        return math.nan
    if kind != "Boolean" and _REAL.fullmatch(text):
        value = float(text)
        most = 1 << (64 if "64" in element.type else 32 if element.type == "UInt32" else 31)
        is_whole = math.isfinite(value) and value == int(value) and abs(value) < most
        if (attribute == "start" and not math.isfinite(value)) or (kind == "Integer" and not is_whole):
            value = None
    if value is None:
        raise FmuError(
            f"'{element.name}' has {attribute}={text[:40]!r} in {DESCRIPTION}, which is no {kind}; "
            "correct it or ask the tool that made the FMU."
        )
    return value


def _nominal_of(element: Any) -> float:
    declaration = element.declaredType
    text = element.nominal if element.nominal is not None or declaration is None else declaration.nominal
    size = abs(float(text)) if text is not None and _REAL.fullmatch(text) else 1.0
    return size if 0.0 < size < math.inf else 1.0


def _variables(
    fmi: Version, element: Any, units: Mapping[str, Unit | None], relatives: frozenset[str]
) -> Iterator[FmuVariable]:
    # A scalar, or the elements of an array.
    reference = int(element.valueReference)
    if not 0 <= reference < _REFERENCES:
        raise FmuError(
            f"'{element.name}' has valueReference {reference} in {DESCRIPTION}; it is a whole number "
            f"from 0 to {_REFERENCES - 1}. Ask the tool that made the FMU."
        )
    if element.causality not in get_args(Causality):
        raise FmuError(
            f"'{element.name}' has causality={element.causality!r} in {DESCRIPTION}; it is one of "
            f"{', '.join(get_args(Causality))}."
        )
    is_text = element.type in ("String", "Binary")
    texts = [element.start] if element.start is None or is_text or not element.shape else element.start.split()
    count = math.prod(element.shape)
    if len(texts) not in (1, count):
        raise FmuError(
            f"'{element.name}' has {len(texts)} start values in {DESCRIPTION} and {count} elements; correct it "
            "or ask the tool that made the FMU."
        )
    declaration = element.declaredType
    unit_name = element.unit or (declaration.unit if declaration is not None else None) or ""
    least = element.min if element.min is not None or declaration is None else declaration.min
    most = element.max if element.max is not None or declaration is None else declaration.max
    first = FmuVariable(
        name=element.name,
        reference=reference,
        kind=_KINDS.get(element.type, "Integer"),
        carrier={2: "Integer", 3: "Int64"}[fmi] if element.type == "Enumeration" else element.type,
        elements=count,
        causality=element.causality,
        # FMI 2.0.4, §2.2.7: only exact or approximate start values may be changed, constants never. Structural
        # parameters of FMI 3.0 would require another mode, and determine the number of variables.
        settable=element.initial in ("exact", "approx")
        and element.variability != "constant"
        and element.causality != "structuralParameter"
        and element.type != "Binary",
        defined_unit=units.get(unit_name),
        unit=unit_name,
        relative=element.name in relatives or bool(declaration is not None and declaration.relativeQuantity),
        start=math.nan,
        start_text=None,
        minimum=_value_of(element, "min", least),
        maximum=_value_of(element, "max", most),
        description=element.description or "",
        nominal=_nominal_of(element),
    )
    for place, index in enumerate(np.ndindex(element.shape)):
        text = texts[place % len(texts)]
        start = _value_of(element, "start", text)
        name = f"{element.name}[{','.join(str(i + 1) for i in index)}]" if index else element.name
        yield replace(first, name=name, element=place, start=math.nan if start is None else start, start_text=text)


def _interface(element: Any, suggested: str = "") -> Interface | None:
    if element is None:
        return None
    text = getattr(element, "fixedInternalStepSize", None)
    if text is not None and not 0.0 < float(text) < math.inf:
        raise FmuError(
            f"fixedInternalStepSize is {text} in {DESCRIPTION}, but a positive time in s is expected; correct "
            "it or ask the tool that made the FMU."
        )
    only_step = None
    if suggested and text is None and not element.canHandleVariableCommunicationStepSize:
        only_step = float(suggested) if _REAL.fullmatch(suggested) else math.nan
        if not 0.0 < only_step < math.inf:
            raise FmuError(
                f"stepSize is {suggested[:40]} in {DESCRIPTION}, but a positive time in s is expected; correct "
                "it or ask the tool that made the FMU."
            )
    return Interface(
        identifier=element.modelIdentifier,
        directional_derivatives=bool(element.providesDirectionalDerivative),
        completed_steps=bool(getattr(element, "needsCompletedIntegratorStep", False)),
        fixed_step=None if text is None else float(text),
        only_step=only_step,
        once=bool(element.canBeInstantiatedOnlyOncePerProcess),
        needs_tool=bool(element.needsExecutionTool),
        saves_state=bool(element.canGetAndSetFMUstate),
    )
