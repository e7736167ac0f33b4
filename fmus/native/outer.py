"""Outer variables: rumoca declares a separate variable for each, without a value.

In equations it uses the inner variable, but not in assertions, nor in what an FMU outputs of the outer one. Section 5.4
of the Modelica Language Specification, version 3.6.
"""

from collections.abc import Mapping

from railgrip.fmus.native.classes import Node, Tree

Names = Mapping[str, str]
"""Name of each outer variable → name of its inner one."""


def outer_variables(tree: Tree, flat: Mapping[str, Node]) -> Names:
    """Return the outer variables of a class.

    Args:
        tree: Declarations of the class and of those that it uses.
        flat: Variables of the flat class by name.
    """
    found: dict[str, str] = {}
    for name, variable in flat.items():
        parts = (variable.get("component_ref") or {}).get("parts") or []
        if parts and _declared(tree, parts[-1], "outer"):
            instance = name.rpartition(".")[0]
            while instance:
                instance = instance.rpartition(".")[0]
                inner = f"{instance}.{parts[-1]['ident']}" if instance else parts[-1]["ident"]
                candidate = (flat.get(inner, {}).get("component_ref") or {}).get("parts")
                if candidate and _declared(tree, candidate[-1], "inner"):
                    found[name] = inner
                    break
    return found


def _declared(tree: Tree, part: Node, prefix: str) -> bool:
    owner = tree.component_of_id.get(part["def_id"])
    return owner is not None and bool(owner[0].components[owner[1]][prefix])


def connect_outer(content: Node, outer: Names) -> list[str]:
    """Give each outer variable of a DAE the value of its inner one, and return those for which that is impossible.

    Args:
        content: rumoca's checked DAE, which is changed.
        outer: See `outer_variables`.
    """
    variables = {v["name"]: v for v in content["variables"]}
    impossible: list[str] = []
    for name, inner in outer.items():
        if name not in variables:
            continue
        mine, other = variables[name], variables.get(inner)
        if other is None or mine["value_type"] != other["value_type"]:
            impossible.append(name)
            continue
        expression = {
            "operation": {"kind": "coordinate", "coordinate": {"kind": other["role"], "id": other["id"]}},
            "binder_domain": None,
            "provenance": mine["declaration"],
        }
        content["expressions"].append(expression)
        number = len(content["expressions"]) - 1
        if mine["role"] in ("parameter", "constant"):
            mine["attributes"] |= {"binding": number, "binding_values": None, "start": None, "start_values": None}
        elif not _define(content, mine["id"], number):
            impossible.append(name)
    return impossible


def _define(content: Node, variable: int, expression: int) -> bool:
    for owner in content["systems"]["discrete_values"]["owners"]:
        if owner["targets"] == [variable] and len(owner["branches"]) == 1:
            owner["branches"][0]["values"][0]["expression"] = expression
            return True
    return False
