"""A plant or prediction in a user's own Modelica: compiled on demand, cached by content, or refused."""

import shutil
from pathlib import Path

import pytest
from train_stops import dry_scenario

import railgrip
from railgrip.base import cache
from railgrip.base.errors import InputError, ScenarioError
from railgrip.controllers.valves import ValveLogic
from railgrip.fmus.native import lower
from railgrip.scenario.load import load, scenario_of
from railgrip.simulate.controller import valve_logic_of
from railgrip.simulate.ideal import _Tracking
from railgrip.simulate.named_models import is_trusted, plant_description
from railgrip.simulate.run import run_stop
from railgrip.simulate.vehicle_data import VehicleData
from railgrip.trace.recorder import Recorder
from railgrip.vehicle.signals import PLANT, PLANT_INPUTS

ROOT = Path(__file__).parents[2]
EXAMPLES = ROOT / "docs" / "examples"
SHORT = ("limits.horizon=1 s", "vehicle.model=SimpleTrain.Car")

PREDICTION = """within SimpleTrain;
block CarPrediction "The train of the catalogue as an estimator believes it to be, under a name of one's own"
  extends RailBraking.Predictions.TrainPredictionReduced;
end CarPrediction;
"""


@pytest.fixture
def mine(tmp_path: Path) -> Path:
    """Return a modifiable copy of the example: a scenario with its library next to it."""
    shutil.copytree(EXAMPLES, tmp_path / "mine")
    return tmp_path / "mine" / "freight_train.toml"


def test_a_class_is_compiled_again_when_its_library_changes(mine):
    first = load(mine, SHORT)
    before = plant_description(first)
    assert before.file.is_relative_to(cache.folder())
    assert is_trusted(first.vehicle)
    assert plant_description(first).file == before.file
    digest, distance = first.digest(), run_stop(first).metrics.distance_travelled
    with pytest.raises(ScenarioError, match=r"has no parameter 'axles'.* compiled in; for other values name a class"):
        run_stop(load(mine, (*SHORT, "vehicle.parameters={axles=3}")))

    # Not the class itself, but one of its components.
    axle = mine.parent / "SimpleTrain" / "Axle.mo"
    axle.write_text(axle.read_text().replace('F[1] "Braking', 'F[1]*(1 - 1e-3) "Braking'))
    second = load(mine, SHORT)
    assert second.digest() != digest
    assert plant_description(second).digest != before.digest
    assert distance < run_stop(second).metrics.distance_travelled < distance + 0.1


def test_its_scenario_keeps_the_library_as_written_and_loads_again(mine):
    scenario = load(mine, SHORT)
    resolved = scenario.resolved()
    assert resolved["vehicle"]["model"] == "SimpleTrain.Car"
    assert resolved["vehicle"]["library"] == "SimpleTrain/package.mo"
    assert "plant" not in resolved["vehicle"]
    assert scenario_of(resolved, directory=mine.parent, origin="again").digest() == scenario.digest()


@pytest.mark.parametrize(
    ("override", "sentence"),
    [
        ("vehicle.plant=Wagon", r"freight_train.toml: \[vehicle\] has two plants; give 'plant', or 'model' and"),
        ("vehicle.library=x.mo", r"freight_train.toml: \[vehicle\] library names 'x.mo', but there is no file"),
        ("vehicle.model=no class", r"freight_train.toml: \[vehicle\] model is 'no class'"),
        ("vehicle.model=SimpleTrain.Tram", "no file of it declares Tram"),
    ],
)
def test_a_table_without_a_class_is_refused(mine, override, sentence):
    with pytest.raises(InputError, match=sentence):
        run_stop(load(mine, [override]))


def test_a_model_requires_its_library(mine):
    mine.write_text(mine.read_text().replace("library =", "# library ="))
    with pytest.raises(ScenarioError, match=r"\[vehicle\] .*needs both 'model' and the 'library' that contains it"):
        load(mine)


MISTAKES = {
    "SimpleTrain/Axle.mo:42: brake.w = omega;": ("Axle.mo", "brake.w = w;", "brake.w = omega;"),
    "must have annotation(uses(RailBraking))": ("package.mo", "RailBraking", "SomethingElse"),
}


@pytest.mark.parametrize("sentence", MISTAKES)
def test_a_class_that_does_not_compile_is_refused_with_file_and_line(mine, sentence, monkeypatch, command):
    name, right, wrong = MISTAKES[sentence]
    file = mine.parent / "SimpleTrain" / name
    assert right in file.read_text()
    file.write_text(file.read_text().replace(right, wrong))
    monkeypatch.chdir(mine.parent)
    refused = command("run", mine.name)
    assert refused.code == 2
    assert "SimpleTrain.FreightTrain does not compile" in refused.err
    assert sentence in refused.err


def test_a_class_without_the_inputs_of_a_plant_is_refused(mine):
    train = mine.parent / "SimpleTrain" / "Train.mo"
    train.write_text(train.read_text().replace("pressure_command[", "demand["))
    with pytest.raises(Exception, match=r"no input 'pressure_command\[1\]'.*demand\[1\]") as refusal:
        run_stop(load(mine, SHORT))
    assert "freight_train: [vehicle.map]" in str(refusal.value)


@pytest.mark.parametrize("compiler", ["native", "openmodelica"])
def test_a_locally_compiled_model_is_trusted_whoever_compiled_it(mine, compiler, monkeypatch):
    monkeypatch.setattr("railgrip.fmus.build.choose", lambda wanted: compiler)
    assert is_trusted(load(mine, SHORT).vehicle)
    assert is_trusted(load(Path("trapezoid")).vehicle)
    assert is_trusted(dry_scenario("tram", 20.0).vehicle)
    foreign = mine.parent / "their.fmu"
    foreign.write_bytes(b"")
    assert not is_trusted(load(Path("trapezoid"), [f"vehicle.plant={foreign}"]).vehicle)


@pytest.mark.usefixtures("own_cache")
def test_the_command_builds_one_class_into_a_file(tmp_path, monkeypatch, command):
    monkeypatch.chdir(tmp_path)
    library = ("--library", str(Path(__file__).with_name("Trolley.mo")))
    done = command("build", *library, "Trolley.Vehicle", "--out", "here/Mine.fmu")
    assert done.code == 0, done.err
    assert done.out.startswith("here/Mine.fmu  built")
    assert (tmp_path / "here" / "Mine.fmu").is_file()
    assert "current" in command("build", *library, "Trolley.Vehicle").out
    assert (tmp_path / "Vehicle.fmu").is_file()
    (tmp_path / "Sized.mo").write_text(
        "model Sized parameter Integer n = 2; parameter Boolean p = n > 1; parameter Boolean q = true; "
        "parameter Real k = if q then n else 1; Real x[n] = fill(k*time, n); end Sized; "
        "model Larger extends Sized(n = 3); end Larger;"
    )
    for name, n in (("Sized", 2), ("Larger", 3), ("Sized", 2)):  # the last is found
        said = command("build", "--compiler=native", "--library=Sized.mo", name).err
        assert f"{name}.fmu: n = {n}, q = true cannot be set in the FMU" in said
        assert [(p.name, p.start) for p in lower(name, Path("Sized.mo")).parameters] == [("k", n)]
    for wrong, sentence in (
        (library, "--library is for one class"),
        (("--library", "Nowhere", "X"), "X: there is no Modelica library Nowhere"),
        (("--out", "x.fmu", "Wagon"), "--out is for a class"),
    ):
        refused = command("build", *wrong)
        assert refused.code == 2
        assert sentence in refused.err


@pytest.mark.parametrize("kind", ["compiled", "fmu"])
def test_a_prediction_of_a_user_estimates_like_the_class_that_it_extends(mine, kind):
    """Equal equations under another name give equal estimates."""
    (mine.parent / "SimpleTrain" / "CarPrediction.mo").write_text(PREDICTION)
    text = (ROOT / "harness" / "scenario" / "library" / "trapezoid.toml").read_text()
    scenario = mine.parent / "trapezoid.toml"
    table = f'[estimator]\nkind = "{kind}"\nmodel = "SimpleTrain.CarPrediction"\nlibrary = "SimpleTrain/package.mo"\n'
    scenario.write_text(text.replace('[estimator]\nkind = "fmu"\nmodel = "TrainPrediction"\n', table))
    short = ["limits.horizon=500 ms", "estimator.noise=reduced_ideal"]
    own = load(scenario, short)
    ours = load(Path("trapezoid"), ["limits.horizon=500 ms", "estimator.model=TrainPredictionReduced"])
    own_trace, our_trace = run_stop(own).trace, run_stop(ours).trace
    assert float(abs(own_trace["estimate_adhesion"] - our_trace["estimate_adhesion"]).max()) < 1e-9
    assert float(our_trace["estimate_adhesion"].max()) > 0.01
    assert own.files()[0].path.name == "package.mo"


def test_a_prediction_without_a_state_of_the_loop_is_refused(mine):
    lacking = """block Lean
  parameter Real r_wheel = 0.4;
  input Real cylinder_pressure[4];
  output Real speed = v;
  Real w[4](each start=1, each fixed=true);
  Real v(start=1, fixed=true);
equation
  der(v) = -1e-5*cylinder_pressure[1];
  for i in 1:4 loop
    der(w[i]) = -1;
  end for;
end Lean;
"""
    library = mine.parent / "Lean.mo"
    library.write_text(lacking)
    estimator = f"estimator={{kind='python', model='Lean', library='{library}', noise='train_ideal'}}"
    with pytest.raises(ScenarioError, match=r"\[estimator\] model 'Lean' has no state pad_friction\[1\]"):
        run_stop(load(mine, [*SHORT, estimator]))


def test_another_plant_replaces_it_in_python(mine):
    """`plant=` of the API replaces any plant of the scenario."""
    scenario = railgrip.Scenario.load(mine, {"limits.horizon": "1 s"})
    assert scenario.vehicle.model is not None
    other = scenario.with_plant(Path("Wagon"))
    assert (other.vehicle.plant, other.vehicle.model, other.vehicle.library) == ("Wagon", None, None)


def with_valves(folder, vehicle, parameters=None):
    """The plain scenario with another plant, which has valves."""
    plain = load(Path("plain")).resolved()
    controller = plain["controller"] | {"parameters": parameters or {}}
    changes = {"vehicle": vehicle, "actuation": {"kind": "pneumatic"}, "controller": controller}
    return VehicleData(scenario_of(plain | changes, directory=folder, origin="slow.toml"))


def test_the_valve_predictor_and_the_tracking_bound_use_the_valves_of_the_plant(tmp_path):
    """A train with slow valves, and one with separate values for controller and plant."""
    (tmp_path / "Slow.mo").write_text(
        "block Slow extends RailBraking.Plants.TwoPartTrainPneumatic("
        "T_fill=0.8, T_vent=0.5, dead_fill=0.09, dead_vent=0.11); end Slow;"
    )
    vehicle = {"model": "Slow", "library": "Slow.mo"}
    slow = with_valves(tmp_path, vehicle)
    other = with_valves(tmp_path, vehicle | {"parameters": {"dead_vent": "120 ms"}}, {"T_fill": "0.6 s"})
    logic = valve_logic_of(slow)
    assert isinstance(logic, ValveLogic)
    values = dict(zip((quantity.name for quantity in logic.formula.parameters), logic.parameters, strict=True))
    assert (values["fill_time"], values["vent_time"]) == (0.8, 0.5)
    # Commands are delayed by (90 + 110)/2 ms, with one each millisecond.
    assert sum(quantity.name.startswith("under_way[1,") for quantity in logic.formula.states) == 100
    assert other.nominal.valves == {"T_fill": 0.6, "T_vent": 0.5, "dead_fill": 0.09, "dead_vent": 0.11}
    assert other.true.valves == {"T_fill": 0.8, "T_vent": 0.5, "dead_fill": 0.09, "dead_vent": 0.12}
    recorder = Recorder((*PLANT, *PLANT_INPUTS), slow.formation, 2)
    assert (_Tracking(slow, recorder)._rail.time, _Tracking(other, recorder)._rail.time) == (0.11, 0.12)


def test_hidden_valves_are_those_of_the_file_or_the_catalogue_train(tmp_path):
    catalogue = {"T_fill": 0.4, "T_vent": 0.2, "dead_fill": 0.05, "dead_vent": 0.04}
    brakes = {"T_fill": "0.3 s", "dead_fill": "20 ms"}
    assert with_valves(tmp_path, {"plant": "own:Train"}).nominal.valves == catalogue
    stated = with_valves(tmp_path, {"plant": "own:Train", "formation": {"brakes": brakes}})
    assert stated.nominal.valves == stated.true.valves == catalogue | {"T_fill": 0.3, "dead_fill": 0.02}


def test_the_ideal_bound_contains_a_rotating_eddy_current_brake(mine):
    """A stop with full brake on a dry rail uses what its brakes draw, however they work.

    It uses 0.45 % more than friction brakes draw, because the class does not declare the resistance of its wheels.
    """
    axle = mine.parent / "SimpleTrain" / "Axle.mo"
    eddy = "brake.torque + 2000*pressure_command/p_max*w/(w + 10)"
    axle.write_text(axle.read_text().replace("wheels.brake_torque = brake.torque;", f"wheels.brake_torque = {eddy};"))
    changes = ("vehicle.model=SimpleTrain.Car", "start.speed=40 km/h", "adhesion.polach=dry", "adhesion.mu0=0.4")
    scenario = load(mine, (*changes, "adhesion.conditioning.fraction=0", "limits.alpha_max=0.4"))
    full = run_stop(scenario.revised({"controller": {"kind": "full_brake"}})).metrics
    assert 1.0 < full.utilisation <= 1.0045
    best = run_stop(scenario.revised({"controller": {"kind": "ideal_bound"}})).metrics
    assert best.utilisation == pytest.approx(1.0, abs=1e-3)
    assert 0.9 * full.distance_travelled < best.distance_travelled < full.distance_travelled
