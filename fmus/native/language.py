"""Constructs that rumoca interprets differently from the Modelica language, or that the language forbids.

Section numbers are those of the Modelica Language Specification, version 3.6. Rules that rumoca 0.10 enforces itself
are not repeated here; tests/fmus/test_strict_modelica.py lists them. This module has the rules of declarations; `names`
has those of expressions and names that rumoca confuses, `connections` those of connect equations.
"""

import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence, Set
from dataclasses import dataclass
from typing import Any

from railgrip.base.errors import InputError, TranslationError
from railgrip.fmus.native import connections, names
from railgrip.fmus.native.classes import (
    KINDS,
    SIMPLE,
    Class,
    Element,
    Finding,
    Modifier,
    Node,
    Tree,
    extends_modifiers,
    join_name,
    prefix,
    without_places,
)

_ATTRIBUTES = frozenset(  # section 4.9
    ("value", "quantity", "unit", "displayUnit", "min", "max", "start", "fixed", "nominal", "unbounded", "stateSelect")
)
_BASES = {  # section 7.1.3; rumoca enforces the others
    "model": ("model", "block", "record"),
    "block": ("block", "record"),
    "record": ("record",),
    "connector": ("connector", "record", "type"),
    "type": ("type",),
}
"""Kind of a class → kinds of its base classes."""
_CLASS_EXTENDS = (
    "`{0} extends {1}` is not supported by the built-in compiler (7.3.1); write a class of another name that extends "
    "the inherited {1}, and redeclare {1} as that class in the extends clause"
)
_CONSTRAINT_MODIFIERS = re.compile(r"\bconstrainedby\s+[\w.]+\s*\(")
_OURS = "built-in compiler"
"""Words of findings on valid Modelica."""
_MAXIMUM_FINDINGS = 3
"""Maximum number of findings in a message."""


def require_strict(tree: Tree, class_name: str, flat: Mapping[str, Node], calls: Iterable[names.Call] = ()) -> None:
    """Raise an error for constructs that Modelica compilers interpret differently, or rumoca misreads.

    Args:
        tree: Declarations of the class and of those that it uses.
        class_name: Full name of the class.
        flat: Variables of the flat class by name; empty if it could not be flattened.
        calls: Calls of functions in the flat class.

    Raises:
        InputError: The class is illegal; the message lists the constructs with file and line.
        TranslationError: It is legal, and has constructs that rumoca misreads.
    """
    found = [*_Checker(tree, class_name).findings(), *names.findings(tree), *connections.findings(tree, flat)]
    misread = [*names.misread_clauses(tree), *(finding for finding in found if _OURS in finding[1])]
    illegal = [finding for finding in found if _OURS not in finding[1]]
    refuse(f"{class_name} does not conform to the Modelica language", tree.locate(illegal), InputError)
    refuse(f"{class_name} has Modelica that the built-in compiler does not translate", tree.locate(misread))
    refuse(f"{class_name} would call the wrong function", tree.locate(names.confused_calls(tree, calls)))


def require_values(
    tree: Tree, class_name: str, variables: Mapping[str, Node], outer: Set[str], *, complete: bool
) -> None:
    """Raise an error for parameters and constants without a value, whose start value would be used (4.4.4, 8.6).

    For parameters this is the only sign of a lost modifier; therefore OpenModelica's warning fails a build as well.
    Parameters of the class itself are set by the importer of the FMU.

    Args:
        tree: Declarations of the class and of those that it uses.
        class_name: Full name of the class.
        variables: Variables of the flat class by name.
        outer: Names of outer variables, which have the value of an inner one.
        complete: Whether the parameters of components must have a value.

    Raises:
        InputError: A constant, or a parameter of a component, has no value and is not an array of size zero.
    """

    def kind(name: str, variable: Node) -> str:
        if name in outer or variable["binding"] is not None or 0 in variable["dims"]:
            return ""
        if "Constant" in variable["variability"]:
            return "constant"
        is_set = "." in name and "Parameter" in variable["variability"] and all(variable["fixed"] or ())
        return "parameter" if complete and is_set else ""

    refuse(
        f"{class_name} has parameters or constants without a value",
        tree.locate(
            ({"span": variable["source_span"]}, f"{kind(name, variable)} {name} has no value")
            for name, variable in variables.items()
            if kind(name, variable)
        ),
        InputError,
    )


def refuse(what: str, sentences: Iterable[str], kind: type[InputError] = TranslationError) -> None:
    """Raise an error of a kind with the first of some sentences, if there are any."""
    every = list(dict.fromkeys(sentences))
    if every:
        more = [f"and {len(every) - _MAXIMUM_FINDINGS} more"] if len(every) > _MAXIMUM_FINDINGS else []
        raise kind("\n  ".join([f"{what}:", *every[:_MAXIMUM_FINDINGS], *more]))


@dataclass(frozen=True)
class _Checker:
    """Checks of a tree of declarations.

    In its methods, `rank` is the number of dimensions, `outside` is whether modifiers come from outside the modified
    class, which excludes protected elements, and `depth` is the level of nested modifiers.
    """

    tree: Tree
    class_name: str

    def findings(self) -> Iterator[Finding]:
        top = self.tree.by_name.get(self.class_name)
        if top is not None:
            yield from self._lost_modifiers(top.definition, top.short_name, top, ())
        yield from self._renamed_functions()
        for class_ in self.tree.every:
            yield from self._built_in_name(class_)
            yield from self._class_extends(class_)
            yield from self._imports(class_)
            yield from self._enumeration(class_)
            yield from self._bases(class_)
            for name, node in class_.components.items():
                yield from self._component(class_, name, node)
            for inner in class_.classes.values():
                yield from self._local_class(class_, inner)

    def _built_in_name(self, class_: Class) -> Iterator[Finding]:
        name = class_.short_name
        if not names.BUILT_IN_FUNCTIONS.fullmatch(name) or class_.kind != "function":
            return
        # A function that only calls the built-in one, as those of Modelica.Math do, is equal to it.
        inputs = r"\s*,\s*".join(n for n, e in self.tree.elements(class_).items() if e.causality == "input")
        call = rf"\balgorithm\s+\w+\s*:=\s*\.{name}\s*\(\s*{inputs}\s*\)\s*;\s*(?:annotation|end)\b"
        external = rf'\bexternal\s+"builtin"\s+\w+\s*=\s*{name}\s*\('
        text, code = self.tree.text(class_.definition["location"]), self.tree.code(class_)
        if not re.search(external, text) and not re.search(call, code):
            yield (
                class_.definition,
                f"the function {class_.name} has the name of a built-in one, which the built-in compiler calls instead "
                "(5.3.1); choose another name",
            )

    def _renamed_functions(self) -> Iterator[Finding]:
        for source, (_, content) in self.tree.sources.items():
            for match in re.finditer(rb"\bimport\s+(\w+)\s*=\s*([\w.]+)", content):
                name, function = match[1].decode(), match[2].decode()
                if names.BUILT_IN_FUNCTIONS.fullmatch(name) and function != f"Modelica.Math.{name}":
                    yield (
                        {"span": {"source": source, "start": match.start()}},
                        f"the import {name} has the name of a built-in function, which the built-in compiler calls "
                        "instead (5.3.1); choose another name",
                    )

    def _bases(self, class_: Class) -> Iterator[Finding]:
        inherited: dict[str, Element] = {}
        clauses = class_.definition["extends"]
        for clause in clauses:
            base = self.tree.by_id.get(clause["base_def_id"])
            named = join_name(clause["base_name"])
            if named == class_.short_name:
                yield class_.definition, _CLASS_EXTENDS.format(class_.kind, named)
                return
            if class_.definition["is_long"] and (class_.components or len(clauses) > 1):
                if named in SIMPLE or self.tree.simple(base)[0]:
                    what = "a simple type"
                elif base is not None and base.definition["array_subscripts"]:
                    what = "an array of a class"
                elif base is not None and prefix(base.definition["causality"]):
                    what = "a class with the prefix input or output"
                else:
                    what = ""
                if what:
                    yield clause, f"{class_.short_name} extends {named}, {what}, and has other elements (7.1.3)"
            if base is None:
                continue
            allowed = _BASES.get(class_.kind)
            if allowed is not None and base.kind not in (*allowed, "class"):
                yield (
                    clause, f"the {class_.kind} {class_.short_name} extends the {base.kind} {named} (7.1.3); "
                    f"the base class must be a {' or '.join(allowed)}"
                )  # fmt: skip
            if base.definition["is_replaceable"] and not class_.definition["is_redeclare"]:
                yield clause, f"{base.name} is replaceable and cannot be a base class (7.1.4)"
            arguments = extends_modifiers(clause)
            simple, base_rank = self.tree.simple(base)
            if simple:
                subscripts = class_.definition["array_subscripts"] or ()
                yield from self._attributes(class_, arguments, class_.short_name, base_rank + len(subscripts))
                continue
            yield from self._modifiers(class_, arguments, base, rank=0, outside=False, depth=0)
            elements = self.tree.elements(base)
            for argument in arguments:
                element = elements.get(argument.name)
                if argument.type and element is not None and element.redeclared and not element.is_class:
                    yield (
                        argument.node,
                        f"the redeclaration of '{argument.name}' is lost in the built-in compiler, because a base "
                        f"class of {class_.short_name} redeclares it as well (7.3); declare it of a replaceable class, "
                        "and redeclare that class",
                    )
            yield from self._inherited_twice(class_, clause, inherited, elements)
            inherited |= elements
        for inner in class_.classes.values():
            name = inner.short_name
            base = self._base_with_class(class_, name)
            if name not in inherited and not inner.definition["is_redeclare"] and base is not None:
                yield (
                    inner.definition,
                    f"the class {name} is declared, and another in the base class {base.name} (7.1); rename it",
                )
            if name not in inherited or inner.definition["is_redeclare"]:
                continue
            theirs = inherited[name]
            if theirs.type is None or without_places(inner.node) != without_places(theirs.type.node):
                yield (
                    inner.definition,
                    f"the class {name} is inherited from {theirs.owner.name} and declared again, differently (7.1)",
                )
        for name in class_.components.keys() & inherited.keys():
            mine, theirs = self.tree.elements(class_)[name], inherited[name]
            if not mine.node["is_redeclare"] and _compared_parts(mine.node) != _compared_parts(theirs.node):
                yield mine.node, f"{name} is inherited from {theirs.owner.name} and declared again, differently (7.1)"

    def _inherited_twice(
        self, class_: Class, clause: Node, first: Mapping[str, Element], second: Mapping[str, Element]
    ) -> Iterator[Finding]:
        modified = {m.name for c in class_.definition["extends"] for m in extends_modifiers(c)}
        for name in first.keys() & second.keys():
            one, other = first[name], second[name]
            if one.node is other.node and name not in modified:
                continue
            if one.node is other.node or _compared_parts(one.node) != _compared_parts(other.node):
                yield (
                    clause,
                    f"{class_.short_name} inherits {name} twice, from {one.owner.name} and {other.owner.name}, with "
                    "declarations or modifiers that may differ (7.1)",
                )

    def _class_extends(self, class_: Class) -> Iterator[Finding]:
        # rumoca's tree omits a class that nothing uses, such as the extended one without the keyword redeclare.
        if class_.kind == "package":
            return
        code, place = self.tree.code(class_), class_.definition["location"]
        for form in re.finditer(rf"\b({KINDS})\s+extends\s+(\w+)", code):
            start = place["start"] + len(code[: form.start()].encode())
            yield {"span": place | {"start": start}}, _CLASS_EXTENDS.format(form[1], form[2])

    def _base_with_class(self, class_: Class, name: str) -> Class | None:
        # rumoca's tree omits a class that nothing uses, so that of a base class may be in its text only.
        declaration = re.compile(rf"\b(?:{KINDS})\s+{re.escape(name)}\b")
        return next((base for base in self.tree.bases(class_) if declaration.search(self.tree.code(base))), None)

    def _imports(self, class_: Class) -> Iterator[Finding]:
        # rumoca looks up imports before inherited elements.
        inherited = self.tree.inherit(class_)
        for clause in class_.definition["imports"]:
            for name in self.tree.imported_names(clause):
                if name in inherited or self._base_with_class(class_, name) is not None:
                    ((_, node),) = clause.items()
                    yield (
                        node,
                        f"{class_.short_name} imports {name} and inherits an element {name}, which the built-in "
                        "compiler does not find (5.3.1); write the full name of the imported one without the import",
                    )

    def _enumeration(self, class_: Class) -> Iterator[Finding]:
        literals = class_.literals
        for literal in sorted(set(literals)):
            if literal in ("quantity", "min", "max", "start", "fixed"):
                yield class_.definition, f"the enumeration {class_.name} has a literal {literal} (4.9.5)"
            if literals.count(literal) > 1:
                yield class_.definition, f"the enumeration {class_.name} has {literal} twice (4.9.5)"

    def _prefixes(self, class_: Class, name: str, element: Element) -> Iterator[Finding]:
        node = element.node
        if name in SIMPLE:
            yield node, f"a component has the name {name} of a predefined type (4.9)"
        if class_.kind == "record" and (node["inner"] or node["outer"]):
            yield node, f"{name} of the record {class_.short_name} is inner or outer (4.7)"
        if node["inner"] and node["outer"]:
            yield (
                node, f"{name} is inner and outer, which the built-in compiler does not support (5.4); declare an "
                "inner component of another name that is modified with values of the outer one"
            )  # fmt: skip
        prefixes = " ".join(p for p in (element.variability, element.causality) if p)
        if prefixes and element.type is not None and element.type.kind in ("model", "block"):
            yield (
                node, f"{name} is {prefixes} and of the {element.type.kind} {element.type.name} (4.4.2.2); "
                "only simple types, records and connectors can be"
            )  # fmt: skip
        if node["outer"] and node["binding"] is None and element.variability == "" and element.simple == "Real":
            yield (
                node, f"the built-in compiler does not support the outer Real variable {name} (5.4); declare it in a "
                f"model, such as `model World Real {name}; end World;`, and write `inner World world` and "
                f"`outer World world`"
            )  # fmt: skip

    def _component(self, class_: Class, name: str, node: Node) -> Iterator[Finding]:
        element = self.tree.elements(class_)[name]
        yield from self._prefixes(class_, name, element)
        yield from self._constraint(class_, name, element)
        yield from self._redeclared_element(class_, name, element)
        modifiers = element.modifiers
        if element.type is None:
            if element.simple:
                yield from self._attributes(class_, modifiers, name, element.rank)
            return
        if element.type.definition["array_subscripts"]:
            yield (
                node, f"the class {element.type.name} of {name} is an array, which the built-in compiler does not "
                f"support; write the subscripts on {name}"
            )  # fmt: skip
        if modifiers and element.type.definition["is_final"]:
            yield node, f"{name} modifies the class {element.type.name}, which is final (7.2.6)"
        yield from self._modifiers(class_, modifiers, element.type, rank=element.rank, outside=True, depth=0)
        yield from self._lost_modifiers(node, name, element.type, modifiers)

    def _local_class(self, class_: Class, inner: Class) -> Iterator[Finding]:
        definition = inner.definition
        short = inner.short_name
        if short in SIMPLE:
            yield definition, f"a class has the name {short} of a predefined type (4.9)"
        if definition["constrainedby"]:
            constraint = self.tree.resolve(join_name(definition["constrainedby"]), class_)
            own = len(definition["array_subscripts"] or ())
            yield from self._subtype(definition, short, inner, constraint, own)
            if _CONSTRAINT_MODIFIERS.search(self.tree.text_of(definition["location"])):
                yield (
                    definition,
                    f"modifiers in the constraining clause of the class {short} are lost in the built-in compiler "
                    f"(7.3.2); write them on components of type {short}",
                )
        yield from self._redeclared_element(class_, short, self.tree.elements(class_)[short])

    def _constraint(self, class_: Class, name: str, element: Element) -> Iterator[Finding]:
        named = element.node["constrainedby"]
        constraint = self.tree.resolve(join_name(named), class_) if named else None
        if constraint is None:
            return
        allowed = self.tree.elements(constraint)
        for modified in element.constraint_modifiers or {}:
            if modified not in allowed:
                yield (
                    element.node, f"the constraining clause of {name} modifies '{modified}', which {constraint.name} "
                    "does not have (7.3.2)"
                )  # fmt: skip
        yield from self._subtype(element.node, name, self.tree.by_id.get(element.node["type_def_id"] or -1), constraint)

    def _subtype(
        self, node: Node, name: str, new: Class | None, constraint: Class | None, own_rank: int = 0
    ) -> Iterator[Finding]:
        # The dimensions that a declaration itself adds to its type do not count.
        if new is None or constraint is None:
            return
        simple, rank = self.tree.simple(new)
        if (simple, rank - own_rank) != self.tree.simple(constraint):
            yield (
                node, f"{name} is of {new.name}, whose type or number of dimensions is not that of {constraint.name} "
                "(7.3.2)"
            )  # fmt: skip
        has = self.tree.elements(new)
        missing = sorted(
            n
            for n, e in self.tree.elements(constraint).items()
            if not e.protected and (n not in has or has[n].protected)
        )
        if missing:
            yield node, f"{name} is of {new.name}, which lacks {', '.join(missing)} of {constraint.name} (7.3.2)"

    def _redeclared_element(self, class_: Class, name: str, element: Element) -> Iterator[Finding]:
        node, original = element.node, self.tree.inherit(class_).get(name)
        if not node["is_redeclare"]:
            return
        if original is None:
            yield node, f"{name} is redeclared, but {class_.name} does not inherit it (7.3)"
            return
        if not original.replaceable:
            yield node, f"{name} is redeclared, but is not replaceable (7.3.3)"
        if original.node["is_final"]:
            yield node, f"{name} is redeclared, but is final in {original.owner.name} (7.2.6)"
        if original.variability == "constant":
            yield node, f"{name} is redeclared, but is a constant of {original.owner.name} (7.3.3)"
        if original.protected != element.protected:
            before, after = ("protected", "public") if original.protected else ("public", "protected")
            yield node, f"{name} is redeclared as {after}, but is {before} in {original.owner.name} (7.3.3)"
        constraint = None if element.is_class else original.node["constrainedby"]
        bound = self.tree.resolve(join_name(constraint), original.owner) if constraint else original.type
        yield from self._subtype(node, name, element.type, bound)
        constrained = original.modifiers if original.constraint_modifiers is None else original.constraint_modifiers
        if constrained and not element.is_class:
            yield (
                node,
                f"the redeclaration of {name} would lose the modifiers of its constraining type in the built-in "
                f"compiler (7.3.2); redeclare it in the extends clause",
            )

    def _modifiers(
        self, scope: Class, modifiers: Sequence[Modifier], target: Class, *, rank: int, outside: bool, depth: int
    ) -> Iterator[Finding]:
        yield from self._duplicates(modifiers)
        elements = self.tree.elements(target)
        for modifier in modifiers:
            name, element = modifier.name, elements.get(modifier.name)
            if element is None:
                yield modifier.node, f"'{name}' is modified, which {target.name} does not have (7.2)"
                continue
            if outside and element.protected:
                yield modifier.node, f"'{name}' is modified, which is protected in {target.name} (4.1)"
            if modifier.node["is_dotted"]:
                path = next(modifier.leaves(), name)
                yield (
                    modifier.node,
                    f"the modifier of '{path}' would be lost in the built-in compiler (7.2); write nested brackets: "
                    f"{path.replace('.', '(')} = ...{')' * path.count('.')}",
                )
            if not element.is_class and element.node["outer"]:
                yield (
                    modifier.node, f"'{name}' is modified, which is outer in {element.owner.name} (5.4); modify the "
                    "inner component"
                )  # fmt: skip
            if modifier.value is not None and "ClassModification" in modifier.value:
                yield (
                    modifier.node,
                    f"'{name}' is replaced without the keyword redeclare; write `redeclare replaceable` (7.3)",
                )
                continue
            if element.is_class and not modifier.type and modifier.value is not None:
                yield (
                    modifier.node,
                    f"the class '{name}' is replaced without the keyword redeclare; write "
                    f"`redeclare {element.node['class_type'].lower()} {name} = ...` (7.3)"
                )  # fmt: skip
                continue
            if element.is_class and not modifier.type:
                yield (
                    modifier.node, f"the modifiers of the class '{name}' would be lost in the built-in compiler (7.2); "
                    f"write them on components of type {name}"
                )  # fmt: skip
                continue
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
                yield modifier.node, f"a part of '{name}' is modified, which has a value as a whole (7.2.3)"
            yield from self._modifiers(
                scope, modifier.inner, element.type, rank=around + element.rank, outside=True, depth=depth + 1
            )

    def _redeclaration(self, scope: Class, modifier: Modifier, element: Element, depth: int) -> Iterator[Finding]:
        name, new = modifier.name, self.tree.resolve(modifier.type, scope)
        if depth:
            yield (
                modifier.node,
                f"the redeclaration of '{name}' inside the modifiers of a component is lost in the built-in compiler; "
                "make a class replaceable at each level and redeclare that",
            )
        if not element.replaceable:
            yield modifier.node, f"'{name}' is redeclared, but is not replaceable (7.3.3)"
        if element.node["is_final"]:
            yield modifier.node, f"'{name}' is redeclared, but is final in {element.owner.name} (7.2.6)"
        # rumoca's tree omits a value that follows modifiers in brackets.
        argument = self._argument_text(modifier)
        follows = re.sub(r"\([^()]*(?:\([^()]*\)[^()]*)*\)", "", argument).partition('"')[0]
        if modifier.value is not None or (not element.is_class and re.match(r"[\w.\[\]:\s]*=", follows)):
            yield (
                modifier.node,
                f"the value of the redeclaration of '{name}' would be lost in the built-in compiler (7.3); if its type "
                f"remains, write `{name} = ...` without redeclare, else write a class that extends "
                f"{element.owner.name} and redeclares {name} as an element: "
                f"`redeclare {modifier.type} {name} = ...;`",
            )
        if _CONSTRAINT_MODIFIERS.search(argument):
            yield (
                modifier.node,
                f"the constraining clause in the redeclaration of '{name}' would be lost in the built-in compiler "
                "(7.3.2); write a class that extends the other and redeclares it as an element",
            )
        if element.is_class and element.modifiers:
            yield (
                modifier.node,
                f"the redeclaration of '{name}' would lose the modifiers of its declaration in the built-in compiler "
                f"(7.3.2); write them on components of type {name}",
            )
        if element.is_class and modifier.inner:
            yield (
                modifier.node,
                f"the modifiers of the class that replaces '{name}' are lost in the built-in compiler; replace it by a "
                "class of your own that extends that class with the modifiers",
            )
        if element.constraint_modifiers is not None and not element.is_class:
            for m in element.modifiers:
                written = m.value if m.value is not None and not m.inner else m.node
                if without_places(written) != without_places(element.constraint_modifiers.get(m.name)):
                    yield (
                        element.node,
                        f"'{m.name}' is modified on the declaration of {name} and not, or otherwise, in its "
                        f"constraining clause: redeclared, {name} loses it (7.3.2); write "
                        "`constrainedby` with the modifiers",
                    )
        simple, rank = (modifier.type, 0) if modifier.type in SIMPLE else self.tree.simple(new)
        if element.is_class and element.type is not None and (simple, rank) != self.tree.simple(element.type):
            yield (
                modifier.node,
                f"'{name}' is replaced by {modifier.type}, whose type or number of dimensions is not that of "
                f"{element.type.name} (7.3.2)",
            )
        if new is not None and not self.tree.simple(new)[0]:
            yield from self._modifiers(scope, modifier.inner, new, rank=element.rank, outside=True, depth=depth + 1)
            yield from self._lost_modifiers(modifier.node, name, new, modifier.inner)

    def _lost_modifiers(self, node: Node, name: str, used: Class, modifiers: Sequence[Modifier]) -> Iterator[Finding]:
        # rumoca reads a constraining clause only where the class is redeclared.
        redeclared = {m.name for m in modifiers if m.type}
        for part, element in self.tree.elements(used).items():
            if element.lost_in_clause and part not in redeclared:
                yield (
                    node,
                    f"{name} does not redeclare '{part}' of {used.name}: the built-in compiler would lose the "
                    f"modifiers of its constraining clause, {', '.join(element.lost_in_clause)} (7.3.2); redeclare it, "
                    "or write them on its declaration as well",
                )

    def _attributes(self, scope: Class, modifiers: Sequence[Modifier], name: str, rank: int) -> Iterator[Finding]:
        yield from self._duplicates(modifiers)
        for modifier in modifiers:
            if modifier.name not in _ATTRIBUTES:
                yield modifier.node, f"'{modifier.name}' is not an attribute of {name} (4.9)"
            yield from self._rank(scope, modifier, 0 if modifier.each else rank)

    def _rank(self, scope: Class, modifier: Modifier, required: int) -> Iterator[Finding]:
        found = None if modifier.value is None else self.rank(modifier.value, scope)
        if found is not None and found != required:
            what = ("a scalar", "a vector", "a matrix")[min(found, 2)]
            hint = "; write `each`" if found < required and not modifier.each else ""
            yield (
                modifier.node,
                f"'{modifier.name}' is given {what} where {required} dimensions are required (7.2.5){hint}",
            )

    def _duplicates(self, modifiers: Sequence[Modifier]) -> Iterator[Finding]:
        counts = Counter(leaf for modifier in modifiers for leaf in modifier.leaves())
        for modifier in modifiers:
            for leaf in modifier.leaves():
                if counts[leaf] > 1:
                    yield modifier.node, f"'{leaf}' is modified twice (7.2.4)"

    def rank(self, value: Node, scope: Class) -> int | None:
        """Return the number of dimensions of an expression, None if its form alone does not determine it."""
        ((kind, node),) = value.items()
        match kind:
            case "Terminal" | "Literal":
                return 0
            case "Array":
                inner = self.rank(node["elements"][0], scope) if node["elements"] else None
                return None if inner is None or node.get("kind") != "Array" else inner + 1
            case "ComponentReference":
                path = self.tree.component_path(scope, node)
                is_whole = path and not any(part["subs"] for part in node["parts"])
                return sum(element.rank for element in path) if is_whole else None
            case "Unary" | "Parenthesized":
                return next((self.rank(node[key], scope) for key in ("rhs", "expr", "inner") if key in node), None)
            case "Binary":
                ranks = {self.rank(node["lhs"], scope), self.rank(node["rhs"], scope)}
                return ranks.pop() if len(ranks) == 1 and node["op"] in ("Add", "Sub") else 0 if ranks == {0} else None
            case _:
                return None

    def _argument_text(self, modifier: Modifier) -> str:
        # From its name to the comma or bracket that ends the argument.
        text, depth = self.tree.text_of(modifier.node["span"]), 0
        for i, character in enumerate(text):
            depth += (character in "([{") - (character in ")]}")
            if depth < 0 or (not depth and character == ","):
                return text[:i]
        return text


def _compared_parts(node: Node) -> Any:
    keys = ("type_def_id", "shape_expr", "binding", "variability", "causality", "modifiers", "is_protected")
    return without_places({key: node.get(key) for key in keys})
