"""Files and names that users name by mistake are refused with a sentence, before anything runs."""

from pathlib import Path

import pytest

from railgrip.base.errors import InputError, ScenarioError
from railgrip.studies.estimators.recordings import require_one_of_each_name
from railgrip.studies.type_test.entrants import Entrant, controller_digest, entrants_named


@pytest.mark.parametrize("arguments", [("run", "plain", "--out"), ("report",)])
def test_a_name_beyond_the_limit_of_the_system_is_refused(command, tmp_path, monkeypatch, arguments):
    monkeypatch.chdir(tmp_path)
    result = command(*arguments, 300 * "d")
    assert result.code == 2
    assert "longer than a name or path may be on this system; name a shorter one" in result.err
    assert "Traceback" not in result.err
    assert 100 * "d" not in result.err


@pytest.mark.skipif(not hasattr(Path, "symlink_to"), reason="needs links")
def test_a_link_to_itself_is_named_as_that(command, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("loop").symlink_to("loop")
    assert command("run", "plain", "--out", "loop").refuses("is a link that leads to itself")


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ('controller = "slip_two_state"', "got 'slip_two_state'"),
        ('[controller]\nkind = ["slip_two_state"]', r"got \['slip_two_state'\]"),
        ("[controller]\nkind = 3", "got 3"),
        ("[controller]\ntuning = 'x'", "got {'tuning': 'x'}"),
        ('estimator = 1\n[controller]\nkind = "slip_two_state"', "got 1"),
    ],
)
def test_a_controller_file_without_a_kind_in_text_is_refused(tmp_path, text, found):
    file = tmp_path / "c.toml"
    file.write_text(text)
    with pytest.raises(ScenarioError, match=rf"c\.toml: \[\w+\] is a table whose kind is a text, {found}"):
        entrants_named([str(file)], {})


def entrant(**controller: object) -> Entrant:
    return Entrant.model_validate({"description": "", "role": "entrant", "controller": controller})


@pytest.mark.skipif(not Path("/dev/zero").exists(), reason="needs the devices of POSIX")
def test_a_device_is_not_read_for_a_digest():
    """It never ends: the program took all memory of the machine."""
    with pytest.raises(ScenarioError, match=r"/dev/zero: is a pipe or a device"):
        controller_digest(entrant(kind="fmu", file="/dev/zero"))


@pytest.mark.parametrize("module", ["os", "math", "sys"])
def test_a_module_without_a_source_of_its_own_is_refused(module):
    with pytest.raises(ScenarioError, match=rf"the module {module} is part of Python or compiled|is not a class"):
        controller_digest(entrant(kind=f"{module}:system"))


def test_a_source_that_is_not_python_is_refused(tmp_path):
    (tmp_path / "mine.py").write_text("class C: (")
    with pytest.raises(ScenarioError, match=r"mine\.py: is not a module in Python"):
        controller_digest(entrant(kind="mine:C"), (tmp_path,))


@pytest.mark.parametrize(
    ("second", "sentence"),
    [
        ("b/est.py:E2", r"Python imports one module named 'est'; rename one of the files"),
        ("b/other.py:E1", r"would have the name of a/est\.py:E1 in the tables, E1"),
    ],
)
def test_estimators_that_cannot_be_told_apart_are_refused_before_any_recording(second, sentence):
    require_one_of_each_name(["a/est.py:E1", "a/est.py:E2", "a/est.py:E1", "interacting"])
    with pytest.raises(InputError, match=sentence):
        require_one_of_each_name(["a/est.py:E1", second])
