"""The command line: 0 a result, 2 a wrong question, 3 a run that failed; always a sentence, never a traceback."""

import importlib
import json
import os
import signal
import time
import tomllib
from pathlib import Path

import pytest
import synthetic_runner

from railgrip.__main__ import main
from railgrip.campaign.one_stop import run
from railgrip.campaign.run import is_there
from railgrip.campaign.sources import sources_digest
from railgrip.scenario.campaign import load_campaign


def stops_in(folder):
    return sorted(path.parent.name for path in folder.glob("*/stop.json"))


def test_the_console_script_is_this_command_line():
    project = tomllib.loads((Path(__file__).parents[2] / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    module, _, function = project["scripts"]["railgrip"].partition(":")
    assert getattr(importlib.import_module(module), function) is main


def test_a_run_prints_its_distance_and_keeps_its_result(railgrip, project):
    result = railgrip("run", "wet.toml", "--set", "start.speed=36 km/h", "--out", "here")
    assert result.code == 0, result.err
    # 10 m/s at 0.95 m/s²
    assert "wet: standstill, 52.63 m in 10.53 s" in result.out
    content = json.loads((project / "here" / "stop.json").read_text(encoding="utf-8"))
    assert content["distance_m"] == pytest.approx(52.63, abs=0.01)
    assert (project / "here" / "trace.nc").exists()


def test_a_stop_that_ends_badly_is_kept_and_exits_3(railgrip, project):
    result = railgrip("run", "wet.toml", "--set", "description=slide", "--out", "here")
    assert result.code == 3
    assert "no braking distance, the stop ended with horizon: Still moving at 3 m/s." in result.err
    assert json.loads((project / "here" / "stop.json").read_text(encoding="utf-8"))["outcome"] == "horizon"


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (("run", "gone.toml"), "gone.toml: there is no such file"),
        (
            ("run", "wet.toml", "--set", "adhesion.levl=2"),
            "wet.toml: [adhesion] has no key 'levl'; did you mean 'level'?",
        ),
        (("run", "wet.toml", "--set", "start.speed=-1"), "wet.toml: [start] speed must be at least 0 m/s, got -1."),
        (("run", "wet.toml", "--set", "start.speed"), "--set start.speed: wanted is table.key=value"),
        (("run", "wet.toml", "--set", "description=refuse"), "wet: the plant has no brakes"),
        (("run", "pair.toml"), "pair.toml: is a file of the kind campaign; use `railgrip campaign pair.toml`"),
        (("run",), "Missing argument 'FILE.toml'"),
        (("fly",), "No such command 'fly'"),
        (("campaign", "wet.toml"), "wet.toml: is a file of the kind scenario; use `railgrip run wet.toml`"),
        (("campaign", "pair.toml", "--set", "seed=x"), "pair.toml, stop wet-sbc (wet.toml): seed is 'x'"),
        (("report", "nowhere"), "nowhere: has neither campaign.json nor stop.json"),
        (("regress", "--baselines", "nowhere"), "nowhere: there is no baseline file (*.toml) in it"),
        (("accept", "--reason", "Because.", "--baselines", "nowhere"), "nowhere: there is no baseline file"),
        (("accept",), "Missing option '--reason'"),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, tuple) else "",
)
def test_a_wrong_question_exits_2_with_a_sentence(railgrip, arguments, sentence):
    result = railgrip(*arguments)
    assert result.code == 2
    assert sentence in result.err
    assert "Traceback" not in result.err
    assert result.out == ""


@pytest.mark.parametrize("command", [("run", "wet.toml"), ("campaign", "pair.toml")], ids=" ".join)
def test_results_that_cannot_be_written_are_told_before_anything_runs(railgrip, project, command):
    (project / "taken").write_text("a file", encoding="utf-8")
    result = railgrip(*command, "--set", "description=break", "--out", "taken/out")
    assert result.code == 2
    assert "taken/out: results cannot be written there: Not a directory; name another folder by --out" in result.err


@pytest.mark.parametrize(
    ("command", "place"),
    [
        (("run", "wet.toml"), "stop.json"),
        (("run", "wet.toml"), "trace.nc"),
        (("campaign", "pair.toml"), "campaign.json"),
        (("campaign", "pair.toml"), "index.html"),
        (("export", "wet.toml"), ""),
    ],
    ids=lambda value: value if isinstance(value, str) else " ".join(value),
)
def test_a_folder_where_a_file_goes_is_found_before_anything_runs(railgrip, project, command, place):
    (project / "out" / place).mkdir(parents=True)
    result = railgrip(*command, "--set", "description=break", "--out", "out")
    assert result.code == 2
    assert f"{Path('out') / place}: a file is to be written there, and it is a folder" in result.err


def test_a_mistake_of_the_program_is_not_dressed_up(railgrip):
    with pytest.raises(RuntimeError, match="a mistake of the program"):
        railgrip("run", "wet.toml", "--set", "description=break")


def test_a_campaign_keeps_every_stop_prints_the_table_and_goes_on_where_it_was_left(railgrip, project):
    result = railgrip("campaign", "pair.toml", "--out", "out", "--panels", "abc")
    assert result.code == 0, result.err
    assert stops_in(project / "out") == ["wet-abc", "wet-sbc"]
    # 0.8 against 0.95 m/s²
    assert "−15.8 %" in result.out
    assert (project / "out" / "pair.md").exists()
    assert (project / "out" / "index.html").exists()

    first_file, other_file = (project / "out" / name / "stop.json" for name in ("wet-sbc", "wet-abc"))
    before, content = first_file.stat().st_mtime_ns, other_file.read_bytes()
    traces = (project / "out" / "wet-abc" / "trace.nc").read_bytes()
    other_file.unlink()
    assert railgrip("campaign", "pair.toml", "--out", "out", "--panels", "abc").code == 0
    assert first_file.stat().st_mtime_ns == before
    # run again in another process: the same bytes
    assert other_file.read_bytes() == content
    assert (project / "out" / "wet-abc" / "trace.nc").read_bytes() == traces


@pytest.mark.usefixtures("in_process")
def test_two_campaigns_in_one_command_have_a_report_each(railgrip, project):
    """The second says itself that it wants no panels: its page lacks those of its two stops."""
    text = (project / "pair.toml").read_text(encoding="utf-8")
    (project / "other.toml").write_text('panels = "none"\n' + text.replace('"pair"', '"other"'), encoding="utf-8")
    result = railgrip("campaign", "pair.toml", "other.toml", "--out", "both")
    assert result.code == 0, result.err
    assert stops_in(project / "both" / "pair") == stops_in(project / "both" / "other") == ["wet-abc", "wet-sbc"]
    pages = [(project / "both" / name / "index.html").read_text(encoding="utf-8") for name in ("pair", "other")]
    assert [page.count("data:image/png") for page in pages] == [4, 2]
    assert result.out.count("−15.8 %") == 2


def test_two_campaigns_of_one_name_are_refused(railgrip, project):
    result = railgrip("campaign", "pair.toml", "pair.toml")
    assert result.code == 2
    assert "two campaigns are named 'pair'" in result.err


def test_what_another_scenario_or_another_program_left_is_run_again(project):
    stop = load_campaign(project / "pair.toml").stops[0]
    directory = project / "there"
    assert not is_there(stop, directory)
    run(stop.scenario, directory, synthetic_runner.run_stop)
    assert is_there(stop, directory)
    assert not is_there(load_campaign(project / "pair.toml", ["seed=3"]).stops[0], directory)
    path = directory / "stop.json"
    path.write_text(path.read_text(encoding="utf-8").replace(sources_digest(), "0" * 64), encoding="utf-8")
    assert not is_there(stop, directory)


@pytest.mark.usefixtures("in_process")
def test_one_refused_stop_does_not_take_the_others_with_it(railgrip, project):
    text = (project / "pair.toml").read_text(encoding="utf-8")
    (project / "pair.toml").write_text(
        text.replace(
            'controller.kind = "slip_two_state"', 'controller.kind = "slip_two_state"\ndescription = "refuse"'
        ),
        encoding="utf-8",
    )
    result = railgrip("campaign", "pair.toml", "--out", "out", "--panels", "abc")
    assert result.code == 2
    assert "wet-sbc: wet: the plant has no brakes" in result.err
    assert stops_in(project / "out") == ["wet-abc"]
    assert "Not run: wet-sbc" in (project / "out" / "pair.md").read_text(encoding="utf-8")


def is_alive(group):
    try:
        os.killpg(group, 0)
    except ProcessLookupError:
        return False
    return True


def test_ctrl_c_leaves_what_had_finished_and_nothing_half_written(program, project):
    text = (project / "pair.toml").read_text(encoding="utf-8")
    marker = project / "running"
    (project / "pair.toml").write_text(
        text.replace(
            'controller.kind = "adhesion_based"', f'controller.kind = "adhesion_based"\ndescription = "wait {marker}"'
        ),
        encoding="utf-8",
    )
    process = program("campaign", "pair.toml", "--out", "out", "--panels", "abc")
    patience = time.monotonic() + 600  # against hanging for ever; the stop itself waits for the signal
    while not (marker.exists() and stops_in(project / "out") == ["wet-sbc"]):
        assert process.poll() is None, process.communicate()
        assert time.monotonic() < patience
        time.sleep(0.05)
    os.killpg(process.pid, signal.SIGINT)
    _, err = process.communicate(timeout=600)
    assert process.returncode == 130
    assert "Interrupted; what had finished is kept." in err
    assert "Traceback" not in err
    assert stops_in(project / "out") == ["wet-sbc"]
    assert list((project / "out").rglob("*.partial")) == []
    # Python's own resource tracker ends a moment after its parent; a worker would sleep for an hour.
    patience = time.monotonic() + 600
    while is_alive(process.pid):
        assert time.monotonic() < patience, "a worker was left behind"
        time.sleep(0.05)


@pytest.fixture
def baselines(project):
    (project / "baselines").mkdir()
    path = project / "baselines" / "pair.toml"
    path.write_text('campaign = "../pair.toml"\n', encoding="utf-8")
    return path


@pytest.mark.usefixtures("in_process")
def test_a_baseline_is_accepted_with_a_reason_kept_and_missed(railgrip, project, baselines):
    where = ("--baselines", "baselines", "--out", "out")
    new = railgrip("regress", *where)
    assert new.code == 3
    assert "2 of 2 stops did not keep to their baseline" in new.err
    assert railgrip("accept", "--reason", " ", *where).code == 2
    assert railgrip("accept", "--reason", "First figures.", *where).code == 0
    assert railgrip("regress", *where).code == 0
    text = baselines.read_text(encoding="utf-8")
    assert text.count('reason = "First figures."') == 2
    baselines.write_text(text.replace("distance = 2", "distance = 3"), encoding="utf-8")
    result = railgrip("regress", *where)
    assert result.code == 3
    assert "moved" in result.out
