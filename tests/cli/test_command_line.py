"""Exit codes: 0 for a result, 2 for a wrong input, 3 for a failed run; always a sentence, never a traceback."""

import json
import os
import re
import shlex
import signal
from pathlib import Path

import pytest
import synthetic_runner
from one_process import one_process
from pages import figures_of
from test_signals import members
from waiting import LONGEST, until
from wrong import table

from railgrip.base.errors import RecordError
from railgrip.base.records import RECORD
from railgrip.campaign.run import find_result, input_versions, run
from railgrip.scenario.campaign import load_campaign


def rewrite(project, old, new):
    """Replace a text that pair.toml must contain."""
    path = project / "pair.toml"
    text = path.read_text(encoding="utf-8")
    assert old in text
    path.write_text(text.replace(old, new), encoding="utf-8")


def stops_in(folder):
    return sorted(path.parent.name for path in folder.glob("*/stop.json"))


@pytest.mark.usefixtures("blank_figures")
def test_each_scenario_has_a_separate_folder_and_pages_stay_with_their_stops(railgrip, project):
    faster = ("run", "wet.toml", "--set", "start.speed=100 km/h")
    assert railgrip("run", "wet.toml").code == 0
    (first,) = (project / "build/runs").iterdir()
    assert re.fullmatch(r"wet-[0-9a-f]{8}", first.name)
    assert railgrip("report", first).code == 0
    page = (first / "index.html").read_text(encoding="utf-8")
    assert railgrip(*faster).code == 0
    (second,) = {*(project / "build/runs").iterdir()} - {first}
    assert not (second / "index.html").exists()
    assert (first / "index.html").read_text(encoding="utf-8") == page


def test_a_folder_without_a_digest_leads_to_the_runs_of_that_name(railgrip, project):
    assert railgrip("run", "wet.toml").code == 0
    (folder,) = (project / "build/runs").iterdir()
    result = railgrip("report", "build/runs/wet")
    assert result.refuses(f"has neither campaign.json nor stop.json; there is {folder.relative_to(project)}")


@pytest.mark.usefixtures("in_process", "blank_figures")
def test_a_stop_is_not_written_into_the_folder_of_a_campaign(railgrip, project):
    assert railgrip("campaign", "pair.toml", "--out", "out").code == 0
    result = railgrip("run", "wet.toml", "--set", "description=break", "--out", "out/wet-sbc")
    assert result.refuses("out/wet-sbc: belongs to the campaign in ")
    with pytest.raises(RecordError, match="belongs to the campaign"):
        synthetic_runner.run_stop(load_campaign(project / "pair.toml").stops[0].scenario).write("out/wet-sbc")


WRONG = table(__file__, "tables.toml")["wrong_commands"]
"""Command and words of its refusal."""


@pytest.mark.parametrize(("words", "sentence"), WRONG, ids=[words for words, _ in WRONG])
def test_a_wrong_input_exits_2_with_a_sentence(railgrip, words, sentence):
    result = railgrip(*shlex.split(words))
    assert (result.code, result.out) == (2, "")
    assert sentence in result.err


@pytest.mark.parametrize(
    ("arguments", "place"),
    [
        ("run wet.toml", "out/stop.json"),
        ("run wet.toml", "out/trace.nc"),
        ("campaign pair.toml", "out/campaign.json"),
        ("campaign pair.toml", "out/index.html"),
        ("export wet.toml", "out"),
        ("run wet.toml", ""),
        ("campaign pair.toml", ""),
    ],
)
def test_an_unwritable_result_is_reported_before_anything_runs(railgrip, project, arguments, place):
    """A folder is in the place of a file, or a file in that of a folder."""
    if place:
        (project / place).mkdir(parents=True)
        out, sentence = "out", f"{place}: a file is to be written there, and it is a folder"
    else:
        (project / "taken").write_text("a file", encoding="utf-8")
        out = "taken/out"
        sentence = "taken/out: results cannot be written there: Not a directory; name another folder by --out"
    assert railgrip(*arguments.split(), "--set", "description=break", "--out", out).refuses(sentence)


def test_a_programming_error_is_not_caught(railgrip):
    with pytest.raises(RuntimeError, match="a mistake of the program"):
        railgrip("run", "wet.toml", "--set", "description=break")


@pytest.mark.usefixtures("blank_figures")
def test_an_interrupted_campaign_resumes(railgrip, project):
    with one_process():
        result = railgrip("campaign", "pair.toml", "--out", "out", "--panels", "abc")
    assert result.code == 0, result.err
    assert stops_in(project / "out") == ["wet-abc", "wet-sbc"]
    # 0.8 against 0.95 m/s²
    assert "−15.8 %" in result.out
    assert (project / "out" / "pair.md").exists()
    assert (project / "out" / "index.html").exists()

    first_file, other_file = (project / "out" / name / "stop.json" for name in ("wet-sbc", "wet-abc"))
    os.utime(first_file, (4e9, 4e9))  # the clock has been put back since
    before, content = first_file.stat().st_mtime_ns, other_file.read_bytes()
    traces = (project / "out" / "wet-abc" / "trace.nc").read_bytes()
    other_file.unlink()
    assert railgrip("campaign", "pair.toml", "--out", "out", "--panels", "abc").code == 0
    assert first_file.stat().st_mtime_ns == before
    # run again in another process: the same bytes
    assert other_file.read_bytes() == content
    assert (project / "out" / "wet-abc" / "trace.nc").read_bytes() == traces


@pytest.mark.usefixtures("in_process", "blank_figures")
def test_two_campaigns_in_one_command_have_separate_reports(railgrip, project):
    """The second campaign file requests no panels, so its two stops have no pages."""
    text = (project / "pair.toml").read_text(encoding="utf-8")
    (project / "other.toml").write_text('panels = "none"\n' + text.replace('"pair"', '"other"'), encoding="utf-8")
    result = railgrip("campaign", "pair.toml", "other.toml", "--out", "both")
    assert result.code == 0, result.err
    assert stops_in(project / "both" / "pair") == stops_in(project / "both" / "other") == ["wet-abc", "wet-sbc"]
    pages = [project / "both" / name / "index.html" for name in ("pair", "other")]
    assert [len(figures_of(page)) for page in pages] == [2, 2]
    assert [len(list(page.parent.glob("*/index.html"))) for page in pages] == [2, 0]
    assert len(re.findall(r"^ peak seeking.* −15\.8 %", result.out, re.MULTILINE)) == 2


def test_results_of_another_scenario_program_package_or_compiler_are_run_again(project, monkeypatch):
    stop = load_campaign(project / "pair.toml").stops[0]
    directory = project / "there"
    assert find_result(stop, directory) is None
    run(stop.scenario, directory, synthetic_runner.run_stop)
    assert find_result(load_campaign(project / "pair.toml", ["seed=3"]).stops[0], directory) is None
    packages = ("python", "casadi", "numpy", "fmpy", "scipy", "rumoca")
    others = [input_versions() | {name: "another"} for name in (*packages, "C compiler", "FMU compiler")]
    assert all(other.keys() == input_versions().keys() for other in others)
    for name, answers in {"input_versions": others, "sources_digest": ["0" * 64]}.items():
        for answer in answers:
            with monkeypatch.context() as patch:
                patch.setattr(f"railgrip.campaign.run.{name}", lambda *_, answer=answer: answer)
                assert find_result(stop, directory) is None
    assert find_result(stop, directory) is not None


def cut_in_half(path):
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])


def swap_a_sample(path):
    """Flip a bit; HDF5 does not notice."""
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 1
    path.write_bytes(content)


def shorten_the_distance(path):
    content = json.loads(path.read_text(encoding="utf-8"))
    content["metrics"]["distance"] -= 20.0
    path.write_text(json.dumps(content), encoding="utf-8")


@pytest.mark.usefixtures("in_process", "blank_figures")
@pytest.mark.parametrize(
    ("name", "damage", "sentence"),
    [
        ("trace.nc", cut_in_half, "trace.nc: is not the file that was written with its stop.json"),
        ("trace.nc", swap_a_sample, "trace.nc: is not the file that was written with its stop.json"),
        ("stop.json", shorten_the_distance, "stop.json: was changed after the stop had written it"),
        ("stop.json", cut_in_half, "stop.json: is not JSON"),
        ("trace.nc", Path.unlink, "trace.nc: there is no such trace"),
    ],
)
def test_a_damaged_result_is_reported_and_run_again(railgrip, project, name, damage, sentence):
    assert railgrip("campaign", "pair.toml", "--out", "out", "--panels", "none").code == 0
    path = project / "out" / "wet-sbc" / name
    whole, table = path.read_bytes(), (project / "out" / "pair.json").read_bytes()
    damage(path)
    again = railgrip("campaign", "pair.toml", "--out", "out", "--panels", "none")
    assert again.code == 0
    assert f"wet-sbc: is run again, for out/wet-sbc/{sentence}" in again.err
    assert "wet-abc" not in again.err
    assert path.read_bytes() == whole
    assert (project / "out" / "pair.json").read_bytes() == table
    assert "is run again" not in railgrip("campaign", "pair.toml", "--out", "out", "--panels", "none").err


def test_no_report_is_made_from_a_changed_result(railgrip, project):
    assert railgrip("run", "wet.toml", "--out", "out").code == 0
    shorten_the_distance(project / "out" / "stop.json")
    assert railgrip("report", "out").refuses("stop.json: was changed after the stop had written it")


@pytest.mark.usefixtures("blank_figures")
def test_another_stop_in_the_same_folder_removes_the_page_of_the_first(railgrip, project):
    """A refused stop leaves the earlier result unchanged: nothing is removed before a new result exists."""
    assert railgrip("run", "wet.toml", "--out", "out").code == 0
    assert railgrip("report", "out").code == 0
    assert sorted(path.name for path in (project / "out").iterdir()) == [
        RECORD, "index.html", "stop.json", "stop.png", "trace.nc",
    ]  # fmt: skip
    assert railgrip("run", "wet.toml", "--set", "controller.kind=full_brake", "--out", "out").code == 0
    assert sorted(path.name for path in (project / "out").iterdir()) == [RECORD, "stop.json", "trace.nc"]
    assert railgrip("report", "out").code == 0
    assert railgrip("run", "wet.toml", "--set", "description=refuse", "--out", "out").code == 2
    # Without a new result the earlier one stays.
    assert {path.name for path in (project / "out").iterdir()} >= {"index.html", "stop.json", "trace.nc"}


@pytest.mark.usefixtures("in_process", "blank_figures")
def test_pages_of_a_campaign_are_removed_only_when_it_has_new_results(railgrip, project):
    """The second run fails with a programming error, so no new page replaces the old one."""
    assert railgrip("campaign", "pair.toml", "--out", "out").code == 0
    pages = ["index.html", "pair.json", "pair.md", "figures"]
    assert all((project / "out" / name).exists() for name in pages)
    with pytest.raises(RuntimeError):
        railgrip("campaign", "pair.toml", "--set", "description=break", "--out", "out")
    assert all((project / "out" / name).exists() for name in pages)


@pytest.mark.usefixtures("in_process", "blank_figures")
def test_a_stop_and_two_campaigns_do_not_share_a_folder(railgrip, project):
    text = (project / "pair.toml").read_text(encoding="utf-8")
    (project / "other.toml").write_text(text.replace('"pair"', '"other"'), encoding="utf-8")
    assert railgrip("campaign", "pair.toml", "--out", "many", "--panels", "none").code == 0
    assert railgrip("run", "wet.toml", "--out", "one").code == 0
    before = {path: path.read_bytes() for path in project.rglob("*") if path.is_file()}
    for command, sentence in (
        (("run", "wet.toml", "--out", "many"), "many: holds the results of a campaign"),
        (("campaign", "other.toml", "--out", "many"), "many: holds campaign 'pair'; name another folder"),
        (("campaign", "pair.toml", "--out", "one"), "one: holds the result of a stop"),
    ):
        assert railgrip(*command).refuses(sentence)
    assert {path: path.read_bytes() for path in project.rglob("*") if path.is_file()} == before


EXPECTED = '\n[[expected]]\nmatch = {{ controller = "{}" }}\noutcome = "horizon"\n'


@pytest.mark.usefixtures("in_process", "blank_figures")
@pytest.mark.parametrize(("sliding", "expected", "code", "remarks"), table(__file__, "tables.toml")["exit_codes"])
def test_the_exit_code_of_each_run_says_whether_outcomes_are_as_expected(
    railgrip, project, sliding, expected, code, remarks
):
    """The second time nothing runs, and results, messages and exit code are the same."""
    text = (project / "pair.toml").read_text(encoding="utf-8")
    for variant, kind in (("sbc", "slip_two_state"), ("abc", "adhesion_based")):
        if variant in sliding:
            text = text.replace(f'kind = "{kind}"', f'kind = "{kind}"\ndescription = "slide"')
    text += "".join(map(EXPECTED.format, expected))
    (project / "pair.toml").write_text(text, encoding="utf-8")
    first, second, fresh = (
        railgrip("campaign", "pair.toml", "--out", "out", "--panels", "none", *more) for more in ((), (), ("--fresh",))
    )
    for result in (first, second, fresh):
        assert result.code == code
        complaints = sorted(line for line in result.err.splitlines() if "expected was" in line)
        assert len(complaints) == len(remarks)
        assert all(line.startswith(start) for line, start in zip(complaints, remarks, strict=True))


@pytest.mark.usefixtures("in_process", "blank_figures")
def test_a_refused_stop_does_not_prevent_the_others(railgrip, project):
    rewrite(project, 'kind = "slip_two_state"', 'kind = "slip_two_state"\ndescription = "refuse"')
    result = railgrip("campaign", "pair.toml", "--out", "out", "--panels", "abc")
    assert result.refuses("wet-sbc: wet: the plant has no brakes")
    assert stops_in(project / "out") == ["wet-abc"]
    assert "Not run: wet-sbc" in (project / "out" / "pair.md").read_text(encoding="utf-8")


def test_ctrl_c_keeps_finished_stops_and_leaves_no_partial_files(program, project):
    marker = project / "running"
    rewrite(project, 'kind = "adhesion_based"', f'kind = "adhesion_based"\ndescription = "wait {marker}"')
    process = program(project, "program.py", "campaign", "pair.toml", "--out", "out", "--panels", "abc")
    until(lambda: (marker.exists() and stops_in(project / "out") == ["wet-sbc"]) or process.poll() is not None)
    assert process.poll() is None, process.communicate()
    os.killpg(process.pid, signal.SIGINT)
    _, err = process.communicate(timeout=LONGEST)
    assert process.returncode == 130
    assert "Interrupted; what had finished is kept." in err
    assert "Traceback" not in err
    assert stops_in(project / "out") == ["wet-sbc"]
    assert list((project / "out").rglob("*.partial")) == []
    # Python's resource tracker ends shortly after its parent; a worker would sleep for an hour.
    until(lambda: not members(process.pid))
