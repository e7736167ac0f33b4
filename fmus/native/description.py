"""modelDescription.xml: variables, units and structure of an FMU."""

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from importlib.metadata import version
from xml.sax.saxutils import escape

import casadi as ca

from railgrip.base.errors import UnitError
from railgrip.base.units import BASE, unit
from railgrip.fmus.native.arrays import SX
from railgrip.fmus.native.code import SOLVERS, first_references, groups_of, nominal, split_algebraics
from railgrip.fmus.native.system import System, column
from railgrip.fmus.native.variables import Scalar

TYPE = {"integer": "Integer", "boolean": "Boolean", "enumeration": "Integer"}

SETTINGS = {
    "_tolerance": "Relative error of an internal step; absolute error is this times the nominal value",
    "_solver": "3 RODAS3, 4 RODAS4",
    "_steps": "Internal steps taken",
    "_rejected": "Internal steps rejected",
    "_jacobians": "Evaluations of the Jacobian",
    "_evaluations": "Evaluations of the derivatives",
    "_events": "Event iterations",
}
"""Settings and counters of the runtime with their descriptions, in the order of their value references."""
_SOLVER_BOUNDS = {"min": "3", "max": "4"}

_Groups = Mapping[str, Sequence[Scalar]]
"""Variables of an FMU, see `groups_of`."""


@dataclass(slots=True)
class Writer:
    """Collects ScalarVariables, time first, and their indices for ModelStructure."""

    rows: list[str] = field(default_factory=list)
    index: dict[int, int] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.add("time", 0, causality="independent", variability="continuous", initial=None, attributes={"unit": "s"})

    def add(
        self,
        name: str,
        reference: int,
        *,
        causality: str,
        variability: str,
        initial: str | None,
        type_: str = "Real",
        start: float | None = None,
        description: str = "",
        attributes: dict[str, str] | None = None,
    ) -> None:
        """Add a variable; `attributes` are those of its type."""
        self.index.setdefault(reference, len(self.rows) + 1)
        inner = dict(attributes or {})
        if start is not None:
            inner["start"] = _number(start, type_)
        head = {"name": name, "valueReference": str(reference)}
        if description:
            head["description"] = description
        head |= {"causality": causality, "variability": variability}
        if initial:
            head["initial"] = initial
        self.rows.append(
            f"    <ScalarVariable{attributes_text(head)}><{type_}{attributes_text(inner)}/></ScalarVariable>"
        )

    def scalar(
        self, s: Scalar, reference: int, variability: str, *, causality: str = "", initial: str | None = "calculated",
        start: float | None = None, attributes: dict[str, str] | None = None,
    ) -> None:  # fmt: skip
        """Add a variable of the class; unless a causality is given, it is an output or local."""
        self.add(
            s.name,
            reference,
            causality=causality or ("output" if s.causality == "output" else "local"),
            variability=variability,
            initial=initial,
            type_="Real" if variability == "continuous" else _type(s),
            start=start,
            description=s.attributes.get("description") or "",
            attributes=_attributes(s) | (attributes or {}),
        )


_NOT_IN_XML = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
_ESCAPES = {'"': "&quot;", "\t": "&#9;", "\n": "&#10;", "\r": "&#13;"}


def attributes_text(values: dict[str, str]) -> str:
    """Return XML attributes with a space before each; a character that XML does not allow becomes U+FFFD."""
    texts = {key: escape(_NOT_IN_XML.sub("\ufffd", value), _ESCAPES) for key, value in values.items()}
    return "".join(f' {key}="{text}"' for key, text in texts.items())


def _number(value: float, type_: str) -> str:
    if type_ == "Boolean":
        return "true" if value else "false"
    return str(int(value)) if type_ == "Integer" else repr(float(value))


def _type(s: Scalar) -> str:
    return TYPE.get(s.type, "Real")


def _attributes(s: Scalar) -> dict[str, str]:
    type_ = _type(s)
    out: dict[str, str] = {}
    if type_ == "Real" and s.attributes.get("unit"):
        out["unit"] = s.attributes["unit"]
    if type_ == "Boolean":
        return out
    for key, name in (("min", "minimum"), ("max", "maximum"), ("nominal", "nominal")):
        value = s.bounds.get(name)
        if key == "nominal" and value is not None:  # FMI requires a positive one; solvers take 1 for zero
            value = abs(value) or None
        # A bound of 1e300 or more represents infinity.
        if value is not None and abs(value) < 1e300 and (type_ == "Real" or key != "nominal"):
            out[key] = _number(value, type_)
    return out


def write(
    system: System,
    *,
    identifier: str,
    interfaces: tuple[str, ...],
    solver: str,
    tolerance: float,
    step: float,
    files: Sequence[str] = ("model.c",),
) -> str:
    """Return modelDescription.xml, its GUID empty.

    Args:
        system: The system.
        identifier: Name of the library.
        interfaces: "me", "cs" or both.
        solver: See `code.c_sources`.
        tolerance: See `code.c_sources`.
        step: Suggested communication step [s].
        files: C files that must be compiled.
    """
    groups = groups_of(system)
    w = Writer()
    _variables(w, system, groups, solver, tolerance)
    flags = {
        "modelIdentifier": identifier,
        "canNotUseMemoryManagementFunctions": "true",
        "canGetAndSetFMUstate": "true",
        "canSerializeFMUstate": "true",
        "providesDirectionalDerivative": "true",
    }
    step_flag = {"canHandleVariableCommunicationStepSize": "true"}
    kinds = {"me": ("ModelExchange", flags), "cs": ("CoSimulation", flags | step_flag)}
    return document(
        {
            "fmiVersion": "2.0",
            "modelName": system.class_name,
            "guid": "",
            "generationTool": f"railgrip (rumoca {version('rumoca')}, CasADi {version('casadi')})",
            "variableNamingConvention": "structured",
            "numberOfEventIndicators": str(system.indicators.numel()),
        },
        dict(kinds[key] for key in kinds if key in interfaces),
        units=_units(groups),
        categories={"logStatusError": "Why a call failed", "logStatusWarning": "Assertions of level warning"},
        experiment={"tolerance": repr(tolerance), "stepSize": repr(step)},
        rows=w.rows,
        structure=_structure(w, system, groups),
        files=files,
    )


def document(
    head: dict[str, str],
    interfaces: Mapping[str, dict[str, str]],
    *,
    units: Iterable[str],
    categories: Mapping[str, str],
    experiment: dict[str, str],
    rows: Iterable[str],
    structure: Mapping[str, Sequence[str]],
    files: Sequence[str] = (),
) -> str:
    """Return modelDescription.xml.

    Args:
        head: Attributes of the document.
        interfaces: Attributes of CoSimulation and ModelExchange, as far as they are offered.
        units: Modelica unit strings in use.
        categories: Log categories with their descriptions.
        experiment: Further attributes of the default experiment.
        rows: Lines of `Writer`.
        structure: Lines of each part of ModelStructure; parts without a line are omitted.
        files: C files in `sources` that must be compiled; they are listed if there are any.
    """
    # Without generationDateAndTime, so that the same sources give the same bytes.
    return "\n".join(
        [
            '<?xml version="1.0" encoding="UTF-8"?>',
            f"<fmiModelDescription{attributes_text(head)}>",
            *(line for kind, flags in interfaces.items() for line in _interface(kind, flags, files)),
            *_unit_definitions(units),
            "  <LogCategories>",
            *(f"    <Category{attributes_text({'name': k, 'description': v})}/>" for k, v in categories.items()),
            "  </LogCategories>",
            f"  <DefaultExperiment{attributes_text({'startTime': '0', 'stopTime': '1'} | experiment)}/>",
            "  <ModelVariables>",
            *rows,
            "  </ModelVariables>",
            "  <ModelStructure>",
            *(
                line
                for name, lines in structure.items()
                if lines
                for line in (f"    <{name}>", *lines, f"    </{name}>")
            ),
            "  </ModelStructure>",
            "</fmiModelDescription>",
            "",
        ]
    )


def _interface(kind: str, flags: dict[str, str], files: Sequence[str]) -> list[str]:
    if not files:
        return [f"  <{kind}{attributes_text(flags)}/>"]
    entries = [f"      <File{attributes_text({'name': file})}/>" for file in files]
    return [f"  <{kind}{attributes_text(flags)}>", "    <SourceFiles>", *entries, "    </SourceFiles>", f"  </{kind}>"]


def _variables(w: Writer, system: System, groups: _Groups, solver: str, tolerance: float) -> None:
    def public(group: str) -> Iterator[tuple[int, Scalar, int]]:
        # Protected variables are hidden, as in OpenModelica's FMUs; states are listed anyway, because FMI requires it.
        return ((i, s, first[group] + i) for i, s in enumerate(groups[group]) if not s.protected)

    first = first_references(groups)
    for i, (s, calculated) in enumerate(zip(groups["states"], system.calculated, strict=True)):
        w.scalar(
            s, first["states"] + i, "continuous", initial="calculated" if calculated else "exact",
            start=None if calculated else s.start,
            attributes={"nominal": repr(nominal(s))} if nominal(s) != 1.0 else {},
        )  # fmt: skip
    for i, s in enumerate(groups["states"]):
        unit = s.attributes.get("unit")
        attributes = {"unit": _per_second(unit)} if unit else {}
        attributes["derivative"] = str(w.index[first["states"] + i])
        w.add(
            f"der({s.name})", first["derivatives"] + i, causality="local", variability="continuous",
            initial="calculated", attributes=attributes,
        )  # fmt: skip
    for i, s in enumerate(groups["inputs"]):
        variability = "continuous" if _type(s) == "Real" else "discrete"
        w.scalar(s, first["inputs"] + i, variability, causality="input", initial=None, start=s.start)
    for i, s, reference in public("parameters"):
        if i < len(system.variables.free):
            variability = "tunable" if s.attributes["is_tunable"] else "fixed"
            w.scalar(s, reference, variability, causality="parameter", initial="exact", start=s.start)
        else:
            w.scalar(s, reference, "tunable", causality="calculatedParameter")
    for group, variability in (("outputs", "continuous"), ("locals", "continuous"), ("discretes", "discrete")):
        for _, s, reference in public(group):
            w.scalar(s, reference, variability)
    parameters = {
        "_tolerance": ("Real", tolerance, {"unit": "1"}),
        "_solver": ("Integer", SOLVERS[solver], _SOLVER_BOUNDS),
    }
    for reference, (name, text) in enumerate(SETTINGS.items(), start=first["settings"]):
        type_, start, attributes = parameters.get(name, ("Integer", None, None))
        kind = ("local", "discrete", "calculated") if start is None else ("parameter", "tunable", "exact")
        w.add(
            name, reference, causality=kind[0], variability=kind[1], initial=kind[2], type_=type_, start=start,
            description=text, attributes=attributes,
        )  # fmt: skip


def _per_second(unit: str) -> str:
    if unit == "1":
        return "1/s"
    numerator, slash, denominator = unit.partition("/")
    if not slash:
        return f"{numerator}/s"
    inner = denominator[1:-1] if denominator.startswith("(") else denominator
    return f"{numerator}/s2" if inner == "s" else f"{numerator}/s3" if inner == "s2" else f"{numerator}/({inner}.s)"


def _units(groups: _Groups) -> set[str]:
    names = {"1", "s"}
    for group in groups.values():
        names |= {s.attributes["unit"] for s in group if s.attributes.get("unit") and _type(s) == "Real"}
    return names | {_per_second(s.attributes["unit"]) for s in groups["states"] if s.attributes.get("unit")}


def _unit_definitions(names: Iterable[str]) -> list[str]:
    out = ["  <UnitDefinitions>"]
    for name in sorted(names):
        try:
            known = unit(name)
        except UnitError:
            out.append(f"    <Unit{attributes_text({'name': name})}/>")
            continue
        base = {b: str(e) for b, e in zip(BASE, known.exponents, strict=True) if e}
        if known.factor != 1.0:
            base["factor"] = repr(known.factor)
        if known.offset:
            base["offset"] = repr(known.offset)
        out.append(f"    <Unit{attributes_text({'name': name})}><BaseUnit{attributes_text(base)}/></Unit>")
    return [*out, "  </UnitDefinitions>"]


def _structure(w: Writer, system: System, groups: _Groups) -> dict[str, list[str]]:
    first = first_references(groups)
    nx = len(groups["states"])
    outputs, _ = split_algebraics(system)
    unknowns = column([system.derivative, outputs])
    knowns = ca.vertcat(system.x, system.u)
    references = [first["states"] + i for i in range(nx)] + [first["inputs"] + i for i in range(len(groups["inputs"]))]
    jacobian = (
        ca.jacobian(unknowns, knowns) if unknowns.numel() and knowns.numel() else SX(unknowns.numel(), knowns.numel())
    )
    depends: list[list[tuple[int, str]]] = [[] for _ in range(unknowns.numel())]
    rows, columns = jacobian.sparsity().get_triplet()
    for k, (row, col) in enumerate(zip(rows, columns, strict=True)):
        kind = "constant" if jacobian.nz[k].is_constant() else "dependent"
        depends[row].append((w.index[references[col]], kind))

    def unknown(reference: int, on: list[tuple[int, str]] | None) -> tuple[int, str]:
        index = w.index[reference]
        if on is None:
            return index, f'      <Unknown index="{index}"/>'
        on = sorted(on)
        return index, (
            f'      <Unknown index="{index}" dependencies="{" ".join(str(i) for i, _ in on)}" '
            f'dependenciesKind="{" ".join(kind for _, kind in on)}"/>'
        )

    derivatives = [unknown(first["derivatives"] + i, depends[i]) for i in range(nx)]
    output_rows = [unknown(first["outputs"] + i, depends[nx + i]) for i in range(len(groups["outputs"]))]
    for i, s in enumerate(groups["states"]):
        if s.causality == "output":
            reference = first["states"] + i
            output_rows.append(unknown(reference, [(w.index[reference], "constant")]))
    discrete = [first["discretes"] + i for i, s in enumerate(groups["discretes"]) if s.causality == "output"]
    output_rows += [unknown(reference, None) for reference in discrete]
    initial = [first["outputs"] + i for i in range(len(groups["outputs"]))] + discrete
    initial += [first["states"] + i for i in range(nx) if system.calculated[i]]
    initial += [first["derivatives"] + i for i in range(nx)]
    initial += [
        first["parameters"] + i
        for i in range(len(system.variables.free), len(groups["parameters"]))
        if not groups["parameters"][i].protected
    ]
    unknowns_at_start = [unknown(reference, None) for reference in initial if reference in w.index]
    return {
        "Outputs": [line for _, line in sorted(output_rows)],
        "Derivatives": [line for _, line in derivatives],
        "InitialUnknowns": [line for _, line in sorted(unknowns_at_start)],
    }
