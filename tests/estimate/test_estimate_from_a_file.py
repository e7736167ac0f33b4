"""Estimates from a user's file equal those from the recording of the same signals."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from typer.testing import CliRunner

from railgrip.base.errors import EstimationError
from railgrip.cli.app import app
from railgrip.estimation.run import estimate
from railgrip.estimation.sources import check_mass, recording_for, recording_of_estimation
from railgrip.estimation.spec import LIBRARY, load_specification, prediction_for, settings_for
from railgrip.recording.samples import recording_of

MAP = """
[data]
time = { column = "t", unit = "ms" }
period = "10 ms"
longest_gap = "100 ms"
frozen = "1 s"
spike = 8.0

[data.columns]
wheelset_speed = { column = "n", unit = "rev/min" }
speed = { column = "v", unit = "km/h" }
pad_force = { column = "F", unit = "kN" }
true_mu_b = { column = "mu", unit = "1" }
"""


@pytest.fixture
def case(tmp_path: Path):
    """Estimation, file, and recording of the same signals: a rig that coasts, then brakes."""
    random = np.random.default_rng(3)
    t = np.arange(1500) * 0.01
    v = 30.0 - 0.05 * t - np.where(t > 5.0, 1.0 * (t - 5.0), 0.0) + 1e-3 * random.standard_normal(t.size)
    w = v / 0.46 + 1e-3 * random.standard_normal(t.size)
    force = np.where(t > 5.0, 2.0e4, 0.0)
    frame = pd.DataFrame(
        {"t": 1e3 * t, "n": w * 30.0 / np.pi, "v": 3.6 * v, "F": force / 1e3, "mu": np.full(t.size, 0.35)}
    )
    frame.loc[700:720, "n"] = np.nan
    file, toml = tmp_path / "run.csv", tmp_path / "run.toml"
    frame.to_csv(file, index=False)
    toml.write_text((LIBRARY / "rig_own.toml").read_text(encoding="utf-8") + MAP, encoding="utf-8")
    w[700:721] = np.nan
    signals = {"wheelset_speed": (w, "rad/s"), "speed": (v, "m/s"), "pad_force": (force, "N")}
    return toml, file, recording_of(signals, period=0.01)


def test_a_file_gives_the_same_estimates_as_its_recording(case):
    toml, file, recording = case
    specification = load_specification(toml)
    prediction, settings = prediction_for(specification), settings_for(specification, 0.01)
    record = recording_for(specification, file)
    assert [flag.kind for flag in record.flags] == ["gap"]
    through, direct = (estimate(one, prediction, settings)["mean"] for one in (record.recording, recording))
    # Units are converted twice, with rounding.
    np.testing.assert_allclose(through.values, direct.values, rtol=1e-6, atol=1e-9)


def test_the_command_reports_repairs_and_errors(case, tmp_path):
    toml, file, _ = case
    result = CliRunner().invoke(app, ["estimate", str(toml), "--data", str(file), "--out", str(tmp_path / "out")])
    assert result.exit_code == 0, result.output
    assert "wheelset_speed, 6.990–7.210 s: no samples" in result.output
    assert "pad_friction" in result.output
    estimates = (tmp_path / "out" / "estimates.nc").read_bytes()
    refused = ["--data", str(tmp_path / "not_there.csv"), "--out", str(tmp_path / "out")]
    assert CliRunner().invoke(app, ["estimate", str(toml), *refused]).exit_code != 0
    assert (tmp_path / "out" / "estimates.nc").read_bytes() == estimates


@pytest.mark.parametrize(
    ("column", "factor", "sentence"),
    [
        ("n", 1e6, "wheelset_speed is"),
        ("F", -1.0, "pad_force is -2e+04 N at"),
        ("v", 3.6, "Filter: lost;"),
    ],
)
def test_an_implausible_recording_fails(case, tmp_path, column, factor, sentence):
    """Wheel speeds in a wrong unit, forces of wrong sign, km/h converted twice; [data] does not change the refusal."""
    toml, file, _ = case
    accepted = 'spike = 8.0\ncontradictions = "warn"\n'
    toml.write_text(toml.read_text(encoding="utf-8").replace("spike = 8.0\n", accepted), encoding="utf-8")
    frame = pd.read_csv(file)
    frame[column] *= factor
    frame.to_csv(file, index=False)
    result = CliRunner().invoke(app, ["estimate", str(toml), "--data", str(file), "--out", str(tmp_path / "out")])
    assert result.exit_code == 3, result.output
    assert sentence in result.output
    assert (tmp_path / "out" / "estimates.nc").exists()


def test_masses_of_course_and_model_must_agree():
    other = load_specification(LIBRARY / "field.toml", ["course.mass='90 t'"])
    with pytest.raises(EstimationError, match=r"\[course\] mass is 90000 kg, m_wheelset .* add up to 84000 kg"):
        recording_of_estimation(other)
    heavier = [f"model.parameters.\"m_wheelset[{i}]\"='15 t'" for i in range(1, 7)]
    check_mass(load_specification(LIBRARY / "field.toml", ["course.mass='90 t'", *heavier]))


def test_an_estimation_without_a_map_cannot_read_a_file(case):
    _, file, _ = case
    with pytest.raises(EstimationError, match=r"has no \[data\], which maps the columns of run\.csv"):
        recording_for(load_specification(LIBRARY / "rig_own.toml"), file)
