"""DAE expressions to arrays of CasADi expressions: operators, indexing, functions, comprehensions."""

from collections.abc import Callable, Generator, Hashable, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import Any

import casadi as ca
import numpy as np

from railgrip.base.errors import ShapeError
from railgrip.fmus.native.arrays import (
    BINARY,
    ELEMENTWISE,
    OF_NO_ELEMENTS,
    PARTIAL,
    RELATIONS,
    SHAPED,
    SX,
    UNARY,
    Array,
    Evaluation,
    Requirement,
    array,
    as_array,
    as_sx,
    both,
    choose,
    conditional_requirements,
    each,
    extended,
    integer,
    is_number,
    require,
    requirements,
    scalar,
)
from railgrip.fmus.native.dae import Binding, Dae, Node
from railgrip.fmus.native.stored_dae import parts_of

# Kind of a reference → kind of the symbols, where they differ. During an event a state has its value before reinit.
STORE = {
    "discrete_real": "discrete",
    "discrete_value": "discrete",
    "pre_discrete_real": "pre",
    "pre_discrete_value": "pre",
    "pre_state": "state",
    "output": "algebraic",
}

Subscript = list[int] | int | SX
"""Places from zero, one place, or an index from one that is known at run time only."""

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
        memo: Values already computed in this frame, by expression, and frames of calls.
    """

    binding: Binding = field(default_factory=dict)
    function: Node | None = None
    arguments: list[Array] = field(default_factory=list)
    definitions: "dict[Any, tuple[Array, Evaluation]]" = field(default_factory=dict)
    memo: dict[Any, Any] = field(default_factory=dict)

    def at(self, point: Binding) -> "Frame":
        """Return this frame with further loop variables."""
        return Frame({**self.binding, **point}, self.function, self.arguments, dict(self.definitions))


def _element(a: Array, axis: int, place: int) -> Array:
    # Without that place, not a number: the requirement of the index is violated wherever it is used.
    if 0 <= place < a.shape[axis]:
        return as_array(np.take(a, place, axis))
    return array([SX(np.nan)] * int(np.prod(a.shape) // max(a.shape[axis], 1)), a.shape[:axis] + a.shape[axis + 1 :])


class ExpressionBuilder:
    """Turns expression ids into arrays of CasADi expressions.

    Attributes:
        symbols: (store, variable id) → symbols of the variable.
        relations: Occurrences of relations that are constant between events → their memory symbols.
        conditions: DAE condition id → its expression; set after the conditions are known.
        required: When its requirements must hold (running, start, event, or watched: also between events if they have a
            meaning there) → evaluation of all expressions built.
    """

    def __init__(self, dae: Dae, symbols: Mapping[tuple[str, int], Array], time: SX) -> None:
        """Start without memory symbols: every relation has its present value."""
        self.dae, self.symbols, self.time = dae, symbols, time
        self.relations: dict[Site, SX] = {}
        self._memory = set[str]()  # the names of their symbols
        self._remembered = set[int]()  # the ids of their expressions
        self.conditions: Any = None
        self.required = {when: Evaluation() for when in ("running", "watched", "start", "event")}
        self._top = Frame()
        self._numbers: dict[float, Array] = {}
        self._user = self.required["running"]
        self._only_if: SX | None = None
        self._calls: list[str] = []
        self._is_guarded = False  # by a relation that keeps its value until an event

    @contextmanager
    def during(self, when: str, only_if: SX | None = None) -> Generator[None]:
        """Require what is built inside at a time (a key of `required`, or "never") and under a condition only."""
        with self._used_by(self.required.get(when, Evaluation()), only_if):
            yield

    @contextmanager
    def for_relations(self) -> Generator[None]:
        """Require nothing of what is built inside: that depends on the use of the relations and on its guards."""
        was_guarded, self._is_guarded = self._is_guarded, True
        with self.during("never"):
            yield
        self._is_guarded = was_guarded

    @contextmanager
    def under(self, condition: SX | None) -> Generator[None]:
        """Require what is built inside under a further condition."""
        with self._used_by(self._user, both(self._only_if, condition)):
            yield

    @contextmanager
    def _used_by(self, user: Evaluation, only_if: SX | None) -> Generator[None]:
        before = self._user, self._only_if
        self._user, self._only_if = user, only_if
        try:
            yield
        finally:
            self._user, self._only_if = before

    def _once(self, memo: dict[Any, Any], key: Hashable, compute: Callable[[], Array]) -> Array:
        # Each evaluation is kept with its requirements, because another user may need it under another condition.
        if key not in memo:
            evaluation = Evaluation()
            # As `_used_by`, which would take a noticeable part of the time, because this happens for every expression.
            before = self._user, self._only_if
            self._user, self._only_if = evaluation, None
            try:
                value = compute()
            finally:
                self._user, self._only_if = before
            memo[key] = value, evaluation
        value, evaluation = memo[key]
        if evaluation:
            self._user.uses.append((evaluation, self._only_if))
        return value

    def requirements(self) -> list[tuple[str, Requirement]]:
        """Return all requirements with the time when they must hold, without repetitions."""
        found: dict[tuple[Any, ...], tuple[str, Requirement]] = {}
        for when, root in self.required.items():
            for r in conditional_requirements(root):
                found.setdefault((when, r.where, r.sentence, r.holds.element_hash()), (when, r))
        return list(found.values())

    def know(self, numbers: Mapping[tuple[str, int], Array]) -> None:
        """Replace these symbols by their values from now on."""
        self.symbols = {**self.symbols, **numbers}
        self._top = Frame()

    def remember(self, relations: dict[Site, SX]) -> None:
        """Replace these occurrences of relations by their memory symbols from now on."""
        self.relations = relations
        self._memory, self._remembered = {s.name() for s in relations.values()}, {number for number, _ in relations}
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
        node = self.dae.expressions[expression]
        if node["operation"]["kind"] == "literal" and expression not in self._remembered:  # a third of all expressions
            return self._literal(node["operation"], node, frame)
        if frame.function is None and not self.relations and not node["domains"]:
            frame = self._top
        return self._once(frame.memo, expression, lambda: self._new_value(expression, frame))

    def _new_value(self, expression: int, frame: Frame) -> Array:
        is_relation = expression in self._remembered and frame.function is None
        memory = self.relations.get(site(expression, frame.binding)) if is_relation else None
        value = self._compute(expression, frame)  # for its requirements, even if its value is the memory
        return value if memory is None else scalar(memory)

    def _compute(self, expression: int, frame: Frame) -> Array:
        # A node of kind K is evaluated by the method _K(operation, node, frame).
        node = self.dae.expressions[expression]
        operation = node["operation"]
        method = getattr(self, f"_{operation['kind']}", None)
        if method is None:
            raise self._refusal(f"expression of kind {operation['kind']}", node)
        try:
            return method(operation, node, frame)
        except ShapeError as error:
            raise self.dae.refuse(f"{self.dae.text(node['provenance'])}: {error}", node["provenance"]) from error
        except (TypeError, IndexError, NotImplementedError, RuntimeError, ZeroDivisionError) as error:
            raise self._refusal("this form of an expression", node) from error

    def _require(self, name: str, operands: tuple[Array, ...], node: Node) -> None:
        if name in PARTIAL and (unfulfilled := requirements(name, operands)):
            text, where = self.dae.text(node["provenance"]), self.dae.where(node["provenance"])
            self._user.requirements += [
                Requirement(as_sx(holds), f"{text}: {rule}, but it is ", found, where)
                for holds, rule, found in unfulfilled
            ]

    def _refusal(self, construct: str, node: Node) -> Exception:
        text = self.dae.text(node["provenance"])
        return self.dae.refuse(f"{construct} is not supported: {text}", node["provenance"])

    def _literal(self, operation: Node, node: Node, frame: Frame) -> Array:
        ((kind, value),) = operation["value"].items()
        if kind == "string":
            raise self._refusal("a String in an equation", node)
        if value not in self._numbers:  # few differ
            self._numbers[value] = scalar(SX(float(value)))
        return self._numbers[value]

    def _coordinate(self, operation: Node, node: Node, frame: Frame) -> Array:
        coordinate = operation["coordinate"]
        kind: str = coordinate["kind"]
        if kind == "time":
            return scalar(self.time)
        if kind == "binder":
            return scalar(SX(float(frame.binding[coordinate["domain"], coordinate["ordinal"]])))
        if kind == "function_parameter":
            return frame.arguments[coordinate["ordinal"]]
        if kind == "condition":
            return scalar(self.conditions(coordinate["id"]))
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
        name, left = operation["operator"], self._value(operation["lhs"], frame)
        # The second operand of `and` and `or` may be guarded by the first (3.3).
        if name in ("and", "or") and left.ndim == 0:
            with self.under(left.item() if name == "and" else ca.logic_not(left.item())):
                right = self._value(operation["rhs"], frame)
        else:
            right = self._value(operation["rhs"], frame)
        value = apply(*(extended(name, (left, right)) if self._is_guarded else (left, right)))
        if not (name == "power" and left.ndim):  # the power of a matrix consists of products
            self._require(name, (left, right), node)
        return value

    def _conditional(self, operation: Node, node: Node, frame: Frame) -> Array:
        *pairs, last = operation["operands"]
        chosen: list[tuple[SX, Array]] = []
        was_guarded = self._is_guarded
        before: SX | None = None  # all earlier conditions are false
        for condition, branch in zip(pairs[::2], pairs[1::2], strict=True):
            with self.under(before):
                test = self._value(condition, frame).item()
            if is_number(test):
                if float(test):
                    last = branch
                    break
                continue
            self._is_guarded |= self._keeps_value(test)
            with self.under(both(before, test)):
                chosen.append((test, self._value(branch, frame)))
            before = both(before, ca.logic_not(test))
        with self.under(before):
            out = self._value(last, frame)
        self._is_guarded = was_guarded
        require(all(value.shape == out.shape for _, value in chosen), "the branches have different sizes (3.6.5)")
        for test, value in reversed(chosen):
            out = as_array(np.frompyfunc(lambda yes, no, test=test: choose(test, yes, no), 2, 1)(value, out))
        return out

    def _keeps_value(self, condition: SX) -> bool:
        return bool(self._memory) and any(s.name() in self._memory for s in ca.symvar(condition))

    def _array(self, operation: Node, node: Node, frame: Frame) -> Array:
        elements = [self._value(element, frame) for element in operation["operands"]]
        require(len({e.shape for e in elements}) == 1, "the elements of an array have equal sizes (10.4)")
        return np.stack(elements).astype(object)

    def _range(self, operation: Node, node: Node, frame: Frame) -> Array:
        first, step, last = (
            1 if operation[f"{k}_expression"] is None else self._whole_number(operation[f"{k}_expression"], frame, node)
            for k in ("start", "explicit_step", "stop")
        )
        values = range(first, last + (1 if step > 0 else -1), step)
        return array([SX(float(value)) for value in values], (len(values),))

    def _whole_number(self, expression: int, frame: Frame, node: Node) -> int:
        value = self._value(expression, frame).item()
        while not is_number(value):  # of a parameter, before `know` replaces it by its value
            symbols = ca.symvar(value)
            if any(s.name() not in self._bindings for s in symbols):
                raise self._refusal("a range that is only known at run time", node)
            bindings = [self._bindings[s.name()] for s in symbols]
            numbers = [SX(self(binding).flat[place]) for binding, place in bindings]
            value = ca.substitute(value, ca.vertcat(*symbols), ca.vertcat(*numbers))
        require(float(value).is_integer(), f"a range has whole numbers, got {float(value):g}")
        return integer(value)

    @cached_property
    def _bindings(self) -> dict[str, tuple[int, int]]:
        # Name of a scalar parameter → expression of its binding and place in that.
        return {
            name: (v["attributes"]["binding"], place)
            for v in self.dae.variables
            if v["role"] in ("parameter", "constant") and v["attributes"]["binding"] is not None
            for place, name in enumerate(v["scalar_names"])
        }

    def _comprehension(self, operation: Node, node: Node, frame: Frame) -> Array:
        points = list(self.dae.iterate(operation["domain"]))
        values = [self._value(operation["body"], frame.at(point)) for point in points]
        if not values:
            return array([], self.dae.extents(operation["domain"]))
        return np.stack(values).astype(object).reshape(self.dae.extents(operation["domain"]) + values[0].shape)

    def _subscripts(self, base: Array, operation: Node, node: Node, frame: Frame) -> list["Subscript"]:
        found: list[Subscript] = []
        subscripts = operation["subscripts"]
        require(len(subscripts) <= base.ndim, f"{len(subscripts)} subscripts for {base.ndim} dimensions (10.5)")
        for axis, subscript in enumerate(subscripts):
            size = base.shape[axis]
            if subscript["kind"] == "whole":
                found.append(list(range(size)))
                continue
            value = self._value(subscript["expression"], frame)
            for v in value.flat:
                self._require_index(v, size, axis, node)
            if all(is_number(v) for v in value.flat):
                places = [integer(v) - 1 for v in value.flat]
                found.append(places if value.ndim else places[0])
            elif value.ndim == 0:
                found.append(value.item())
            else:
                raise self._refusal("a vector of subscripts that is only known at run time", node)
        return [*found, *(list(range(size)) for size in base.shape[len(found) :])]

    def _require_index(self, index: SX, size: int, axis: int, node: Node) -> None:
        if is_number(index) and 1 <= float(index) <= size:  # most are; comparing expressions would take much longer
            return
        inside = SX(ca.logic_and(index >= 1, index <= size))
        text, where = self.dae.text(node["provenance"], subscripts=True), self.dae.where(node["provenance"])
        sentence = f"{text}: subscript {axis + 1} must be from 1 to {size}, but it is "
        self._user.requirements.append(Requirement(inside, sentence, SX(index), where))

    def _index(self, operation: Node, node: Node, frame: Frame) -> Array:
        out = self._value(operation["base"], frame)
        subscripts = self._subscripts(out, operation, node, frame)
        for axis, subscript in reversed(list(enumerate(subscripts))):
            if isinstance(subscript, list):
                parts = [_element(out, axis, place) for place in subscript]
                out = np.stack(parts, axis) if parts else np.take(out, [], axis)
            elif isinstance(subscript, int):
                out = _element(out, axis, subscript)
            else:
                value = _element(out, axis, 0)
                for place in range(1, out.shape[axis]):
                    value = each(partial(choose, subscript >= place + 0.5), 2)(_element(out, axis, place), value)
                inside = ca.logic_and(subscript >= 0.5, subscript <= out.shape[axis] + 0.5)
                out = each(lambda v, inside=inside: choose(inside, v, SX(np.nan)))(value)
        return out

    def _array_update(self, operation: Node, node: Node, frame: Frame) -> Array:
        base = self._value(operation["base"], frame).copy()
        subscripts = self._subscripts(base, operation, node, frame)
        value = self._value(operation["value"], frame)
        slices = [axis for axis, subscript in enumerate(subscripts) if isinstance(subscript, list)]
        shape = tuple(len(subscript) for subscript in subscripts if isinstance(subscript, list))
        require(
            value.shape == shape, f"an array of sizes {value.shape} is assigned to elements of sizes {shape} (11.2)"
        )
        every = [
            s if isinstance(s, list) else [s] if isinstance(s, int) else list(range(n))
            for s, n in zip(subscripts, base.shape, strict=True)
        ]
        for number in np.ndindex(*map(len, every)):
            place = tuple(places[k] for places, k in zip(every, number, strict=True))
            if not all(0 <= k < n for k, n in zip(place, base.shape, strict=True)):
                continue  # its requirement is violated
            element = value[tuple(number[axis] for axis in slices)] if slices else value.item()
            for subscript, k in zip(subscripts, place, strict=True):
                if isinstance(subscript, SX):
                    element = choose(subscript == k + 1, SX(element), SX(base[place]))
            base[place] = element
        return base

    def _builtin(self, operation: Node, node: Node, frame: Frame) -> Array:
        name = operation["builtin"]
        apply = ELEMENTWISE.get(name) or SHAPED.get(name)
        if apply is None:
            raise self._refusal(f"built-in operator {name}", node)
        arguments = tuple(self._value(argument, frame) for argument in operation["operands"])
        if name in OF_NO_ELEMENTS and len(arguments) == 1 and not arguments[0].size:
            return scalar(SX(OF_NO_ELEMENTS[name][self._type(operation["operands"][0])]))
        self._require(name, arguments, node)
        return apply(*(extended(name, arguments) if self._is_guarded else arguments))

    def _type(self, expression: int) -> str:
        # The type of an expression: that of its operands, unless an operator has a result of another type.
        operation = self.dae.expressions[expression]["operation"]
        name = operation.get("operator") or operation.get("builtin")
        if operation["kind"] == "literal":
            return next(iter(operation["value"]))
        if operation["kind"] == "coordinate":
            coordinate = operation["coordinate"]
            if coordinate["kind"] in ("binder", "condition"):
                return "integer" if coordinate["kind"] == "binder" else "boolean"
            return self.dae.variables[coordinate["id"]]["value_type"]["scalar"] if "id" in coordinate else "real"
        if name in RELATIONS or name == "not":
            return "boolean"
        if name in ("integer", "size", "ndims"):
            return "integer"
        operands = [operation["base"]] if "base" in operation else list(parts_of(operation))
        if operation["kind"] == "conditional":
            operands = [*operands[1::2], operands[-1]]
        types = {self._type(operand) for operand in operands}
        keeps_type = name is None or name in ("add", "subtract", "multiply", "negate", "plus", "abs", "sum", "product")
        return types.pop() if len(types) == 1 and keeps_type else "real"

    def _call(self, operation: Node, node: Node, frame: Frame) -> Array:
        function = self.dae.functions[operation["function"]]
        if function["external"]:
            return self._external(function, operation, node, frame)
        for assertion in function["assertions"]:
            if not self.dae.text(assertion["provenance"]).startswith("assert"):
                raise self.dae.refuse(
                    f"an output of function {function['name']} is not assigned in every case; assign it a value at "
                    f"the beginning: {self.dae.text(assertion['provenance'])}",
                    assertion["provenance"],
                )
            raise self.dae.refuse(
                f"an assert inside function {function['name']} is not supported; assert in the model that calls it",
                assertion["provenance"],
            )
        key = ("call", operation["function"], tuple(operation["operands"]))
        if key not in frame.memo:
            if function["name"] in self._calls:
                raise self._refusal(f"the recursive function {function['name']}", node)
            frame.memo[key] = Frame(function=function, arguments=[])
        inside = frame.memo[key]
        inside.arguments = [self._value(argument, frame) for argument in operation["operands"]]
        self._calls.append(function["name"])
        try:
            return self._definition(function["results"][operation["output"]], inside)
        finally:
            self._calls.pop()

    def _external(self, function: Node, operation: Node, node: Node, frame: Frame) -> Array:
        # Section 12.9: language "builtin" calls the function of the Modelica language, as in Modelica.Math.sin.
        external = function["external"]
        expressions = [argument.get("input") for argument in external["arguments"]]
        is_builtin = external["language"] == "builtin" and external["symbol"] in _BUILTIN_IN_LIBRARIES
        if not is_builtin or None in expressions or external["result"] != 0:
            raise self._refusal(f"external function {function['name']}", node)
        values = [self._value(argument, frame) for argument in operation["operands"]]
        call = {"builtin": external["symbol"], "operands": expressions}
        return self._builtin(call, node, Frame(function=function, arguments=values))

    def _function_value(self, operation: Node, node: Node, frame: Frame) -> Array:
        return self._definition(operation["definition_ordinal"], frame)

    def _definition(self, number: int, frame: Frame) -> Array:
        self._define(number, frame)
        return self._once(frame.definitions, number, lambda: array([]))  # it is defined now, and used here

    def _define(self, number: int, frame: Frame) -> None:
        function = frame.function
        assert function is not None
        if number in frame.definitions:
            return
        # A fold is a for loop: from its initial definitions, each step computes the parameters of the next.
        for fold in function["folds"]:
            if number in fold["output_definitions"]:
                current = self._definitions(fold["initial_definitions"], frame)
                for point in self.dae.iterate(fold["domain"]):
                    step = frame.at(point)
                    step.definitions.update(zip(fold["parameter_definitions"], current, strict=True))
                    current = self._definitions(fold["update_definitions"], step)
                frame.definitions.update(zip(fold["output_definitions"], current, strict=True))
                return
        with self.during("never"):
            self._once(frame.definitions, number, lambda: self._assigned(number, frame, function))

    def _definitions(self, numbers: list[int], frame: Frame) -> "list[tuple[Array, Evaluation]]":
        with self.during("never"):
            for number in numbers:
                self._define(number, frame)
        return [frame.definitions[number] for number in numbers]

    def _assigned(self, number: int, frame: Frame, function: Node) -> Array:
        definition = function["definitions"][number]
        value = self._value(definition["rhs"], frame)
        shape = self.dae.shape(function["values"][definition["target"]]["value_type"])
        require(value.shape == shape or not value.ndim, f"sizes {value.shape} are assigned to sizes {shape} (11.2)")
        return value if value.shape == shape else np.broadcast_to(value, shape)
