"""Any file is read or refused in a short sentence, and none of its names leads out of the intended folder."""

import json
from pathlib import Path

import pytest
from synthetic import TWO_PART_TRAIN

import railgrip.scenario
from railgrip.base.errors import ScenarioError
from railgrip.scenario.adhesion import profile_of
from railgrip.scenario.campaign import load_campaign
from railgrip.scenario.load import load

SCENARIOS = Path(railgrip.scenario.__file__).parent
TRAPEZOID = SCENARIOS / "library" / "trapezoid.toml"
TEXT = TRAPEZOID.read_text(encoding="utf-8")


def refusal(read, *arguments):
    with pytest.raises(ScenarioError) as found:
        read(*arguments)
    sentence = str(found.value)
    assert len(sentence) < 500, sentence
    return sentence


def test_the_content_of_a_file_that_is_not_toml_is_not_printed(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "secret.txt").write_text("password hunter2\nsecret,2\n", encoding="utf-8")
    path = tmp_path / "mine.toml"
    path.write_text(TEXT, encoding="utf-8")
    change = "adhesion={kind='table', polach='dry', file='secret.txt'}"
    sentence = refusal(load, path, [change])
    assert "secret.txt: has 1 columns" in sentence
    assert "hunter2" not in sentence
    (tmp_path / "secret.txt").write_text("time,mu0\nhunter2,3\n", encoding="utf-8")
    assert "hunter2" not in refusal(load, path, [change])
    (tmp_path / "secret.txt").write_bytes(b"\xff\x00hunter2\n")
    assert "hunter2" not in refusal(load, path, [change])


def test_a_file_of_another_kind_is_refused_with_its_command():
    """Here an estimation; tests/cli/test_command_line.py has scenarios and campaigns."""
    wagon = SCENARIOS.parent / "estimation" / "library" / "wagon.toml"
    assert refusal(load, wagon).endswith("use `railgrip estimate wagon.toml`")


@pytest.mark.parametrize("name", ["..", ".", "../../up", "-flag", "a" * 5000, ".hidden"])
def test_no_name_leads_out_of_the_folder_of_a_campaign(tmp_path, name):
    (tmp_path / "mine.toml").write_text(TEXT.replace('"trapezoid"', json.dumps(name), 1), encoding="utf-8")
    campaign = tmp_path / "campaign.toml"
    campaign.write_text('name = "c"\nscenarios = ["mine.toml"]\n', encoding="utf-8")
    sentence = refusal(load_campaign, campaign, ["name=ok"])
    assert "must begin with a letter or digit" in sentence
    refusal(load, tmp_path / "mine.toml")


def test_names_of_variants_stay_inside_the_folder(tmp_path):
    (tmp_path / "mine.toml").write_text(TEXT, encoding="utf-8")
    campaign = tmp_path / "campaign.toml"
    campaign.write_text(
        'name = "c"\nscenarios = ["mine.toml"]\n[axes.a."../../x"]\nseed = 3\n[axes.a.".."]\nseed = 4\n',
        encoding="utf-8",
    )
    names = [stop.name for stop in load_campaign(campaign).stops]
    assert [(Path("out") / name).resolve().parent for name in names] == [Path("out").resolve()] * 2


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        ("a = " + "[" * 5000 + "]" * 5000, "nested deeper than"),
        ("a." * 500 + "b = 1", "nested deeper than"),
        ("seed = " + "9" * 5000, "a number of thousands of digits"),
        ("# " + "x" * 5_000_000, "more than the 4 MB"),
    ],
)
def test_a_hostile_file_is_refused(tmp_path, content, sentence):
    path = tmp_path / "odd.toml"
    path.write_text(content, encoding="utf-8")
    assert sentence in refusal(load, path)


@pytest.mark.parametrize("path", ["x" * 5000, "d/" * 2500 + "x.toml", "a\0b"])
def test_an_impossible_path_is_reported_as_a_missing_file(path):
    refusal(load, Path(path))
    table = json.dumps(f"{path}.csv")
    refusal(load, TRAPEZOID, [f"adhesion={{kind='table', polach='dry', file={table}}}"])


@pytest.mark.parametrize(("name", "key"), [("random", "correlation=1e-6 s"), ("sine_sweep", "end_frequency=1 MHz")])
def test_a_rail_finer_than_the_samples_is_refused(name, key):
    scenario = load(SCENARIOS / "library" / f"{name}.toml", [f"adhesion.{key}"])
    assert "too fine for a rail that is looked at every 0.001 s" in refusal(profile_of, scenario, TWO_PART_TRAIN)
