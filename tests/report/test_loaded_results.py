"""Folders of results load as values of the Python interface, and as tables in files of other programs."""

import io
from functools import partial

import numpy as np
import pandas
import pytest
import xarray
from calls import assert_linear
from command_line import exit_code
from synthetic import COARSE, LIBRARY, of_scenario
from synthetic_runner import stop_with

import railgrip as rg
from railgrip.base.errors import InputError, RecordError
from railgrip.campaign.run import write_description
from railgrip.campaign.sweep import Result, Sweep, csv_of, load_results, write_table
from railgrip.report.index import write_report
from railgrip.report.results import read_results
from railgrip.report.stop import read_stop, write_stop
from railgrip.scenario.campaign import load_campaign
from railgrip.trace.recorder import FILE_NAME

CAMPAIGN = """
name = "axes"
scenarios = ["{library}/trapezoid.toml"]
sweep = {{ "start.speed" = ["80 km/h", "60 km/h"] }}
[axes.controller]
sbc = {{ controller.kind = "slip_two_state" }}
abc = {{ controller.kind = "adhesion_based" }}
[[exclude]]
controller = "abc"
"start.speed" = "60 km/h"
"""


@pytest.fixture(scope="module")
def stop(tmp_path_factory):
    folder = tmp_path_factory.mktemp("results") / "stop"
    write_stop(stop_with(), folder)
    return folder


def test_a_stop_loads_as_it_was_written(stop):
    loaded, record = rg.load(stop), read_stop(stop)
    assert isinstance(loaded, rg.Stop)
    assert loaded.scenario.digest() == record.digest
    assert repr(loaded.metrics) == repr(record.metrics)  # NaN is not equal to NaN
    frame, written = loaded.to_pandas(), xarray.open_dataset(stop / FILE_NAME)
    assert frame.index.name == "time"
    assert frame["speed"].to_numpy() == pytest.approx(written["speed"].values)
    assert frame["slip[2]"].to_numpy() == pytest.approx(written["slip"].values[:, 1])
    assert frame.attrs["units"]["speed"] == "m/s"


def test_a_campaign_loads_over_its_axes_without_excluded_stops(folder):
    loaded = rg.load(folder)
    assert isinstance(loaded, Sweep)
    frame = loaded.to_pandas()
    assert frame.index.names == ["scenario", "controller", "start.speed"]
    assert len(frame) == 3
    for stop in read_results(folder).stops:
        place = tuple(stop.variants[axis] for axis in frame.index.names)
        assert frame.loc[place, "distance"] == stop.metrics.distance
    grid = loaded.to_xarray()["distance"]
    assert np.isnan(grid.sel(scenario="trapezoid", controller="abc", **{"start.speed": "60 km/h"}))
    assert int(np.isfinite(grid).sum()) == 3


def test_a_sweep_is_indexed_by_its_parameter():
    results = tuple(Result("refused", "no train", None) for _ in range(2))
    frame = Sweep({"seed": (3, 5)}, results).to_pandas()
    assert frame.index.name == "seed"
    assert frame.loc[5, "outcome"] == "refused"
    tables = Sweep({"demand": ({"pressure": 1}, {"pressure": 2})}, results).to_pandas()
    assert tables.index.tolist() == ['{"pressure": 1}', '{"pressure": 2}']
    assert len(Sweep({}, results[:1]).to_pandas()) == 1


def test_a_table_is_printed_and_written_with_units(folder, stop, capfd, tmp_path):
    def run(*arguments):
        assert exit_code("table", *arguments) == 0
        return capfd.readouterr().out

    printed = pandas.read_csv(io.StringIO(run(folder)))
    assert printed["distance [m]"].tolist() == pytest.approx(rg.load(folder).to_pandas()["distance"].tolist())
    assert printed["controller"].tolist() == ["sbc", "sbc", "abc"]
    for name, read in (("stop.csv", pandas.read_csv), ("stop.parquet", pandas.read_parquet)):
        run(stop, "--out", tmp_path / name)
        written = read(tmp_path / name)
        assert written["time [s]"].to_numpy() == pytest.approx(rg.load(stop).trace["time"].values)
        assert written["wheelset_speed[1] [rad/s]"].notna().all()


def test_an_axis_with_the_name_of_a_metric_is_allowed_in_a_table(tmp_path):
    metrics = stop_with().metrics
    frame = Sweep({"distance": ("near", "far")}, (Result("standstill", "", metrics),) * 2).to_pandas()
    assert csv_of(frame).startswith("distance (axis),outcome")
    write_table(frame, tmp_path / "x.parquet")
    assert pandas.read_parquet(tmp_path / "x.parquet")["distance (axis)"].tolist() == ["near", "far"]


def test_a_path_without_result_or_table_is_refused(tmp_path, stop):
    with pytest.raises(RecordError, match=r"has neither campaign\.json nor stop\.json"):
        rg.load(tmp_path / "nothing")
    with pytest.raises(InputError, match=r"x\.xlsx: a table is written as \.csv or \.parquet"):
        write_table(rg.load(stop).to_pandas(), tmp_path / "x.xlsx")
    write_stop(stop_with(), tmp_path / "bare", keep_trace=False)
    with pytest.raises(RecordError, match="the samples of this stop were not kept"):
        load_results(tmp_path / "bare")


@pytest.fixture(scope="module")
def many(tmp_path_factory):
    """Folders of 12, 18 and 24 stops that differ by their seed."""
    folders, any_stop = [tmp_path_factory.mktemp("many") for _ in range(3)], stop_with()
    for count, folder in zip((12, 18, 24), folders, strict=True):
        text = f'name = "many"\nscenarios = ["{LIBRARY.as_posix()}/trapezoid.toml"]\nsweep.seed = {[*range(count)]}\n'
        (folder / "many.toml").write_text(text, encoding="utf-8")
        campaign = load_campaign(folder / "many.toml", COARSE)
        write_description(campaign, folder)
        for stop in campaign.stops:
            write_stop(of_scenario(any_stop, stop.scenario), folder / stop.name, keep_trace=False)
    return folders


USES = {
    "read": lambda folder: rg.load(folder).to_pandas(),
    "compare": lambda folder: rg.compare(folder, folder),
    "report": lambda folder: write_report(folder, panels="none"),
}


@pytest.mark.usefixtures("blank_figures")
@pytest.mark.parametrize("use", USES)
def test_a_further_stop_takes_as_many_calls_whatever_the_number_of_stops(many, use):
    """Thus 5,000 stops take a hundred times as long as 50."""
    USES[use](many[0])  # fills caches
    assert_linear(partial(USES[use], folder) for folder in many)
