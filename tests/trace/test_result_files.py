"""Results are complete, exact and reproducible to the byte; foreign files are refused in a sentence."""

import json

import numpy as np
import pytest
import xarray
from synthetic import COARSE, LIBRARY, TWO_PART_TRAIN, of_scenario, stop_of, uniform_stop

from railgrip.base.errors import RecordError
from railgrip.base.files import replacing, write_text
from railgrip.base.units import unit
from railgrip.campaign.sweep import Result, Sweep
from railgrip.report.figures import signals_figure
from railgrip.report.signals import signals_plot
from railgrip.report.stop import read_stop, write_stop
from railgrip.scenario.load import load
from railgrip.scenario.outcome import Outcome
from railgrip.trace.recorder import Recorder, read_trace, require_stop, thin, write_trace
from railgrip.vehicle.signals import PLANT, PLANT_INPUTS

SCENARIO = load(LIBRARY / "trapezoid.toml", COARSE)


@pytest.fixture(scope="module")
def stop():
    return stop_of(SCENARIO)


def test_rows_of_the_loop_equal_the_trace():
    recorder = Recorder((*PLANT, *PLANT_INPUTS), TWO_PART_TRAIN, capacity=10)
    recorder.rows[:5] = np.nan
    recorder.rows[3, recorder.at["speed"]] = 12.5
    recorder.rows[3, recorder.columns["slip"]] = [0.1, 0.2, 0.3, 0.4]
    trace = recorder.trace(5, 0.001)
    assert trace.sizes == {"time": 5, "group": 4, "wheelset": 6}
    assert trace["time"].values[3] == 0.003
    assert trace["speed"].values[3] == 12.5
    assert trace["slip"].values[3].tolist() == [0.1, 0.2, 0.3, 0.4]
    assert np.isnan(trace["speed"].values[[0, 1, 2, 4]]).all()
    assert trace["slip"].attrs["units"] == "1"


def test_a_trace_file_reads_back_to_the_same_trace(tmp_path):
    trace = uniform_stop()
    write_trace(trace, tmp_path / "trace.nc")
    assert read_trace(tmp_path / "trace.nc").identical(trace)


def test_thinning_keeps_the_grid_and_the_last_sample():
    trace = thin(uniform_stop(period=0.01), 7)
    assert trace["time"].values[:3] == pytest.approx([0, 0.07, 0.14])
    assert trace["speed"].values[-1] == pytest.approx(0.0)


def test_the_trace_has_scenario_and_versions_as_cf_attributes(stop, tmp_path):
    """Read by xarray itself, as users without this package do."""
    write_stop(stop, tmp_path)
    with xarray.open_dataset(tmp_path / "trace.nc", engine="h5netcdf") as trace:
        assert trace.attrs["Conventions"] == "CF-1.11"
        assert trace.attrs["seed"] == SCENARIO.seed
        assert trace.attrs["scenario_digest"] == SCENARIO.digest()
        assert json.loads(trace.attrs["versions"]) == stop.versions
        assert "0" * 64 in json.loads(trace.attrs["fmus"])["Plant.fmu"]
        assert SCENARIO.name in trace.attrs["title"]
        assert "22.2222 m/s" in trace.attrs["question"]
        assert all(variable.attrs["long_name"] for variable in trace.variables.values())
        numbers = {"group", "wheelset", "group_of_wheelset", "car_of_wheelset"}
        assert {name for name, variable in trace.variables.items() if "units" not in variable.attrs} == numbers
        for variable in trace.variables.values():
            unit(variable.attrs.get("units", "1"))  # raises if it is not one
        assert trace["speed"].attrs["standard_name"] == "platform_speed_wrt_ground"
        assert trace["wheelset_position"].values.tolist() == list(TWO_PART_TRAIN.wheelset_position)
        assert trace["car_of_wheelset"].values.tolist() == [1, 1, 1, 2, 2, 2]


@pytest.mark.parametrize("outcome", Outcome)
def test_only_a_standstill_has_a_braking_distance(outcome, tmp_path):
    """However a stop ends, the distance travelled has a different name, so no table can confuse the two."""
    stop = stop_of(SCENARIO, outcome=outcome)
    travelled = (80 / 3.6) ** 2 / 2
    write_stop(stop, tmp_path, keep_trace=False)
    content, record = json.loads((tmp_path / "stop.json").read_text(encoding="utf-8")), read_stop(tmp_path)
    frame = Sweep({"seed": (1,)}, (Result(outcome.value, "", stop.metrics),)).to_pandas()
    assert content["metrics"]["distance_travelled"] == pytest.approx(travelled, rel=1e-6)
    assert record.metrics.distance_travelled == pytest.approx(travelled, rel=1e-6)
    assert frame["distance_travelled"].iloc[0] == pytest.approx(travelled, rel=1e-6)
    if outcome is Outcome.STANDSTILL:
        assert (
            content["distance_m"]
            == content["metrics"]["distance"]
            == record.braking_distance
            == frame["distance"].iloc[0]
        )
        assert record.braking_distance == stop.metrics.distance_travelled
    else:
        assert content["distance_m"] is content["metrics"]["distance"] is record.braking_distance is None
        assert np.isnan(stop.metrics.distance)
        assert np.isnan(frame["distance"].iloc[0])


def test_an_interrupted_write_leaves_no_partial_files(tmp_path):
    path = tmp_path / "stop.json"
    write_text(path, "before")

    def interrupted():
        with replacing(path) as partial:
            partial.write_text("half", encoding="utf-8")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert path.read_text(encoding="utf-8") == "before"
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("function", ["write_trace", "write_json"])
def test_an_interrupted_rewrite_leaves_the_earlier_result_or_none(stop, tmp_path, monkeypatch, function):
    """Before the new trace exists, the earlier stop is complete; afterwards its stop.json no longer matches."""
    other = of_scenario(stop, stop.scenario.model_copy(update={"seed": 7}))
    write_stop(stop, tmp_path)

    def interrupt(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(f"railgrip.report.stop.{function}", interrupt)
    with pytest.raises(KeyboardInterrupt):
        write_stop(other, tmp_path)
    assert read_stop(tmp_path).digest == stop.scenario.digest()
    if function == "write_trace":
        assert read_stop(tmp_path).trace.sizes["time"] > 1
    else:
        with pytest.raises(RecordError, match=r"not the file that was written with its stop\.json"):
            _ = read_stop(tmp_path).trace


@pytest.mark.parametrize(
    ("name", "content", "sentence"),
    [
        ("stop.json", None, "there is no such result"),
        ("stop.json", b"{", "is not JSON"),
        ("stop.json", b"[]", "a table in JSON is expected"),
        ("stop.json", b'{"outcome": "tired"}', "is not the result of a stop"),
        ("stop.json", b"\xff\xfe\x00", "is not JSON"),
    ],
)
def test_a_folder_without_a_stop_is_refused(tmp_path, name, content, sentence):
    if content is not None:
        (tmp_path / name).write_bytes(content)
    with pytest.raises(RecordError, match=sentence):
        read_stop(tmp_path)


@pytest.mark.parametrize("content", [None, b"", b"no hdf5 at all"])
def test_a_file_that_is_not_a_trace_is_refused(tmp_path, content):
    if content is not None:
        (tmp_path / "trace.nc").write_bytes(content)
    with pytest.raises(RecordError, match=r"trace\.nc: (there is no such trace|is not a NetCDF file)"):
        read_trace(tmp_path / "trace.nc")


def test_a_trace_whose_distance_is_a_dimension_is_refused(stop, tmp_path):
    """It is then a coordinate of the data set, of any length."""
    trace = stop.trace.drop_vars("distance").assign_coords(distance=[0.0, 1.0])
    with pytest.raises(RecordError, match="'distance' has the dimensions"):
        require_stop(tmp_path / "trace.nc", trace, groups=trace.sizes["group"])


def test_a_loaded_stop_is_written_with_all_samples_of_its_file(tmp_path):
    write_stop(stop_of(load(LIBRARY / "trapezoid.toml", [*COARSE, "periods.trace=50 ms"])), tmp_path / "first")
    read_stop(tmp_path / "first").write(tmp_path / "second")
    first, second = (read_stop(tmp_path / folder).trace for folder in ("first", "second"))
    assert second.identical(first)


def test_a_standard_deviation_without_its_estimate_is_refused(stop, tmp_path):
    trace = stop.trace.assign(estimate_adhesion_sd=stop.trace["adhesion"]).drop_vars(
        "estimate_adhesion", errors="ignore"
    )
    with pytest.raises(RecordError, match="'estimate_adhesion_sd' is a standard deviation of 'estimate_adhesion'"):
        require_stop(tmp_path / "trace.nc", trace, groups=trace.sizes["group"])


def test_a_stop_that_lacks_a_signal_is_drawn_or_refused(stop, tmp_path):
    """Each variable of the trace of a stop with estimates is removed in turn."""
    trace = thin(stop.trace.assign(demand=stop.trace["command"]), 100)
    require_stop(tmp_path / "trace.nc", trace, groups=trace.sizes["group"])
    trace = trace.isel(group=[0], wheelset=[0])  # each group adds a column of panels to all figures
    drawn = 0
    for name in map(str, trace.data_vars):
        less = trace.drop_vars(name)
        try:
            require_stop(tmp_path / "trace.nc", less, groups=trace.sizes["group"])
        except RecordError:
            continue
        signals_plot(less)
        signals_figure(less, stop.metrics, stop.heading)
        drawn += 1
    assert drawn > 10
