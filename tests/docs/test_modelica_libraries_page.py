"""The train of docs/how_to/modelica_libraries.md runs as printed, where the Modelica Standard Library is present."""

import re
from pathlib import Path

import pytest
from command_line import exit_code
from sybil import Sybil
from sybil.parsers.markdown import PythonCodeBlockParser

from railgrip.fmus.native.library import search_folders

PAGE = Path(__file__).parents[2] / "docs/how_to/modelica_libraries.md"


def has_standard_library() -> bool:
    return any(
        (folder / name).is_dir()
        for folder in search_folders()
        for name in ("Modelica", "Modelica 4.0.0", "Modelica 4.0.0+maint.om")
    )


@pytest.mark.skipif(not has_standard_library(), reason="the Modelica Standard Library is not in MODELICAPATH")
def test_the_train_of_the_page_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    text = PAGE.read_text(encoding="utf-8")
    (model,) = re.findall(r"```modelica\n(.*?)```", text, re.DOTALL)
    Path("CoupledCars.mo").write_text(model, encoding="utf-8")
    (command,) = re.findall(r"^railgrip (build .*)$", text, re.MULTILINE)
    assert exit_code(*command.split(), "--compiler", "native") == 0
    examples = list(Sybil(parsers=[PythonCodeBlockParser()]).parse(PAGE).examples())
    assert examples
    for example in examples:
        example.evaluate()
