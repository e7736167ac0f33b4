"""Every result in README.md and docs/ is written by a command, between marks; other numbers name their source.

CONTRIBUTING.md, "Numbers in the documentation", describes both comments.
"""

import math
import re
from collections.abc import Iterator
from pathlib import Path

import pytest
from commands import tools
from project_files import ROOT
from study_pages import cells, pages, text_of
from typer.main import get_command
from wrong import table

from railgrip.cli.app import app
from railgrip.studies.study import study_named

STUDIES = list(pages(ROOT / "docs/studies").values())
"""Pages that a command writes as a whole, from their text cells and results."""
WRITTEN_BY_HAND = {ROOT / "README.md", *(ROOT / "docs").rglob("*.md")} - {path.with_suffix(".md") for path in STUDIES}
PAGES = [*sorted(WRITTEN_BY_HAND), *STUDIES]
WRITTEN = re.compile(r"<!-- [^>]*?: written by `(?P<command>[^`]+)` -->.*?<!-- end[^>]*-->", re.DOTALL)
CONSTANTS = re.compile(r"<!-- constants: (?P<source>.+?) -->", re.DOTALL)
NEITHER = re.compile(
    r"```.*?```|^    [^\n]*$|`[^`]*`|\]\([^)]*\)|<!--.*?-->"  # code, addresses, other comments
    # Versions, clauses, quantiles by their name.
    r"|\b(?:Python|FMI|FMUs?|SSP|EN|OpenModelica)\s+\d+(?:\.\d+)*(?:\s(?:to|or|and)\s\d+(?:\.\d+)*)*"
    r"|§ ?[\d.]+|\d+(?:\.\d+){2,}"
    r"|\d+ %(?= quantile| interval)",
    re.DOTALL | re.MULTILINE,
)
SCALES = {
    "%": 1e-2, "‰": 1e-3, "m": 1.0, "mm": 1e-3, "km": 1e3, "s": 1.0, "ms": 1e-3, "µs": 1e-6, "min": 60.0,
    "minutes": 60.0, "hours": 3600.0, "km/h": 1 / 3.6, "m/s": 1.0, "m/s²": 1.0, "bar": 1e5, "kN": 1e3, "kg": 1.0,
    "t": 1e3, "g/m": 1e-3, "kg/min": 1 / 60, "l": 1e-3, "l/min": 1e-3 / 60, "Hz": 1.0, "MJ": 1e6, "MB": 1e6,
    "GiB": 2.0**30, "m²": 1.0,
}  # fmt: skip
UNIT = "|".join(re.escape(unit) for unit in sorted(SCALES, key=len, reverse=True))
NUMBER = re.compile(
    rf"(?<![\w.])(?P<value>\d+(?:\.\d+)?)(?: ?(?P<unit>{UNIT})(?![\w/²])| of (?:the )?(?P<total>\d+))?(?![\w])"
)
STANDARD = re.compile(r"\b(?:19|20)\d\d\b|\b(?:EN|UIC|ISO|IEC|TSI|EBO|SUBSET)\b")


def results_in(text: str, known: str = "") -> Iterator[str]:
    """Yield numbers without a source that are decimals, have a unit, or count a part of a total.

    Args:
        text: Text of a page.
        known: Text whose numbers need no source.
    """
    for paragraph in re.split(r"\n\s*\n", NEITHER.sub(_keep_sources, WRITTEN.sub("", text))):
        source = CONSTANTS.search(paragraph)
        for number in NUMBER.finditer(CONSTANTS.sub("", paragraph)):
            is_result = number["unit"] or number["total"] or "." in number["value"]
            if not is_result or is_in(known, number):
                continue
            if source is None:
                yield f"{number.group()}: has no source"
            elif problem := problem_of(number, source["source"]):
                yield f"{number.group()}: {problem}"


def _keep_sources(found: re.Match[str]) -> str:
    return found.group() if found.group().startswith("<!-- constants:") else " "


def is_in(text: str, number: re.Match[str]) -> bool:
    """Return whether a text contains a number, as written or in SI units."""
    value = float(number["value"])
    candidates = (value, value * SCALES.get(number["unit"] or "", 1.0))
    return any(math.isclose(float(one), other, rel_tol=1e-3) for one in _TOKENS.findall(text) for other in candidates)


def problem_of(number: re.Match[str], source: str) -> str:
    """Return the error in the source of a number: a file must contain the number, a text must be a citation."""
    paths = [ROOT / word for word in source.split() if (ROOT / word).is_file()]
    if STANDARD.search(source) or any(is_in(path.read_text(encoding="utf-8"), number) for path in paths):
        return ""
    if paths:
        return f"is not in {source}"
    return f"'{source}' is neither a file nor a publication with its year nor a standard"


_TOKENS = re.compile(r"(?<![\w.])\d(?:_?\d)*(?:\.\d+)?(?:e[+-]?\d+)?")


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_every_result_is_written_by_a_command(page: Path):
    text = page.read_text(encoding="utf-8")
    if page.suffix == ".py":
        text = "\n\n".join(text_of(cell) for cell in cells(text) if cell.is_text)
    # The code of tutorials runs in a test, and their text repeats its numbers.
    known = "".join(re.findall(r"```.*?```", text, re.DOTALL)) if page.parent.name == "tutorials" else ""
    assert not list(results_in(text, known))


@pytest.mark.parametrize(("text", "count"), table(__file__, "tables.toml")["numbers"])
def test_results_are_found(text: str, count: int):
    assert len(list(results_in(text))) == count


def test_every_mark_names_a_command_that_exists():
    commands = {found["command"] for page in PAGES for found in WRITTEN.finditer(page.read_text(encoding="utf-8"))}
    targets = set(re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE))
    assert commands
    for command in commands:
        program, *words = command.split()
        if program == "make":
            assert words[0] in targets
        else:
            assert program == "railgrip" or [program, words[0]] == ["python", "tools"]
            assert "--write" in words
            if words[0] == "study":
                assert hasattr(study_named(words[1]), "write")
            else:
                group, name = (tools, words[1]) if program == "python" else (app, words[0])
                assert "write" in {option.name for option in get_command(group).get_command(None, name).params}
