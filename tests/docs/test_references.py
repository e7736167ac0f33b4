"""Docstrings and comments name only files, modules, classes and variables that exist."""

import ast
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest
from project_files import project_files

ROOT = Path(__file__).parents[2]
PACKAGES = ("harness", "controllers", "estimators", "fmus", "tools", "tests")
SUFFIXES = r"(?:py|c|h|toml|md|mo|json|svg|js|css)"
FILE = re.compile(rf"(?<![\w./*<{{-])(?:[\w-]+/)*[\w-]+\.{SUFFIXES}(?!\.?\w|[*(])")
DOTTED = re.compile(r"(?<![\w./`])`?(railgrip(?:\.\w+)+)")
MODELICA = re.compile(r"(?<![\w.])RailBraking(?:\.[A-Za-z]\w*)+")
QUOTED = re.compile(r"`([A-Za-z_]\w*(?:\.[A-Za-z_]\w*)*)(?:\(\))?`")
_STRING = r""""{3}(?:[^\\]|\\.)*?"{3}|'{3}(?:[^\\]|\\.)*?'{3}|"(?:[^"\\\n]|\\.)*"|'(?:[^'\\\n]|\\.)*'"""
COMMENT = re.compile(rf"#[^\n]*|{_STRING}", re.DOTALL)
"""A comment or a string of Python; Python's own tokenizer takes far longer."""
TOKEN = re.compile(rf"#[^\n]*|[rbfu]{{0,2}}(?:{_STRING})|[^\W\d]\w*", re.DOTALL | re.IGNORECASE)
"""A comment, a string or a name of Python."""
GENERATED = {
    "friction.json",
}  # fmt: skip
"""Files written by commands."""
ENTRY_POINTS = {f"railgrip.{role}" for role in ("controllers", "estimators", "sensors", "plants")}
"""Entry point groups of other packages."""
EXAMPLE = re.compile(r"My|.*_\d$")
"""Names in a user's library, and names of array elements."""


@cache
def sources() -> tuple[Path, ...]:
    return tuple(ROOT / name for name in project_files() if name.endswith(".py") and name.startswith(PACKAGES[:-1]))


@cache
def tree(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"))


def statements(node: ast.AST) -> Iterator[ast.AST]:
    """Yield the statements in a module or statement, at any depth; most nodes are parts of expressions."""
    for name in ("body", "orelse", "handlers", "finalbody", "cases"):
        for each in getattr(node, name, ()):
            yield each
            yield from statements(each)


def prose(path: Path) -> list[tuple[int, str]]:
    """Return the docstrings and comments of a file with their line numbers."""
    text = path.read_text(encoding="utf-8")
    if path.suffix != ".py":
        return [(text.count("\n", 0, c.start()) + 1, c[0]) for c in re.finditer(r"/\*.*?\*/", text, re.DOTALL)]
    found = [
        (text.count("\n", 0, token.start()) + 1, token[0])
        for token in COMMENT.finditer(text)
        if token[0].startswith("#")
    ]
    for node in statements(tree(path)):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str):
            found.append((node.lineno, node.value.value))
    return found


@cache
def endings() -> frozenset[str]:
    """Return the files by each ending of their paths: `loop/loop.py` is `harness/simulate/loop/loop.py`."""
    parts = [name.split("/") for name in project_files()]
    return frozenset("/".join(each[i:]) for each in parts for i in range(len(each)))


@cache
def identifiers() -> frozenset[str]:
    """Return all identifiers in the code of the sources, in any language."""
    words: set[str] = set()
    for name in project_files():
        path = ROOT / name
        if path in (Path(__file__), ROOT / "tests/left_out.toml"):  # with names that do not exist
            continue
        if name.endswith(".py"):
            for token in TOKEN.finditer(path.read_text(encoding="utf-8")):
                if not token[0].startswith(("#", '"""', 'r"""')):
                    words.update(re.findall(r"\w+", token[0]))
        elif name.endswith((".c", ".h", ".toml", ".mo", ".js", ".jinja")):
            words.update(re.findall(r"\w+", path.read_text(encoding="utf-8")))
    return frozenset(words)


def members(path: Path, names: list[str]) -> bool:
    """Return whether a module has the first name at top level, and each class the next name."""
    body: list[ast.stmt] = tree(path).body
    for name in names:
        found = [node for node in body if name in defined(node)]
        if not found:
            return False
        body = found[0].body if isinstance(found[0], ast.ClassDef) else []
        if not isinstance(found[0], ast.ClassDef):
            return name == names[-1]
    return True


def defined(node: ast.stmt) -> set[str]:
    if isinstance(node, ast.ClassDef | ast.FunctionDef):
        return {node.name}
    if isinstance(node, ast.Import | ast.ImportFrom):
        return {alias.asname or alias.name for alias in node.names}
    targets = node.targets if isinstance(node, ast.Assign) else [node.target] if isinstance(node, ast.AnnAssign) else []
    return {target.id for target in targets if isinstance(target, ast.Name)}


def exists(dotted: str) -> bool:
    """Return whether a module, class or attribute `railgrip.a.b.C` exists."""
    first, *rest = dotted.split(".")[1:]
    if dotted in ENTRY_POINTS or (not rest and members(ROOT / "harness" / "api.py", [first])):
        return True
    place = ROOT / first if first in PACKAGES[1:-2] else ROOT / "harness" / first
    while rest and (place / rest[0]).is_dir():
        place /= rest.pop(0)
    if rest and (place / f"{rest[0]}.py").is_file():
        return members(place / f"{rest[0]}.py", rest[1:])
    file = place.with_suffix(".py") if place.with_suffix(".py").is_file() else place / "__init__.py"
    return file.is_file() and members(file, rest)


def modelica_exists(name: str) -> bool:
    """Return whether a class of the Modelica library, or a component of a class, exists."""
    place, parts = ROOT / "modelica", name.split(".")
    while parts and (place / parts[0]).is_dir():
        place /= parts.pop(0)
    if not parts:
        return True
    texts = [
        file.read_text(encoding="utf-8") for file in (place / f"{parts[0]}.mo", place / "package.mo") if file.is_file()
    ]
    return any(re.search(rf"\b{part}\b", text) for text in texts for part in parts[-1:])


@cache
def classes() -> dict[str, set[str]]:
    """Return the classes of the sources with all names in their bodies; classes of equal name are merged."""
    found: dict[str, set[str]] = {}
    for path in sources():
        for node in statements(tree(path)):
            if isinstance(node, ast.ClassDef):
                inner = {each.name for each in node.body if isinstance(each, ast.FunctionDef)}
                inner |= {name for each in node.body for name in defined(each)}
                inner |= {
                    each.attr
                    for each in ast.walk(node)
                    if isinstance(each, ast.Attribute) and isinstance(each.value, ast.Name) and each.value.id == "self"
                }
                if node.bases:
                    inner.add("*")
                found.setdefault(node.name, set()).update(inner)
    return found


def missing(text: str) -> list[str]:
    """Return the references in a text that do not exist."""
    files = [name for name in FILE.findall(text) if "/" in name and not EXAMPLE.match(name)]
    wrong = [name for name in files if name not in endings() and name.rpartition("/")[2] not in GENERATED]
    wrong += [name for name in DOTTED.findall(text) if not exists(name)]
    wrong += [name for name in MODELICA.findall(text) if not modelica_exists(name)]
    for name in QUOTED.findall(text):
        owner, _, rest = name.partition(".")
        if owner in classes() and rest and "*" not in classes()[owner]:
            wrong += [name] if rest.partition(".")[0] not in classes()[owner] else []
        elif (
            not rest
            and not EXAMPLE.fullmatch(name)
            and ("_" in name.strip("_") or re.search(r"[a-z][A-Z]", name))
            and name not in identifiers()
        ):
            wrong.append(name)
    return wrong


def test_references_in_docstrings_and_comments_exist():
    in_c = [ROOT / name for name in project_files() if name.endswith((".c", ".h")) and name.startswith(PACKAGES)]
    wrong = [
        f"{path.relative_to(ROOT)}:{line}: {name}"
        for path in (*sources(), *in_c)
        for line, text in prose(path)
        for name in missing(text)
    ]
    assert not wrong, "\n".join(wrong)


INVALID = [
    "see kernel/cycel.c", "`railgrip.simulate.faults.Site`", "`Binding.translated`", "RailBraking.FMUs.Wagon",
    "railgrip.fmi.mapping.bound", "`no_name_that_exists`",
]  # fmt: skip
VALID = [
    "kernel/cycle.c", "`railgrip.simulate.faults.site.Site`", "`Binding.translate`", "RailBraking.Plants.Wagon",
    "`railgrip.simulate.user_parts`", "harness/fmi/mapping.py", "`did_you_mean`",
]  # fmt: skip


@pytest.mark.parametrize("text", [*INVALID, *VALID])
def test_an_invalid_reference_is_found_and_a_valid_one_accepted(text):
    assert bool(missing(text)) == (text in INVALID)


def test_defaults_are_written_as_users_write_them():
    """80/3.6, not 22.222222222222222: in the Modelica library, the scenarios and the templates."""
    files = [
        ROOT / name
        for name in project_files()
        if name.startswith(("modelica/", "harness/")) and name[-3:] in (".mo", "oml")
    ]
    assert len(files) > 100
    long = [
        f"{file.relative_to(ROOT)}: a long run of the digit {number}"
        for file in files
        for number in re.findall(r"\b\d*\.\d*?(?:(\d)\1{9,})\d?\b", file.read_text(encoding="utf-8"))
    ]
    assert not long, "\n".join(long)
