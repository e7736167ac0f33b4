"""DAE expressions to arrays of CasADi expressions: operators, indexing, functions, comprehensions."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from railgrip.fmus.native.arrays import (
    BINARY,
    ELEMENTWISE,
    SHAPED,
    SX,
    UNARY,
    Array,
    array,
    as_array,
    choose,
    integer,
    is_number,
)
from railgrip.fmus.native.dae import Binding, Dae, Node

# Kind of a reference → kind of the symbols, where they differ. During an event a state has its value before reinit.
STORE = {
    "discrete_real": "discrete",
    "discrete_value": "discrete",
    "pre_discrete_real": "pre",
    "pre_discrete_value": "pre",
    "pre_state": "state",
    "output": "algebraic",
}

Site = tuple[int, tuple[tuple[tuple[int, int], int], ...]]
"""One scalar occurrence of an expression: its id and the values of loop variables."""


def site(expression: int, binding: Binding) -> Site:
    """Return the occurrence of an expression under loop variables."""
    return expression, tuple(sorted(binding.items()))


_BUILTIN_IN_LIBRARIES = frozenset(
    ["sin", "cos", "tan", "asin", "acos", "atan", "atan2", "sinh", "cosh", "tanh", "exp", "log", "log10"]
)
"""Functions with language "builtin" in the Modelica Standard Library; none of them triggers events."""


@dataclass
class Frame:
    """Scope of an expression besides model variables.

    Attributes:
        binding: Values of loop variables.
        function: The function being evaluated, if any, with its arguments and definitions.
        memo: Values already computed in this frame, by expression or call.
    """

    binding: Binding = field(default_factory=dict)
    function: Node | None = None
    arguments: list[Array] = field(default_factory=list)
    definitions: dict[int, Array] = field(default_factory=dict)
    memo: dict[Any, Any] = field(default_factory=dict)

    def at(self, point: Binding) -> "Frame":
        """Return this frame with further loop variables."""
        return Frame({**self.binding, **point}, self.function, self.arguments, dict(self.definitions))


class ExpressionBuilder:
    """Turns expression ids into arrays of CasADi expressions.

    Attributes:
        symbols: (store, variable id) → symbols of the variable.
        relations: Occurrences of relations that are constant between events → their memory symbols.
        conditions: DAE condition id → its expression; set after the conditions are known.
    """

    def __init__(self, dae: Dae, symbols: Mapping[tuple[str, int], Array], time: SX) -> None:
        """Start without memory symbols: every relation has its present value."""
        self.dae, self.symbols, self.time = dae, symbols, time
        self.relations: dict[Site, SX] = {}
        self.conditions: Any = None
        self._top = Frame()

    def remember(self, relations: dict[Site, SX]) -> None:
        """Replace these occurrences of relations by their memory symbols from now on."""
        self.relations = relations
        self._top = Frame()

    def __call__(self, expression: int, binding: Binding | None = None) -> Array:
        """Return the value of an expression under loop variables."""
        return self._value(expression, Frame(binding) if binding else self._top)

    def live(self, expression: int, binding: Binding) -> Array:
        """Return the value of a relation itself, not of its memory."""
        return self._compute(expression, Frame(binding))

    def _value(self, expression: int, frame: Frame) -> Array:
        # An expression without loop variables has the same value at all points, unless its relations have a memory for
        # each point.
        if frame.function is None and not self.relations and self.dae.expressions[expression]["binder_domain"] is None:
            frame = self._top
        if expression not in frame.memo:
            memory = self.relations.get(site(expression, frame.binding)) if frame.function is None else None
            frame.memo[expression] = array([memory]) if memory is not None else self._compute(expression, frame)
        return frame.memo[expression]

    def _compute(self, expression: int, frame: Frame) -> Array:
        # A node of kind K is evaluated by the method _K(operation, node, frame).
        node = self.dae.expressions[expression]
        operation = node["operation"]
        method = getattr(self, f"_{operation['kind']}", None)
        if method is None:
            raise self._refusal(f"expression of kind {operation['kind']}", node)
        return method(operation, node, frame)

    def _refusal(self, construct: str, node: Node) -> Exception:
        text = self.dae.text(node["provenance"])
        return self.dae.refuse(f"{construct} is not supported: {text}", node["provenance"])

    def _literal(self, operation: Node, node: Node, frame: Frame) -> Array:
        ((kind, value),) = operation["value"].items()
        if kind == "string":
            raise self._refusal("a String in an equation", node)
        return array([SX(float(value))])

    def _coordinate(self, operation: Node, node: Node, frame: Frame) -> Array:
        coordinate = operation["coordinate"]
        kind: str = coordinate["kind"]
        if kind == "time":
            return array([self.time])
        if kind == "binder":
            return array([SX(float(frame.binding[coordinate["domain"], coordinate["ordinal"]]))])
        if kind == "function_parameter":
            return frame.arguments[coordinate["ordinal"]]
        if kind == "condition":
            return array([self.conditions(coordinate["id"])])
        store = STORE.get(kind, kind)
        if (store, coordinate.get("id")) not in self.symbols:
            raise self._refusal(f"a reference of kind {kind}", node)
        return self.symbols[store, coordinate["id"]]

    def _unary(self, operation: Node, node: Node, frame: Frame) -> Array:
        return UNARY[operation["operator"]](self._value(operation["operand"], frame))

    def _binary(self, operation: Node, node: Node, frame: Frame) -> Array:
        apply = BINARY.get(operation["operator"])
        if apply is None:
            raise self._refusal(f"operator {operation['operator']}", node)
        return apply(self._value(operation["lhs"], frame), self._value(operation["rhs"], frame))

    def _conditional(self, operation: Node, node: Node, frame: Frame) -> Array:
        *pairs, last = (self._value(operand, frame) for operand in operation["operands"])
        out = last
        for condition, value in reversed(list(zip(pairs[::2], pairs[1::2], strict=True))):
            test = condition.item()
            out = as_array(np.frompyfunc(lambda yes, no, test=test: choose(test, yes, no), 2, 1)(value, out))
        return out

    def _array(self, operation: Node, node: Node, frame: Frame) -> Array:
        return np.stack([self._value(element, frame) for element in operation["elements"]]).astype(object)

    def _range(self, operation: Node, node: Node, frame: Frame) -> Array:
        first, step, last = (
            operation[k]["value"] if operation.get(k) else 1 for k in ("start", "explicit_step", "stop")
        )
        values = range(first, last + (1 if step > 0 else -1), step)
        return array([SX(float(value)) for value in values], (len(values),))

    def _comprehension(self, operation: Node, node: Node, frame: Frame) -> Array:
        points = list(self.dae.iterate(operation["domain"]))
        values = [self._value(operation["body"], frame.at(point)) for point in points]
        if not values:
            return array([], self.dae.extents(operation["domain"]))
        return np.stack(values).astype(object).reshape(self.dae.extents(operation["domain"]) + values[0].shape)

    def _subscripts(self, base: Array, operation: Node, node: Node, frame: Frame) -> tuple[Any, ...] | SX:
        # Indices from zero if they are numbers, else Modelica's index of a vector, from one.
        places: list[Any] = []
        for subscript in operation["subscripts"]:
            if subscript["kind"] == "whole":
                places.append(slice(None))
                continue
            value = self._value(subscript["expression"], frame)
            if not all(is_number(v) for v in value.flat):
                if len(operation["subscripts"]) == 1 and value.ndim == 0 and base.ndim == 1:
                    return value.item()
                raise self._refusal("a matrix subscript that is only known at run time", node)
            places.append([integer(v) - 1 for v in value.flat] if value.ndim else integer(value.item()) - 1)
        return tuple(places)

    def _index(self, operation: Node, node: Node, frame: Frame) -> Array:
        base = self._value(operation["base"], frame)
        places = self._subscripts(base, operation, node, frame)
        if isinstance(places, tuple):
            return as_array(base[places])
        # Beyond the bounds the nearest element is selected, because the C code cannot raise an error here.
        out = base[0]
        for j in range(1, len(base)):
            out = choose(places >= j + 0.5, base[j], out)
        return array([out])

    def _array_update(self, operation: Node, node: Node, frame: Frame) -> Array:
        base = self._value(operation["base"], frame).copy()
        places = self._subscripts(base, operation, node, frame)
        value = self._value(operation["value"], frame)
        if not isinstance(places, tuple):
            return array([choose(places == j + 1, value.item(), base[j]) for j in range(len(base))], base.shape)
        base[places] = value.item() if value.ndim == 0 else value
        return base

    def _builtin(self, operation: Node, node: Node, frame: Frame) -> Array:
        name = operation["builtin"]
        apply = ELEMENTWISE.get(name) or SHAPED.get(name)
        if apply is None:
            raise self._refusal(f"built-in operator {name}", node)
        return apply(*(self._value(argument, frame) for argument in operation["arguments"]))

    def _call(self, operation: Node, node: Node, frame: Frame) -> Array:
        function = self.dae.functions[operation["function"]]
        if function["external"]:
            return self._external(function, operation, node, frame)
        for statement in function["statements"]:
            if statement["kind"] == "assertion":
                raise self.dae.refuse(
                    f"an assert inside function {function['name']} is not supported; assert in the model that calls it",
                    statement["provenance"],
                )
        key = ("call", operation["function"], tuple(operation["arguments"]))
        if key not in frame.memo:
            arguments = [self._value(argument, frame) for argument in operation["arguments"]]
            frame.memo[key] = Frame(function=function, arguments=arguments)
        return self._definition(function["results"][operation["output"]], frame.memo[key])

    def _external(self, function: Node, operation: Node, node: Node, frame: Frame) -> Array:
        # Section 12.9: language "builtin" calls the function of the Modelica language, as in Modelica.Math.sin.
        external = function["external"]
        expressions = [argument.get("input") for argument in external["arguments"]]
        is_builtin = external["language"] == "builtin" and external["symbol"] in _BUILTIN_IN_LIBRARIES
        if not is_builtin or None in expressions or external["result"] != 0:
            raise self._refusal(f"external function {function['name']}", node)
        values = [self._value(argument, frame) for argument in operation["arguments"]]
        call = {"builtin": external["symbol"], "arguments": expressions}
        return self._builtin(call, node, Frame(function=function, arguments=values))

    def _function_value(self, operation: Node, node: Node, frame: Frame) -> Array:
        return self._definition(operation["definition"], frame)

    _function_fold_parameter = _function_value
    _function_fold_output = _function_value

    def _definition(self, number: int, frame: Frame) -> Array:
        if number in frame.definitions:
            return frame.definitions[number]
        function = frame.function
        assert function is not None
        # A fold is a for loop: from its initial definitions, each step computes the parameters of the next.
        for fold in function["folds"]:
            if number in fold["output_definitions"]:
                current = [self._definition(k, frame) for k in fold["initial_definitions"]]
                for point in self.dae.iterate(fold["domain"]):
                    step = frame.at(point)
                    step.definitions.update(zip(fold["parameter_definitions"], current, strict=True))
                    current = [self._definition(k, step) for k in fold["update_definitions"]]
                frame.definitions.update(zip(fold["output_definitions"], current, strict=True))
                return frame.definitions[number]
        definition = function["definitions"][number]
        value = self._value(definition["rhs"], frame)
        shape = self.dae.shape(function["values"][definition["target"]]["value_type"])
        frame.definitions[number] = value if value.shape == shape else np.broadcast_to(value, shape)
        return frame.definitions[number]
