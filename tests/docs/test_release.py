"""Version and date of the release agree wherever they are written."""

import re
import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[2]


def releases() -> list[tuple[str, str]]:
    """Version and date of each release in CHANGELOG.md, newest first."""
    text = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    return re.findall(r"^## (\d+\.\d+\.\d+) – (\d{4}-\d{2}-\d{2})$", text, re.MULTILINE)


def cited(key: str) -> str:
    found = re.search(rf"^{key}: (\S+)$", (ROOT / "CITATION.cff").read_text(encoding="utf-8"), re.MULTILINE)
    return found[1].strip('"') if found else ""


def test_the_newest_release_of_the_changelog_is_the_version_of_the_project():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert releases()[0][0] == project["version"]


def test_the_citation_has_version_and_date_of_the_newest_release():
    assert (cited("version"), cited("date-released")) == releases()[0]


def test_the_modelica_library_has_the_version_of_the_project():
    package = (ROOT / "modelica/RailBraking/package.mo").read_text(encoding="utf-8")
    assert f'version="{releases()[0][0]}"' in package
