"""`railgrip maintain regress` and `accept` in the repository of a user; the commands that they print work."""

import json
import re
import shlex
from xml.etree import ElementTree

import pytest
from wrong import table

from railgrip.report.junit import junit_xml

pytestmark = pytest.mark.usefixtures("in_process", "blank_figures")


def follow(railgrip, text, before):
    """Run the command that a message proposes."""
    (line,) = re.findall(rf"{before}: railgrip (.*)$", text, re.MULTILINE)
    return railgrip(*shlex.split(line))


@pytest.mark.parametrize("file", ["stops.toml", "my train/stops.toml"])
def test_commands_lead_from_an_empty_folder_to_kept_distances(railgrip, project, monkeypatch, file):
    (project / "empty").mkdir()
    monkeypatch.chdir(project / "empty")
    assert railgrip("maintain", "regress").refuses("`railgrip new regression stops.toml`")
    begun = railgrip("new", "regression", file, "--workflow")
    new = follow(railgrip, begun.out, "continue with")
    assert (new.code, "stops.toml: 2 of 2 stops deviate" in new.err) == (3, True)
    assert re.search(r"  trapezoid-two_state: \d+\.\d\d m; it has no baseline$", new.err, re.MULTILINE)
    assert follow(railgrip, new.err, "If that is right").code == 0
    assert follow(railgrip, begun.out, "continue with").code == 0
    workflow = (project / "empty/.github/workflows/stops.yml").read_text(encoding="utf-8")
    assert follow(railgrip, workflow, "run").code == 0
    cases = ElementTree.parse("build/regress.xml").findall("testsuite/testcase")
    assert [case.find("failure") for case in cases] == [None, None]
    accepted = (project / "empty" / file).parent / "tests/baselines/stops.toml"
    assert accepted.read_text(encoding="utf-8").startswith("# Accepted distances of a campaign.")


@pytest.fixture
def where(railgrip, project):
    """Options of a baseline of pair.toml with accepted distances, in folders with blanks."""
    where = ("--baselines", "base lines", "--out", "my out")
    (project / "base lines").mkdir()
    (project / "base lines" / "pair.toml").write_text('campaign = "../pair.toml"\n', encoding="utf-8")
    assert railgrip("maintain", "regress", *where).code == 3
    assert railgrip("maintain", "accept", "--reason", " ", *where).code == 2
    assert railgrip("maintain", "accept", "--reason", "First figures.", *where).code == 0
    return where


def test_a_moved_distance_is_red_with_stop_metres_and_limits(railgrip, project, where):
    file = project / "base lines" / "pair.toml"
    text = file.read_text(encoding="utf-8")
    assert text.count('reason = "First figures."') == 2
    value = float(re.findall(r"^value = (.*)$", text, re.MULTILINE)[0])
    file.write_text(re.sub("^value = .*$", f"value = {value - 9}", text, count=1, flags=re.MULTILINE), encoding="utf-8")
    result = railgrip("maintain", "regress", *where, "--json", "--junit", "reports/regress.xml")
    assert result.code == 3
    (moved,) = (one for one in json.loads(result.out)["baselines"]["base lines/pair.toml"] if one["state"] == "moved")
    assert moved["change"] == pytest.approx(9, abs=0.01)
    assert moved["lowest"] < moved["accepted"] < moved["highest"] < moved["value"]
    numbers = (moved[name] for name in ("accepted", "value", "change", "lowest", "highest"))
    form = "wet-abc: {:.2f} m → {:.2f} m ({:+.2f} m); permitted is {:.2f} m to {:.2f} m"
    assert form.format(*numbers) == moved["sentence"]
    assert moved["sentence"] in result.err
    (failure,) = ElementTree.parse(project / "reports/regress.xml").findall("testsuite/testcase/failure")
    assert failure.get("message") == failure.text == moved["sentence"]
    assert follow(railgrip, result.err, "If that is right").code == 0
    assert json.loads(railgrip("maintain", "regress", *where, "--json").out)["accept"] is not None
    assert railgrip("maintain", "regress", *where).code == 0


@pytest.mark.parametrize(("change", "options", "sentence"), table(__file__, "tables.toml")["empty_comparisons"])
def test_a_comparison_of_nothing_is_an_error_and_never_a_green_report(
    railgrip, project, where, change, options, sentence
):
    file = project / "base lines" / "pair.toml"
    text = file.read_text(encoding="utf-8").partition("\n[accepted")[0]
    file.write_text(change if options else text + "\n" + change, encoding="utf-8")
    assert railgrip("maintain", "regress", *where, *options, "--junit", "regress.xml").refuses(sentence)
    assert ElementTree.parse(project / "regress.xml").find("testsuite/testcase/failure") is not None


def test_a_stop_that_fails_is_red_and_not_to_be_accepted(railgrip, project, where):
    """This holds for a stop without a baseline, too."""
    text = (project / "pair.toml").read_text(encoding="utf-8")
    new = '[axes.controller.new]\ncontroller.kind = "full_brake"\ndescription = "refuse"\n'
    (project / "pair.toml").write_text(text + new, encoding="utf-8")
    result = railgrip("maintain", "regress", *where, "--junit", "regress.xml")
    assert result.code == 3
    assert "wet-new: no result; it has no baseline" in result.err
    assert "If that is right" not in result.err
    (failure,) = ElementTree.parse(project / "regress.xml").findall("testsuite/testcase/failure")
    assert failure.text == "wet-new: no result; it has no baseline"


def test_acceptance_without_results_names_the_command_that_makes_them(railgrip, where):
    result = railgrip("maintain", "accept", "--reason", "R.", *where[:2], "--out", "nowhere")
    assert result.refuses("nowhere/pair: there are no results of pair.toml; run `railgrip maintain regress`")


@pytest.mark.parametrize(
    ("text", "read"),
    [
        ("a <b> & 'c' \"d\"", "a <b> & 'c' \"d\""),
        ("\x1b[31mred\x00", "#x1B[31mred#x00"),
        ("340,1 m → 350 m, Größe ≤ 1 😀", "340,1 m → 350 m, Größe ≤ 1 😀"),
        ("name\udcff.toml\ufffe", "name#xDCFF.toml#xFFFE"),
    ],
    ids=["markup", "control characters", "other scripts", "names that are not UTF-8"],
)
def test_any_text_is_well_formed_in_junit_xml(text, read):
    root = ElementTree.fromstring(junit_xml({text: {text: text, "kept": ""}}).encode())
    suite = root[0]
    assert (suite.get("name"), suite.get("tests"), suite.get("failures"), suite.get("errors")) == (read, "2", "1", "0")
    assert re.fullmatch(r"[\d-]{10}T[\d:]{8}\+00:00", suite.get("timestamp") or "")
    failed, kept = suite
    assert (failed.get("classname"), failed.get("name"), failed[0].get("message"), failed[0].text) == (read,) * 4
    assert (kept.tag, len(kept)) == ("testcase", 0)
