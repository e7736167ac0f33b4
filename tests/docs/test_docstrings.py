"""Docstrings name only arguments and attributes that exist."""

import ast
import re

from project_files import ROOT, trees

FUNCTION = ast.FunctionDef, ast.AsyncFunctionDef


def named(docstring, section):
    """Return the names that a section of a docstring describes, such as `Args`; several may share a description."""
    text = re.search(rf"^{section}:\n((?:    .*\n|\n)+)", f"{docstring}\n", re.MULTILINE)
    lines = re.findall(r"^    (\*{0,2}\w+(?:, [*\w…]+)*):", text[1], re.MULTILINE) if text else []
    return {name.strip("*") for line in lines for name in line.split(", ")} - {"…"}


def arguments(function):
    every = function.args
    whole = (*every.posonlyargs, *every.args, *every.kwonlyargs, every.vararg, every.kwarg)
    return {argument.arg for argument in whole if argument is not None}


def members(node):
    """Return the names of a class: fields, methods, classes, and attributes that its methods set."""
    found = {inner.name for inner in node.body if isinstance(inner, (*FUNCTION, ast.ClassDef))}
    for inner in ast.walk(node):
        if isinstance(inner, ast.Attribute) and isinstance(inner.value, ast.Name) and inner.value.id in ("self", "cls"):
            found.add(inner.attr)
    for statement in node.body:
        targets = statement.targets if isinstance(statement, ast.Assign) else [getattr(statement, "target", None)]
        found |= {inner.id for target in targets if target for inner in ast.walk(target) if isinstance(inner, ast.Name)}
    return found


def findings(tree, classes):
    for node in ast.walk(tree):
        if isinstance(node, FUNCTION):
            yield from ((node.name, name) for name in named(ast.get_docstring(node) or "", "Args") - arguments(node))
        if isinstance(node, ast.ClassDef):
            known, queue = set(), [node]
            while queue:
                one = queue.pop()
                known |= members(one) | {n for f in one.body if isinstance(f, FUNCTION) for n in arguments(f)}
                queue += [classes[base.id] for base in one.bases if isinstance(base, ast.Name) and base.id in classes]
            docstring = ast.get_docstring(node) or ""
            for section in ("Args", "Attributes"):
                yield from ((node.name, name) for name in named(docstring, section) - known)


def test_a_described_argument_or_attribute_exists():
    """If this fails, correct the name in the docstring, or remove its line."""
    parsed = trees()
    every = (node for _, tree in parsed.values() for node in ast.walk(tree))
    classes = {node.name: node for node in every if isinstance(node, ast.ClassDef)}
    wrong = [
        f"{path.relative_to(ROOT)}: {owner} has no '{name}'"
        for path, (_, tree) in parsed.items()
        for owner, name in findings(tree, classes)
    ]
    assert wrong == []


def test_a_name_that_does_not_exist_is_found():
    code = (
        'class Box:\n    """A box.\n\n    Attributes:\n        width, most: Sizes.\n    """\n'
        "    def __init__(self):\n        self.width = 1\n"
        '    def fill(self, share):\n        """Fill it.\n\n        Args:\n            part: Share.\n        """\n'
    )
    assert sorted(findings(ast.parse(code), {})) == [("Box", "most"), ("fill", "part")]
