"""`railgrip monitor` on stops of the harness and on recorded files of users."""

import numpy as np
import pandas as pd
import pytest
from typer.testing import CliRunner

import railgrip as rg
from railgrip.cli.app import app
from railgrip.estimation.sources import recording_for
from railgrip.estimation.spec import load_specification
from railgrip.recording.samples import reading_of
from railgrip.studies.pad_monitor.evidence import evidence_of
from railgrip.studies.pad_monitor.life import Life, live
from railgrip.studies.pad_monitor.watch import stops_in

MAP = """
name = "stops"
model = { class = "TrainPredictionReduced" }
noise = { kind = "density", process = {}, readings = {} }
start = { deviation = {} }

[data]
time = { column = "t", unit = "s" }
period = "40 ms"
longest_gap = "200 ms"
frozen = "2 s"
spike = 8.0

[data.columns]
speed = { column = "v", unit = "km/h" }
acceleration = { column = "a", unit = "m/s^2" }
track_force = { value = "0 N" }
"""


@pytest.fixture(scope="module")
def slid(tmp_path_factory):
    """A folder with one short stop with locked wheels on ice, as `run` and `campaign` write it."""
    folder = tmp_path_factory.mktemp("stops")
    changes = {"controller.kind": "full_brake", "estimator.kind": "none", "start.speed": "60 km/h"}
    rg.run(rg.Scenario.load("trapezoid", changes)).write(folder / "locked")
    return folder


def test_locked_wheels_are_not_mistaken_for_worn_pads(slid):
    """Their pads transmit less than they could; the error of the evidence must be within its claimed deviation."""
    (evidence,) = stops_in(slid)[0].values()
    assert (np.abs(evidence.health - 1.0) < 3.0 * evidence.deviation).all()
    # The evidence is weak: strong evidence would require sliding pads.
    assert evidence.deviation.max() > 0.1


def test_stops_that_do_not_distinguish_groups_are_reported(slid):
    result = CliRunner().invoke(app, ["monitor", str(slid)])
    assert result.exit_code == 0, result.output
    text = " ".join(result.output.split())
    assert "Stops that distinguish the groups: 0 of 1;" in text
    assert "nan" not in text
    assert (slid / "monitor.png").exists()


def test_recorded_files_give_the_same_evidence_as_the_stops(tmp_path):
    recording, _ = next(live(Life(stops=60, seed=3), range(7, 8)))
    columns = {"t": recording["time"].values, "v": 3.6 * reading_of(recording, "speed")}
    columns["a"] = reading_of(recording, "acceleration")
    text = MAP
    for g in range(1, 5):
        columns[f"n{g}"] = reading_of(recording, f"wheelset_speed[{g}]") * 30.0 / np.pi
        columns[f"p{g}"] = reading_of(recording, f"cylinder_pressure[{g}]") / 1e5
        text += f'"wheelset_speed[{g}]" = {{ column = "n{g}", unit = "rev/min" }}\n'
        text += f'"cylinder_pressure[{g}]" = {{ column = "p{g}", unit = "bar" }}\n'
    (tmp_path / "map.toml").write_text(text, encoding="utf-8")
    folder = tmp_path / "files"
    folder.mkdir()
    pd.DataFrame(columns).to_csv(folder / "stop-1.csv", index=False)
    result = CliRunner().invoke(app, ["monitor", str(folder), "--map", str(tmp_path / "map.toml")])
    assert result.exit_code == 0, result.output
    assert "1 stops do not have the temperature of their discs" in " ".join(result.output.split())
    read = recording_for(load_specification(tmp_path / "map.toml"), folder / "stop-1.csv").recording
    cold = np.full(4, 313.15)
    through, direct = evidence_of(read, cold), evidence_of(recording, cold)
    # Converting units there and back leaves rounding; an omitted spike, a hundredth of a deviation.
    assert (np.abs(through.health - direct.health) < 0.1 * direct.deviation).all()
    wrong = folder.parent / "wrong"
    wrong.mkdir()
    pd.DataFrame(columns | {"v": columns["v"] / 3.6}).to_csv(wrong / "stop-1.csv", index=False)
    result = CliRunner().invoke(app, ["monitor", str(wrong), "--map", str(tmp_path / "map.toml")])
    assert "stop-1.csv: left out: stop-1.csv: wheelset_speed" in " ".join(result.output.split())
    assert "is column 'v' in m/s, not km/h?" in " ".join(result.output.split())
    # Evaluated as a train whose pistons are a quarter smaller: the same braking then requires a pad friction higher by
    # a third, and, since the return spring of 1.2 kN does not change, by a half at 1.5 bar.
    smaller = 0.75 * 0.0324
    with_parameter = text.replace(" }\nnoise", f', parameters = {{ A_piston = "{smaller} m^2" }} }}\nnoise', 1)
    (tmp_path / "smaller.toml").write_text(with_parameter, encoding="utf-8")
    (health,) = (one.health for one in stops_in(folder, load_specification(tmp_path / "smaller.toml"))[0].values())
    assert ((health / through.health > 1.32) & (health / through.health < 1.5)).all()


def test_a_folder_without_stops_is_reported_in_a_sentence(tmp_path):
    result = CliRunner().invoke(app, ["monitor", str(tmp_path)])
    assert result.exit_code != 0
    assert "there are no stops (*/trace.nc) in it" in str(result.exception)
