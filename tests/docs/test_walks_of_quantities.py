"""The table on the architecture page that follows quantities from the scenario file to the FMU."""

import re
from pathlib import Path

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "architecture.md"
FOLDERS = (ROOT, ROOT / "harness", ROOT / "harness/kernel")
KERNELS = (ROOT / "harness/kernel", ROOT / "harness/fmi/kernel")
MOST_FILES = 10
MOST_COPIES = 4


def walks():
    """Return for each quantity its names, the files listed on the page, and its copies on each branch."""
    section = PAGE.read_text(encoding="utf-8").split("## Where a quantity goes")[1].split("\n## ")[0]
    found = []
    for line in [line for line in section.splitlines() if line.startswith("| ")][1:]:
        first, *others = line.strip("|").split("|")
        if first.strip():
            found.append((re.findall(r"`([\w.]+)`", first), [], []))
        found[-1][1].extend(re.findall(r"`([\w/]+\.(?:py|c|h|mo))`", "|".join(others)))
        found[-1][2].append(re.findall(r"`(\w+)\.(\w+)`", others[-1]))
    return found


def path_of(name):
    return next(folder / name for folder in FOLDERS if (folder / name).is_file())


def test_each_file_uses_a_name_of_its_quantity():
    assert [names[0] for names, *_ in walks()] == ["start.speed", "mu0", "demand", "wheelset_speed"]
    for names, files, _ in walks():
        assert len(names) <= 2
        for file in files:
            text = path_of(file).read_text(encoding="utf-8").lower()
            assert any(name in text for name in names), f"{file} has none of {names}"


def test_a_quantity_passes_few_files():
    for names, files, _ in walks():
        assert len(set(files)) == len(files) <= MOST_FILES, names


def fields_of(kind):
    """Return the text of the declaration of a struct in C or of a class in Python."""
    for folder in KERNELS:
        for header in folder.glob("*.h"):
            match = re.search(rf"typedef struct {{([^}}]*)}} {kind};", header.read_text(encoding="utf-8"))
            if match:
                return match[1]
    modules = (module.read_text(encoding="utf-8") for module in (ROOT / "harness").rglob("*.py"))
    return next(
        text.split(f"\nclass {kind}:")[1].split("\nclass ")[0] for text in modules if f"\nclass {kind}:" in text
    )


def test_a_quantity_is_copied_few_times():
    for names, _, branches in walks():
        assert any(branches), names
        for copies in branches:
            assert len(copies) <= MOST_COPIES, names
            for kind, field in copies:
                assert re.search(rf"\b{field}\b", fields_of(kind)), f"{kind} has no {field}"
