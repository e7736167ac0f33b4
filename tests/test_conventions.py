"""Conventions of the project that no linter checks; .importlinter checks imports between packages."""

import ast
import re
from collections import Counter

from project_files import ROOT, modules, trees


def test_all_errors_for_users_have_one_base_class():
    base = ROOT / "harness" / "base"
    roots = {base / "errors.py", base / "interrupted.py"}  # a signal is not an error
    assert not [
        f"{path}: {node.name}"
        for path, (_, tree) in trees().items()
        if path not in roots
        for node in ast.walk(tree)
        if isinstance(node, ast.ClassDef)
        and any(ast.unparse(base).endswith(("Error", "Exception")) for base in node.bases)
    ]


def test_types_of_arrays_are_defined_once():
    own = re.compile(r"^\w+ = NDArray\[np\.(float64|bool_|intp)\]", re.MULTILINE)
    defined = {path.relative_to(ROOT).as_posix() for path in modules() if own.search(path.read_text(encoding="utf-8"))}
    others = ", ".join(sorted(defined - {"harness/base/arrays.py"}))
    assert not others, f"{others}: import Vector, Matrix, Array, Indices or Mask from railgrip.base.arrays instead"


def test_modules_are_named_for_their_contents():
    assert not [path for path in modules() if {"core", "common", "utils"} & {path.stem, path.parent.name}]


def test_no_two_modules_of_tests_have_one_name():
    """Pytest imports them by their names alone; stale bytecode hides a clash until somebody clones again."""
    names = Counter(path.name for path in (ROOT / "tests").rglob("*.py") if path.name != "conftest.py")
    assert not [name for name, count in names.items() if count > 1]


def test_modules_of_tests_import_modules_that_exist():
    """Modules without a package are looked up in the folders of tests, so stale bytecode has no effect."""
    stems = {path.stem for path in (ROOT / "tests").rglob("*.py")}
    assert not [
        f"{path.relative_to(ROOT)}: {node.module}"
        for path in (ROOT / "tests").rglob("*.py")
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("test_") and node.module not in stems
    ]
