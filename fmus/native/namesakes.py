"""Elements of different packages that rumoca 0.10 confuses, because it keeps only a part of their names.

Section numbers are those of the Modelica Language Specification, version 3.6.
"""

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from railgrip.fmus.native.classes import Class, Node, Tree, extends_modifiers


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


def findings(tree: Tree) -> Iterator[str]:
    """Yield a sentence with file and line for each constant that rumoca confuses with another one."""
    yield from _computed_constants(tree)
    for class_ in tree.every:
        for clause in class_.definition["extends"]:
            base = tree.by_id.get(clause["base_def_id"])
            if base is not None:
                yield from _shared_constants(tree, class_, clause, base)


def confused_calls(tree: Tree, calls: Iterable[Call]) -> Iterator[str]:
    """Yield a sentence for each call for which rumoca took another function of the same name.

    rumoca keeps the name of a function as it is written, unless it is imported or redeclared, so that two functions `f`
    of different packages become one.
    """
    declared = {_start(class_.definition["location"]): class_ for class_ in tree.every}
    for call in calls:
        written = re.match(r"[\w.]*", _text_at(tree, call.node["span"]))
        if written is None or written[0] != call.name:
            continue
        right = tree.resolve(call.name, _around(tree, call.node["span"]))
        taken = declared.get(_start(call.declaration["span"]))
        if right is not None and taken is not None and taken.name not in {right.name, *_bases(tree, right)}:
            yield tree.locate(
                call.node,
                f"{call.name} is {right.name}, but the built-in compiler takes {taken.name}, which has the same name; "
                "rename one of them (5.3)",
            )


def _computed_constants(tree: Tree) -> Iterator[str]:
    # rumoca computes constants by the last two parts of their names.
    found: dict[tuple[str, str], list[Node]] = {}
    for class_ in tree.every:
        if class_.kind == "package" and "." in class_.name:
            for name, node in class_.components.items():
                found.setdefault((class_.short_name, name), []).append(node)
    for (package, name), nodes in found.items():
        computed = any(kind in str(node["binding"]) for node in nodes for kind in ("Reference", "FunctionCall"))
        uses = re.compile(rf"\b{package}\s*\.\s*{name}\b")
        if len(nodes) > 1 and computed and _is_written(tree, uses):
            yield tree.locate(
                nodes[-1],
                f"{package}.{name} is a computed constant of {len(nodes)} packages of the name {package}, which the "
                "built-in compiler confuses; rename one of them (5.3)",
            )


def _shared_constants(tree: Tree, heir: Class, clause: Node, base: Class) -> Iterator[str]:
    # If a class uses both packages, rumoca gives the base the constants of its heir.
    modified = {modifier.name for modifier in extends_modifiers(clause)}
    if base.kind != "package" or not modified & base.components.keys():
        return
    affected = "|".join([*base.components, *base.classes])
    uses = re.compile(rf"\b{base.short_name}\s*\.\s*(?:{affected})\b")
    if _is_written(tree, uses) and _is_written(tree, re.compile(rf"\b{heir.short_name}\s*\.")):
        yield tree.locate(
            clause,
            f"{heir.name} modifies constants of {base.name}, which is used itself: the built-in compiler would modify "
            f"them in {base.name} too (7.1); declare the constants without a value there",
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


def _bases(tree: Tree, class_: Class) -> set[str]:
    # A short class is declared where its base is.
    return {base.name for base in tree.bases(class_)}


def _text_at(tree: Tree, span: Node) -> str:
    _, text = tree.sources.get(span["source"], ("", b""))
    return text[span["start"] : span["end"]].decode(errors="replace")


def _start(place: Node) -> tuple[int, int]:
    return place["source"], place["start"]
