"""Class declarations as they are written: a tree of rumoca's, with the name lookup of the Modelica language.

Section numbers are those of the Modelica Language Specification, version 3.6.
"""

import json
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any

from railgrip.base.errors import TranslationError

DECLARATIONS = Path(__file__).parent / "declarations"

Node = dict[str, Any]
"""A node of the syntax tree as rumoca writes it, with its field names."""

Finding = tuple[Node, str]
"""A node, and a sentence on what is forbidden or misread there."""

Sources = Mapping[int, tuple[str, bytes]]
"""Source id → (file name, text); places are byte offsets into the text."""

_TEXTS = re.compile(r"""//[^\n]*|/\*.*?\*/|"(?:[^"\\]|\\.)*"|'(?:[^'\\]|\\.)*'""", re.DOTALL)
KINDS = "model|block|class|record|connector|type|function|package|operator"
"""Keywords of class definitions, as a regular expression."""
SIMPLE = ("Real", "Integer", "Boolean", "String")


@dataclass(frozen=True, slots=True)
class Modifier:
    """One argument of a modification.

    Attributes:
        value: Expression of its value, or None.
        type: Name of the new type of a redeclaration, else ''.
        node: Node with its place in the source; `is_dotted` says whether its name is written with dots.
    """

    name: str
    value: Node | None
    inner: tuple["Modifier", ...]
    each: bool
    type: str
    node: Node

    def leaves(self, before: str = "") -> Iterator[str]:
        """Yield the paths of all elements that it assigns a value or redeclares."""
        path = f"{before}{self.name}"
        if self.value is not None or self.type:
            yield path
        if not self.type:
            for modifier in self.inner:
                yield from modifier.leaves(f"{path}.")


@dataclass(frozen=True)
class Class:
    """A class definition; `name` is the full one."""

    name: str
    node: Node
    components: Mapping[str, Node]
    classes: Mapping[str, "Class"]

    @property
    def definition(self) -> Node:
        """Declaration of the class itself."""
        return self.node["own"]

    @property
    def short_name(self) -> str:
        """Last part of its name."""
        return self.name.rpartition(".")[2]

    @property
    def kind(self) -> str:
        """Model, block, class, record, connector, type, function, package or operator."""
        return self.definition["class_type"].lower()

    @property
    def content(self) -> list[Any]:
        """Equations and algorithms, initial ones included."""
        return [item for section in self.node["sections"] for item in section]

    @property
    def literals(self) -> list[str]:
        """Literals of an enumeration, else empty."""
        return [literal["ident"]["text"] for literal in self.definition["enum_literals"]]


@dataclass(frozen=True, slots=True)
class Element:
    """A component or class in a class, own or inherited.

    Attributes:
        owner: Class in which it is declared.
        type: Type of a component, or the class itself; None for simple and unknown types.
        simple: The simple type of which it is a scalar or array: Real, Integer, Boolean, String or the class of an
            enumeration; None for other types.
        rank: Number of array dimensions.
        modifiers: Modifiers of its declaration.
        constraint_modifiers: Modifiers of an explicit constraining clause, name → expression; None without one.
        redeclared: Whether an extends clause redeclares it.
    """

    owner: Class
    node: Node
    is_class: bool
    type: Class | None
    simple: "str | Class | None"
    rank: int
    protected: bool
    replaceable: bool
    modifiers: tuple[Modifier, ...]
    constraint_modifiers: Mapping[str, Node] | None
    redeclared: bool = False

    @property
    def lost_in_clause(self) -> list[str]:
        """Names that the constraining clause modifies and the declaration does not: lost unless it is redeclared."""
        if self.redeclared or self.is_class:
            return []
        return sorted((self.constraint_modifiers or {}).keys() - {m.name for m in self.modifiers})

    @property
    def variability(self) -> str:
        """Declared prefix constant, parameter or discrete, else ''."""
        return "" if self.is_class else prefix(self.node["variability"])

    @property
    def causality(self) -> str:
        """Declared prefix input or output, else ''."""
        return "" if self.is_class else prefix(self.node["causality"])


@dataclass(frozen=True)
class Tree:
    """The classes that a class uses, by name and by rumoca's number of a definition."""

    content: Node
    sources: Sources
    _elements: dict[str, dict[str, Element]] = field(default_factory=dict[str, dict[str, Element]])
    _bases: dict[str, list[Class]] = field(default_factory=dict[str, list[Class]])

    @cached_property
    def roots(self) -> dict[str, Element]:
        """Classes that no class contains; the owner of each is itself."""
        classes = {name: self.by_name[name] for name in self.content if name}
        return {name: self._class_element(class_, class_) for name, class_ in classes.items()}

    @cached_property
    def every(self) -> list[Class]:
        """All classes, outer ones first."""

        def walk(classes: Mapping[str, Class]) -> Iterator[Class]:
            for class_ in classes.values():
                yield class_
                yield from walk(class_.classes)

        return list(walk({name: _class(name, node) for name, node in self.content.items() if name}))

    @cached_property
    def by_name(self) -> dict[str, Class]:
        """Classes by full name."""
        return {class_.name: class_ for class_ in self.every}

    @cached_property
    def by_id(self) -> dict[int, Class]:
        """Classes by rumoca's number."""
        return {class_.definition["def_id"]: class_ for class_ in self.every}

    @cached_property
    def component_of_id(self) -> dict[int, tuple[Class, str]]:
        """Class and name of each component, by rumoca's number."""
        return {
            node["def_id"]: (class_, name)
            for class_ in self.every
            for name, node in class_.components.items()
            if node["def_id"] is not None
        }

    def bases(self, class_: Class) -> list[Class]:
        """Return the classes that a class extends, directly or not."""
        if class_.name not in self._bases:
            self._bases[class_.name] = self._find_bases(class_)
        return self._bases[class_.name]

    def _find_bases(self, class_: Class) -> list[Class]:
        found: dict[str, Class] = {}
        pending = [class_]
        while pending:
            for clause in pending.pop().definition["extends"]:
                base = self.by_id.get(clause["base_def_id"])
                if base is not None and base.name not in found:
                    found[base.name] = base
                    pending.append(base)
        return list(found.values())

    def elements(self, class_: Class) -> dict[str, Element]:
        """Return the elements of a class by name, inherited ones first."""
        if class_.name not in self._elements:
            self._elements[class_.name] = {}  # where classes extend each other, which rumoca refuses
            self._elements[class_.name] = self.inherit(class_) | {
                **{name: self._element(class_, node) for name, node in class_.components.items()},
                **{inner.short_name: self._class_element(inner, class_) for inner in class_.classes.values()},
            }
        return self._elements[class_.name]

    def inherit(self, class_: Class) -> dict[str, Element]:
        """Return the elements that a class inherits, by name."""
        found: dict[str, Element] = {}
        for clause in class_.definition["extends"]:
            base = self.by_id.get(clause["base_def_id"])
            if base is None:
                continue
            elements = dict(self.elements(base))
            if clause["is_protected"]:
                elements = {name: replace(element, protected=True) for name, element in elements.items()}
            for modifier in extends_modifiers(clause):
                element = elements.get(modifier.name)
                if modifier.type and element is not None:
                    new = self.resolve(modifier.type, class_)
                    elements[modifier.name] = replace(
                        element,
                        type=new,
                        simple=self.simple(new)[0] or (modifier.type if modifier.type in SIMPLE else None),
                        replaceable=self.is_replaceable(modifier),
                        redeclared=True,
                    )
            found |= elements
        return found

    def _element(self, owner: Class, node: Node) -> Element:
        declared = self.by_id.get(node["type_def_id"] or -1)
        simple, rank = self.simple(declared)
        if declared is None and join_name(node["type_name"]) in SIMPLE:
            simple = join_name(node["type_name"])
        named = {
            path.removeprefix("__constrainedby__.").partition(".")[0]: value[0]
            for path, value in node["clause"].items()
            if path
        }
        return Element(
            owner=owner,
            node=node,
            is_class=False,
            type=None if simple else declared,
            simple=simple,
            rank=rank + len(node["shape_expr"] or ()),
            protected=node["is_protected"],
            replaceable=node["is_replaceable"],
            modifiers=modifiers_of(node["modifiers"], node["each"], node["redeclare"]),
            constraint_modifiers=named if node["constrainedby"] else None,
        )

    def _class_element(self, inner: Class, owner: Class) -> Element:
        definition = inner.definition
        return Element(
            owner=owner,
            node=definition,
            is_class=True,
            type=inner,
            simple=None,
            rank=0,
            protected=definition["is_protected"],
            replaceable=definition["is_replaceable"],
            modifiers=()
            if definition["is_long"]
            else tuple(m for clause in definition["extends"] for m in extends_modifiers(clause)),
            constraint_modifiers={} if definition["constrainedby"] else None,
        )

    def simple(self, class_: Class | None) -> tuple["str | Class | None", int]:
        """Return the simple type from which a class is derived, if any, and its number of array dimensions."""
        if class_ is None:
            return None, 0
        if class_.definition["enum_literals"]:
            return class_, 0
        rank = len(class_.definition["array_subscripts"] or ())
        for clause in class_.definition["extends"]:
            if join_name(clause["base_name"]) in SIMPLE:
                return join_name(clause["base_name"]), rank
            simple, more = self.simple(self.by_id.get(clause["base_def_id"]))
            if simple:
                return simple, rank + more
        return None, rank

    def resolve(self, name: str, scope: Class) -> Class | None:
        """Return the class of a name that is written in a class, None if it is unknown (section 5.3)."""
        first, *rest = name.split(".")
        path = self.follow(self.look_up(first, scope), rest)
        return path[-1].type if len(path) > len(rest) and all(element.is_class for element in path) else None

    def follow(self, found: Element | None, names: Iterable[str]) -> list[Element]:
        """Return an element, and those that further names denote in it, in that and so on, as far as they are known."""
        path: list[Element] = []
        for name in (*names, None):
            if found is None:
                break
            path.append(found)
            found = None if found.type is None or name is None else self.elements(found.type).get(name)
        return path

    def look_up(self, name: str, scope: Class) -> Element | None:
        """Return the element of a simple name in a class or the classes around it, or an imported or outermost class.

        An import is looked up where it is written only; it is not inherited (5.3.1).
        """
        place = scope.name
        while place:
            class_ = self.by_name.get(place)
            if class_ is not None:
                found = self.elements(class_).get(name) or self._imported(name, class_)
                if found is not None:
                    return found
            place = place.rpartition(".")[0]
        return self.roots.get(name)

    def _imported(self, name: str, class_: Class) -> Element | None:
        for clause in class_.definition["imports"]:
            ((kind, node),) = clause.items()
            path = join_name(node["path"]).split(".")
            if kind == "Unqualified":
                found = self.global_element([*path, name])
                if found is not None:
                    return found
            elif name in self.imported_names(clause):
                return self.global_element([*path, name] if kind == "Selective" else path)
        return None

    def imported_names(self, clause: Node) -> list[str]:
        """Return the names that an import clause makes known."""
        ((kind, node),) = clause.items()
        path = join_name(node["path"]).split(".")
        if kind == "Renamed":
            return [node["alias"]["text"]]
        if kind == "Selective":
            return [part["text"] for part in node.get("names", ())]
        if kind == "Unqualified":
            package = self.global_element(path)
            return [] if package is None or package.type is None else list(self.elements(package.type))
        return path[-1:]

    def global_element(self, names: Sequence[str]) -> Element | None:
        """Return the element of a name that starts at the outermost classes."""
        path = self.follow(self.roots.get(names[0]), names[1:])
        return path[-1] if len(path) == len(names) else None

    def component_path(self, class_: Class, reference: Node) -> list[Element]:
        """Return the components that the parts of a reference denote in a class, empty if one of them is unknown."""
        first, *rest = parts_of(reference)
        path = self.follow(self.elements(class_).get(first), rest)
        return path if len(path) > len(rest) and not any(element.is_class for element in path) else []

    def is_replaceable(self, modifier: Modifier) -> bool:
        """Return whether a redeclaration in an extends clause keeps the element replaceable."""
        # rumoca's tree omits `replaceable` in a redeclaration of an extends clause.
        span = modifier.node["span"]
        text = self._octets(span)[: span["start"]].decode(errors="replace").rpartition(",")[2].rpartition("(")[2]
        return re.search(r"\breplaceable\s+(?:\w+\s+)*[\w.]*\s*$", text) is not None

    def text(self, place: Node) -> str:
        """Return the text at a place."""
        return self._octets(place)[place["start"] : place["end"]].decode(errors="replace")

    def text_of(self, place: Node) -> str:
        """Return the text from a place to the next semicolon: rumoca's tree omits some of a declaration."""
        return self._octets(place)[place["start"] :].partition(b";")[0].decode(errors="replace")

    def _octets(self, place: Node) -> bytes:
        return self.sources.get(place["source"], ("", b""))[1]

    def code(self, class_: Class) -> str:
        """Return the text of the definition of a class, with strings and comments blanked so that lines stay."""
        return without_texts(self.text(class_.definition["location"]))

    def starts_with_dot(self, place: Node) -> bool:
        """Return whether a name is written with a leading dot, which rumoca's tree omits for the name of a type."""
        before = self._octets(place)[: place["start"]].rstrip()
        return before.endswith(b".") and not re.search(rb"[\w\])']\s*\.$", before[-200:])

    def locate(self, findings: Iterable[Finding]) -> Iterator[str]:
        """Yield `file:line: sentence.` for each finding."""
        for node, sentence in findings:
            place = node.get("location") or node["span"]
            name, text = self.sources.get(place["source"], ("?", b""))
            line = text.count(b"\n", 0, place["start"]) + 1
            yield f"{name}:{line}: {sentence}."


def read_tree(model: Any, class_name: str, sources: Sources) -> Tree:
    """Return the declarations of the classes that a class uses.

    Raises:
        TranslationError: A quoted name contains a quotation mark.
    """
    text: str = model.codegen(str(DECLARATIONS)).files[0].content
    try:
        return Tree(json.loads(_as_json(text), strict=False), sources)
    except json.JSONDecodeError as error:
        # rumoca does not escape quoted names, so a quotation mark in a name ends the string.
        raise TranslationError(f"{class_name}: a quoted name with a quotation mark in it is not translated.") from error


def _as_json(text: str) -> str:
    # minijinja writes `none` outside of strings, and escapes as Rust within, so that no control character remains.
    parts = text.replace("\\\\", "\0").replace('\\"', "\1").split('"')
    parts[::2] = "\2".join(parts[::2]).replace("none", "null").split("\2")
    text = '"'.join(parts).replace("\1", '\\"')
    return re.sub(r"\\u\{([0-9a-f]+)\}", lambda m: f"\\u{int(m[1], 16):04x}", text).replace("\0", "\\\\")


def _class(name: str, node: Node) -> Class:
    return Class(
        name=name,
        node=node,
        components={key: {**k["own"], "clause": k["clause"]} for key, k in node["components"].items() if key},
        classes={key: _class(f"{name}.{key}", inner) for key, inner in node["classes"].items() if key},
    )


def extends_modifiers(clause: Node) -> tuple[Modifier, ...]:
    """Return the modifiers of an extends clause."""
    arguments = clause["modifications"]
    return modifiers_of(
        [a["expr"] for a in arguments], [a["each"] for a in arguments], [a["redeclare"] for a in arguments]
    )


def modifiers_of(arguments: Sequence[Node], each: Sequence[bool], redeclare: Sequence[bool]) -> tuple[Modifier, ...]:
    """Return the modifiers of a list of arguments with their flags."""
    found: list[Modifier] = []
    for i, argument in enumerate(arguments):
        modifier = _modifier(argument, i < len(each) and each[i], i < len(redeclare) and redeclare[i])
        if modifier is not None:
            found.append(modifier)
    return tuple(found)


def _modifier(argument: Node, each: bool, redeclare: bool) -> Modifier | None:
    ((kind, node),) = argument.items()
    target, value, nested, new_type = node.get("target"), None, {}, ""
    if kind == "ClassModification":  # a(...)
        nested = node
    elif kind == "Binary" and node["op"] == "Assign" and "ClassModification" in node["lhs"]:  # a(...) = value
        nested, value = node["lhs"]["ClassModification"], node["rhs"]
        target = nested["target"]
    elif kind == "Modification" and redeclare:  # redeclare Type a(...) = value
        ((form, nested),) = node["value"].items()
        if form not in ("ClassModification", "ComponentReference"):  # replaceable Type a = value, without its type
            nested, value = {}, {"ClassModification": {}}
        else:
            new_type = path_of(nested.get("target", nested))
            value = next((a for a in nested.get("modifications") or () if not _is_modification(a)), None)
    elif kind == "Modification":  # a = value
        value = node["value"]
    else:
        return None
    inner = modifiers_of(
        nested.get("modifications") or (), nested.get("each_flags") or (), nested.get("redeclare_flags") or ()
    )
    *outer, last = path_of(target).split(".")
    written = {"span": target["span"], "whole": argument, "is_dotted": False}
    found = Modifier(last, value, inner, each, new_type, written)
    for name in reversed(outer):
        found = Modifier(name, None, (found,), False, "", written)
    return replace(found, node=written | {"is_dotted": bool(outer)})


def _is_modification(argument: Node) -> bool:
    # rumoca appends the value of a redeclaration to its modifiers.
    ((kind, node),) = argument.items()
    return kind in ("Modification", "ClassModification") or (kind == "Binary" and node["op"] == "Assign")


def without_texts(code: str) -> str:
    """Return a Modelica text with comments, strings and quoted names blanked, so that places stay as they are."""
    return _TEXTS.sub(blank, code)


def blank(match: re.Match[str]) -> str:
    """Return spaces in place of a match, with its lines."""
    return re.sub(r"[^\n]", " ", match[0])


def parts_of(reference: Node) -> list[str]:
    """Return the parts of the name of a reference, without subscripts."""
    return [part["ident"]["text"] for part in reference["parts"]]


def path_of(reference: Node) -> str:
    """Return the name of a reference, without subscripts."""
    return ".".join(parts_of(reference))


def join_name(name: Node | None) -> str:
    """Return a name with dots, '' for none."""
    return ".".join(part["text"] for part in name["name"]) if name else ""


def prefix(value: "str | Node") -> str:
    """Return a prefix such as parameter or input, '' for none."""
    return "" if isinstance(value, str) else next(iter(value)).lower()


def walk(tree: Any) -> Iterator[tuple[Node, frozenset[str]]]:
    """Yield all nodes of a tree but places, outer ones first, each with the iteration variables around it."""
    stack: list[tuple[Any, frozenset[str]]] = [(tree, frozenset())]
    while stack:
        node, bound = stack.pop()
        inside: Any = node
        if isinstance(node, dict):
            if "indices" in node:
                bound |= {index["ident"]["text"] for index in node["indices"]}
            yield node, bound
            inside = [value for key, value in node.items() if key not in ("span", "location")]
        stack += [(value, bound) for value in reversed(inside) if isinstance(value, (list, dict))]


def without_places(tree: Any) -> Any:
    """Return a tree without the positions in the source, for comparison."""
    if isinstance(tree, dict):
        skipped = ("span", "location", "token_number", "def_id", "scope_id")
        return {key: without_places(value) for key, value in tree.items() if key not in skipped}
    return [without_places(value) for value in tree] if isinstance(tree, list) else tree
