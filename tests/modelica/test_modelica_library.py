"""The library on disk follows its style: order, documentation, units, coverage."""

import re
from functools import cache
from itertools import combinations
from pathlib import Path

import pytest

LIBRARY = Path(__file__).parents[2] / "modelica" / "RailBraking"
FILES = sorted(LIBRARY.rglob("*.mo"))
EXPORTED = ("Plants", "Predictions", "FMUs")
"""Packages whose blocks become FMUs."""
KINDS = r"(?:partial\s+)?(?:model|block|function|record|package|connector|class)"


def identify(path: Path) -> str:
    return str(path.relative_to(LIBRARY))


@cache
def text(path: Path) -> str:
    return path.read_text(encoding="utf-8")


def code(path: Path) -> str:
    """The file without strings and comments."""
    return re.sub(r'"(?:[^"\\]|\\.)*"|//[^\n]*', "", text(path))


@pytest.mark.parametrize("path", FILES, ids=identify)
def test_format(path: Path) -> None:
    source = text(path)
    assert not source.startswith("\ufeff")
    assert "\t" not in source
    assert not re.search(r"[ \t]+$", source, re.MULTILINE), "trailing blanks"
    assert source.endswith("\n")
    assert not re.search(r"</?h[1-3]\b", source), "h1 to h3 belong to the tools"
    assert not re.search(r"\btodo\b|\bfixme\b|__\w+\(", source, re.IGNORECASE)
    assert max(map(len, source.splitlines())) <= 120


@pytest.mark.parametrize("path", FILES, ids=identify)
def test_one_class_named_for_its_file_with_a_description(path: Path) -> None:
    name = path.parent.name if path.name == "package.mo" else path.stem
    source = text(path)
    head = re.search(rf'^{KINDS}\s+{name}(?:\s*=[^"]*)?\s+"([A-Z][^"]*[^."])"', source, re.MULTILINE)
    assert head, "a class named for its file, with a description that begins with a capital and has no full stop"
    assert len(re.findall(rf"^{KINDS}\s+\w+", code(path), re.MULTILINE)) == 1


@pytest.mark.parametrize("path", [p for p in FILES if "connector" not in text(p)], ids=identify)
def test_documentation(path: Path) -> None:
    source = text(path)
    assert "Documentation(info=" in source
    kind = re.search(rf"^({KINDS})", source, re.MULTILINE)[1]
    packages = {"Contact", "Friction", "Pneumatics", "Components", "Tracks", "Vehicles", *EXPORTED}
    if path.parent.name in packages and path.name != "package.mo" and kind != "record":
        assert "<h4>Limitations</h4>" in source


@pytest.mark.parametrize("path", FILES, ids=identify)
def test_every_declaration_has_a_description(path: Path) -> None:
    prefixes = r"(?:final |constant |discrete |input |output |parameter )*"
    types = r"(?:Types\.\w+|Real|Boolean|Integer|Interfaces\.\w+)"
    declaration = rf"^  {prefixes}{types}\s+\w+[^;]*;"
    for found in re.findall(declaration, text(path), re.MULTILINE):
        assert '"' in found, f"no description: {found}"


@pytest.mark.parametrize("folder", sorted({p.parent for p in FILES}), ids=identify)
def test_package_order_is_complete(folder: Path) -> None:
    order = (folder / "package.order").read_text().split()
    assert len(order) == len(set(order))
    inside = {p.stem for p in folder.glob("*.mo")} - {"package"}
    inside |= {p.parent.name for p in folder.glob("*/package.mo")}
    here = set(re.findall(r"^  (?:type|constant [\w.]+) (\w+)", text(folder / "package.mo"), re.MULTILINE))
    assert set(order) == inside | here


def test_every_class_is_used_by_a_validation_or_an_example() -> None:
    """Used directly or through other used classes; connectors and the user's guide are exempt."""
    apart = {"UsersGuide", "Validation", "Examples"}
    classes = {p.stem: p for p in FILES if p.name != "package.mo" and p.parent.name not in apart}
    reached: set[str] = set()
    pending = [p for p in FILES if p.parent.name in {"Validation", "Examples"}]
    while pending:
        words = set(re.findall(r"\w+", code(pending.pop())))
        fresh = (words & classes.keys()) - reached
        reached |= fresh
        pending += [classes[name] for name in fresh]
    assert classes.keys() - reached == set()


def test_every_parameter_of_an_exported_block_has_a_value_and_every_input_a_start() -> None:
    exported = [p for p in FILES if p.parent.name in EXPORTED and p.name != "package.mo"]
    for path in [*exported, *(LIBRARY / "Vehicles").glob("Partial*.mo")]:
        public = text(path).partition("protected")[0]
        for found in re.findall(r"^  parameter [^;]*;", public, re.MULTILINE):
            assert re.search(r"\w(?:\[\w+\])?(?:\([^)]*\))?\s*=", found), found
        for found in re.findall(r"^  Interfaces\.RealInput [^;]*;", public, re.MULTILINE):
            assert "start=" in found, found
        if "Interfaces.Real" in public:
            assert "final unit" in public


def test_every_array_input_or_output_has_one_unit() -> None:
    """Another compiler assigns one unit to all elements of an array, and warns of equations that give it two."""
    for path in FILES:
        for found in re.findall(r"Interfaces\.Real(?:In|Out)put \w+\[[^;]*;", text(path)):
            assert "final unit=" in found, f"{path.name}: {found}"


def test_the_version_is_that_of_the_project() -> None:
    version = re.search(r'version="([^"]+)"', text(LIBRARY / "package.mo"))[1]
    pyproject = (LIBRARY.parents[1] / "pyproject.toml").read_text()
    assert f'\nversion = "{version}"\n' in pyproject


PICTURED = {"Contact", "Pneumatics", "Components", "Vehicles", "Examples"}
DRAWN = [path for path in FILES if path.parent.name in PICTURED and path.name != "package.mo"]
PART = re.compile(
    r"^  (?:(?:replaceable|parameter)\s+)*"
    rf"(?:Interfaces|Friction|Pneumatics|Components|Contact|Tracks|Vehicles|{'|'.join(EXPORTED)})"
    r"\.(?:\w+\.)*[A-Z]\w*\s+(\w+)[^;]*?;",
    re.MULTILINE,
)
EXTENT = re.compile(r"extent=\{\{(-?\d+), (-?\d+)\}, \{(-?\d+), (-?\d+)\}\}")


@pytest.mark.parametrize("path", DRAWN, ids=identify)
def test_a_class_has_an_icon_and_places_its_components(path: Path) -> None:
    """Components are inside the diagram and do not overlap."""
    source = text(path)
    assert "  extends Icons." in source or ("Icon(" in code(path) and "%name" in source)
    if not re.search(r"^(?:partial )?(?:model|block) ", source, re.MULTILINE):
        return
    edges = [int(x) for x in EXTENT.search(source, source.index("Diagram(")).groups()]
    declared = re.split(r"^(?:initial )?(?:equation|algorithm)$", code(path), flags=re.MULTILINE)[0]
    places = []
    for part in PART.finditer(declared):
        assert "Placement(" in part[0], f"{part[1]} has no place"
        places.append([int(x) for x in EXTENT.search(part[0]).groups()])
    for x1, y1, x2, y2 in places:
        assert edges[0] <= x1 < x2 <= edges[2]
        assert edges[1] <= y1 < y2 <= edges[3]
    for one, other in combinations(places, 2):
        apart = one[2] <= other[0] or other[2] <= one[0] or one[3] <= other[1] or other[3] <= one[1]
        assert apart, f"{one} covers {other}"
