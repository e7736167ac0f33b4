"""Version and date of the release agree wherever they are written."""

import re
import tomllib

import pytest
import yaml
from project_files import ROOT

from railgrip.base.programs import installation


def releases() -> list[tuple[str, str]]:
    """Version and date of each release in CHANGELOG.md, newest first."""
    text = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    return re.findall(r"^## (\d+\.\d+\.\d+) – (\d{4}-\d{2}-\d{2})$", text, re.MULTILINE)


def test_the_newest_release_of_the_changelog_is_the_version_of_the_project():
    """And that of the citation and of the Modelica library; tests/modelica/test_modelica_library.py has its package."""
    version, date = releases()[0]
    assert tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["version"] == version
    cited = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert (cited["version"], str(cited["date-released"])) == (version, date)
    notes = (ROOT / "modelica/RailBraking/UsersGuide/ReleaseNotes.mo").read_text(encoding="utf-8")
    assert re.findall(r"<h4>Version (\S+)</h4>", notes) == [version for version, _ in releases()]
    example = (ROOT / "docs/examples/SimpleTrain/package.mo").read_text(encoding="utf-8")
    assert f'uses(RailBraking(version="{version}"))' in example


def test_no_text_asks_for_extras_of_a_name_that_is_on_no_index():
    """`railgrip[parquet]` would be searched there; a clone, a wheel or the packages of the extra are at hand."""
    folders = ("harness", "fmus", "estimators", "controllers", "docs", ".github")
    files = [
        path for folder in folders for path in (ROOT / folder).rglob("*.*") if path.suffix in (".py", ".md", ".yml")
    ]
    texts = {path: path.read_text(encoding="utf-8") for path in (*files, ROOT / "README.md", ROOT / "Dockerfile")}
    assert len(texts) > 400
    assert not [
        path for path, text in texts.items() if re.search(r"install[^`\n]* '?railgrip(\[|'|`|\"|$)", text, re.MULTILINE)
    ]


@pytest.mark.parametrize(
    ("extra", "package"),
    [("compiler", "ziglang"), ("parquet", "pyarrow"), ("mf4", "asammdf"), ("cluster", "distributed")],
)
def test_a_message_installs_the_packages_of_an_extra(extra, package):
    assert re.fullmatch(rf"`python -m pip install '{package}[<>=][\w.,<>=]*'`", installation(extra))
