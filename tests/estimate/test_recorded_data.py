"""Recordings from a user's file: formats, units, faults, and messages about invalid files."""

import tomllib
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any

import h5py
import numpy as np
import pandas as pd
import pint
import pytest
from data_table import data_table
from hypothesis import given
from hypothesis import strategies as st
from scipy.io import savemat
from wrong import table as table_of
from wrong import words

from railgrip.base.errors import EstimationError
from railgrip.base.units import unit
from railgrip.estimation.judgement import check_signals
from railgrip.recording.faults import Flag, find_repeats, spikes, summary
from railgrip.recording.read import FileRecording, input_on_grid, on_grid, read_recording
from railgrip.recording.samples import reading_of, unit_of
from railgrip.recording.table import Column, DataTable

UNITS = {"speed": "m/s", "wheelset_speed": "rad/s", "pad_force": "N", "disc_temperature": "K", "mu_b": "1"}
INPUTS, OUTPUTS = ["pad_force"], ["speed", "wheelset_speed", "disc_temperature"]
PERIOD = 0.01
COLUMNS = {
    "speed": {"column": "v", "unit": "km/h"},
    "wheelset_speed": {"column": "n", "unit": "rev/min"},
    "pad_force": {"column": "F", "unit": "kN"},
    "disc_temperature": {"column": "T", "unit": "degC"},
}
SPEED = COLUMNS["speed"]
LIMITED = {"speed": SPEED | {"range": ["0 km/h", "200 km/h"]}}
WRITTEN = {column["column"]: column["unit"] for column in COLUMNS.values()}


def stop() -> pd.DataFrame:
    """A stop of ten seconds as a logger writes it: milliseconds, km/h, rev/min, kN, degrees Celsius."""
    t = np.arange(1000) * PERIOD
    v = 20.0 - t + 0.01 * np.random.default_rng(5).standard_normal(t.size)
    return pd.DataFrame(
        {
            "t": 1e3 * t,
            "v": 3.6 * v,
            "n": v / 0.46 / (2 * np.pi) * 60.0,
            "F": np.where(t > 2.0, 20.0, 0.0),
            "T": 40.0 + 5.0 * t + 0.1 * np.sin(7.0 * t),
        }
    )


LOCKED = (
    {row: 340.0 * (300 - row) / 30 for row in range(270, 300)}
    | dict.fromkeys(range(300, 500), 0.0)
    | {row: 310.0 * (row - 499) / 30 for row in range(500, 530)}
)
"""Rows of a wheelset that locks in 0.3 s and rolls again, in rev/min: no wheelset stops within 10 ms."""


def table(columns: Mapping[str, Any] = MappingProxyType({}), **changes: Any) -> DataTable:
    """Return the map of a stop as `stop` writes it, with other columns, of which None leaves one out."""
    known = {name: column for name, column in (COLUMNS | columns).items() if column is not None}
    return data_table(known, **{"time": {"column": "t", "unit": "ms"}} | changes)


def recording_from(path: Path, **changes: Any) -> FileRecording:
    return read_recording(path, table(**changes), UNITS, INPUTS, OUTPUTS)


def csv(directory: Path, frame: pd.DataFrame) -> Path:
    path = directory / "run.csv"
    frame.to_csv(path, index=False)
    return path


def write_mf4(path: Path, frame: pd.DataFrame, units: dict[str, str]) -> None:
    """Write an MDF file; the first column is the time in milliseconds."""
    asammdf = pytest.importorskip("asammdf")
    time = frame.iloc[:, 0].to_numpy() / 1e3
    file = asammdf.MDF(version="4.10")
    for name, unit_of_channel in units.items():  # each in a separate group, the temperature sampled ten times slower
        every = 10 if name == "T" else 1
        samples = frame[name].to_numpy()[::every]
        file.append(asammdf.Signal(samples=samples, timestamps=time[::every], name=name, unit=unit_of_channel))
    file.save(path, overwrite=True)
    file.close()


def written(directory: Path, frame: pd.DataFrame, suffix: str, units: dict[str, str] = WRITTEN) -> Path:
    path = directory / f"run{suffix}"
    if suffix == ".csv":
        frame.to_csv(path, index=False)
    elif suffix == ".parquet":
        pytest.importorskip("pyarrow")
        frame.to_parquet(path)
    elif suffix == ".mat":
        savemat(path, {name: frame[name].to_numpy() for name in frame.columns})
    else:
        write_mf4(path, frame, units)
    return path


@pytest.mark.parametrize("suffix", [".csv", ".parquet", ".mat", ".mf4"])
def test_every_format_gives_the_signals_in_the_units_of_the_model(tmp_path, suffix):
    frame = stop()
    result = recording_from(written(tmp_path, frame, suffix))
    signals = result.recording
    assert not [flag for flag in result.flags if flag.signal != "disc_temperature"]
    # Text keeps 16 digits, MDF the time as double: the difference is rounding.
    np.testing.assert_allclose(reading_of(signals, "speed"), frame["v"] / 3.6, rtol=1e-9)
    np.testing.assert_allclose(reading_of(signals, "wheelset_speed"), frame["n"] * np.pi / 30.0, rtol=1e-9)
    np.testing.assert_allclose(reading_of(signals, "pad_force"), frame["F"] * 1e3, rtol=1e-9, atol=1e-6)
    celsius = reading_of(signals, "disc_temperature") - 273.15
    there = np.isfinite(celsius)
    np.testing.assert_allclose(celsius[there], frame["T"].to_numpy()[there], rtol=1e-9)
    assert there.sum() == (100 if suffix == ".mf4" else 1000)
    assert unit_of(signals, "speed") == "m/s"


def test_a_structure_of_a_mat_file_is_addressed_by_a_dot(tmp_path):
    frame = stop()
    path = tmp_path / "run.mat"
    savemat(path, {"log": {name: frame[name].to_numpy() for name in frame.columns}})
    columns = {signal: column | {"column": f"log.{column['column']}"} for signal, column in COLUMNS.items()}
    result = recording_from(path, columns=columns, time={"column": "log.t", "unit": "ms"})
    np.testing.assert_allclose(reading_of(result.recording, "speed"), frame["v"] / 3.6, rtol=1e-12)


@pytest.mark.parametrize(
    ("column", "values", "changes", "flag", "omitted"),
    [
        ("n", {500: 2000.0}, {}, ("wheelset_speed", "spike", 5.0, 1), range(500, 501)),
        ("v", dict.fromkeys(range(300, 500), 61.2), {}, ("speed", "frozen", 3.01, 199), range(301, 500)),
        ("n", LOCKED, {}, ("wheelset_speed", "zero", 3.0, 200), range(0)),
        ("n", dict.fromkeys(range(300, 500), 0.0), {}, ("wheelset_speed", "jump", 3.0, 200), range(300, 500)),
        ("v", dict.fromkeys(range(600, 610), 655.35), LIMITED, ("speed", "range", 6.0, 10), range(600, 610)),
        ("v", dict.fromkeys(range(200, 240), np.nan), {}, ("speed", "gap", 1.99, 0), range(200, 240)),
        ("v", {700: np.nan}, {}, None, range(700, 701)),
    ],
    ids=["spike", "frozen", "locked", "drop-out", "range", "gap", "short gap"],
)
def test_a_fault_is_flagged_and_its_samples_omitted(tmp_path, column, values, changes, flag, omitted):
    """The filter receives no invented number; a wheel that reads zero may be locked, so this reading is used."""
    frame = stop()
    for row, value in values.items():
        frame.loc[row, column] = value
    result = recording_from(csv(tmp_path, frame), columns=changes)
    flags = [(one.signal, one.kind, pytest.approx(one.begin), one.samples) for one in result.flags]
    assert flags == ([] if flag is None else [flag])
    signal = {"n": "wheelset_speed", "v": "speed"}[column]
    assert np.flatnonzero(np.isnan(reading_of(result.recording, signal))).tolist() == list(omitted)
    # The pad force steps from 0 to 20 kN at 2 s, and every sample is kept.
    np.testing.assert_allclose(reading_of(result.recording, "pad_force"), frame["F"] * 1e3)


def test_white_noise_alone_is_not_thinned():
    """A Gaussian has 1e-15 of its mass beyond 8σ; the estimated scale uses some of that margin."""
    noise = np.random.default_rng(1).standard_normal(20_000)
    time = 1e-2 * np.arange(noise.size)
    assert spikes(time, noise, 8.0).sum() == 0
    assert spikes(time, np.round(20.0 - 1e-3 * np.arange(20_000) + noise, 1), 8.0).sum() == 0


@pytest.fixture(scope="module")
def valves():
    """Time [s] and cylinder pressure [Pa] of a group whose valves open for 20 ms or longer, every millisecond.

    A first-order cylinder, filled with 80 ms from 6 bar and vented with 60 ms, so every sample is valid.
    """
    period, seed = 1e-3, np.random.default_rng(3)
    pressure, supply, course = 3.0e5, 6.0e5, []
    while len(course) < 20_000:
        for target, time_constant, pulse in (
            (0.0, 60e-3, seed.uniform(20e-3, 40e-3)),
            (None, 1.0, seed.uniform(0.05, 0.5)),
            (supply, 80e-3, seed.uniform(20e-3, 40e-3)),
            (None, 1.0, seed.uniform(0.05, 0.5)),
        ):
            for _ in range(round(pulse / period)):
                if target is not None:
                    pressure += period / time_constant * (target - pressure)
                course.append(pressure)
    return period * np.arange(len(course)), np.array(course)


@pytest.mark.parametrize("noise", [100.0, 1000.0], ids="{:g} Pa".format)
@pytest.mark.parametrize("every", [1, 2, 5, 10])
def test_spikes_are_found_and_valve_pulses_are_not(valves, every, noise):
    """No sample of a pulse is flagged, and every spike of 1 bar is."""
    seed = np.random.default_rng(every)
    time, pressure = valves[0][::every], valves[1][::every].copy()
    pressure += noise * seed.standard_normal(pressure.size)
    assert spikes(time, pressure, 8.0).sum() == 0
    # Spikes next to a pulse cannot be distinguished from it.
    course = valves[1][::every]
    resting = np.convolve(np.abs(np.gradient(course)) > 0.0, np.ones(9), mode="same") == 0.0
    outliers = np.flatnonzero(resting[:-1])[5::37]
    assert outliers.size > 10
    pressure[outliers] += seed.choice([-1e5, 1e5], outliers.size)
    np.testing.assert_array_equal(np.flatnonzero(spikes(time, pressure, 8.0)), outliers)


@pytest.mark.parametrize(("period", "length"), [(1e-3, 3), (5e-3, 3), (10e-3, 1)])
def test_a_spike_is_shorter_than_a_valve_pulse(period, length):
    time = period * np.arange(400)
    for samples in (length, length + 1):
        values = 3e5 + 50.0 * np.random.default_rng(7).standard_normal(time.size)
        values[200 : 200 + samples] -= 4e4
        expected = list(range(200, 200 + samples)) if samples == length else []
        assert np.flatnonzero(spikes(time, values, 8.0)).tolist() == expected


def test_spikes_two_samples_apart_are_found_and_the_ends_are_kept():
    time = 1e-2 * np.arange(300)
    values = np.random.default_rng(5).standard_normal(time.size)
    values[[0, 100, 102, 299]] += 1e3
    assert np.flatnonzero(spikes(time, values, 8.0)).tolist() == [100, 102]


def test_many_flags_are_summarised_by_time_or_samples():
    gaps = [Flag(signal="speed", kind="gap", begin=k, end=k + 0.5, samples=0) for k in range(7)]
    strikes = [Flag(signal="speed", kind="spike", begin=k, end=k, samples=1) for k in range(7)]
    sentences = summary([*gaps, *strikes])
    assert sentences[5] == "speed: 2 more like these (gap), 3.5 s in all."
    assert sentences[11] == "speed: 2 more like these (spike), 7 samples in all."


def test_a_short_gap_of_an_input_is_interpolated_and_a_long_one_refused(tmp_path):
    frame = stop()
    frame["F"] = 20.0 + frame["t"] / 1e3
    whole = frame["F"].to_numpy() * 1e3
    frame.loc[400:405, "F"] = np.nan
    result = recording_from(csv(tmp_path, frame))
    # A ramp equals its linear interpolation.
    np.testing.assert_allclose(reading_of(result.recording, "pad_force"), whole, rtol=1e-12)
    (flag,) = result.flags
    assert (flag.kind, flag.begin, flag.end) == ("bridged", pytest.approx(3.99), pytest.approx(4.06))
    frame.loc[400:450, "F"] = np.nan
    with pytest.raises(EstimationError, match=r"input pad_force \(column 'F'\) is missing from 4\.000 s for 0\.51 s"):
        recording_from(csv(tmp_path, frame))


def test_a_held_signal_is_new_only_when_it_changes(tmp_path):
    frame = stop()
    frame["v"] = frame["v"].to_numpy()[np.arange(1000) // 10 * 10]
    result = recording_from(csv(tmp_path, frame), columns={"speed": SPEED | {"holds": True}})
    new = np.flatnonzero(np.isfinite(reading_of(result.recording, "speed")))
    assert new.tolist() == list(range(0, 1000, 10))


def test_a_fast_signal_is_averaged_and_a_slow_one_keeps_its_samples():
    grid = np.arange(100) * 0.01
    fast = np.arange(-5, 1000) * 1e-3
    noise = np.random.default_rng(2).standard_normal(fast.size)
    means, flags = on_grid("x", fast, 3.0 * fast + noise, grid, 0.01)
    assert not flags
    # Means of ten samples: σ/√10; a deviation estimated from 100 means is accurate to 7 %, times three.
    assert np.std(means - 3.0 * grid) == pytest.approx(1.0 / np.sqrt(10.0), rel=0.22)
    slow = np.arange(0.0, 1.0, 0.05) + 0.002
    samples_on_grid, flags = on_grid("x", slow, slow, grid, 0.01)
    assert np.isfinite(samples_on_grid).sum() == 20
    assert [flag.kind for flag in flags] == ["timing"]
    bridged_samples, _ = input_on_grid("x", slow, slow, grid[1:90], 0.01, 0.1)
    np.testing.assert_allclose(bridged_samples, grid[1:90], atol=1e-12)


def test_constant_stretches_are_measured_in_seconds():
    time = np.arange(10) * 0.1
    values = np.array([0.0, 1.0, 1.0, 1.0, 1.0, 2.0, 3.0, 3.0, 4.0, 5.0])
    assert np.flatnonzero(find_repeats(time, values, 0.25)).tolist() == [1, 2, 3, 4]


def test_the_recipe_of_the_documentation_yields_no_negative_force(tmp_path):
    """A piston moves its pads once it overcomes its spring: below 0.5 bar the force is zero."""
    page = Path(__file__).parents[2] / "docs" / "how_to" / "recorded_data.md"
    (line,) = [line for line in page.read_text(encoding="utf-8").splitlines() if line.startswith("pad_force = ")]
    force = tomllib.loads(line)["pad_force"]
    frame = stop().assign(**{force["column"]: np.linspace(0.0, 3.8, 1000)})
    recording = recording_from(csv(tmp_path, frame), columns={"pad_force": force}).recording
    expected = np.maximum(8e3 * frame[force["column"]] - 4e3, 0.0)
    np.testing.assert_allclose(reading_of(recording, "pad_force"), expected, rtol=1e-12, atol=1e-9)
    assert check_signals(recording, ["pad_force"]) == []


PINT = pint.UnitRegistry()
FACTORS = [
    ("bar", "kN/bar", "N"), ("kPa", "cm**2", "N"), ("mbar", "kN/Pa", "N"), ("A", "N*m/A", "N*m"), ("mm", "kN/mm", "N"),
    ("km/h", "1/m", "1/s"), ("rpm", "m/rad", "m/s"), ("1", "km/h", "m/s"), ("t", "m/s**2", "N"),
    ("V", "percent/V", "1"), ("bar", "percent", "Pa"), ("K", "kJ/(kg*K)", "m**2/s**2"),
    ("bar", "", "Pa"),
]  # fmt: skip
"""Units of column, factor, if it has one, and signal."""
NUMBERS = st.floats(-1e6, 1e6).map(lambda number: round(number, 6))  # no product underflows


@given(st.sampled_from(FACTORS), NUMBERS, NUMBERS, NUMBERS)
def test_column_times_factor_plus_offset_equals_the_result_of_pint(units, reading, number, offset):
    column, factor, target = units
    entry = {"column": "x", "factor": f"{number!r} {factor}" if factor else number, "offset": offset}
    gain, shift = Column(**entry).conversion(unit(column), target)
    product = PINT.Quantity(reading, column) * PINT.Quantity(number, factor)
    size = PINT.Quantity(abs(product.magnitude) + abs(offset), product.units).to(target).magnitude
    expected = (product + PINT.Quantity(offset, product.units)).to(target).magnitude
    # A dozen roundings of 1.1e-16, relative to the larger of product and offset.
    assert gain * reading + shift == pytest.approx(expected, rel=0.0, abs=2e-15 * size)


@pytest.mark.parametrize(("sentence", "signal", "column"), table_of(__file__, "wrong_maps.toml")["rows"])
def test_an_invalid_map_is_refused(tmp_path, sentence, signal, column):
    with pytest.raises(EstimationError, match=words(sentence)):
        recording_from(csv(tmp_path, stop()), columns={signal: column or None})


def test_the_unit_of_the_header_is_used_and_must_agree_with_the_map(tmp_path):
    path = csv(tmp_path, stop().rename(columns={"v": "v [km/h]"}))
    speed = reading_of(recording_from(path, columns={"speed": {"column": "v [km/h]"}}).recording, "speed")
    assert speed[0] == pytest.approx(20.0, abs=0.05)
    with pytest.raises(EstimationError, match=r"its unit in the file is 'km/h', in the map 'm/s'; correct the map\.$"):
        recording_from(path, columns={"speed": {"column": "v [km/h]", "unit": "m/s"}})


def test_repeated_instants_are_flagged_and_decreasing_time_is_refused(tmp_path):
    frame = stop()
    frame.loc[100, "t"] = frame.loc[99, "t"]
    result = recording_from(csv(tmp_path, frame))
    assert [(flag.signal, flag.samples) for flag in result.flags if flag.kind == "time"] == [("time", 1)]
    frame.loc[400:, "t"] -= 500.0
    with pytest.raises(EstimationError, match=r"time goes backwards at sample 401 of \w+, from 3\.990000 s to 3\.500"):
        recording_from(csv(tmp_path, frame))


def test_a_cell_that_is_not_a_number_is_refused(tmp_path):
    frame = stop().astype({"v": object})
    frame.loc[41, "v"] = "71,2"
    with pytest.raises(
        EstimationError, match=r"column 'v' must have numbers, sample 42 of 1000 is '71,2'.*decimal sign"
    ):
        recording_from(csv(tmp_path, frame))


def test_missing_damaged_and_unknown_files_are_refused(tmp_path):
    (tmp_path / "run.xls").write_text("")
    with pytest.raises(EstimationError, match=r"'\.xls' is not a supported format"):
        recording_from(tmp_path / "run.xls")
    with pytest.raises(EstimationError, match="there is no such file"):
        recording_from(tmp_path / "run.csv")
    for suffix, what in ((".mat", "a MATLAB file"), (".mf4", "an MDF file"), (".parquet", "a parquet file")):
        (tmp_path / f"bad{suffix}").write_bytes(b"not at all" * 100)
        with pytest.raises(EstimationError, match=f"is not {what}"):
            recording_from(tmp_path / f"bad{suffix}")


def test_a_short_file_that_asks_for_much_memory_is_refused(tmp_path, monkeypatch):
    """Compressed, or of HDF5 with chunks that were never written; a file of random numbers of this size is read."""
    pytest.importorskip("pyarrow")
    monkeypatch.setattr("railgrip.recording.files.LARGEST_TABLE", 1 << 20)
    frame = pd.DataFrame(dict.fromkeys("tvnFT", np.zeros(100_000)))
    with h5py.File(tmp_path / "run.mat", "w") as file:
        file.create_dataset("v", shape=(300_000_000,), dtype="f4", chunks=(1000,))
    savemat(tmp_path / "old.mat", dict(frame.items()), do_compression=True)
    frame.to_parquet(tmp_path / "run.parquet")
    with pytest.importorskip("asammdf").MDF() as file:
        file.append(frame)
        file.save(tmp_path / "run.mf4", compression=2)
    for name in ("run.mat", "old.mat", "run.parquet", "run.mf4"):
        with pytest.raises(EstimationError, match=rf"^{name}: has \d+ bytes and asks for \d+ values, \d+ MiB"):
            recording_from(tmp_path / name)


@pytest.mark.filterwarnings("error::pytest.PytestUnraisableExceptionWarning")
def test_a_damaged_mdf_file_is_refused_without_a_traceback(tmp_path):
    """Truncated, or with a block of zeros or ones, at many places; a file that is still readable is accepted."""
    write_mf4(tmp_path / "whole.mf4", stop().iloc[:50], WRITTEN)
    whole = (tmp_path / "whole.mf4").read_bytes()
    path, refusals = tmp_path / "run.mf4", list[str]()
    damaged = [whole[:end] for end in range(0, len(whole), len(whole) // 20)]
    for at in range(0, len(whole) - 16, len(whole) // 30):
        damaged += [whole[:at] + block + whole[at + 16 :] for block in (bytes(16), b"\xff" * 16)]
    for content in damaged:
        path.write_bytes(content)
        try:
            recording_from(path)
        except EstimationError as refusal:
            refusals.append(str(refusal))
    assert len(refusals) > len(damaged) // 3
    assert [sentence for sentence in refusals if not sentence.startswith("run.mf4: ")] == []
