"""Results that release 0.1.0 wrote are read; `release_0_1_0` has stops at 25 km/h, as written by its own code."""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest
from synthetic import LIBRARY
from synthetic_runner import run_stop

import railgrip as rg
from railgrip.campaign.sweep import csv_of
from railgrip.report.distances import write_table
from railgrip.report.results import read_results
from railgrip.report.stop import read_stop, write_stop
from railgrip.scenario.load import load
from railgrip.trace.metrics import FIGURES, Metrics

RELEASE = Path(__file__).parent / "release_0_1_0"
LATER = {"flat_length", "adhesion_allowed", "adhesion_at_slide", "adhesion_peak", "adhesion_sd"}
"""Figures of a stop that the release did not have, besides the errors of readings."""


@pytest.fixture
def folder(tmp_path):
    return shutil.copytree(RELEASE, tmp_path / "small")


def stored(folder, controller):
    return json.loads((folder / f"trapezoid-slow-{controller}" / "stop.json").read_text(encoding="utf-8"))


@pytest.mark.parametrize("controller", ["full_brake", "slip_two_state", "adhesion_based"])
def test_figures_are_those_of_the_file_and_new_ones_are_missing(folder, controller):
    written, metrics = stored(folder, controller)["metrics"], read_stop(folder / f"trapezoid-slow-{controller}").metrics
    later = {name for name in FIGURES.keys() - written.keys() if not name.endswith("_error")}
    assert not later - LATER, f"add the new figures {sorted(later - LATER)} to LATER: release 0.1.0 did not have them"
    assert not LATER - later, f"{sorted(LATER - later)} are not figures any more: remove them from LATER"
    plain, removed = metrics.to_plain(), sorted(written.keys() - FIGURES.keys())
    assert not removed, (
        f"Metrics lacks {removed}, which results of release 0.1.0 have: keep these figures, or let "
        "Metrics.from_plain read the name of that release"
    )
    assert {name: plain[name] for name in written} == written, "figures are read with other values than the file has"
    for name in FIGURES.keys() - written.keys():
        value = getattr(metrics, name)
        assert value is None or np.isnan(value).all(), name
    assert len(metrics.adhesion_peak) == len(metrics.longest_lock)
    assert np.isnan(metrics.of_train("adhesion_peak"))


def test_tables_comparison_and_csv_have_empty_cells_for_them(folder):
    found = read_results(folder)
    assert found.missing == ()
    as_json, as_markdown = write_table(found, folder)
    rows = json.loads(as_json.read_text(encoding="utf-8"))["rows"]
    for row in rows:
        assert row["distance_m"] == stored(folder, row["stop"].rpartition("-")[2])["distance_m"]
        assert row["adhesion_peak"] is None
    assert "greatest adhesion" not in as_markdown.read_text(encoding="utf-8")
    frame = rg.load(folder).to_pandas()
    assert frame["adhesion_allowed"].isna().all()
    assert "adhesion_allowed" in csv_of(frame)
    present = run_stop(load(LIBRARY / "trapezoid.toml", ["start.speed=25 km/h", "periods.communication=10 ms"]))
    write_stop(present, folder / "present", keep_trace=False)
    compared = rg.compare(folder / "trapezoid-slow-full_brake", folder / "present")
    figures = {row["figure"]: row for row in compared.answer.rows}
    assert np.isnan(figures["adhesion_allowed"]["A"])
    assert figures["adhesion_allowed"]["B"] > 0


def test_a_figure_of_another_program_is_refused(folder):
    metrics = read_stop(folder / "trapezoid-slow-full_brake").metrics.to_plain()
    with pytest.raises(ValueError, match="comfort"):
        Metrics.from_plain(metrics | {"comfort": 1.0})
    with pytest.raises(ValueError, match="distance"):
        Metrics.from_plain(metrics | {"distance": "near"})
    with pytest.raises(ValueError, match="one value for each group"):
        Metrics.from_plain({"distance": 1.0})
