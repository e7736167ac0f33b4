"""Estimates from a user's file equal those from the recording of the same signals."""

import numpy as np
import pandas as pd
import pytest
from test_recording_agreement import PERIOD, changed, recording, times, wagon, written
from typer.testing import CliRunner

from railgrip.base.errors import EstimationError
from railgrip.cli.app import app
from railgrip.estimation.run import estimate
from railgrip.estimation.sources import check_mass, recording_for, recording_of_estimation
from railgrip.estimation.spec import LIBRARY, load_specification, prediction_for, settings_for
from railgrip.recording.samples import truth_of


@pytest.fixture
def signals():
    """A wagon that coasts, then brakes; the encoder of its first wheelset is silent for a while."""
    recorded = wagon(start=15.0, coasting=3.0)
    recorded["wheelset_speed[1]"][500:511] = np.nan
    return recorded


@pytest.fixture
def arguments(signals, tmp_path):
    """Arguments of `railgrip estimate` for a file of the signals, with the true friction of a wheelset's pads."""
    arguments = written(tmp_path, signals)
    toml, file = tmp_path / "run.toml", tmp_path / "run.csv"
    pd.read_csv(file).assign(mu=0.35).to_csv(file, index=False)
    truth = '"true_mu_b[1]" = { column = "mu", unit = "1" }\n'
    toml.write_text(toml.read_text(encoding="utf-8") + truth, encoding="utf-8")
    return arguments


@pytest.mark.usefixtures("arguments")
def test_a_file_gives_the_same_estimates_as_its_recording(signals, tmp_path):
    specification = load_specification(tmp_path / "run.toml")
    prediction, settings = prediction_for(specification), settings_for(specification, PERIOD)
    record = recording_for(specification, tmp_path / "run.csv")
    assert [flag.kind for flag in record.flags] == ["gap"]
    assert truth_of(record.recording, "mu_b[1]") == pytest.approx(0.35)
    through, direct = (estimate(one, prediction, settings)["mean"] for one in (record.recording, recording(signals)))
    # Units are converted twice, with rounding.
    np.testing.assert_allclose(through.values, direct.values, rtol=1e-6, atol=1e-9)


def test_the_command_reports_repairs_and_errors(arguments, tmp_path):
    result = CliRunner().invoke(app, arguments)
    assert result.exit_code == 0, result.output
    assert "wheelset_speed[1], 9.980–10.220 s: no samples" in result.output
    assert "pad_friction" in result.output
    estimates = (tmp_path / "out" / "estimates.nc").read_bytes()
    (tmp_path / "run.csv").unlink()
    assert CliRunner().invoke(app, arguments).exit_code != 0
    assert (tmp_path / "out" / "estimates.nc").read_bytes() == estimates


@pytest.mark.parametrize(
    ("name", "factor", "sentence"),
    [
        ("wheelset_speed", 1e6, "wheelset_speed[1] is"),
        ("pad_force", -1.0, "pad_force[1] is -"),
        ("speed", 3.6, "and beyond 0 to 1 in"),
    ],
)
def test_an_implausible_recording_fails(signals, tmp_path, name, factor, sentence):
    """Wheel speeds in a wrong unit, forces of wrong sign, km/h converted twice; [data] does not change the refusal."""
    arguments = written(tmp_path, changed(signals, name, times(factor)), 'contradictions = "warn"')
    result = CliRunner().invoke(app, arguments)
    assert result.exit_code == 3, result.output
    assert sentence in " ".join(result.output.split())
    assert (tmp_path / "out" / "estimates.nc").exists()


def test_masses_of_course_and_model_must_agree():
    other = load_specification(LIBRARY / "field.toml", ["course.mass='90 t'"])
    with pytest.raises(EstimationError, match=r"\[course\] mass is 90000 kg, m_wheelset .* add up to 84000 kg"):
        recording_of_estimation(other)
    heavier = [f"model.parameters.\"m_wheelset[{i}]\"='15 t'" for i in range(1, 7)]
    check_mass(load_specification(LIBRARY / "field.toml", ["course.mass='90 t'", *heavier]))


def test_an_estimation_without_a_map_cannot_read_a_file(signals, tmp_path):
    written(tmp_path, signals)
    with pytest.raises(EstimationError, match=r"has no \[data\], which maps the columns of run\.csv"):
        recording_for(load_specification(LIBRARY / "wagon.toml"), tmp_path / "run.csv")
