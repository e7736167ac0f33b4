"""`railgrip study k_factors`: its files, its messages, and stops with the controller that can be interrupted."""

import json
import random

import pytest
from command_line import exit_code
from wrong import table

from railgrip.report.table import END
from railgrip.studies.k_factors.k_dry import LIBRARY

RARELY = [f"--set=failures.{part}.probability=1e-8" for part in ("isolated_unit", "stuck_valve")]
"""Failures of a sixth of the states, each of which takes a search for its worst draws."""

LITTLE = ["--set=estimate.samples=20", "--set=estimate.runs=2", "--set=speed_steps=[]", *RARELY]


def files(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir()}


@pytest.mark.usefixtures("few_rates")
def test_the_same_file_gives_the_same_bytes_except_for_seconds(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    page = tmp_path / "docs" / "k_factors.md"
    page.parent.mkdir()
    begin = "<!-- K: written by `railgrip study k_factors vt642 --write` -->"
    page.write_text(f"before\n{begin}\n{END}\nafter\n", encoding="utf-8")
    for name, options in (("first", []), ("again", ["--write"])):
        assert exit_code("study", "k_factors", "vt642", "--out", tmp_path / name, *options, *LITTLE) == 0
    written = page.read_text(encoding="utf-8")
    assert written.startswith("before\n")
    assert written.endswith("after\n")
    first, again = (files(tmp_path / name) for name in ("first", "again"))
    contents = [json.loads(folder_files.pop("k_factors.json")) for folder_files in (first, again)]
    assert all(content.pop("seconds")["quasi_static"] > 0 for content in contents)
    assert contents[0] == contents[1]
    # The page contains the time of writing.
    assert all("EBCL" in folder_files.pop("index.html").decode() for folder_files in (first, again))
    assert first == again
    assert set(first) == {"k_factors.png", ".railgrip.json"}
    assert [one["ebcl"] for one in contents[0]["k_dry"]] == 2 * list(range(10))
    assert all(one["low_of_rates"] <= one["low"] for one in contents[0]["k_dry"])
    assert all(one["high"] <= one["high_of_rates"] for one in contents[0]["k_dry"])
    assert all(one["low"] <= one["k"] <= one["high"] for one in contents[0]["k_dry"])
    assert "EBCL" in capsys.readouterr().out
    k = next(one["k"] for one in contents[0]["k_dry"] if one["ebcl"] == 3)
    assert f"| 3 | 0.001 | {k:.4f} " in written


@pytest.mark.usefixtures("in_process", "few_rates", "blank_figures")
def test_stops_in_the_loop_agree_with_the_quasi_static_brake(tmp_path):
    never_run = 15.0 + 1e-3 * random.SystemRandom().random()
    study = tmp_path / "short.toml"
    text = (LIBRARY / "vt642.toml").read_text(encoding="utf-8").replace("vt642_dry.toml", "stop.toml")
    study.write_text(text.replace('["40 km/h", "80 km/h"]', "[]").replace("samples = 1000", "samples = 40"), "utf-8")
    stop = (LIBRARY / "vt642_dry.toml").read_text(encoding="utf-8")
    (tmp_path / "stop.toml").write_text(stop.replace("120 km/h", f"{never_run} km/h"), "utf-8")
    command = ["study", "k_factors", study, "--loop", "--out", tmp_path / "out", "--set=estimate.runs=4", *RARELY]
    contents = []
    for _ in range(2):
        few = (f"--set=loop.{one}" for one in ("probability=0.1", "samples=20", "runs=2"))
        assert exit_code(*command, *few) == 0
        contents.append(json.loads((tmp_path / "out" / "k_factors.json").read_text(encoding="utf-8")))
    first, again = contents
    assert (first["seconds"].pop("new_stops"), again["seconds"].pop("new_stops")) == (40, 0)
    assert first["loop"] == again["loop"]
    assert first["loop"]["samples"] == 40
    # Two runs of 20 draws: an interval of some hundredths about the tenth percentile, which 4000 draws determine
    # better.
    assert first["loop"]["low"] <= first["loop"]["quasi_static"]["k"] <= first["loop"]["high"]
    assert first["loop"]["high"] - first["loop"]["low"] < 1.0
    assert abs(first["loop"]["k"] - first["loop"]["quasi_static"]["k"]) < 0.05


@pytest.mark.parametrize("row", table(__file__, "wrong_files.toml")["rows"], ids=str)
def test_a_wrong_file_is_reported_in_a_sentence(row, tmp_path, command):
    sentence, *changes = row
    refused = command("study", "k_factors", "vt642", "--out", tmp_path, *(f"--set={change}" for change in changes))
    assert (refused.code, sentence in refused.err) == (2, True), refused.err


def test_stops_require_their_table(tmp_path, command):
    study = tmp_path / "study.toml"
    text = (
        (LIBRARY / "vt642.toml").read_text(encoding="utf-8").replace("vt642_dry.toml", str(LIBRARY / "vt642_dry.toml"))
    )
    study.write_text(text.replace("[loop]\nprobability = 0.01\nruns = 4\nsamples = 50\n", ""), "utf-8")
    refused = command("study", "k_factors", study, "--loop", "--out", tmp_path / "out")
    assert (refused.code, "has no [loop]" in refused.err) == (2, True)
