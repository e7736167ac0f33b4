"""Each wrong file of wrong_files.toml is refused with its sentence."""

import pytest
from wrong import table, words

from railgrip.base.errors import RailgripError
from railgrip.estimation.sources import recording_of_estimation
from railgrip.estimation.spec import LIBRARY, load_specification
from railgrip.fmus.recipe import read_recipes
from railgrip.report.baseline import load_baseline
from railgrip.scenario.campaign import load_campaign
from railgrip.studies.benefit.line import LIBRARY as LINES
from railgrip.studies.benefit.line import load_study_line

KINDS = {
    "campaign": (load_campaign, lambda _: 'name = "c"\nscenarios = ["plain"]\n'),
    "estimation": (
        lambda file: recording_of_estimation(load_specification(file)),
        lambda name: (LIBRARY / f"{name}.toml").read_text(encoding="utf-8"),
    ),
    "recipe": (
        read_recipes,
        lambda _: '[Ball]\nclass = "A.B"\ninterfaces = ["me"]\nsolver = "rodas3"\ntolerance = 1e-5\n',
    ),
    "baseline": (load_baseline, lambda _: ""),
    "line": (load_study_line, lambda _: (LINES / "line_leaves.toml").read_text(encoding="utf-8")),
}
"""Kind → the function that reads a file, and one that returns the text of a correct file of this name."""
FILES = table(__file__, "wrong_files.toml")
ROWS = [(kind, name, *row) for kind, names in FILES.items() for name, rows in names.items() for row in rows]


@pytest.mark.parametrize(("kind", "name", "sentence", "old", "new"), ROWS)
def test_a_wrong_file_is_refused_in_a_sentence(tmp_path, kind, name, sentence, old, new):
    read, correct = KINDS[kind]
    text = correct(name)
    assert old in text
    (tmp_path / "own.toml").write_text(text.replace(old, new) if old else text + new, encoding="utf-8")
    with pytest.raises(RailgripError, match=words(sentence)):
        read(tmp_path / "own.toml")
