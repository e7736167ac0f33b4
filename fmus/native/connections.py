"""Connect equations that rumoca reads differently from the Modelica language, or that the language forbids.

Section numbers are those of the Modelica Language Specification, version 3.6.
"""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from railgrip.base.groups import gather
from railgrip.fmus.native.classes import Class, Element, Finding, Node, Tree, path_of, prefix, walk

_Places = dict[str, list[tuple[Node, list[Node], int]]]
"""Simple name of a component → flat variables, the parts of their names, and its place among these."""


def findings(tree: Tree, flat: Mapping[str, Node]) -> Iterator[Finding]:
    """Yield a finding for each connect equation that is misread or forbidden.

    Args:
        tree: Declarations of the class and of those that it uses.
        flat: Variables of the flat class by name; empty if it could not be flattened.
    """
    places = _places(flat)
    for class_ in tree.every:
        equations: list[Node] = [node["Connect"] for node, _ in walk(class_.content) if "Connect" in node]
        for equation in equations:
            yield from _forms(tree, class_, equation)
            yield from _sizes(tree, class_, equation, places)
        yield from _sources(tree, class_, equations)


def _places(flat: Mapping[str, Node]) -> _Places:
    # So that not the names of all variables are searched for each reference.
    return gather(
        (part["ident"], (variable, parts, place))
        for variable in flat.values()
        for parts in [(variable.get("component_ref") or {}).get("parts") or []]
        for place, part in enumerate(parts)
    )


def _forms(tree: Tree, class_: Class, equation: Node) -> Iterator[Finding]:
    for side in ("lhs", "rhs"):
        types = [element.type for element in tree.component_path(class_, equation[side])]
        if sum(type_ is not None and type_.kind in ("model", "block", "class") for type_ in types) > 1:
            yield (
                equation[side],
                f"connect uses {path_of(equation[side])}, a connector inside of two components; it must be a connector "
                "of this class or of a component of it (9.1)",
            )


def _sizes(tree: Tree, class_: Class, equation: Node, places: _Places) -> Iterator[Finding]:
    # rumoca connects the first elements of two arrays of different sizes and leaves the others open.
    sides = [equation["lhs"], equation["rhs"]]
    paths = [tree.component_path(class_, side) for side in sides]
    if not all(paths) or any(part["subs"] for side in sides for part in side["parts"]):
        return
    if not any(element.rank for path in paths for element in path):
        return
    counts = [_count(tree, class_, side, places) for side in sides]
    for prefix_ in counts[0].keys() & counts[1].keys():
        shapes = [counts[i][prefix_] for i in (0, 1)]
        if shapes[0] != shapes[1]:
            yield (
                equation["lhs"],
                f"connect has {' x '.join(map(str, shapes[0]))} elements of {path_of(sides[0])} and "
                f"{' x '.join(map(str, shapes[1]))} of {path_of(sides[1])}; the sizes must agree (9.3)",
            )
            return


def _count(
    tree: Tree, class_: Class, reference: Node, places: _Places
) -> dict[tuple[tuple[str, str], ...], tuple[int, ...]]:
    # Instance of the class → sizes of the array of connectors in it: the largest subscripts of its variables.
    names = [part["ident"]["text"] for part in reference["parts"]]
    family = {class_.name, *(b.name for b in tree.bases(class_))}
    family |= {c.name for c in tree.every if class_ in tree.bases(c)}
    found: dict[tuple[tuple[str, str], ...], tuple[int, ...]] = {}
    for variable, parts, start in places.get(names[0], []):
        selected = parts[start : start + len(names)]
        if [part["ident"] for part in selected] != names:
            continue
        owner = tree.component_of_id.get(parts[start]["def_id"])
        if owner is None or owner[0].name not in family:
            continue
        subscripts = [_subscript(s) for part in selected for s in part["subs"]]
        if None in subscripts:
            continue
        at_end = start + len(names) == len(parts)
        sizes = (*(s or 0 for s in subscripts), *(variable["dims"] if at_end else ()))
        key = tuple((p["ident"], str([_subscript(s) for s in p["subs"]])) for p in parts[:start])
        before = found.get(key, sizes)
        found[key] = tuple(map(max, before, sizes)) if len(before) == len(sizes) else sizes
    return found


def _subscript(subscript: Any) -> int | None:
    while isinstance(subscript, dict) and len(subscript) > 0:
        for key in ("Index", "Expr", "Expression", "Literal", "value", "Integer"):
            if key in subscript:
                subscript = subscript[key]
                break
        else:
            return None
    return subscript if isinstance(subscript, int) else None


def _sources(tree: Tree, class_: Class, equations: Sequence[Node]) -> Iterator[Finding]:
    # In each set of connected signals, one may be a source: an output inside, or an input of the class itself.
    sets: list[set[_Signal]] = []
    place: dict[_Signal, Node] = {}
    for equation in equations:
        sides = [equation["lhs"], equation["rhs"]]
        if any(part["subs"] for side in sides for part in side["parts"]):
            continue
        joined = {signal: side for side in sides for signal in _signal_sources(tree, class_, side)}
        place |= joined
        touching = [s for s in sets if s & joined.keys()]
        sets = [s for s in sets if not s & joined.keys()] + [set(joined).union(*touching)]
    for connected in map(sorted, sets):
        names = (
            (signal, f"{connector}.{signal}".rstrip(".")) for connector, signal, is_source in connected if is_source
        )
        for sources in gather(names).values():
            if len(sources) > 1:
                first = place[connected[0]]
                yield first, f"connect joins two sources of a signal, {sources[0]} and {sources[1]} (9.3)"


_Signal = tuple[str, str, bool]
"""A connector, one of its signals, '' for itself, and whether this is a source."""


def _signal_sources(tree: Tree, class_: Class, reference: Node) -> Iterator[_Signal]:
    # The connector, and each of its signals that is a source.
    path = tree.component_path(class_, reference)
    if not path or any(element.node["condition"] is not None for element in path):
        return
    is_inside = any(e.type is not None and e.type.kind in ("model", "block", "class") for e in path[:-1])
    name, last = path_of(reference), path[-1]
    own = last.causality or _declared_causality(tree, last)
    signals = {"": own} if own else {}
    if last.type is not None:
        signals |= {n: e.causality for n, e in tree.elements(last.type).items() if not e.is_class}
    yield name, "", False
    for signal, causality in signals.items():
        if causality and causality == ("output" if is_inside else "input"):
            yield name, signal, True


def _declared_causality(tree: Tree, element: Element) -> str:
    # Of `connector RealInput = input Real`; its component is of a simple type.
    type_ = tree.by_id.get(element.node["type_def_id"] or -1)
    while type_ is not None:
        if prefix(type_.definition["causality"]):
            return prefix(type_.definition["causality"])
        clauses = type_.definition["extends"]
        type_ = tree.by_id.get(clauses[0]["base_def_id"]) if len(clauses) == 1 else None
    return ""
