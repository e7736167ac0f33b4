"""rumoca's checked DAE as it is stored in JSON, converted to the form that the compiler reads.

In JSON a tagged value is a name or {name: content}, the operands and subscripts of all expressions are two lists in the
order of the expressions, and the statements of a function assign variables; here a tagged value is {"kind": name,
**content}, each expression has its operands, and a function is in static single assignment form.
"""

from collections.abc import Iterator, Sequence
from itertools import islice, product
from math import pi
from typing import Any

from railgrip.base.errors import TranslationError
from railgrip.fmus.native.classes import Node

VERSION = 43
"""Version of the JSON that is read."""


def convert(stored: Node) -> Node:
    """Return a DAE in that form.

    Args:
        stored: The object `storage` of rumoca's JSON of a DAE; parts of it are in the result.
    """
    types = stored["value_types"]
    expressions, steps = _expressions(stored["expressions"])
    owners = [o | {"branches": [_activated(b) for b in o["branches"]]} for o in stored["discrete_value_owners"]]
    return stored | {
        "variables": [_variable(i, v, types[v["value_type"]]) for i, v in enumerate(stored["variables"])],
        "functions": [_function(f) for f in stored["functions"]],
        "expressions": expressions,
        "continuous_equation_operations": [_tagged(o) for o in stored["continuous_equation_operations"]],
        "initialization_equation_operations": [_tagged(o) for o in stored["initialization_equation_operations"]],
        "discrete_real_equations": [_activated(e) for e in stored["discrete_real_equations"]],
        "discrete_value_owners": owners,
        "relations": [_relation(i, r, expressions, steps) for i, r in enumerate(stored["relations"])],
        "conditions": [_with_operation(c, "node") for c in stored["conditions"]],
        "event_actions": [_with_operation(a, "kind") for a in stored["event_actions"]],
        "clocks": [_with_operation(c, "kind") for c in stored["clocks"]],
    }


_CONTENT = {
    "relation": "relation", "clock": "clock", "not": "condition",
    "discrete": "expression", "index": "expression", "slice": "expression",
}  # fmt: skip
"""Kind → name of its content, if that is a number and not the id of a variable."""


def _tagged(value: Any) -> Node:
    if isinstance(value, str):
        return {"kind": value}
    ((kind, content),) = value.items()
    if kind == "quotient_owner":  # the condition under which its steps cause events
        return {"kind": "always"}
    return {**(content if isinstance(content, dict) else {_CONTENT.get(kind, "id"): content}), "kind": kind}


def _activated(node: Node) -> Node:
    return node | {"activation": _tagged(node["activation"])}


def _with_operation(node: Node, name: str) -> Node:
    return {"operation": _tagged(node[name]), **{k: v for k, v in node.items() if k != name}}


def _variable(number: int, variable: Node, value_type: Node) -> Node:
    name, shape = variable["name"], value_type["dimensions"]
    points = product(*(range(1, n + 1) for n in shape))
    names = [f"{name}[{','.join(map(str, point))}]" for point in points] if shape else [name]
    return variable | {"id": number, "value_type": value_type, "scalar_names": names}


def _relation(number: int, relation: Node, expressions: Sequence[Node], steps: Sequence[int]) -> Node:
    if "quotient_owner" in relation:
        expression = steps[relation["quotient_owner"]["owner"]]
        return {"id": number, "expression": expression, "provenance": expressions[expression]["provenance"]}
    return {"id": number, **_tagged(relation)}


def _expressions(stored: Node) -> tuple[list[Node], list[int]]:
    # The expressions, and for each mod, rem and div the id of the relation that represents its steps; one in a function
    # has none, but a number.
    out: list[Node] = []
    steps: list[int] = []
    operands, subscripts = iter(stored["operands"]), iter(stored["subscripts"])
    for node, provenance in zip(stored["nodes"], stored["provenance"], strict=True):
        if "runtime_quotient_owner" in node:
            operations = _quotient(node["runtime_quotient_owner"], len(out))
            steps.append(len(out) + len(operations) - 1)
        else:
            operations = [_operation(node, operands, subscripts, out)]
        out += [{"operation": operation, "provenance": provenance} for operation in operations]
    for expression in out:
        _domains(expression, out)
    return out, steps


def _quotient(content: Node, number: int) -> list[Node]:
    # In a model, unlike in a function, sin(π lhs/rhs) >= 0 represents the steps; these expressions have ids, too.
    lhs, rhs = content["lhs"], content["rhs"]
    value: Node = {"kind": "builtin", "builtin": content["builtin"], "operands": [lhs, rhs]}
    if "model" not in content["kind"]:
        return [value]
    return [
        value,
        {"kind": "binary", "operator": "divide", "lhs": lhs, "rhs": rhs},
        {"kind": "literal", "value": {"real": pi}},
        {"kind": "binary", "operator": "multiply", "lhs": number + 2, "rhs": number + 1},
        {"kind": "builtin", "builtin": "sin", "operands": [number + 3]},
        {"kind": "literal", "value": {"real": 0.0}},
        {"kind": "binary", "operator": "greater_equal", "lhs": number + 4, "rhs": number + 5},
    ]


def _operation(node: Node, operands: Iterator[int], subscripts: Iterator[Node], before: Sequence[Node]) -> Node:
    ((kind, content),) = node.items()
    if kind == "literal":
        return {"kind": kind, "value": content}
    if kind == "coordinate":
        return {"kind": kind, "coordinate": _tagged(content)}
    operation = {**content, "kind": kind}
    if "operand_count" in content:
        operation["operands"] = list(islice(operands, content["operand_count"]))
    if "subscript_count" in content:
        operation["subscripts"] = [_tagged(s["kind"]) for s in islice(subscripts, content["subscript_count"])]
    if kind == "call" and content["owner"] < len(before):  # further outputs of the same call
        operation["operands"] = before[content["owner"]]["operation"]["operands"]
    return operation


_NONE = frozenset[int]()


def _domains(expression: Node, every: Sequence[Node]) -> frozenset[int]:
    # The domains of the loop variables on which an expression depends, which become a part of it.
    if "domains" not in expression:
        operation = expression["operation"]
        kind, found = operation["kind"], _NONE
        if kind == "coordinate" and operation["coordinate"]["kind"] == "binder":
            found = frozenset([operation["coordinate"]["domain"]])
        elif kind not in ("coordinate", "literal", "function_value"):
            for number in parts_of(operation):
                found |= _domains(every[number], every)
            if kind == "comprehension":
                found -= {operation["domain"]}
        expression["domains"] = found
    return expression["domains"]


def parts_of(operation: Node) -> Iterator[int]:
    """Yield the expressions of which an operation consists."""
    for key in ("operand", "lhs", "rhs", "base", "value", "body"):
        if key in operation:
            yield operation[key]
    yield from operation.get("operands", ())
    for subscript in operation.get("subscripts", ()):
        if "expression" in subscript:
            yield subscript["expression"]


def _function(function: Node) -> Node:
    definitions: list[Node] = []
    folds: list[Node] = []
    assertions: list[Node] = []
    last: dict[int, int] = {}

    def define(target: int, expression: int | None = None) -> int:
        last[target] = len(definitions)
        definitions.append({"target": target, "rhs": expression})
        return last[target]

    def run(statements: Sequence[Node]) -> None:
        for statement in statements:
            ((kind, content),) = statement.items()
            match kind:
                case "assertion":
                    assertions.append(content)
                case "assignment":
                    define(content["target"], content["rhs"])
                case "assignment_group":
                    for assignment in content["assignments"]:
                        define(assignment["target"], assignment["rhs"])
                case "for":  # the definitions of its parameters are before those of its body
                    fold: Node = {"domain": content["domain"]}
                    folds.append(fold)
                    fold["initial_definitions"] = [last[target] for target in content["targets"]]
                    fold["parameter_definitions"] = [define(target) for target in content["targets"]]
                    run(content["statements"])
                    fold["update_definitions"] = [last[target] for target in content["targets"]]
                    fold["output_definitions"] = [define(target) for target in content["targets"]]
                case _:
                    raise TranslationError(f"function {function['name']}: statements of kind {kind} are not supported")

    run(function["statements"])
    return function | {
        "values": [*function["outputs"], *function["locals"]],
        "definitions": definitions,
        "assertions": assertions,
        "folds": folds,
        "results": [last.get(i) for i in range(len(function["outputs"]))],
    }
