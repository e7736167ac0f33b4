"""The scalar variables of a flat class: symbols, start values, and the parameters that may be set."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from graphlib import TopologicalSorter
from math import isfinite

import casadi as ca
import numpy as np

from railgrip.fmus.native.arrays import SX, Array, array, as_sx, is_number
from railgrip.fmus.native.dae import Dae, Node
from railgrip.fmus.native.expressions import STORE, ExpressionBuilder

KINDS = ("parameter", "constant", "input", "state", "algebraic", "discrete")


@dataclass(slots=True, kw_only=True, eq=False)
class Scalar:
    """One scalar variable during translation.

    Attributes:
        kind: parameter, constant, input, state, algebraic or discrete.
        type: real, integer, boolean or enumeration.
        attributes: Attributes of the whole declared variable, which may be an array.
        start: Value before initialisation, with every parameter at its default.
        bounds: Attribute minimum, maximum or nominal → its value, with every parameter at its default.
        expression: Symbolic binding (parameters) or start (others), or None.
        fixed: Whether the start value is an initial condition.
        protected: Whether it is hidden from users of the class.
    """

    name: str
    kind: str
    type: str
    causality: str
    symbol: SX
    attributes: Node
    provenance: Node
    protected: bool
    start: float = 0.0
    expression: SX | None = None
    fixed: bool = False
    bounds: dict[str, float] = field(default_factory=dict[str, float])

    @property
    def binding(self) -> SX:
        """Symbolic binding or start, a number if none is declared."""
        return SX(self.start) if self.expression is None else self.expression

    def set_expression(self, expression: SX) -> None:
        """Set the symbolic binding or start; a number is also the value before initialisation."""
        self.expression = expression
        if is_number(expression):
            self.start = float(expression)


@dataclass(frozen=True, slots=True, kw_only=True)
class ModelVariables:
    """All scalars of a class by kind, in declaration order.

    Attributes:
        free: Parameters that may be set.
        dependent: Parameters computed from `free` by `dependent_values`.
        constants: Symbols and values of constants and structural parameters, whose value is compiled in: all
            parameters that are not Real, and final numbers.
    """

    of_id: dict[int, list[Scalar]]
    symbols: dict[tuple[str, int], Array]
    states: list[Scalar]
    inputs: list[Scalar]
    algebraics: list[Scalar]
    discretes: list[Scalar]
    free: list[Scalar]
    dependent: list[Scalar]
    dependent_values: list[SX]
    constants: tuple[SX, SX]
    derivatives: list[SX]
    previous: list[SX]

    def numbers(self) -> dict[tuple[str, int], Array]:
        """Return the values of constants and structural parameters by store and variable id."""
        symbols, values = (ca.vertsplit(part) if part.numel() else [] for part in self.constants)
        known = {s.name(): value for s, value in zip(symbols, values, strict=True)}
        return {
            key: array([known.get(s.name(), s) for s in of.flat], of.shape)
            for key, of in self.symbols.items()
            if key[0] in ("parameter", "constant")
        }

    def with_numbers(self, expressions: Sequence[SX]) -> list[SX]:
        """Return expressions with constants and structural parameters replaced by their numbers."""
        if not self.constants[0].numel():
            return list(expressions)
        return list(ca.substitute(list(expressions), [self.constants[0]], [self.constants[1]]))


def vector(scalars: Sequence[Scalar]) -> SX:
    """Return the column of the scalars' symbols."""
    return ca.vertcat(*[s.symbol for s in scalars]) if scalars else SX(0, 1)


def declare(dae: Dae) -> tuple[dict[int, list[Scalar]], dict[tuple[str, int], Array]]:
    """Return scalars by variable id, and the symbols that expressions refer to.

    Raises:
        TranslationError: An expression reads a String, or a variable has an unknown type or role.
    """
    of_id: dict[int, list[Scalar]] = {}
    symbols: dict[tuple[str, int], Array] = {}
    for v in dae.variables:
        kind, type_, names = STORE.get(v["role"], v["role"]), v["value_type"]["scalar"], v["scalar_names"]
        if type_ == "string" and kind in ("parameter", "constant") and not dae.is_read(v["id"]):
            of_id[v["id"]] = []
            continue
        if type_ not in ("real", "integer", "boolean", "enumeration"):
            raise dae.refuse(f"variable {v['name']} of type {type_} is not supported", v["declaration"])
        if kind not in KINDS:
            raise dae.refuse(f"variable {v['name']} of role {kind} is not supported", v["declaration"])
        shape = tuple(v["value_type"]["dimensions"])
        scalars = [SX.sym(name) for name in names]
        symbols[kind, v["id"]] = array(scalars, shape)
        if kind == "constant":  # expressions refer to both in the same way
            symbols["parameter", v["id"]] = symbols[kind, v["id"]]
        if kind == "state":
            symbols["derivative", v["id"]] = array([SX.sym(f"der({name})") for name in names], shape)
        if kind == "discrete":
            symbols["pre", v["id"]] = array([SX.sym(f"pre({name})") for name in names], shape)
        attributes = v["attributes"]
        fixed = set(attributes["fixed"] or ())
        # A protected output belongs to the equations of its class, and not to its interface.
        protected = v["name"] in dae.protected
        of_id[v["id"]] = [
            Scalar(
                name=name,
                kind=kind,
                type=type_,
                causality="local" if protected and kind != "input" else attributes["causality"],
                symbol=symbol,
                attributes=attributes,
                provenance=v["declaration"],
                protected=protected,
                fixed=fixed == {True},
            )
            for name, symbol in zip(names, scalars, strict=True)
        ]
        if kind == "parameter" and attributes["binding"] is None and fixed == {False}:
            raise dae.refuse(f"parameter {v['name']}(fixed=false) is not supported", v["declaration"])
    return of_id, symbols


def settle(
    dae: Dae, of_id: dict[int, list[Scalar]], symbols: dict[tuple[str, int], Array], evaluate: ExpressionBuilder
) -> ModelVariables:
    """Return the variables of a class, with their start values, and its parameters as free, dependent or structural.

    Raises:
        TranslationError: A structural parameter depends on a parameter that can be set.
    """
    for v in dae.variables:
        if v["value_type"]["scalar"] != "string":
            _set_start(v, of_id[v["id"]], evaluate)
    bounds = [bound for v in dae.variables for bound in _bounds(v, of_id[v["id"]], evaluate)]
    every = [s for scalars in of_id.values() for s in scalars]
    by_kind = {kind: [s for s in every if s.kind == kind] for kind in KINDS}

    # Constants and structural parameters come first, because the bindings of all others may depend on them.
    structural = by_kind["constant"] + [p for p in by_kind["parameter"] if _is_structural(p)]
    values = _evaluate_structural(dae, structural)
    constants = vector(structural), ca.vertcat(*values) if values else SX(0, 1)
    parameters = [p for p in by_kind["parameter"] if not _is_structural(p)]
    # One substitution for all, because each call has a fixed cost.
    symbolic = [p for p in parameters if p.expression is not None and not is_number(p.expression)]
    if symbolic and constants[0].numel():
        bindings = ca.substitute([p.binding for p in symbolic], [constants[0]], [constants[1]])
        for p, expression in zip(symbolic, bindings, strict=True):
            p.set_expression(expression)
    free = [p for p in parameters if p.expression is None or is_number(p.expression)]
    dependent = [p for p in symbolic if not is_number(p.binding)]
    dependent, dependent_values = _sort_dependent(dependent)
    out = ModelVariables(
        of_id=of_id,
        symbols=symbols,
        states=by_kind["state"],
        inputs=by_kind["input"],
        algebraics=by_kind["algebraic"],
        discretes=by_kind["discrete"],
        free=free,
        dependent=dependent,
        dependent_values=dependent_values,
        constants=constants,
        derivatives=[s for (store, _), symbols_ in symbols.items() if store == "derivative" for s in symbols_.flat],
        previous=[s for (store, _), symbols_ in symbols.items() if store == "pre" for s in symbols_.flat],
    )
    _set_default_values(dae, every, bounds, out)
    return out


def _is_structural(p: Scalar) -> bool:
    # Integers, Booleans and enumerations may have decided sizes, conditional components or if-equations in the front
    # end, which does not report it. A final number cannot be set.
    return p.type != "real" or (not p.attributes["is_tunable"] and p.expression is not None and is_number(p.expression))


def _set_start(v: Node, scalars: list[Scalar], evaluate: ExpressionBuilder) -> None:
    a = v["attributes"]
    has_binding = a["binding"] is not None and scalars and scalars[0].kind in ("parameter", "constant", "input")
    expression = a["binding"] if has_binding else a["start"]
    if expression is None:
        return
    for s, value in zip(scalars, _elements(v, evaluate(expression)), strict=True):
        s.set_expression(value)


_Bound = tuple[Scalar, str, SX]
"""A variable, the name of one of its attributes, and the expression of that."""


def _bounds(v: Node, scalars: list[Scalar], evaluate: ExpressionBuilder) -> Iterator[_Bound]:
    if v["value_type"]["scalar"] not in ("real", "integer"):
        return
    for key, name in (("min", "minimum"), ("max", "maximum"), ("nominal", "nominal")):
        if v["attributes"][key] is not None:
            with evaluate.during("never"):
                values = _elements(v, evaluate(v["attributes"][key]))
            yield from ((s, name, value) for s, value in zip(scalars, values, strict=True))


def _elements(v: Node, value: Array) -> list[SX]:
    shape = tuple(v["value_type"]["dimensions"])
    return [as_sx(element) for element in (value if value.shape == shape else np.broadcast_to(value, shape)).flat]


def _evaluate_structural(dae: Dae, scalars: list[Scalar]) -> list[SX]:
    values = [s.binding for s in scalars]
    # They may depend on each other in any order; a chain of dependences is not longer than their number.
    names, out = vector(scalars), ca.vertcat(*values) if values else SX(0, 1)
    for _ in range(len(scalars) + 1):
        if not out.numel() or not ca.depends_on(out, names):
            break
        out = ca.substitute(out, names, out)
    for s, value in zip(scalars, ca.vertsplit(out) if scalars else [], strict=True):
        if not is_number(value):
            raise dae.refuse(
                f"{s.name} must be a number at build time, but depends on a parameter that can be set",
                s.provenance,
            )
        s.start = float(value)
    return [SX(s.start) for s in scalars]


def _sort_dependent(dependent: list[Scalar]) -> tuple[list[Scalar], list[SX]]:
    if not dependent:  # CasADi cannot infer the type of an empty list
        return [], []
    before: dict[int, set[int]] = {i: set() for i in range(len(dependent))}
    bindings = ca.vertcat(*[p.binding for p in dependent])
    for i, j in zip(*ca.jacobian_sparsity(bindings, vector(dependent)).get_triplet(), strict=True):
        before[i].add(j)
    order = [dependent[i] for i in TopologicalSorter(before).static_order()]
    values, _ = ca.substitute_inplace([p.symbol for p in order], [p.binding for p in order], [])
    return order, list(values)


def _set_default_values(dae: Dae, every: list[Scalar], bounds: list[_Bound], v: ModelVariables) -> None:
    symbols = ca.vertcat(v.constants[0], vector(v.free), vector(v.dependent))
    free = ca.vertcat(*[SX(p.start) for p in v.free])
    dependent = ca.vertcat(*v.dependent_values)
    if v.dependent and v.free:
        dependent = ca.substitute(dependent, vector(v.free), free)
    numbers = ca.vertcat(v.constants[1], free, dependent)
    starts = [(s, "start", s.expression) for s in every if s.expression is not None]
    symbolic = [value for _, _, value in (*starts, *bounds) if not is_number(value)]
    values = iter(ca.substitute(symbolic, [symbols], [numbers]) if symbolic else [])
    for s, name, expression in (*starts, *bounds):
        value = expression if is_number(expression) else next(values)
        what = f"the value of {s.name}" if name == "start" and s.kind in KINDS[:3] else f"the {name} of {s.name}"
        if not is_number(value):
            if s.kind == "input":
                continue
            raise dae.refuse(f"{what} depends on a variable that changes (4.4.4)", s.provenance)
        if not isfinite(float(value)):
            raise dae.refuse(f"{what} is not a finite number if every parameter has its default value", s.provenance)
        if name == "start":
            s.start = float(value)
        else:
            s.bounds[name] = float(value)
