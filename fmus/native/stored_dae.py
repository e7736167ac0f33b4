"""rumoca's checked DAE as it is stored in JSON, converted to the form that the compiler reads.

In JSON a tagged value is a name or {name: content}, the operands and subscripts of all expressions are two lists in the
order of the expressions, and the statements of a function assign variables; here a tagged value is {"kind": name,
**content}, each expression has its operands, and a function is in static single assignment form.
"""

from collections.abc import Iterator, Sequence
from itertools import islice, product
from typing import Any

from railgrip.fmus.native.classes import Node

VERSION = 43
"""Version of the JSON that is read."""


def convert(stored: Node) -> Node:
    """Return the variables, functions, domains, value types, expressions and systems of a DAE.

    Args:
        stored: The object `storage` of rumoca's JSON of a DAE; parts of it are in the result.
    """
    types = stored["value_types"]
    return {
        "value_types": types,
        "variables": [_variable(i, v, types[v["value_type"]]) for i, v in enumerate(stored["variables"])],
        "functions": [_function(f) for f in stored["functions"]],
        "domains": stored["domains"],
        "expressions": _expressions(stored["expressions"]),
        "systems": {
            "continuous": {"owners": [_tagged(o) for o in stored["continuous_equation_operations"]]},
            "initialization": {
                "parameter_values": stored["initial_parameter_values"],
                "discrete_values": stored["initial_discrete_values"],
                "owners": [_tagged(o) for o in stored["initialization_equation_operations"]],
            },
            "discrete_real": {"residuals": [_activated(e) for e in stored["discrete_real_equations"]]},
            "discrete_values": {
                "owners": [
                    o | {"branches": [_activated(b) for b in o["branches"]]} for o in stored["discrete_value_owners"]
                ]
            },
            "conditions": {
                "relations": [{"id": i, **_tagged(r)} for i, r in enumerate(stored["relations"])],
                "conditions": [_with_operation(c, "node") for c in stored["conditions"]],
                "structured_roots": [_tagged(r) for r in stored["structured_roots"]],
            },
            "events": {
                "time_events": stored["time_events"],
                "actions": [_with_operation(a, "kind") for a in stored["event_actions"]],
            },
            "clocks": {"clocks": [_with_operation(c, "kind") for c in stored["clocks"]]},
            "temporal": {
                "previous": stored["previous_values"],
                "terminals": stored["terminals"],
                "delays": stored["delays"],
            },
        },
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
    return {"kind": kind, **(content if isinstance(content, dict) else {_CONTENT.get(kind, "id"): content})}


def _activated(node: Node) -> Node:
    return node | {"activation": _tagged(node["activation"])}


def _with_operation(node: Node, name: str) -> Node:
    return {"operation": _tagged(node[name]), **{k: v for k, v in node.items() if k != name}}


def _variable(number: int, variable: Node, value_type: Node) -> Node:
    name, shape, attributes = variable["name"], value_type["dimensions"], variable["attributes"]
    fixed = attributes["fixed"]
    points = product(*(range(1, n + 1) for n in shape))
    return {
        "id": number,
        "name": name,
        "role": variable["role"],
        "value_type": value_type,
        "scalar_names": [f"{name}[{','.join(map(str, point))}]" for point in points] if shape else [name],
        "declaration": variable["declaration"],
        "attributes": {
            "binding": attributes["binding"],
            "start": attributes["start"],
            "fixed": fixed[0] if fixed is not None and len(set(fixed)) == 1 else None,
            "minimum": attributes["min"],
            "maximum": attributes["max"],
            "nominal": attributes["nominal"],
            "unit": attributes["unit"],
            "state_select": attributes["state_select"],
            "description": attributes["description"],
            "causality": attributes["causality"],
            "tunable": attributes["is_tunable"],
        },
    }


def _expressions(stored: Node) -> list[Node]:
    out: list[Node] = []
    operands, subscripts = iter(stored["operands"]), iter(stored["subscripts"])
    for node, provenance in zip(stored["nodes"], stored["provenance"], strict=True):
        operation = _operation(node, operands, subscripts, out)
        out.append({"operation": operation, "domains": _domains(operation, out), "provenance": provenance})
    return out


def _operation(node: Node, operands: Iterator[int], subscripts: Iterator[Node], before: Sequence[Node]) -> Node:
    ((kind, content),) = node.items()
    if kind == "literal":
        return {"kind": kind, "value": content}
    if kind == "coordinate":
        return {"kind": kind, "coordinate": _tagged(content)}
    operation = {"kind": kind, **content}
    if "operand_count" in content:
        operation["operands"] = list(islice(operands, content["operand_count"]))
    if "subscript_count" in content:
        operation["subscripts"] = [_tagged(s["kind"]) for s in islice(subscripts, content["subscript_count"])]
    if kind == "call" and content["owner"] < len(before):  # further outputs of the same call
        operation["operands"] = before[content["owner"]]["operation"]["operands"]
    return operation


_NONE = frozenset[int]()


def _domains(operation: Node, before: Sequence[Node]) -> frozenset[int]:
    # The domains of the loop variables on which an expression depends.
    kind = operation["kind"]
    if kind == "coordinate":
        coordinate = operation["coordinate"]
        return frozenset([coordinate["domain"]]) if coordinate["kind"] == "binder" else _NONE
    found = _NONE
    for key in ("operand", "lhs", "rhs", "base", "value", "body"):
        if isinstance(number := operation.get(key), int):
            found |= before[number]["domains"]
    for number in operation.get("operands", ()):
        found |= before[number]["domains"]
    for subscript in operation.get("subscripts", ()):
        if "expression" in subscript:
            found |= before[subscript["expression"]]["domains"]
    return found - {operation["domain"]} if kind == "comprehension" else found


def _function(function: Node) -> Node:
    values = [*function["outputs"], *function["locals"]]
    definitions: list[Node] = []
    folds: list[Node] = []
    last: dict[int, int] = {}

    def define(target: int, expression: int | None = None) -> int:
        last[target] = len(definitions)
        definitions.append({"target": target, "rhs": expression})
        return last[target]

    def run(statements: Sequence[Node]) -> None:
        for statement in statements:
            ((kind, content),) = statement.items()
            for assignment in {"assignment": [content], "assignment_group": content.get("assignments")}.get(kind, ()):
                define(assignment["target"], assignment["rhs"])
            if kind == "for":  # the definitions of its parameters are before those of its body
                fold: Node = {"domain": content["domain"]}
                folds.append(fold)
                fold["initial_definitions"] = [last[target] for target in content["targets"]]
                fold["parameter_definitions"] = [define(target) for target in content["targets"]]
                run(content["statements"])
                fold["update_definitions"] = [last[target] for target in content["targets"]]
                fold["output_definitions"] = [define(target) for target in content["targets"]]

    run(function["statements"])
    return {
        "name": function["name"],
        "values": values,
        "definitions": definitions,
        "statements": [_tagged(s) for s in function["statements"]],
        "folds": folds,
        "results": [last.get(i) for i in range(len(function["outputs"]))],
        "external": function["external"],
        "declaration": function["declaration"],
    }
