"""Names and types in expressions that rumoca reads differently from the language, or that the language forbids.

Section numbers are those of the Modelica Language Specification, version 3.6.
"""

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice, pairwise
from typing import Any

from railgrip.base.groups import gather
from railgrip.fmus.native.classes import (
    SIMPLE,
    Class,
    Element,
    Finding,
    Modifier,
    Node,
    Tree,
    extends_modifiers,
    parts_of,
    path_of,
    walk,
)

_COMPARISONS = ("Eq", "Neq", "Lt", "Le", "Gt", "Ge")
BUILT_IN_FUNCTIONS = re.compile(  # section 3.7
    r"abs|sign|sqrt|div|mod|rem|ceil|floor|integer|sin|cos|tan|asin|acos|atan|atan2|sinh|cosh|tanh|exp|"
    r"log|log10|delay|cardinality|homotopy|min|max|sum|product|size|ndims|scalar|vector|matrix|transpose|"
    r"outerProduct|symmetric|cross|skew|identity|diagonal|zeros|ones|fill|linspace|cat|noEvent|smooth"
)
_DISCRETE_FUNCTIONS = frozenset(
    ("integer", "pre", "edge", "change", "initial", "terminal", "sample", "Integer", "String", "size", "ndims")
)
"""Built-in functions whose value changes at events only, whatever their arguments."""
_TERMINALS = {"UnsignedInteger": "Integer", "UnsignedReal": "Real", "Bool": "Boolean", "String": "String"}

_ALGORITHM = "a when statement in an algorithm section (11.2.7); write a when equation with `=`"
_BRANCHES = (
    "when equations in several branches of an if equation (8.3.5); write one when equation outside of it, with if "
    "expressions"
)
_ELEMENT = (
    "a part of an array in a when equation (8.3.5); assign all elements, of a number that is written in its class, in "
    "one when equation without elsewhen whose condition has no iterator"
)
_REINIT = "reinit of an element of an array (8.3.6); declare the states as scalars"
_INSIDE = "an if equation in a when equation (8.3.5); write an if expression, `y = if ... then ... else ...`"

Kind = str | Class
"""A simple type: Real, Integer, Boolean, String or the class of an enumeration."""


def findings(tree: Tree) -> Iterator[Finding]:
    """Yield a finding for each name, type or constant that is misread or forbidden."""
    for class_ in tree.every:
        yield from _Names(tree, class_).findings()
    yield from _computed_constants(tree)


def misread_clauses(tree: Tree) -> Iterator[Finding]:
    """Yield a finding for each valid when clause that rumoca misreads or cannot name."""
    for class_ in tree.every:
        if class_.kind != "function":
            yield from _Names(tree, class_).misread_clauses()


def misread_values(
    tree: Tree, flat: Mapping[str, Node], selections: Iterable[Node]
) -> Iterator[tuple[str, float | None, str]]:
    """Yield each parameter whose default rumoca takes in place of a value from an array, that default, and a sentence.

    The default is None if its form does not give it.

    Args:
        tree: Declarations of the class and of those that it uses.
        flat: Variables of the flat class by name.
        selections: Selections of branches and ranges in the flat class, by their `references` to parameters.
    """
    sizes = (
        path[-1].node["def_id"]
        for class_ in tree.every
        for node in class_.components.values()
        for reference, _, _ in references(node["shape_expr"])
        if (path := tree.component_path(class_, reference))
    )
    sizing = set(sizes)
    number = {
        name: parts[-1]["def_id"] for name, v in flat.items() if (parts := (v.get("component_ref") or {}).get("parts"))
    }
    selecting = [(names[0], node) for node in selections for names in node["references"] if names[0] in number]
    selecting += [(name, {"span": flat[name]["source_span"]}) for name, id_ in number.items() if id_ in sizing]
    for name, node in selecting:
        if _reads_array(flat[name]["binding"], flat, tree):
            owner, component = tree.component_of_id.get(number[name], (None, ""))
            declared = {} if owner is None else owner.components[component]["binding"] or {}
            text = declared.get("Terminal", {}).get("token", {}).get("text", "")
            default = {"true": 1.0, "false": 0.0}.get(text, float(text) if text.isdigit() else None)
            sentence = (
                f"{name} decides equations or sizes, and the built-in compiler would take its default in place of a "
                "value that is computed from an array (4.5); give a number, a scalar parameter, or a list of these"
            )
            (located,) = tree.locate([(node, sentence)])
            yield name, default, located


def _reads_array(value: Any, flat: Mapping[str, Node], tree: Tree) -> bool:
    # Whether an expression of the flat class, or the value of a parameter in it, has an array other than in size().
    if isinstance(value, list):
        return any(_reads_array(part, flat, tree) for part in value)
    if not isinstance(value, dict) or value.get("function") == "Size":
        return False
    # A literal may be in place of an element of a constant, and an array in place of a constant.
    if "Literal" in value:
        span = value["Literal"].get("span")
        return span is not None and re.match(r"[A-Za-z_][\w.]*\s*\[", tree.text_of(span)) is not None
    if "span" in value.get("Array", ()):
        span = value["Array"]["span"]
        is_constructor = tree.text(span | {"start": 0, "end": span["start"]}).rstrip().endswith(("{", "["))
        is_constant = re.match("[A-Za-z_]", tree.text_of(span)) and not is_constructor
        return bool(is_constant) or _reads_array(value["Array"]["elements"], flat, tree)
    if "VarRef" in value:
        reference = value["VarRef"]
        variable = flat.get(reference["name"]["name"], {"dims": (), "binding": None})
        return bool(reference["subscripts"] or variable["dims"]) or _reads_array(variable["binding"], flat, tree)
    return any(_reads_array(part, flat, tree) for key, part in value.items() if key != "span")


def references(tree: Any) -> Iterator[tuple[Node, frozenset[str], bool]]:
    """Yield the node of each name in a tree of equations or expressions, including those of functions.

    With each node come the iteration variables around it, and whether it is an argument of connect.
    """
    for node, bound in walk(tree):
        yield from ((node[key], bound, False) for key in ("ComponentReference", "comp") if key in node)
        yield from ((node["Connect"][side], bound, True) for side in ("lhs", "rhs") if "Connect" in node)


def _inside(kind: str, tree: Any) -> Iterator[Any]:
    # The equations or statements of a kind; an if expression has other keys.
    for node, _ in walk(tree):
        if kind in node and (kind != "If" or "cond_blocks" in node["If"]):
            yield node[kind]


@dataclass(frozen=True)
class _Names:
    """Checks of the expressions in one class."""

    tree: Tree
    class_: Class

    def findings(self) -> Iterator[Finding]:
        yield from self._types()
        for expression in self._expressions():
            for node, bound, in_connect in references(expression):
                if parts_of(node)[0] not in bound:
                    yield from self._reference(node, in_connect=in_connect)
            yield from self._mismatches(expression)
        yield from self._lost_assertions()
        yield from self._bindings()
        if not self.class_.definition["is_long"]:
            yield from self._short_class()

    def _expressions(self) -> Iterator[Any]:
        for node in self.class_.components.values():
            yield [node["binding"], node["modifiers"], node["shape_expr"], node["condition"]]
        yield [a["expr"] for clause in self.class_.definition["extends"] for a in clause["modifications"]]
        yield self.class_.content

    def _types(self) -> Iterator[Finding]:
        for name, node in self.class_.components.items():
            yield from self._type(name, node["type_name"], node["type_def_id"], self.class_)
        scope = self.class_
        if not scope.definition["is_long"]:
            scope = self.tree.by_name.get(scope.name.rpartition(".")[0], scope)
        for clause in self.class_.definition["extends"]:
            yield from self._type(self.class_.short_name, clause["base_name"], clause["base_def_id"], scope)

    def _type(self, name: str, written: Node, number: int | None, scope: Class) -> Iterator[Finding]:
        parts = [part["text"] for part in written["name"]]
        if not parts or (len(parts) == 1 and parts[0] in SIMPLE):
            return
        node = written["name"][0]
        is_global = self.tree.starts_with_dot(node["location"])
        path = self._path(parts, scope, is_global)
        yield from self._protected(node, path, parts)
        last, used = (path[-1] if len(path) == len(parts) else None), self.tree.by_id.get(number or -1)
        meant = last.type if last is not None and last.is_class else None
        local = self.tree.look_up(parts[0], scope)
        if is_global and local is not None and local is not self.tree.roots.get(parts[0]):
            yield (
                node,
                f"the built-in compiler reads .{'.'.join(parts)}, the type of {name}, as the local {parts[0]} in "
                f"{local.owner.name} (5.3.3); rename the local one",
            )
            return
        redeclared = any(element.redeclared for element in path)
        if meant is not None and used is not None and meant is not used and not redeclared:
            yield (
                node,
                f"the built-in compiler reads the type {'.' * is_global}{'.'.join(parts)} of {name} as {used.name}, "
                f"but it is {meant.name} (5.3); rename one of them",
            )

    def _reference(self, node: Node, *, in_connect: bool) -> Iterator[Finding]:
        parts, name = parts_of(node), path_of(node)
        first = parts[0]
        if name == "time" and self.class_.kind not in ("model", "block", "class"):
            yield node, f"the {self.class_.kind} {self.class_.short_name} uses time (3.6.7)"
            return
        if node.get("local"):
            found = self.tree.look_up(first, self.class_)
            # A function with the name of a built-in one is equal to it, or `language` refuses it.
            is_function = BUILT_IN_FUNCTIONS.fullmatch(first) and self.tree.resolve(first, self.class_) is not None
            if found is not None and found is not self.tree.roots.get(first) and not is_function:
                yield node, f"the built-in compiler reads .{name} as the local {first} (5.3.3); rename the local one"
        path = self._path_of(node)
        yield from self._protected(node, path, parts)
        for element, part in zip(path, parts, strict=False):
            if not element.is_class and element.node["condition"] is not None and not in_connect:
                yield node, f"{name} uses the conditional component {part}, which only connect may (4.4.5)"
        for element, following in pairwise(path):
            if not element.is_class and element.rank and following.is_class:
                yield node, f"{name} is a class in an array of components (5.3.2)"

    def _protected(self, node: Node, path: Sequence[Element], parts: Sequence[str]) -> Iterator[Finding]:
        for element, part in list(zip(path, parts, strict=False))[1:]:
            if element.protected:
                yield node, f"{'.'.join(parts)} uses {part}, which is protected in {element.owner.name} (4.1)"

    def _path(self, parts: Sequence[str], scope: Class, is_global: bool) -> list[Element]:
        # The elements that the parts of a name denote, as far as they are known.
        first = self.tree.roots.get(parts[0]) if is_global else self.tree.look_up(parts[0], scope)
        return self.tree.follow(first, parts[1:])

    def _path_of(self, reference: Node) -> list[Element]:
        return self._path(parts_of(reference), self.class_, bool(reference.get("local")))

    def _short_class(self) -> Iterator[Finding]:
        inherited = self.tree.inherit(self.class_)
        around = self.tree.by_name.get(self.class_.name.rpartition(".")[0])
        for clause in self.class_.definition["extends"]:
            for node, bound, _ in references([a["expr"] for a in clause["modifications"]]):
                first = parts_of(node)[0]
                element = inherited.get(first)
                if element is None or first in bound or node.get("local"):
                    continue
                if around is None or self.tree.look_up(first, around) != element:
                    yield (
                        node,
                        f"the built-in compiler reads {first} in the modifiers of the short class "
                        f"{self.class_.short_name} as the element of {element.owner.name}, but it is that of the class "
                        f"around {self.class_.short_name} (5.3); rename that one",
                    )

    def misread_clauses(self) -> Iterator[Finding]:
        """Yield a finding for each when clause that rumoca misreads or cannot name."""
        equations, _, algorithms, _ = self.class_.node["sections"]
        # Of several assignments of a variable rumoca keeps one, and ignores the conditions around it.
        for when in _inside("When", algorithms):
            yield self._keyword("when", when[0]["cond"]), _ALGORITHM
        for node in _inside("If", equations):
            branches = [*(block["eqs"] for block in node["cond_blocks"]), node["else_block"] or []]
            clauses = [clause for branch in branches for clause in islice(_inside("When", branch), 1)]
            for when in clauses[1:]:
                yield self._keyword("when", when[0]["cond"]), _BRANCHES
        for when in _inside("When", equations):
            for node, _ in walk([block["eqs"] for block in when]):
                target, sentence = node["Simple"]["lhs"] if "Simple" in node else {}, _ELEMENT
                if "FunctionCall" in node and path_of(node["FunctionCall"]["comp"]) == "reinit":
                    target, sentence = node["FunctionCall"]["args"][0], _REINIT
                if "ComponentReference" in target and target["ComponentReference"]["parts"][-1]["subs"]:
                    yield target["ComponentReference"], sentence
            for node in _inside("If", [block["eqs"] for block in when]):
                conditions = [block["cond"] for block in node["cond_blocks"]]
                if not all(map(self._is_parameter, conditions)):
                    yield self._keyword("if", conditions[0]), _INSIDE

    def _keyword(self, keyword: str, condition: Node) -> Node:
        # rumoca's tree has no place of the keyword in front of a condition.
        place = next(node["span"] for node, _ in walk(condition) if "span" in node)
        before = self.tree.text(place | {"start": 0, "end": place["start"]}).rpartition(keyword)[0]
        return {"span": place | {"start": len(before.encode())}}

    def _lost_assertions(self) -> Iterator[Finding]:
        # rumoca drops the assertions of an if equation unless it can decide its condition at translation.
        for node in _inside("If", self.class_.content if self.class_.kind != "function" else []):
            if not all(self._is_parameter(block["cond"]) for block in node["cond_blocks"]):
                for inside, _ in walk(node):
                    if "FunctionCall" in inside and path_of(inside["FunctionCall"]["comp"]) == "assert":
                        yield (
                            inside["FunctionCall"]["comp"],
                            "the built-in compiler drops an assertion in an if equation whose condition changes "
                            "(8.3.4); write `assert(not condition or ..., ...)` outside of it",
                        )

    def _is_parameter(self, expression: Any) -> bool:
        for node, bound, _ in references(expression):
            first, path = parts_of(node)[0], self._path_of(node)
            if first in bound:
                continue
            if any(element.variability in ("parameter", "constant") for element in path):
                continue
            class_ = path[-1].type if path and path[-1].is_class else None
            if class_ is not None and (class_.kind == "function" or class_.literals):
                continue
            if not path and first not in ("time", "initial", "terminal", "sample"):
                continue  # a built-in function
            return False
        return True

    def kind(self, value: Node, bound: frozenset[str] = frozenset()) -> Kind | None:
        """Return the simple type of an expression, None if its form alone does not determine it."""
        ((form, node),) = value.items()
        match form:
            case "Terminal" | "Literal":
                return _TERMINALS.get(node.get("terminal_type", ""))
            case "ComponentReference":
                return self._reference_kind(node, bound)
            case "Parenthesized" | "Unary":
                inner = next((node[key] for key in ("inner", "rhs", "expr") if key in node), None)
                return None if inner is None else self.kind(inner, bound)
            case "If":
                return self.kind(node["else_branch"], bound)
            case "Array":
                return self.kind(node["elements"][0], bound) if node["elements"] else None
            case "Binary":
                return self._binary_kind(node, bound)
            case "FunctionCall":
                function = self.tree.resolve(path_of(node["comp"]), self.class_)
                if function is None or function.kind != "function":
                    return None
                outputs = [e for e in self.tree.elements(function).values() if e.causality == "output"]
                return outputs[0].simple if outputs else None
            case _:
                return None

    def _binary_kind(self, node: Node, bound: frozenset[str]) -> Kind | None:
        if node["op"] in (*_COMPARISONS, "And", "Or"):
            return "Boolean"
        kinds = [self.kind(node[side], bound) for side in ("lhs", "rhs")]
        if not all(kind in ("Real", "Integer") for kind in kinds):
            return None
        return "Integer" if kinds == ["Integer", "Integer"] and node["op"] in ("Add", "Sub", "Mul") else "Real"

    def _reference_kind(self, node: Node, bound: frozenset[str]) -> Kind | None:
        parts, path = parts_of(node), self._path_of(node)
        if parts[0] in bound or not path:
            return None
        last = path[-1]
        if len(path) == len(parts):
            return last.simple
        literals = self.tree.simple(last.type)[0] if last.is_class else None
        is_literal = len(path) == len(parts) - 1 and isinstance(literals, Class) and parts[-1] in literals.literals
        return literals if is_literal else None

    def _mismatch(
        self, node: Node, what: str, target: Kind | None, value: Node | None, bound: frozenset[str] = frozenset()
    ) -> Iterator[Finding]:
        found = None if value is None or "Empty" in value else self.kind(value, bound)
        if target is None or found is None or _fits(target, found):
            return
        yield node, f"{what} is of {_named(target)}, but its value is of {_named(found)} (6.7)"

    def _bindings(self) -> Iterator[Finding]:
        elements = self.tree.elements(self.class_)
        for name, node in self.class_.components.items():
            element = elements[name]
            yield from self._mismatch(node, name, element.simple, node["binding"])
            yield from self._continuous(node, name, element, node["binding"])
            if element.type is not None:
                yield from self._modifiers(element.modifiers, element.type)
        for clause in self.class_.definition["extends"]:
            base = self.tree.by_id.get(clause["base_def_id"])
            if base is not None:
                yield from self._modifiers(extends_modifiers(clause), base)
                yield from self._shared_constants(clause, base)

    def _modifiers(self, modifiers: Sequence[Modifier], target: Class) -> Iterator[Finding]:
        for modifier in modifiers:
            element = self.tree.elements(target).get(modifier.name)
            if element is None or element.is_class or modifier.type:
                continue
            yield from self._mismatch(modifier.node, f"'{modifier.name}'", element.simple, modifier.value)
            yield from self._continuous(modifier.node, f"'{modifier.name}'", element, modifier.value)
            if element.type is not None:
                yield from self._modifiers(modifier.inner, element.type)

    def _shared_constants(self, clause: Node, base: Class) -> Iterator[Finding]:
        # If a class uses both packages, rumoca gives the base the constants of its heir.
        heir, modified = self.class_, {modifier.name for modifier in extends_modifiers(clause)}
        if base.kind != "package" or not modified & base.components.keys():
            return
        affected = "|".join([*base.components, *base.classes])
        uses = re.compile(rf"\b{base.short_name}\s*\.\s*(?:{affected})\b")
        if _is_written(self.tree, uses) and _is_written(self.tree, re.compile(rf"\b{heir.short_name}\s*\.")):
            yield (
                clause,
                f"{heir.name} modifies constants of {base.name}, which is used itself: the built-in compiler would "
                f"modify them in {base.name} too (7.1); declare the constants without a value there",
            )

    def _mismatches(self, tree: Any) -> Iterator[Finding]:
        for node, bound in walk(tree):
            for key, value in node.items():
                if key == "Binary" and value["op"] in _COMPARISONS:
                    yield from self._pair([value["lhs"], value["rhs"]], bound, "a comparison")
                elif key == "Simple":
                    yield from self._pair([value["lhs"], value["rhs"]], bound, "an equation")
                    yield from self._discrete(value["lhs"], value["rhs"])
                elif key == "Assignment":
                    target = {"ComponentReference": value["comp"]}
                    name = path_of(value["comp"])
                    yield from self._mismatch(value["comp"], name, self.kind(target, bound), value["value"], bound)
                    yield from self._discrete(target, value["value"])
                elif key == "If" and "branches" in value:
                    branches = [branch[1] for branch in value["branches"]]
                    yield from self._pair([*branches, value["else_branch"]], bound, "an if expression")
                elif key == "Array" and value.get("kind") == "Array":
                    yield from self._pair(value["elements"], bound, "an array")
                elif key == "FunctionCall":
                    yield from self._arguments(value)

    def _pair(self, values: Sequence[Node], bound: frozenset[str], what: str) -> Iterator[Finding]:
        kinds = [kind for kind in (self.kind(value, bound) for value in values) if kind is not None]
        for other in kinds[1:]:
            if not (_fits(kinds[0], other) or _fits(other, kinds[0])):
                place = next((node for node, _ in walk(values) if node.get("span")), None)
                if place is not None:
                    sentence = f"{what} has values of {_named(kinds[0])} and of {_named(other)} (6.7)"
                    yield place, sentence

    def _arguments(self, call: Node) -> Iterator[Finding]:
        function = self.tree.resolve(path_of(call["comp"]), self.class_)
        if function is None or function.kind not in ("function", "record"):
            return
        inputs = {
            name: element
            for name, element in self.tree.elements(function).items()
            if not element.is_class and (element.causality == "input" or function.kind == "record")
        }
        for i, argument in enumerate(call["args"]):
            named = argument.get("NamedArgument")
            if named is None:
                name, value = next(islice(inputs, i, None), ""), argument
            else:
                value = named["value"]
                name = named["name"]["text"] if isinstance(named["name"], dict) else named["name"]
            if name in inputs:
                yield from self._mismatch(call["comp"], f"argument {name}", inputs[name].simple, value)

    def _discrete(self, target: Node, value: Node) -> Iterator[Finding]:
        if "ComponentReference" in target:
            node = target["ComponentReference"]
            path = self._path_of(node)
            if len(path) == len(node["parts"]):
                yield from self._continuous(node, path_of(node), path[-1], value)

    def _continuous(self, node: Node, name: str, element: Element, value: Node | None) -> Iterator[Finding]:
        if value is None or element.simple in (None, "Real") or element.variability in ("parameter", "constant"):
            return
        if element.causality != "input" and self.class_.kind != "function" and self._is_continuous(value):
            yield (
                node, f"{name} changes at events only, but the function or noEvent in its value does not (3.8.3); "
                "use Real, or relations without noEvent"
            )  # fmt: skip

    def _is_continuous(self, tree: Any, *, without_events: bool = False) -> bool:
        # Whether a value of type Integer, Boolean or enumeration may change between events.
        if isinstance(tree, list):
            return any(self._is_continuous(item, without_events=without_events) for item in tree)
        if not isinstance(tree, dict):
            return False
        for key, value in tree.items():
            if key == "FunctionCall":
                name = path_of(value["comp"])
                if name in _DISCRETE_FUNCTIONS:
                    continue
                function = self.tree.resolve(name, self.class_)
                inside = without_events or name in ("noEvent", "smooth") or (
                    function is not None and function.kind == "function"
                )  # fmt: skip
                if self._is_continuous(value["args"], without_events=inside):
                    return True
            elif key == "ComponentReference":
                if without_events and self._is_continuous_variable(value):
                    return True
            elif key not in ("target", "subs") and self._is_continuous(value, without_events=without_events):
                return True
        return False

    def _is_continuous_variable(self, node: Node) -> bool:
        if path_of(node) == "time":
            return True
        path = self._path_of(node)
        is_known = len(path) == len(node["parts"]) and not any(element.variability for element in path)
        return is_known and path[-1].simple == "Real"


def _named(kind: Kind) -> str:
    return kind if isinstance(kind, str) else f"the enumeration {kind.name}"


def _fits(target: Kind, value: Kind) -> bool:
    # Enumerations with the same literals in the same order are the same type (6.5).
    if isinstance(target, Class) and isinstance(value, Class):
        return target.literals == value.literals
    return target == value or (target == "Real" and value == "Integer")


Call = tuple[str, Node, Node]
"""A call of a function: its name in the flat class, and nodes with the places of its declaration and of the call."""


def confused_calls(tree: Tree, calls: Iterable[Call]) -> Iterator[Finding]:
    """Yield a finding for each call for which rumoca took another function of the same name.

    rumoca keeps the name of a function as it is written, unless it is imported or redeclared, so that two functions `f`
    of different packages become one.
    """
    declared = {_start(class_.definition["location"]): class_ for class_ in tree.every}
    for name, declaration, node in calls:
        written = re.match(r"[\w.]*", tree.text(node["span"]))
        if written is None or written[0] != name:
            continue
        right = tree.resolve(name, _around(tree, node["span"]))
        taken = declared.get(_start(declaration["span"]))
        # A short class is declared where its base is.
        names = {class_.name for class_ in (right, *tree.bases(right))} if right is not None else set[str]()
        if right is not None and taken is not None and taken.name not in names:
            yield (
                node,
                f"{name} is {right.name}, but the built-in compiler takes {taken.name}, which has the same name; "
                "rename one of them (5.3)",
            )


def _computed_constants(tree: Tree) -> Iterator[Finding]:
    # rumoca computes constants by the last two parts of their names.
    packages = (class_ for class_ in tree.every if class_.kind == "package" and "." in class_.name)
    found = gather(((each.short_name, name), node) for each in packages for name, node in each.components.items())
    for (package, name), nodes in found.items():
        computed = any(kind in str(node["binding"]) for node in nodes for kind in ("Reference", "FunctionCall"))
        uses = re.compile(rf"\b{package}\s*\.\s*{name}\b")
        if len(nodes) > 1 and computed and _is_written(tree, uses):
            yield (
                nodes[-1],
                f"{package}.{name} is a computed constant of {len(nodes)} packages of the name {package}, which the "
                "built-in compiler confuses; rename one of them (5.3)",
            )


def _is_written(tree: Tree, pattern: re.Pattern[str]) -> bool:
    return any(pattern.search(text.decode(errors="replace")) for _, text in tree.sources.values())


def _around(tree: Tree, span: Node) -> Class:
    around = [
        class_
        for class_ in tree.every
        if (place := class_.definition["location"])["source"] == span["source"]
        and place["start"] <= span["start"] < place["end"]
    ]
    return max(around, key=lambda class_: class_.definition["location"]["start"])


def _start(place: Node) -> tuple[int, int]:
    return place["source"], place["start"]
