"""Constructs that rumoca interprets differently from the Modelica language, or that the language forbids.

Section numbers are those of the Modelica Language Specification, version 3.6. Rules that rumoca 0.10 enforces itself
are not repeated here; tests/fmus/test_strict_modelica.py lists them.
"""

import json
import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any

from railgrip.base.errors import TranslationError

DECLARATIONS = Path(__file__).parent / "declarations"

Node = dict[str, Any]
"""A node of the syntax tree as rumoca writes it, with its field names."""

Sources = Mapping[int, tuple[str, bytes]]
"""Source id → (file name, text); places are byte offsets into the text."""

_SIMPLE = ("Real", "Integer", "Boolean", "String")
_ATTRIBUTES = frozenset(  # section 4.9
    ("value", "quantity", "unit", "displayUnit", "min", "max", "start", "fixed", "nominal", "unbounded", "stateSelect")
)
_MAXIMUM_FINDINGS = 3
"""Maximum number of findings in a message."""


def require_strict(model: Any, class_name: str, sources: Sources, calls: Iterable["Call"] = ()) -> None:
    """Raise an error for constructs that Modelica compilers interpret differently.

    Args:
        model: rumoca's model of the class.
        class_name: Full name of the class.
        sources: Source texts.
        calls: Calls of functions in the flat class.

    Raises:
        TranslationError: The class has such constructs; the message lists them with file and line.
    """
    text: str = model.codegen(str(DECLARATIONS)).files[0].content
    text = re.sub(r"\bnone\b", "null", text)
    text = re.sub(r"\\u\{([0-9a-f]+)\}", lambda m: f"\\u{int(m[1], 16):04x}", text)
    try:
        tree = json.loads(text)
    except json.JSONDecodeError as error:
        # rumoca does not escape quoted names, so a quotation mark in a name ends the string.
        raise TranslationError(f"{class_name}: a quoted name with a quotation mark in it is not translated.") from error
    checker = _Checker(tree, sources)
    _refuse(f"{class_name} does not conform to the Modelica language", checker.findings())
    _refuse(f"{class_name} would call the wrong function", checker.confused(calls))


def require_values(class_name: str, variables: Mapping[str, Node], sources: Sources) -> None:
    """Raise an error for component parameters without a value, whose start value would be used (section 8.6).

    This is the only sign of a lost modifier; therefore OpenModelica's warning fails a build as well. Parameters of the
    class itself are set by the importer of the FMU.

    Args:
        class_name: Full name of the class.
        variables: Variables of the flat class by name.
        sources: Source texts.

    Raises:
        TranslationError: A parameter without a value is not an array of size zero.
    """
    unset = (
        _locate({"span": variable["source_span"]}, f"parameter {name} has no value", sources)
        for name, variable in variables.items()
        if "." in name
        and "Parameter" in variable["variability"]
        and variable["binding"] is None
        and all(variable["fixed"] or ())
        and 0 not in variable["dims"]
    )
    _refuse(f"{class_name} has parameters without a value", unset)


def _refuse(what: str, findings: Iterable[str]) -> None:
    every = list(dict.fromkeys(findings))
    if every:
        more = [f"and {len(every) - _MAXIMUM_FINDINGS} more"] if len(every) > _MAXIMUM_FINDINGS else []
        raise TranslationError("\n  ".join([f"{what}:", *every[:_MAXIMUM_FINDINGS], *more]))


@dataclass(frozen=True, slots=True)
class Call:
    """A call of a function.

    Attributes:
        name: Name of the function in the flat class.
        declaration: Node with the place of its declaration.
        node: Node with the place of the call.
    """

    name: str
    declaration: Node
    node: Node


@dataclass(frozen=True, slots=True)
class _Modifier:
    """One argument of a modification.

    Attributes:
        value: Expression of its value, or None.
        type: Name of the new type of a redeclaration, else ''.
        node: Node with its place in the source.
        dotted: Its name as it is written if that has dots, else ''.
    """

    name: str
    value: Node | None
    inner: tuple["_Modifier", ...]
    each: bool
    type: str
    node: Node
    dotted: str = ""

    def leaves(self, before: str = "") -> Iterator[str]:
        """Yield the paths of all elements that it assigns a value or redeclares."""
        path = f"{before}{self.name}"
        if self.value is not None or self.type:
            yield path
        if not self.type:
            for modifier in self.inner:
                yield from modifier.leaves(f"{path}.")


@dataclass(frozen=True)
class _Class:
    """A class definition; `name` is the full one."""

    name: str
    node: Node
    components: Mapping[str, Node]
    classes: Mapping[str, "_Class"]

    @property
    def definition(self) -> Node:
        return self.node["own"]


@dataclass(frozen=True, slots=True)
class _Element:
    """A component or class in a class, own or inherited.

    Attributes:
        owner: Class in which it is declared.
        type: Type of a component, or the class itself; None for simple and unknown types.
        simple: Whether it is a scalar or array of a simple type.
        rank: Number of array dimensions.
        modifiers: Modifiers of its declaration.
        constraint_modifiers: Modifiers of an explicit constraining clause, name → expression; None without one.
        redeclared: Whether an extends clause redeclares it.
    """

    owner: _Class
    node: Node
    is_class: bool
    type: _Class | None
    simple: bool
    rank: int
    protected: bool
    replaceable: bool
    modifiers: tuple[_Modifier, ...]
    constraint_modifiers: Mapping[str, Node] | None
    redeclared: bool = False

    @property
    def lost_in_clause(self) -> list[str]:
        """Names that the constraining clause modifies and the declaration does not: lost unless it is redeclared."""
        if self.redeclared or self.is_class:
            return []
        return sorted((self.constraint_modifiers or {}).keys() - {m.name for m in self.modifiers})


@dataclass(frozen=True)
class _Checker:
    """Checks of a tree of declarations; methods that yield strings yield findings with file and line.

    In these, `rank` is the number of dimensions, `outside` is whether modifiers come from outside the modified class,
    which excludes protected elements, and `depth` is the level of nested modifiers.
    """

    tree: Node
    sources: Sources
    _elements: dict[str, dict[str, _Element]] = field(default_factory=dict[str, dict[str, _Element]])

    @cached_property
    def roots(self) -> dict[str, _Class]:
        return {name: _class(name, node) for name, node in self.tree.items() if name}

    @cached_property
    def every(self) -> list[_Class]:
        def walk(classes: Mapping[str, _Class]) -> Iterator[_Class]:
            for class_ in classes.values():
                yield class_
                yield from walk(class_.classes)

        return list(walk(self.roots))

    @cached_property
    def by_name(self) -> dict[str, _Class]:
        return {class_.name: class_ for class_ in self.every}

    @cached_property
    def by_id(self) -> dict[int, _Class]:
        return {class_.definition["def_id"]: class_ for class_ in self.every}

    def findings(self) -> Iterator[str]:
        for class_ in self.every:
            yield from self._bases(class_)
            for name, node in class_.components.items():
                yield from self._component(class_, name, node)
            for inner in class_.classes.values():
                yield from self._local_class(class_, inner)
        yield from self._confused_constants()

    def _confused_constants(self) -> Iterator[str]:
        # rumoca 0.10 computes constants by the last two parts of their names.
        found: dict[tuple[str, str], list[Node]] = {}
        for class_ in self.every:
            if "package" in str(class_.definition["class_type"]).lower() and "." in class_.name:
                for name, node in class_.components.items():
                    found.setdefault((class_.name.rpartition(".")[2], name), []).append(node)
        for (package, name), nodes in found.items():
            computed = any(kind in str(node["binding"]) for node in nodes for kind in ("Reference", "FunctionCall"))
            uses = re.compile(rf"\b{package}\s*\.\s*{name}\b")
            if (
                len(nodes) > 1
                and computed
                and any(uses.search(t.decode(errors="replace")) for _, t in self.sources.values())
            ):
                yield self._locate(
                    nodes[-1],
                    f"{package}.{name} is a computed constant of {len(nodes)} packages of that name, which the "
                    "built-in compiler confuses; rename one of them (5.3)",
                )

    def confused(self, calls: Iterable[Call]) -> Iterator[str]:
        """Yield the calls for which the front end took another function of the same name.

        rumoca 0.10 keeps the name of a function as it is written, unless it is imported or redeclared, so that two
        functions `f` of different packages become one.
        """
        declared = {_start(class_.definition["location"]): class_ for class_ in self.every}
        for call in calls:
            written = re.match(r"[\w.]*", self._text_at(call.node["span"]))
            if written is None or written[0] != call.name:
                continue
            right = self.resolve(call.name, self._around(call.node["span"]))
            taken = declared.get(_start(call.declaration["span"]))
            if right is not None and taken is not None and taken.name not in self._family(right):
                yield self._locate(
                    call.node, f"{call.name} is {right.name}, but the built-in compiler takes {taken.name}, which has "
                    "the same name; rename one of them (5.3)"
                )  # fmt: skip

    def _around(self, span: Node) -> _Class:
        around = [
            class_
            for class_ in self.every
            if (place := class_.definition["location"])["source"] == span["source"]
            and place["start"] <= span["start"] < place["end"]
        ]
        return max(around, key=lambda class_: class_.definition["location"]["start"])

    def _family(self, class_: _Class) -> set[str]:
        # The names of a class and its bases; a short class is declared where its base is.
        bases = (self.by_id.get(clause["base_def_id"]) for clause in class_.definition["extends"])
        return {class_.name}.union(*(self._family(base) for base in bases if base is not None))

    def _bases(self, class_: _Class) -> Iterator[str]:
        inherited: dict[str, _Element] = {}
        for clause in class_.definition["extends"]:
            base = self.by_id.get(clause["base_def_id"])
            if base is None:
                continue
            if base.definition["is_replaceable"] and not class_.definition["is_redeclare"]:
                yield self._locate(clause, f"{base.name} is replaceable and cannot be a base class (7.1.4)")
            yield from self._modifiers(class_, _extends_modifiers(clause), base, rank=0, outside=False, depth=0)
            yield from self._shared_constants(class_, clause, base)
            inherited |= self.elements(base)
        for name in class_.components.keys() & inherited.keys():
            mine, theirs = self.elements(class_)[name], inherited[name]
            if not mine.node["is_redeclare"] and _compared_parts(mine.node) != _compared_parts(theirs.node):
                yield self._locate(
                    mine.node, f"{name} is inherited from {theirs.owner.name} and declared again, differently (7.1)"
                )

    def _shared_constants(self, heir: _Class, clause: Node, base: _Class) -> Iterator[str]:
        # If a class uses both packages, rumoca gives the base the constants of its heir.
        modified = {modifier.name for modifier in _extends_modifiers(clause)}
        is_package = "package" in str(base.definition["class_type"]).lower()
        if not is_package or not modified & base.components.keys():
            return
        affected = [*base.components, *base.classes]
        short, heirs = base.name.rpartition(".")[2], heir.name.rpartition(".")[2]
        uses = re.compile(rf"\b{short}\s*\.\s*(?:{'|'.join(affected)})\b")
        texts = [text.decode(errors="replace") for _, text in self.sources.values()]
        both = (uses, re.compile(rf"\b{heirs}\s*\."))
        if all(any(pattern.search(text) for text in texts) for pattern in both):
            yield self._locate(
                clause,
                f"{heir.name} modifies constants of {base.name}, which is used itself: the built-in compiler would "
                f"modify them in {base.name} too (7.1); declare the constants without a value there",
            )

    def _component(self, class_: _Class, name: str, node: Node) -> Iterator[str]:
        element = self.elements(class_)[name]
        yield from self._constraint(class_, name, element)
        if node["is_redeclare"]:
            yield from self._element_redeclaration(class_, name, element)
        modifiers = element.modifiers
        if element.type is None:
            if element.simple:
                yield from self._attributes(class_, modifiers, name, element.rank)
            return
        if modifiers and element.type.definition["is_final"]:
            yield self._locate(node, f"{name} modifies the class {element.type.name}, which is final (7.2.6)")
        yield from self._modifiers(class_, modifiers, element.type, rank=element.rank, outside=True, depth=0)
        yield from self._lost_modifiers(node, name, element.type, modifiers)

    def _local_class(self, class_: _Class, inner: _Class) -> Iterator[str]:
        definition = inner.definition
        short = inner.name.rpartition(".")[2]
        if definition["constrainedby"] and re.search(r"\bconstrainedby\s+[\w.]+\s*\(", self._text_of(definition)):
            yield self._locate(
                definition,
                f"modifiers in the constraining clause of the class {short} are lost in the built-in compiler (7.3.2); "
                f"write them on components of type {short}",
            )
        if definition["is_redeclare"]:
            original = self._inherit(class_).get(short)
            if original is None:
                yield self._locate(definition, f"{short} is redeclared, but {class_.name} does not inherit it (7.3)")
            elif not original.replaceable:
                yield self._locate(definition, f"{short} is redeclared, but is not replaceable (7.3.3)")

    def _constraint(self, class_: _Class, name: str, element: _Element) -> Iterator[str]:
        named = element.node["constrainedby"]
        constraint = self.resolve(_join_name(named), class_) if named else None
        if constraint is None:
            return
        allowed = self.elements(constraint)
        for modified in element.constraint_modifiers or {}:
            if modified not in allowed:
                yield self._locate(
                    element.node, f"the constraining clause of {name} modifies '{modified}', which {constraint.name} "
                    "does not have (7.3.2)"
                )  # fmt: skip
        yield from self._subtype(element.node, name, element.type, constraint)

    def _subtype(self, node: Node, name: str, new: _Class | None, constraint: _Class | None) -> Iterator[str]:
        if new is None or constraint is None:
            return
        has = self.elements(new)
        missing = sorted(
            n for n, e in self.elements(constraint).items() if not e.protected and (n not in has or has[n].protected)
        )
        if missing:
            yield self._locate(
                node, f"{name} is of {new.name}, which lacks {', '.join(missing)} of {constraint.name} (7.3.2)"
            )

    def _element_redeclaration(self, class_: _Class, name: str, element: _Element) -> Iterator[str]:
        original = self._inherit(class_).get(name)
        if original is None:
            yield self._locate(element.node, f"{name} is redeclared, but {class_.name} does not inherit it (7.3)")
            return
        if not original.replaceable:
            yield self._locate(element.node, f"{name} is redeclared, but is not replaceable (7.3.3)")
        constraint = original.node["constrainedby"]
        bound = self.resolve(_join_name(constraint), original.owner) if constraint else original.type
        yield from self._subtype(element.node, name, element.type, bound)
        if original.constraint_modifiers or (original.constraint_modifiers is None and original.modifiers):
            yield self._locate(
                element.node,
                f"the redeclaration of {name} would lose the modifiers of its constraining type in the built-in "
                f"compiler (7.3.2); redeclare it in the extends clause",
            )

    def _modifiers(
        self, scope: _Class, modifiers: Sequence[_Modifier], target: _Class, *, rank: int, outside: bool, depth: int
    ) -> Iterator[str]:
        yield from self._duplicates(modifiers)
        elements = self.elements(target)
        for modifier in modifiers:
            name, element = modifier.name, elements.get(modifier.name)
            if modifier.dotted:
                brackets = f"{modifier.dotted.replace('.', '(')}=...{')' * modifier.dotted.count('.')}"
                yield self._locate(
                    modifier.node,
                    f"the modifier {modifier.dotted} is lost in the built-in compiler; write {brackets} (7.2)",
                )
            if element is None:
                yield self._locate(modifier.node, f"'{name}' is modified, which {target.name} does not have (7.2)")
                continue
            if outside and element.protected:
                yield self._locate(modifier.node, f"'{name}' is modified, which is protected in {target.name} (4.1)")
            around = 0 if modifier.each else rank
            if modifier.type:
                yield from self._redeclaration(scope, modifier, element, depth)
                continue
            yield from self._rank(scope, modifier, around + element.rank)
            if element.type is None:
                if element.simple:
                    yield from self._attributes(scope, modifier.inner, name, around + element.rank)
                continue
            if element.node.get("binding") is not None and any(m.value is not None for m in modifier.inner):
                yield self._locate(
                    modifier.node, f"a part of '{name}' is modified, which has a value as a whole (7.2.3)"
                )
            yield from self._modifiers(
                scope, modifier.inner, element.type, rank=around + element.rank, outside=True, depth=depth + 1
            )

    def _redeclaration(self, scope: _Class, modifier: _Modifier, element: _Element, depth: int) -> Iterator[str]:
        name, new = modifier.name, self.resolve(modifier.type, scope)
        if depth:
            yield self._locate(
                modifier.node,
                f"the redeclaration of '{name}' inside the modifiers of a component is lost in the built-in compiler; "
                "make a class replaceable at each level and redeclare that",
            )
        if not element.replaceable:
            yield self._locate(modifier.node, f"'{name}' is redeclared, but is not replaceable (7.3.3)")
        if element.is_class and element.modifiers:
            yield self._locate(
                modifier.node,
                f"the redeclaration of '{name}' would lose the modifiers of its declaration in the built-in compiler "
                f"(7.3.2); write them on components of type {name}",
            )
        if element.is_class and modifier.inner:
            yield self._locate(
                modifier.node,
                f"the modifiers of the class that replaces '{name}' are lost in the built-in compiler; replace it by a "
                "class of your own that extends that class with the modifiers",
            )
        if element.constraint_modifiers is not None and not element.is_class:
            for m in element.modifiers:
                written = m.value if m.value is not None and not m.inner else m.node
                if _without_places(written) != _without_places(element.constraint_modifiers.get(m.name)):
                    yield self._locate(
                        element.node,
                        f"'{m.name}' is modified on the declaration of {name} and not, or otherwise, in its "
                        f"constraining clause: redeclared, {name} loses it (7.3.2); write "
                        "`constrainedby` with the modifiers",
                    )
        if new is not None:
            yield from self._modifiers(scope, modifier.inner, new, rank=element.rank, outside=True, depth=depth + 1)
            yield from self._lost_modifiers(modifier.node, name, new, modifier.inner)

    def _lost_modifiers(self, node: Node, name: str, used: _Class, modifiers: Sequence[_Modifier]) -> Iterator[str]:
        # rumoca reads a constraining clause only where the class is redeclared.
        redeclared = {m.name for m in modifiers if m.type}
        for part, element in self.elements(used).items():
            if element.lost_in_clause and part not in redeclared:
                yield self._locate(
                    node,
                    f"{name} does not redeclare '{part}' of {used.name}: the built-in compiler would lose the "
                    f"modifiers of its constraining clause, {', '.join(element.lost_in_clause)} (7.3.2); redeclare it, "
                    "or write them on its declaration as well",
                )

    def _attributes(self, scope: _Class, modifiers: Sequence[_Modifier], name: str, rank: int) -> Iterator[str]:
        yield from self._duplicates(modifiers)
        for modifier in modifiers:
            if modifier.name not in _ATTRIBUTES:
                yield self._locate(modifier.node, f"'{modifier.name}' is not an attribute of {name} (4.9)")
            yield from self._rank(scope, modifier, 0 if modifier.each else rank)

    def _rank(self, scope: _Class, modifier: _Modifier, required: int) -> Iterator[str]:
        found = None if modifier.value is None else self.rank(modifier.value, scope)
        if found is not None and found != required:
            what = ("a scalar", "a vector", "a matrix")[min(found, 2)]
            hint = "; write `each`" if found < required and not modifier.each else ""
            yield self._locate(
                modifier.node,
                f"'{modifier.name}' is given {what} where {required} dimensions are required (7.2.5){hint}",
            )

    def _duplicates(self, modifiers: Sequence[_Modifier]) -> Iterator[str]:
        counts = Counter(leaf for modifier in modifiers for leaf in modifier.leaves())
        for modifier in modifiers:
            for leaf in modifier.leaves():
                if counts[leaf] > 1:
                    yield self._locate(modifier.node, f"'{leaf}' is modified twice (7.2.4)")

    def elements(self, class_: _Class) -> dict[str, _Element]:
        """Return the elements of a class by name, inherited ones first."""
        if class_.name not in self._elements:
            self._elements[class_.name] = {}  # where classes extend each other, which rumoca refuses
            self._elements[class_.name] = self._inherit(class_) | {
                **{name: self._element(class_, node) for name, node in class_.components.items()},
                **{
                    inner.name.rpartition(".")[2]: self._class_element(inner, class_)
                    for inner in class_.classes.values()
                },
            }
        return self._elements[class_.name]

    def _inherit(self, class_: _Class) -> dict[str, _Element]:
        found: dict[str, _Element] = {}
        for clause in class_.definition["extends"]:
            base = self.by_id.get(clause["base_def_id"])
            if base is None:
                continue
            elements = dict(self.elements(base))
            if clause["is_protected"]:
                elements = {name: replace(element, protected=True) for name, element in elements.items()}
            for modifier in _extends_modifiers(clause):
                element = elements.get(modifier.name)
                if modifier.type and element is not None:
                    elements[modifier.name] = replace(
                        element,
                        type=self.resolve(modifier.type, class_),
                        replaceable=self._is_replaceable(modifier),
                        redeclared=True,
                    )
            found |= elements
        return found

    def _element(self, owner: _Class, node: Node) -> _Element:
        declared = self.by_id.get(node["type_def_id"] or -1)
        simple, rank = self._simple(declared)
        simple = simple or (declared is None and _join_name(node["type_name"]) in _SIMPLE)
        named = {
            path.removeprefix("__constrainedby__.").partition(".")[0]: value[0]
            for path, value in node["clause"].items()
            if path
        }
        return _Element(
            owner=owner,
            node=node,
            is_class=False,
            type=None if simple else declared,
            simple=simple,
            rank=rank + len(node["shape_expr"] or ()),
            protected=node["is_protected"],
            replaceable=node["is_replaceable"],
            modifiers=_modifiers(node["modifiers"], node["each"], node["redeclare"]),
            constraint_modifiers=named if node["constrainedby"] else None,
        )

    def _class_element(self, inner: _Class, owner: _Class) -> _Element:
        definition = inner.definition
        return _Element(
            owner=owner,
            node=definition,
            is_class=True,
            type=inner,
            simple=False,
            rank=0,
            protected=definition["is_protected"],
            replaceable=definition["is_replaceable"],
            modifiers=()
            if definition["is_long"]
            else tuple(m for clause in definition["extends"] for m in _extends_modifiers(clause)),
            constraint_modifiers={} if definition["constrainedby"] else None,
        )

    def _simple(self, class_: _Class | None) -> tuple[bool, int]:
        if class_ is None:
            return False, 0
        if class_.definition["enum_literals"]:
            return True, 0
        rank = len(class_.definition["array_subscripts"] or ())
        for clause in class_.definition["extends"]:
            if _join_name(clause["base_name"]) in _SIMPLE:
                return True, rank
            simple, more = self._simple(self.by_id.get(clause["base_def_id"]))
            if simple:
                return True, rank + more
        return False, rank

    def resolve(self, name: str, scope: _Class) -> _Class | None:
        """Return the class of a name that is written in a class, None if it is unknown (section 5.3)."""
        first, *rest = name.split(".")
        place = scope.name
        while True:
            class_ = self.by_name.get(place)
            found = None if class_ is None else self.elements(class_).get(first)
            if found is not None and found.is_class:
                break
            if not place:
                root = self.roots.get(first)
                return root and self._inside(root, rest)
            place = place.rpartition(".")[0]
        return found.type and self._inside(found.type, rest)

    def _inside(self, type_: _Class, names: Sequence[str]) -> _Class | None:
        for name in names:
            element = self.elements(type_).get(name)
            if element is None or not element.is_class or element.type is None:
                return None
            type_ = element.type
        return type_

    def rank(self, value: Node, scope: _Class) -> int | None:
        """Return the number of dimensions of an expression, None if its form alone does not determine it."""
        ((kind, node),) = value.items()
        match kind:
            case "Terminal" | "Literal":
                return 0
            case "Array":
                inner = self.rank(node["elements"][0], scope) if node["elements"] else None
                return None if inner is None or node.get("kind") != "Array" else inner + 1
            case "ComponentReference":
                return self._reference_rank(node["parts"], scope)
            case "Unary" | "Parenthesized":
                return next((self.rank(node[key], scope) for key in ("rhs", "expr", "inner") if key in node), None)
            case "Binary":
                ranks = {self.rank(node["lhs"], scope), self.rank(node["rhs"], scope)}
                return ranks.pop() if len(ranks) == 1 and node["op"] in ("Add", "Sub") else 0 if ranks == {0} else None
            case _:
                return None

    def _reference_rank(self, parts: Sequence[Node], scope: _Class) -> int | None:
        type_: _Class | None = scope
        rank = 0
        for part in parts:
            element = None if type_ is None else self.elements(type_).get(part["ident"]["text"])
            if element is None or element.is_class or part["subs"]:
                return None
            rank += element.rank
            type_ = element.type
        return rank

    def _is_replaceable(self, modifier: _Modifier) -> bool:
        # rumoca's tree omits `replaceable` in a redeclaration of an extends clause.
        span = modifier.node["span"]
        text = self.sources[span["source"]][1][: span["start"]].decode(errors="replace")
        return (
            re.search(r"\breplaceable\s+(?:\w+\s+)*[\w.]*\s*$", text.rpartition(",")[2].rpartition("(")[2]) is not None
        )

    def _text_of(self, definition: Node) -> str:
        # Its declaration as it is written: rumoca's tree omits the modifiers of the constraining clause.
        place = definition["location"]
        _, text = self.sources.get(place["source"], ("", b""))
        return text[place["start"] :].partition(b";")[0].decode(errors="replace")

    def _text_at(self, span: Node) -> str:
        _, text = self.sources.get(span["source"], ("", b""))
        return text[span["start"] : span["end"]].decode(errors="replace")

    def _locate(self, node: Node, sentence: str) -> str:
        return _locate(node, sentence, self.sources)


def _locate(node: Node, sentence: str, sources: Sources) -> str:
    place = node.get("location") or node["span"]
    name, text = sources.get(place["source"], ("?", b""))
    line = text.count(b"\n", 0, place["start"]) + 1
    return f"{name}:{line}: {sentence}."


def _start(place: Node) -> tuple[int, int]:
    return place["source"], place["start"]


def _class(name: str, node: Node) -> _Class:
    return _Class(
        name=name,
        node=node,
        components={key: {**k["own"], "clause": k["clause"]} for key, k in node["components"].items() if key},
        classes={key: _class(f"{name}.{key}", inner) for key, inner in node["classes"].items() if key},
    )


def _extends_modifiers(clause: Node) -> tuple[_Modifier, ...]:
    arguments = clause["modifications"]
    return _modifiers(
        [a["expr"] for a in arguments], [a["each"] for a in arguments], [a["redeclare"] for a in arguments]
    )


def _modifiers(arguments: Sequence[Node], each: Sequence[bool], redeclare: Sequence[bool]) -> tuple[_Modifier, ...]:
    found: list[_Modifier] = []
    for i, argument in enumerate(arguments):
        modifier = _modifier(argument, i < len(each) and each[i], i < len(redeclare) and redeclare[i])
        if modifier is not None:
            found.append(modifier)
    return tuple(found)


def _modifier(argument: Node, each: bool, redeclare: bool) -> _Modifier | None:
    ((kind, node),) = argument.items()
    target, value, nested, new_type = node.get("target"), None, {}, ""
    if kind == "ClassModification":  # a(...)
        nested = node
    elif kind == "Binary" and node["op"] == "Assign" and "ClassModification" in node["lhs"]:  # a(...) = value
        nested, value = node["lhs"]["ClassModification"], node["rhs"]
        target = nested["target"]
    elif kind == "Modification" and redeclare:  # redeclare Type a(...)
        ((_, nested),) = node["value"].items()
        new_type = _path(nested.get("target", nested))
    elif kind == "Modification":  # a = value
        value = node["value"]
    else:
        return None
    inner = _modifiers(
        nested.get("modifications") or (), nested.get("each_flags") or (), nested.get("redeclare_flags") or ()
    )
    *outer, last = _path(target).split(".")
    written = {"span": target["span"], "whole": argument}
    found = _Modifier(last, value, inner, each, new_type, written)
    for name in reversed(outer):
        found = _Modifier(name, None, (found,), False, "", written, _path(target))
    return found


def _path(reference: Node) -> str:
    return ".".join(part["ident"]["text"] for part in reference["parts"])


def _join_name(name: Node | None) -> str:
    return ".".join(part["text"] for part in name["name"]) if name else ""


def _compared_parts(node: Node) -> Any:
    keys = ("type_def_id", "shape_expr", "binding", "variability", "causality", "modifiers", "is_protected")
    return _without_places({key: node.get(key) for key in keys})


def _without_places(tree: Any) -> Any:
    if isinstance(tree, dict):
        skipped = ("span", "location", "token_number", "def_id")
        return {key: _without_places(value) for key, value in tree.items() if key not in skipped}
    return [_without_places(value) for value in tree] if isinstance(tree, list) else tree
