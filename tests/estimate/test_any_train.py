"""Estimates for any train: the prediction of a train file or of a user's class is treated like the library's."""

import json
from pathlib import Path

import numpy as np
import pytest
from filterpy.kalman import KalmanFilter
from small_train import BEGINNING
from test_estimate_from_a_stop import assert_equal_to_the_loop, squares_of
from test_specification import written
from typer.testing import CliRunner

import railgrip as rg
import railgrip.scenario
from railgrip.base.errors import EstimationError, ScenarioError
from railgrip.cli.app import app
from railgrip.estimation.models import of_train
from railgrip.estimation.sources import recording_of_estimation, require_consistent
from railgrip.estimation.spec import load_specification, model_parameters
from railgrip.estimators.design import NOISE_SETS
from railgrip.recording.samples import recording_of
from railgrip.rolling_stock.modelica import nominal_data
from railgrip.rolling_stock.schema import load_train
from railgrip.scenario.file import NamedFile
from railgrip.scenario.load import load, scenario_of
from railgrip.simulate.run import run_stop
from railgrip.simulate.vehicle_data import VehicleData
from railgrip.trace.measures import SLOWEST
from railgrip.trace.recorder import write_trace

TRAM = Path(railgrip.scenario.__file__).parent / "trains" / "tram.toml"


def trace_of_tram(estimator, changes, folder=Path(), **tables):
    """Return the trace of a tram's stop in the scenario `trapezoid`."""
    table = load(Path("trapezoid"), changes).resolved()
    table |= {"vehicle": {"train": "tram"}, "estimator": {"kind": estimator}} | tables
    return run_stop(scenario_of(table, directory=folder, origin="tram")).trace


@pytest.fixture(scope="module")
def trace():
    """The first 2.5 s with ideal sensors, and adhesion that falls after the first second."""
    return trace_of_tram("fmu", ["limits.horizon=2.5 s", "adhesion.first_fall=1 s", "periods.trace=1 ms"])


@pytest.mark.parametrize("train", ["vt642", "tram"])
def test_the_data_of_a_train_file_are_those_of_its_plant(train):
    """Filters in the loop get them from the FMU of the plant; the estimation does not need that FMU."""
    table = load(Path("plain")).resolved() | {"vehicle": {"train": train}, "estimator": {"kind": "none"}}
    declared = VehicleData(scenario_of(table, directory=Path(), origin="stop")).declared
    data = nominal_data(load_train(Path(train)))
    assert {name: declared[name] for name in data} == data


@pytest.fixture(scope="module")
def mine(tmp_path_factory):
    """A train file of a user: that of tests/cli/test_new.py, so that both need one FMU."""
    text = BEGINNING.replace("NAME", "mine").replace("coupled = false", "coupled = true")
    file = tmp_path_factory.mktemp("train") / "mine.toml"
    file.write_text(text, encoding="utf-8")
    return file


def test_the_estimates_of_a_train_file_equal_those_of_the_loop(mine):
    """The same prediction, noises, gate and start give the same bits, in the loop of the stop and from its trace."""
    short = ["limits.horizon=2.5 s", "adhesion.first_fall=1 s", "periods.trace=1 ms"]
    trace = trace_of_tram("fmu", short, mine.parent, vehicle={"train": mine.name})
    changes = squares_of(NOISE_SETS["train_ideal"]) | {
        "model.train": str(mine),
        "model.class": "ConsistPrediction",
        "between": "held",
    }
    changes |= {"outlier_limit": 1e6}  # the filter in the loop uses every reading
    assert_equal_to_the_loop(rg.estimate(trace, "train", changes), trace)


WHITE = {"speed": "0.1 m/s", "wheelset_speed": "0.1 rad/s", "acceleration": "0.05 m/s**2", "deflection": "0.2 mm"}


def test_adhesion_of_a_simulated_train_is_within_its_claimed_intervals(mine):
    """The plant is not the prediction: its adhesion follows a creep curve, and its suspension other equations.

    The bound of 90 % is the one that the study of estimators requires of every family of stops. Chance has a smaller
    effect: errors are correlated over some 0.2 s, the time constant of the filter, so that 4 groups over 10 s have 200
    independent samples, whose coverage scatters by 0.015 around 0.95.
    """
    changes = ["periods.trace=10 ms", "periods.controller=10 ms", "start.speed=60 km/h"]
    tables = {"sensors": {"kind": "white", "noise": WHITE}, "controller": {"kind": "slip_three_state"}}
    trace = trace_of_tram("none", changes, mine.parent, **tables, vehicle={"train": mine.name})
    found = rg.estimate(trace, "train", {"model.train": str(mine)})
    moving = trace["speed"].values > SLOWEST
    for state, name in (("group_adhesion", "group_adhesion"), ("pad_friction", "pad_friction")):
        states = [f"{state}[{group}]" for group in range(1, 5)]
        mean, deviation = (found[key].sel(state=states).values[moving] for key in ("mean", "sd"))
        error = mean - trace[name].values[moving]
        assert np.mean(np.abs(error) < 1.96 * deviation) >= 0.9


CART = """
block Cart "A mass that a force and an unknown acceleration move"
  parameter Real m(unit="kg", start=1) = 2 "Mass";
  input Real force(unit="N");
  output Real speed(unit="m/s") = v;
  Real v(unit="m/s", start=0, fixed=true);
  Real d(unit="m/s2", start=0, fixed=true);
equation
  der(v) = force/m + d;
  der(d) = 0;
end Cart;
"""

ESTIMATION = """
name = "cart"
[model]
class = "Cart"
library = "Cart.mo"
[noise]
kind = "density"
process = { v = 0.01, d = 0.1 }
readings = { speed = 0.04 }
[start]
mean = { v = 0.0, d = 0.0 }
deviation = { v = 1.0, d = 2.0 }
"""


@pytest.mark.parametrize("kind", ["fmu", "compiled"])
def test_a_linear_class_of_a_user_has_the_estimates_of_the_kalman_filter(tmp_path, kind):
    (tmp_path / "Cart.mo").write_text(CART, encoding="utf-8")
    (tmp_path / "cart.toml").write_text(ESTIMATION, encoding="utf-8")
    random, period, count = np.random.default_rng(5), 0.1, 50
    force, reading = random.standard_normal(count), random.standard_normal(count)
    recording = recording_of({"force": (force, "N"), "speed": (reading, "m/s")}, period=period)
    found = rg.estimate(recording, tmp_path / "cart.toml", {"model.parameters.m": "4 kg", "model.kind": kind})
    reference = KalmanFilter(dim_x=2, dim_z=1, dim_u=1)
    reference.F, reference.B = np.array([[1.0, period], [0.0, 1.0]]), np.array([[period / 4.0], [0.0]])
    reference.H, reference.Q, reference.R = np.array([[1.0, 0.0]]), period * np.diag([0.01, 0.1]), np.array([[0.04]])
    reference.x, reference.P = np.zeros(2), np.diag([1.0, 4.0])
    for k in range(1, count):
        reference.predict(u=force[k - 1 : k])
        reference.update(reading[k])
        state = found.isel(time=k).sel(state=["speed", "d"])
        np.testing.assert_allclose(state["mean"].values, reference.x, rtol=1e-10, atol=1e-12)
        np.testing.assert_allclose(state["sd"].values, np.sqrt(np.diagonal(reference.P)), rtol=1e-10)
    rows = {each["name"]: each["origin"] for each in json.loads(found.attrs["parameters"])}
    assert rows == {"m": "--set"}


@pytest.mark.usefixtures("blank_figures")
def test_page_and_json_have_every_parameter_with_its_origin(trace, tmp_path):
    (tmp_path / "mine.toml").write_text(
        'extends = "train"\n[model]\ntrain = "tram"\n[model.parameters]\nrho_air = 1.3\n'
        "[noise]\nprocess = { alpha = 1e-3 }\n",
        encoding="utf-8",
    )
    write_trace(trace, tmp_path / "trace.nc")
    arguments = ["estimate", str(tmp_path / "mine.toml"), "--data", str(tmp_path / "trace.nc"), "--json"]
    arguments += ["--out", str(tmp_path / "out"), "--set", 'model.parameters."J[2]"=90 kg*m**2']
    result = CliRunner().invoke(app, arguments)
    assert result.exit_code == 0, result.output
    value = json.loads(result.stdout)
    origins = {each["name"]: each["origin"] for each in value["parameters"] + value["settings"]}
    expected = {
        "J[1]": "train file tram",
        "J[2]": "--set",
        "rho_air": "given in mine.toml",
        "noise.process.group_adhesion": "given in mine.toml",
        "noise.process.wheelset_speed": "library default",
        "start.mean.speed": "recording",
        "start.mean.pad_friction[3]": "train file tram",
        "gate.threshold": "library default",
    }
    assert {name: origins[name] for name in expected} == expected
    assert {each["name"] for each in value["settings"] if each["is_default"]} >= {"noise.process.wheelset_speed"}
    page = Path(value["page"]).read_text(encoding="utf-8")
    assert all(text in page for text in ("train file tram", "given in mine.toml", "recording"))
    assert "Inertia of each group" in (tmp_path / "out" / "parameters.csv").read_text(encoding="utf-8")


def test_a_prediction_without_the_track_brakes_of_the_train_is_reported(trace):
    warnings = rg.estimate(trace, "train", {"model.train": "tram"}).attrs["warnings"]
    assert "tram has brakes on the rail itself" in warnings


def test_a_prediction_without_the_linear_resistance_of_the_train_is_reported(trace, tmp_path):
    """A prediction needs no Davis coefficient: that of the tram is used with and without it."""
    text = TRAM.read_text(encoding="utf-8")
    begin, end = text.index("[resistance]"), text.index("[pads.organic]")
    davis = '[davis]\nconstant = "450 N"\nlinear = "110 N.s/m"\nquadratic = "3.4 N.s2/m2"\nestimated = true\n\n'
    (tmp_path / "rolling.toml").write_text(text[:begin] + davis + text[end:], encoding="utf-8")
    warnings = rg.estimate(trace, "train", {"model.train": str(tmp_path / "rolling.toml")}).attrs["warnings"]
    assert "tram has a linear running resistance of 110 N s/m" in warnings


def test_the_train_of_the_library_estimation_counts_as_default():
    """Nobody chose the train, so its data are defaults."""
    parameters = model_parameters(load_specification(Path("train")))
    assert all(each.is_default for each in parameters)
    parameters = model_parameters(load_specification(Path("train"), {"model.train": "tram"}))
    assert [each.name for each in parameters if each.is_default] == ["rho_air"]


def test_a_name_without_index_sets_all_elements():
    given = load_specification(Path("train"), {"model.train": "tram", "model.parameters.r_wheel": "0.3 m"})
    assert {each.value for each in model_parameters(given) if each.name.startswith("r_wheel")} == {0.3}
    parameters = given.model.prediction.equations({"r_wheel": 0.3}).parameters
    assert np.sum(parameters == 0.3) == 4


def test_readings_of_a_train_with_several_kinds_of_bogies_have_the_numbers_of_the_train():
    """Bogies of three axles have no suspension in the prediction; those behind them keep their wheelsets' numbers."""
    train = NamedFile(entry="loco_coaches", path=Path("harness/scenario/trains/loco_coaches.toml").resolve())
    model = of_train(train)
    names = [variable.name for variable in model.model.outputs if variable.name.startswith("deflection")]
    assert names[0] == "deflection[7]"
    assert names[-1] == "deflection[46]"


def test_groups_of_a_trace_that_do_not_match_the_train_are_refused_together(trace):
    with pytest.raises(EstimationError) as error:
        rg.estimate(trace, "train", {"model.train": "emu387"})
    text = str(error.value)
    assert "the recording has 4 groups of wheelset_speed, and emu387 has 16" in text
    assert "the recording has 4 groups of cylinder_pressure, and emu387 has 16" in text


def test_columns_that_do_not_match_the_train_are_refused_together_before_the_file_is_read():
    columns = {"speed": {"column": "v", "unit": "bar"}}
    columns |= {f"wheelset_speed[{group}]": {"column": f"n{group}", "unit": "rad/s"} for group in range(1, 7)}
    columns |= {f"cylinder_pressure[{group}]": {"column": f"p{group}", "unit": "bar"} for group in range(1, 4)}
    data = {"time": {"column": "t", "unit": "s"}, "period": 0.01, "longest_gap": 0.1, "frozen": 1.0, "spike": 8.0}
    changes = {"model.train": "tram", "data": data | {"columns": columns}}
    with pytest.raises(EstimationError) as error:
        recording_of_estimation(load_specification(Path("train"), changes), data=Path("missing.csv"))
    text = str(error.value)
    assert "[data.columns] has wheelset_speed[5], wheelset_speed[6], and tram has 4 groups" in text
    assert "lacks cylinder_pressure[4], which the model must know" in text
    assert "[data.columns] speed" in text


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"model": {"outputs": ["speed"]}}, "names no model"),
        ({"model.class": "WagonPrediction"}, "has a train and the class WagonPrediction"),
        ({"model.train": "trm"}, "did you mean 'tram'|did you mean tram"),
        ({"model.parameters": {"m_group[1]": "9 t"}}, "has no parameter 'm_group"),
    ],
)
def test_an_invalid_model_is_refused(tmp_path, changes, sentence):
    file = Path("train")
    if "model" in changes:
        file = written(tmp_path, "train", model=('train = "vt642"\nclass = "ConsistPredictionDisturbed"\n', ""))
    with pytest.raises((ScenarioError, EstimationError), match=sentence):
        require_consistent(load_specification(file, changes))
