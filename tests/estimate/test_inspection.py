"""The contents that `railgrip inspect` finds in a recording; the proposed estimation reads it."""

import json
import tomllib
from dataclasses import replace
from pathlib import Path

import jsonschema
import numpy as np
import pandas as pd
import pytest
from test_recorded_data import written as written_as
from typer.testing import CliRunner

import railgrip as rg
from railgrip.base.errors import EstimationError, InputError, ScenarioError
from railgrip.cli.app import app
from railgrip.estimation.inspection import Inspection, inspect_recording
from railgrip.estimation.sources import recording_for
from railgrip.estimation.spec import load_specification
from railgrip.recording.samples import reading_of

T = np.arange(1000) * 0.01
RNG = np.random.default_rng(1)
V = 30.0 - T + 1e-3 * RNG.standard_normal(T.size)
W = V / 0.46
FORCE = np.where(T > 2.0, 2e4, 0.0)


def rig(**columns: np.ndarray) -> pd.DataFrame:
    """Recording of a roller rig in German units, with additional columns."""
    recorded = {"Zeit [ms]": 1e3 * T, "Geschwindigkeit (km/h)": 3.6 * V, "Drehzahl [U/min]": W * 30 / np.pi}
    return pd.DataFrame(recorded | {"Kraft_kN": FORCE / 1e3} | columns)


def written(folder: Path, frame: pd.DataFrame, name: str = "run.csv") -> Path:
    path = folder / name
    frame.to_csv(path, index=False, sep=";", decimal=",", encoding="cp1252")
    return path


def read_by(inspection: Inspection, path: Path):
    """Return the recording in a file as read by the proposal."""
    file = path.with_suffix(".toml")
    file.write_text(inspection.proposal, encoding="utf-8")
    return recording_for(load_specification(file), path).recording


def test_columns_of_a_train_are_recognised_by_name_number_and_unit(tmp_path):
    """Wheelset speeds numbered from 0, accelerations in g; 1/min may mean radians, so the assumption is printed."""
    wheels = {f"n_{i} [1/min]": W + i for i in range(4)}
    cylinders = {f"BC{i} (bar)": FORCE / 1e4 + i for i in range(1, 5)}
    frame = pd.DataFrame(
        {"time_s": T, "v_gps_kmh": 3.6 * V, **wheels, **cylinders, "acc_x_1_g": V, "lat": T, "lon": T, "alt_m": T}
    )
    inspection = inspect_recording(written(tmp_path, frame.assign(driving=0)), Path("field"))
    expected = {f"wheelset_speed[{i + 1}]": f"n_{i} [1/min]" for i in range(4)}
    expected |= {f"cylinder_pressure[{i}]": f"BC{i} (bar)" for i in range(1, 5)}
    expected |= {"speed": "v_gps_kmh", "acceleration_along[1]": "acc_x_1_g", "driving": "driving"}
    assert inspection.signals == expected | {"latitude": "lat", "longitude": "lon", "height": "alt_m"}
    assert not inspection.unrecognised
    units = {finding.name: finding.unit for finding in inspection.findings}
    assert (units["v_gps_kmh"], units["acc_x_1_g"], units["n_0 [1/min]"]) == ("km/h", "g", "rev/min")
    assert inspection.proposal.count("revolutions are assumed") == 4


def test_brake_cylinder_pressures_are_recognised_and_commands_are_not(tmp_path):
    """bcp is the usual abbreviation of brake cylinder pressure; a command or an initial value is not a reading."""
    names = ["bcp_1 [bar]", "BCP_2_kPa", "axle3_bcp [bar]", "coach_bcp_4 [mbar]"]
    others = ["bcp_cmd_1 [bar]", "p_setpoint_2 [bar]", "v_init [m/s]"]
    frame = pd.DataFrame({"time_s": T} | {name: V + i for i, name in enumerate((*others, *names))})
    inspection = inspect_recording(written(tmp_path, frame), Path("stop"))
    assert inspection.signals == {f"cylinder_pressure[{i}]": name for i, name in enumerate(names, start=1)}


def test_a_proposal_runs_once_unrecognised_columns_are_filled_in(tmp_path):
    frame = rig().rename(columns={"Kraft_kN": "Kanal 7", "Geschwindigkeit (km/h)": "v"})
    path = written(tmp_path, frame)
    inspection = inspect_recording(path, Path("rig_own"))
    assert inspection.unrecognised == ("pad_force", "speed")
    with pytest.raises(EstimationError, match=r"run\.csv"):
        read_by(inspection, path)
    lines = [
        line.replace('column = "?", unit = "N"', 'column = "Kanal 7", unit = "kN"').replace('"?"', '"km/h"')
        for line in inspection.proposal.splitlines()
    ]
    recording = read_by(replace(inspection, proposal="\n".join(lines)), path)
    np.testing.assert_allclose(reading_of(recording, "pad_force"), FORCE, rtol=1e-9)
    np.testing.assert_allclose(reading_of(recording, "speed"), V, rtol=1e-9)


def test_sampling_gaps_and_ranges_are_found(tmp_path):
    frame = rig()
    frame.loc[300:349, "Drehzahl [U/min]"] = np.nan
    frame = frame.assign(empty=np.nan, words="x", once=[1.0, *[np.nan] * (len(frame) - 1)])
    inspection = inspect_recording(written(tmp_path, frame), Path("rig_own"))
    wheel = next(finding for finding in inspection.findings if finding.name.startswith("Drehzahl"))
    assert (wheel.samples, wheel.period) == (950, pytest.approx(0.01))
    assert (wheel.begin, wheel.end) == (0.0, pytest.approx(9.99))
    assert wheel.gaps == (pytest.approx((2.99, 0.51)),)
    assert sorted(inspection.texts) == ["empty", "once", "words"]
    numbers = frame["Drehzahl [U/min]"]
    assert (wheel.low, wheel.high) == pytest.approx((numbers.min(), numbers.max()))


@pytest.mark.parametrize(
    ("lost", "begin", "end"), [(range(300, 350), 0.0, 9.99), (range(100, 300), 3.0, 9.99), (range(700, 990), 0.0, 6.99)]
)
def test_a_proposal_bridges_short_gaps_of_inputs_and_cuts_at_long_ones(tmp_path, lost, begin, end):
    frame = rig()
    frame.loc[list(lost), "Kraft_kN"] = np.nan
    path = written(tmp_path, frame)
    time = read_by(inspect_recording(path, Path("rig_own")), path)["time"].values
    assert (time[0], time[-1]) == (pytest.approx(begin), pytest.approx(end))


@pytest.mark.parametrize("suffix", [".csv", ".parquet", ".mat", ".mf4"])
def test_a_proposal_reads_a_recording_in_any_format_unchanged(tmp_path, suffix):
    path = written(tmp_path, rig())
    if suffix != ".csv":
        names = {"Zeit [ms]": "time_ms", "Geschwindigkeit (km/h)": "v_kmh", "Drehzahl [U/min]": "n_rpm"}
        units = {"v_kmh": "km/h", "n_rpm": "rpm", "Kraft_kN": "kN"}
        path = written_as(tmp_path, rig().rename(columns=names), suffix, units)
    inspection = inspect_recording(path, Path("rig_own"))
    assert not inspection.unrecognised
    recording = read_by(inspection, path)
    # Text has 16 digits, and units are rounded once.
    for name, expected in (("speed", V), ("wheelset_speed", W), ("pad_force", FORCE)):
        np.testing.assert_allclose(reading_of(recording, name), expected, rtol=1e-9)


def test_a_file_without_time_requires_the_name_of_the_column(tmp_path):
    path = written(tmp_path, rig().rename(columns={"Zeit [ms]": "k"}))
    with pytest.raises(EstimationError, match="--time"):
        inspect_recording(path, Path("rig_own"))
    inspection = inspect_recording(path, Path("rig_own"), "k")
    assert 'time = { column = "k", unit = "s" }  #' in inspection.proposal
    with pytest.raises(EstimationError, match=r"run\.csv: has no column 'K'"):
        inspect_recording(path, Path("rig_own"), "K")


@pytest.mark.parametrize(
    ("name", "sentence"),
    [
        *((name, "") for name in ("lost.csv", "lost.mf4", "run.nc", "empty.csv")),
        ("words.csv", " has no column besides its time with two numbers at rising times; name another"),
        ("back.csv", " has no column besides its time with two numbers at rising times; name another"),
        ("twice.parquet", " there are 2 columns 'v'; rename them"),
    ],
)
def test_a_file_without_a_recording_is_refused_with_its_name(tmp_path, name, sentence):
    parquet, pa = pytest.importorskip("pyarrow.parquet"), pytest.importorskip("pyarrow")
    parquet.write_table(pa.Table.from_arrays([pa.array([0.0, 1.0])] * 3, ["t", "v", "v"]), tmp_path / "twice.parquet")
    (tmp_path / "back.csv").write_text("time [s],v\n2,20\n1,21\n", encoding="utf-8")
    (tmp_path / "run.nc").write_bytes(b"")
    (tmp_path / "empty.csv").write_bytes(b"")
    (tmp_path / "words.csv").write_text("time [s],v\n0,a\n1,b\n", encoding="utf-8")
    with pytest.raises(EstimationError, match=f"{name}:{sentence}"):
        inspect_recording(tmp_path / name, Path("rig_own"))


def test_a_channel_of_texts_in_an_mdf_file_is_named(tmp_path):
    asammdf = pytest.importorskip("asammdf")
    texts = {0: b"off", 1: b"on"}
    conversion = {
        f"{key}_{number}": value for number, text in texts.items() for key, value in (("val", number), ("text", text))
    }
    with asammdf.MDF() as file:
        for name, more in (("v", {}), ("mode", {"conversion": conversion})):
            file.append(asammdf.Signal(samples=np.arange(50) % 2, timestamps=np.arange(50) * 0.1, name=name, **more))
        file.save(tmp_path / "run.mf4")
    assert inspect_recording(tmp_path / "run.mf4", Path("rig_own")).texts == ("mode",)


def test_time_stamps_are_recognised(tmp_path):
    stamps = (pd.Timestamp("2024-05-01T12:00:00Z") + pd.to_timedelta(T, unit="s")).astype(str)
    path = written(tmp_path, rig().rename(columns={"Zeit [ms]": "Datum"}).assign(Datum=stamps))
    inspection = inspect_recording(path, Path("rig_own"))
    assert 'time = { column = "Datum", unit = "timestamp" }' in inspection.proposal
    assert inspection.findings[0].end == pytest.approx(9.99)


def test_the_command_prints_a_proposal_and_what_it_lacks(tmp_path):
    (tmp_path / "run.csv").write_text("time [s],ω [rad/s]\n0,1\n1,2\n2,3\n", encoding="utf-8")
    done = CliRunner().invoke(app, ["inspect", str(tmp_path / "run.csv"), "--for", "rig_own"])
    assert done.exit_code == 0, done.output
    assert "ω [rad/s]" in done.stdout
    assert "Fill in what was not recognised: " in done.stderr


def test_the_command_writes_a_file_that_estimate_accepts(tmp_path):
    path, file = written(tmp_path, rig()), tmp_path / "mine.toml"
    result = CliRunner().invoke(app, ["inspect", str(path), "--for", "rig_own", "--out", str(file)])
    assert result.exit_code == 0, result.output
    for fact in ("Drehzahl [U/min]", "wheelset_speed", "9.990", str(file)):
        assert fact in result.output
    text = file.read_text(encoding="utf-8")
    assert text.startswith("#:schema ./estimation.schema.json\n")
    schema = json.loads((tmp_path / "estimation.schema.json").read_text(encoding="utf-8"))
    jsonschema.Draft7Validator(schema).validate(tomllib.loads(text))
    estimates = rg.estimate(path, file)
    assert np.isfinite(estimates["mean"].values).all()
    with pytest.raises(InputError, match=r"mine\.toml"):
        app(["inspect", str(path), "--out", str(file)], standalone_mode=False)


def test_an_extending_estimation_inherits_no_columns(tmp_path):
    file = tmp_path / "mine.toml"
    file.write_text('extends = "field"\n[course]\nmass = "84.01 t"\n', encoding="utf-8")
    specification, base = load_specification(file), load_specification(Path("field"))
    assert specification.name == "mine"
    assert specification.course.mass == 84010.0
    assert (specification.noise, specification.data) == (base.noise, base.data)
    file.write_text('extends = "mine.toml"\n[model]\n', encoding="utf-8")
    with pytest.raises(ScenarioError, match="circle"):
        load_specification(file)
    file.write_text('extends = "felid"\n[model]\n', encoding="utf-8")
    with pytest.raises(ScenarioError, match="field"):
        load_specification(file)
