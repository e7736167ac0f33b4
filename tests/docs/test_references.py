"""Sources name only files, modules, classes and variables that exist, in docstrings and comments, too."""

import ast
import re
from functools import cache
from pathlib import Path
from pkgutil import resolve_name

import pytest
from project_files import PACKAGES, ROOT, modules, project_files, trees
from test_docstrings import members

SUFFIXES = r"(?:py|c|h|toml|md|mo|json|svg|js|css)"
FILE = re.compile(rf"(?<![\w./*<{{-])(?:[\w-]+/)*[\w-]+\.{SUFFIXES}(?!\.?\w|[*(])")
DOTTED = re.compile(r"(?<![\w./`])`?(railgrip(?:\.\w+)+)")
MODELICA = re.compile(r"(?<![\w.])RailBraking(?:\.[A-Za-z]\w*)+")
QUOTED = re.compile(r"`([A-Za-z_]\w*(?:\.[A-Za-z_]\w*)*)(?:\(\))?`")
PROSE = re.compile(r'#[^\n]*|"{3}(?:[^\\]|\\.)*?"{3}', re.DOTALL)
"""A comment or a docstring of Python."""
GENERATED = {"friction.json", "model.c"}
"""Files written by commands, and those in FMUs."""
ENTRY_POINTS = {f"railgrip.{role}" for role in ("controllers", "estimators", "sensors", "plants")}
"""Entry point groups of other packages."""
EXAMPLE = re.compile(r"My|.*_\d$")
"""Names in a user's library, and names of array elements."""


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
        if name.endswith((".py", ".c", ".h", ".toml", ".mo", ".js", ".jinja")):
            text = path.read_text(encoding="utf-8")
            words.update(re.findall(r"\w+", PROSE.sub(" ", text) if name.endswith(".py") else text))
    return frozenset(words)


@cache
def exists(dotted: str) -> bool:
    """Return whether a module, class or attribute `railgrip.a.b.C` exists."""
    try:
        resolve_name(dotted)
    except (ImportError, AttributeError):
        return dotted in ENTRY_POINTS
    return True


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
    for _, tree in trees().values():
        for node in ast.walk(tree):
            if isinstance(node, ast.ClassDef):
                found.setdefault(node.name, set()).update(members(node), {"*"} if node.bases else ())
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


def test_references_in_the_sources_exist():
    """In docstrings and comments, and in code and messages as well; modules of tests have names of users' files."""
    in_c = [
        ROOT / name
        for name in project_files()
        if name.endswith((".c", ".h")) and name.startswith((*PACKAGES, "tests/"))
    ]
    wrong = [
        f"{path.relative_to(ROOT)}: {name}"
        for path in (*modules(), *in_c)
        for name in missing(path.read_text(encoding="utf-8"))
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
