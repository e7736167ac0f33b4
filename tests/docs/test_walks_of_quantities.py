"""The table of the architecture page that follows quantities from the scenario file to the FMU."""

import re
from pathlib import Path

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "architecture.md"
FOLDERS = (ROOT, ROOT / "harness", ROOT / "harness/simulate/loop/kernel")
MOST_FILES = 10


def walks():
    """Return the names of each quantity, and the files that the page names for it."""
    section = PAGE.read_text(encoding="utf-8").split("## Where a quantity goes")[1].split("\n## ")[0]
    found = []
    for line in [line for line in section.splitlines() if line.startswith("| ")][1:]:
        first, *others = line.strip("|").split("|")
        if first.strip():
            found.append((re.findall(r"`([\w.]+)`", first), []))
        found[-1][1].extend(re.findall(r"`([\w/]+\.(?:py|c|h|mo))`", "|".join(others)))
    return found


def path_of(name):
    return next(folder / name for folder in FOLDERS if (folder / name).is_file())


def test_each_file_uses_one_of_the_names_of_its_quantity():
    assert [names[0] for names, _ in walks()] == ["start.speed", "mu0", "demand", "wheelset_speed"]
    for names, files in walks():
        assert len(names) <= 2
        for file in files:
            text = path_of(file).read_text(encoding="utf-8").lower()
            assert any(name in text for name in names), f"{file} has none of {names}"


def test_a_quantity_passes_a_handful_of_files():
    for names, files in walks():
        assert len(set(files)) == len(files) <= MOST_FILES, names
