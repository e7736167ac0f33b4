"""The table on the architecture page that follows quantities to the FMU, to a law and to a table of a study."""

import ast
import re

from project_files import ROOT
from test_references import PROSE

PAGE = ROOT / "docs" / "architecture.md"
FOLDERS = (ROOT, ROOT / "harness", ROOT / "harness/kernel")
KERNELS = (ROOT / "harness/kernel", ROOT / "harness/fmi/kernel")
MOST_NAMES, MOST_FILES, MOST_COPIES = 6, 14, 6
"""Largest numbers of a walk on the page, headers in C included.

Six names are those of the driver's demand, of which a stop has five: the plant has one of the last two.
"""
MORE_FOR_A_FILTER = 3
"""Files and copies that the walk through a filter has in addition: a filter is used without the loop, too."""
COMMENT = re.compile(r"/\*.*?\*/", re.DOTALL)


def walks():
    """Return for each row of the page its names, files and copies."""
    section = PAGE.read_text(encoding="utf-8").split("## Where a quantity goes")[1].split("\n## ")[0]
    rows = [line.strip("|").split("|") for line in section.splitlines() if line.startswith("| ")][1:]
    return [
        (
            re.findall(r"`(\w+)`", first),
            re.findall(r"`([\w/]+\.(?:py|c|h))`", files),
            re.findall(r"`(\w+)\.(\w+)`", copies),
        )
        for first, files, copies in rows
    ]


def path_of(name):
    return next(folder / name for folder in FOLDERS if (folder / name).is_file())


def words_in(path):
    """Return the words in the code of a file, without comments and docstrings; case is ignored."""
    prose = PROSE if path.suffix == ".py" else COMMENT
    return set(re.findall(r"[a-z0-9_]+", prose.sub(" ", path.read_text(encoding="utf-8")).lower()))


def test_each_file_has_the_quantity_in_its_code():
    """By one of its names, alone or in the name of a place such as READING_WHEELSET_SPEED, or by a field of a copy."""
    assert len(walks()) == 7
    for names, files, copies in walks():
        known = {*names, *(field for _, field in copies)}
        for file in files:
            words = words_in(path_of(file))
            assert any(word == name or name in word for word in words for name in known), f"{file}: none of {known}"


def test_a_quantity_passes_few_files_under_few_names():
    for names, files, copies in walks():
        more = MORE_FOR_A_FILTER * ("estimators/kernel/step.h" in files)
        assert len(set(files)) == len(files) <= MOST_FILES + more, names
        assert len(names) <= MOST_NAMES, names
        assert len(copies) <= MOST_COPIES + more, names


def declared(kind):
    """Return the names that a struct in C or a class in Python declares."""
    for folder in KERNELS:
        for header in folder.glob("*.h"):
            text = COMMENT.sub("", header.read_text(encoding="utf-8"))
            if match := re.search(rf"typedef struct {{([^}}]*)}} {kind};", text):
                return set(re.findall(r"\w+", match[1]))
    for path in (ROOT / "harness").rglob("*.py"):
        for node in ast.parse(path.read_text(encoding="utf-8")).body:
            if isinstance(node, ast.ClassDef) and node.name == kind:
                return {s.target.id for s in node.body if isinstance(s, ast.AnnAssign)}
    raise AssertionError(f"there is no {kind}")


def test_each_copy_is_a_declared_field():
    for names, _, copies in walks():
        assert copies, names
        for kind, field in copies:
            assert field in declared(kind), f"{kind} has no {field}"
