"""Trains of any number of wheelsets and groups run from their scenario to metrics and figures."""

import shutil
from functools import reduce
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray
from command_line import exit_code
from pages import signals_of
from PIL import Image
from sampling import sample

from railgrip.base.errors import ScenarioError
from railgrip.controllers.laws.slip_two_state import SlipTwoState
from railgrip.controllers.observation import Observation
from railgrip.fmus.build import build_class
from railgrip.fmus.native.package import pack
from railgrip.report.stop import Stop, read_stop
from railgrip.scenario.load import load, scenario_of
from railgrip.scenario.outcome import Outcome
from railgrip.scenario.schema import Scenario
from railgrip.simulate.export.controller_and_plant import controller_fmu
from railgrip.simulate.run import Bench, run_stop
from railgrip.simulate.user_parts import CustomParts
from railgrip.simulate.vehicle_data import VehicleData
from railgrip.trace.metrics import Metrics
from railgrip.vehicle.formation import Formation

ROOT = Path(__file__).parents[2]
LIBRARY = ROOT / "harness" / "scenario" / "library"
FREIGHT = str(ROOT / "docs" / "examples" / "freight_train.toml")
TROLLEY_CLASS = str(Path(__file__).with_name("Trolley.mo"))
SPEED = 10  # km/h
SLOW = (f"start.speed={SPEED} km/h",)

TROLLEY = """
name = "trolley"
seed = 1

[vehicle]
plant = "Vehicle.fmu"
trust = true

[vehicle.map]
pressure_command = "air[{i}]"
mu0 = { variable = "rail[{i}]" }
speed = "v_kmh"
distance = "way"
acceleration = "-braking"
wheelset_speed = "turns[{i}]"
cylinder_pressure = "cylinder[{i}]"
slip = "slide[{i}]"
adhesion = "used[{i}]"
group_adhesion = ["used[1]", "used[3]"]
start_speed = "v0"

[vehicle.formation]
wheelsets_per_group = [2, 1]
"""
BRAKES = """p_max = ["3 bar", "3 bar"], n_units = [4, 2], r_friction = 0.25, r_wheel = 0.4, A_piston = 0.02, \
J = ["200 kg.m2", "100 kg.m2"], i_rigging = 5.0, eta_rigging = 0.95, F_spring = 500.0"""


def trolley(folder: Path, *, formation: str = "", parameters: str = "") -> Path:
    """Write a scenario of a trolley whose data are keys of [vehicle.formation] or [controller] parameters."""
    shutil.copy(build_class("Trolley.Vehicle", Path(TROLLEY_CLASS)).path, folder)
    rest = (LIBRARY / "foreign_train.toml").read_text()
    rest = rest[rest.index("[start]") : rest.index("[controller]")] + rest[rest.index("[periods]") :]
    path = folder / "trolley.toml"
    path.write_text(f'{TROLLEY}{formation}\n[controller]\nkind = "slip_two_state"\n{parameters}\n{rest}')
    return path


# Wheelsets of each resulting group → scenario and overrides.
TRAINS = {
    "wagon": ((1, 1), (str(LIBRARY / "wagon.toml"), *SLOW)),
    "car": ((1,) * 4, (FREIGHT, "vehicle.model=SimpleTrain.Car", *SLOW)),
    "trolley": ((2, 1), ("trolley.toml", *SLOW)),
    "freight train": (
        (1,) * 16,
        (FREIGHT, "estimator.kind=decentralised", "estimator.noise=ideal", "controller.kind=adhesion_based", *SLOW),
    ),
}


@pytest.mark.parametrize("name", TRAINS)
def test_a_train_runs_to_metrics_and_figures(tmp_path: Path, name: str, monkeypatch):
    monkeypatch.chdir(tmp_path)
    counts, (scenario, *overrides) = TRAINS[name]
    if name == "trolley":
        trolley(tmp_path, parameters=f'parameters = {{ {BRAKES}, m = "24 t" }}')
    changes = [text for override in overrides for text in ("--set", override)]
    assert exit_code("run", scenario, *changes, "--out", "stop") == 0
    record = read_stop(tmp_path / "stop")
    assert record.outcome is Outcome.STANDSTILL
    _sensible(record.metrics, groups=len(counts))
    with xarray.open_dataset(tmp_path / "stop" / "trace.nc") as trace:
        assert (trace.sizes["group"], trace.sizes["wheelset"]) == (len(counts), sum(counts))
        # Wheelsets of a group turn as one, and every group is braked.
        assert bool((trace["cylinder_pressure"].max("time") > 1e5).all())
        distance = np.trapezoid(trace["speed"], trace["time"])
    assert record.metrics.distance == pytest.approx(distance, rel=1e-3)

    if name not in sample([*TRAINS], 2):
        return  # only those with the fewest and the most groups are drawn
    assert exit_code("report", "stop") == 0
    with Image.open(tmp_path / "stop" / "stop.png") as figure:
        assert figure.width == 2100
    lines = signals_of(tmp_path / "stop" / "index.html")["data"]
    assert {line["name"] for line in lines} >= {f"wheelset {k + 1}" for k in range(sum(counts))}


def _sensible(metrics: Metrics, groups: int) -> None:
    """Between sliding throughout at 5 % and braking at 20 %, in time and distance of a constant deceleration."""
    speed = SPEED / 3.6
    assert speed**2 / 2 / (0.2 * 9.81) < metrics.distance < speed**2 / 2 / (0.04 * 9.81)
    assert speed / (0.2 * 9.81) < metrics.duration < speed / (0.04 * 9.81)
    assert len(metrics.longest_lock) == groups


def test_one_value_for_all_is_overridden_by_that_of_a_group():
    """Also where the plant, like the wagon, has one number of brake units for both wheelsets."""
    groups = VehicleData(
        load(LIBRARY / "wagon.toml", ["controller.parameters={ 'n_units[2]' = 1.0 }"])
    ).nominal.formation.brakes
    assert [group.units for group in groups] == [2.0, 1.0]
    alike = VehicleData(
        load(LIBRARY / "trapezoid.toml", ["controller.parameters.r_friction='0.2 m'"])
    ).nominal.formation.brakes
    assert [group.friction_radius for group in alike] == [0.2] * 4


def test_an_exported_law_brakes_sixteen_groups_like_the_law(tmp_path: Path):
    """Commands over two seconds; a last digit of slip may differ between C and Python."""
    short = ["limits.horizon=2 s", "periods.trace=1 ms"]
    law = load(Path(FREIGHT), short)
    pack(controller_fmu(law), tmp_path / "law.fmu")
    exported = f"controller={{kind='fmu', file='{tmp_path / 'law.fmu'}', trust=true}}"
    stops = [run_stop(scenario) for scenario in (law, load(Path(FREIGHT), [*short, exported]))]
    commands = [stop.trace["command"].values for stop in stops]
    assert commands[0].shape == (2001, 16)
    assert commands[0].min(axis=0).max() == 0.0, "every group was released once"
    np.testing.assert_allclose(commands[1], commands[0], atol=0.34)


def test_the_train_provides_positions_and_loads_of_its_wheelsets():
    """Geometry of the bogies, 15.05 + 1.9/2 m from the middle of the Jacobs bogie, and the masses, by hand."""
    formation = VehicleData(load(LIBRARY / "trapezoid.toml")).nominal.formation
    ahead = [16.95, 15.05, 1.325, -1.325, -15.05, -16.95]
    assert formation.position == pytest.approx(16.95 - np.array(ahead), abs=1e-12)
    assert formation.load == pytest.approx(9.81 * np.array([13400, 14100, 14500, 14500, 14100, 13400]))
    assert formation.wheelsets_per_car == (3, 3)
    assert [brake.load for brake in formation.brakes] == pytest.approx(formation.sum_by_group(formation.load))
    wagon = VehicleData(load(LIBRARY / "wagon.toml")).nominal.formation
    assert (wagon.cars, wagon.position.tolist()) == (1, [0.0, 9.0])
    assert wagon.load == pytest.approx([40e3 * 9.81 / 2] * 2)
    onboard = VehicleData(load(LIBRARY / "trapezoid.toml", ["controller.parameters.m='60 t'"])).nominal.formation
    assert onboard.load == pytest.approx([98100.0] * 6)


@pytest.fixture(scope="module")
def foreign(tmp_path_factory) -> Path:
    """A trolley whose formation and brakes are in [vehicle.formation] alone."""
    keys = f"""wheelsets_per_car = [1, 2]
wheelset_position = ["0 m", "250 cm", "9 m"]
wheelset_load = ["70 kN", "70 kN", "90 kN"]
brakes = {{ {BRAKES} }}"""
    return trolley(tmp_path_factory.mktemp("foreign"), formation=keys)


def test_a_foreign_plant_has_the_formation_of_its_table(foreign):
    """Also for a rail over distance, where the last wheelset passes the places of the first."""
    formation = VehicleData(load(foreign)).nominal.formation
    assert formation.position.tolist() == [0.0, 2.5, 9.0]
    assert formation.load == pytest.approx([70e3, 70e3, 90e3])
    assert (formation.cars, formation.pressure_max.tolist()) == (2, [3e5, 3e5])
    over = [
        "start.speed=25 km/h", "adhesion={kind='trapezoid', polach='wet', over='distance', minimum=0.05, maximum=0.1, "
        "first_fall='1 m', period='10 m', low='4 m', ramp='1 m'}",
    ]  # fmt: skip
    mu0 = run_stop(load(foreign, [*over, "limits.horizon=1 s"])).trace["mu0"].values
    assert (mu0[:, 0] < mu0[:, 2]).any()


@pytest.mark.parametrize(
    ("override", "sentence"),
    [
        ("wheelsets_per_car=[2, 2]", r"\[vehicle.formation\]: wheelsets_per_car has 4 wheelsets, .* has 3, \[2, 1\]"),
        ("wheelset_position=[0, 2]", r"\[vehicle.formation\]: wheelset_position is for 2 wheelsets"),
        ("wheelset_position=[0, 2, 1]", r"\[vehicle.formation\]: wheelset_position must be rising distances \[m\]"),
        ("wheelset_load=[7e4]", r"\[vehicle.formation\]: wheelset_load is for 1 wheelsets"),
        ("brakes.p_mex=1", r"\[vehicle.formation\] brakes has no parameter 'p_mex'; did you mean 'p_max'"),
    ],
)
def test_an_inconsistent_formation_is_refused_with_its_key(foreign, override, sentence):
    with pytest.raises(ScenarioError, match=rf"trolley: {sentence}"):
        run_stop(load(foreign, [f"vehicle.formation.{override}"]))


def test_a_library_of_predictions_requires_the_name_of_one():
    table = load(LIBRARY / "plain.toml").resolved()
    table["estimator"] = {"kind": "fmu", "library": TROLLEY_CLASS, "noise": "ideal"}
    with pytest.raises(ScenarioError, match="has no model; name the class of the prediction"):
        scenario_of(table, directory=LIBRARY, origin="plain.toml")


def test_the_decentralised_estimator_uses_its_own_parameters():
    """Wheels assumed 1 % larger seem to turn faster than they roll: a slip of −1 % while they roll."""
    estimator = ("estimator.kind=decentralised", "estimator.noise=ideal")
    plain, larger = (
        run_stop(load(LIBRARY / "trapezoid.toml", (*estimator, *more, "controller.kind=full_brake", *SLOW))).trace
        for more in ((), ("estimator.parameters.r_wheel=0.3838 m",))
    )
    beyond = (1.0 - larger["estimate_slip"]) / (1.0 - plain["estimate_slip"])
    assert beyond.isel(time=slice(5, 50)).values == pytest.approx(1.01, abs=1e-3)


@pytest.mark.parametrize("kind", ["decentralised", "compiled"])
def test_one_mass_assumed_for_all_wheelsets_equals_one_for_each(kind: str):
    """The deceleration is measured: if wheelsets are assumed 10 % too heavy, the estimated pad friction is higher."""
    rolling = ("controller.kind=full_brake", "adhesion.mu0=0.5", "start.speed=30 km/h", "estimator={kind='none'}")
    table = load(LIBRARY / "plain.toml", rolling).resolved()

    def pads(masses: dict[str, str]) -> np.ndarray:
        estimator = {"kind": kind, "noise": "ideal", "parameters": masses}
        stop = run_stop(scenario_of(table | {"estimator": estimator}, directory=LIBRARY, origin="plain.toml"))
        return stop.trace["estimate_pad_friction"].values[20:50]

    heavier = pads({"m_wheelset": "15.4 t"})
    assert (heavier > 1.03 * pads({})).all()
    assert np.array_equal(heavier, pads({f"m_wheelset[{i}]": "15.4 t" for i in range(1, 7)}))


PARTLY = {"demand": {"phases": [{"pressure": "2.3 bar"}]}, "start": {"speed": "50 km/h"}}


SHARED_VALVES = {"vehicle": {"formation": {"groups_per_valve": [2] * 8}}}


def freight_scenario(*changes: dict[str, Any]) -> Scenario:
    return reduce(Scenario.revised, changes, load(Path(FREIGHT)))


def freight(*changes: dict[str, Any], controller: Any = None) -> Stop:
    return run_stop(freight_scenario(*changes), objects=CustomParts(controller=controller))


def test_rear_wheelsets_supply_the_missing_force_of_front_ones():
    """On a rail that wheels clean for those behind: a shorter stop within the limits of the law and the cylinders."""
    alone = freight(PARTLY)
    together = freight(PARTLY, {"controller": {"kind": "slip_two_state", "redistribute": True}})
    assert together.metrics.distance < 0.995 * alone.metrics.distance
    assert 2.4e5 < float(together.trace["demand"].max()) <= 3.2e5


def test_wheelsets_of_a_valve_have_the_same_command():
    """Two bogies of two wheelsets in each car, with one valve each: the stop is longer than with one per wheelset."""
    slow = {"start": {"speed": "40 km/h"}}
    alone, shared = freight(slow), freight(slow, SHARED_VALVES)
    demand = shared.trace["demand"].values
    assert np.array_equal(demand[:, ::2], demand[:, 1::2])
    assert demand.min() == 0.0
    assert shared.metrics.distance > alone.metrics.distance


ZERO = {"start": {"speed": "40 km/h"}, "faults": [{"part": "speed_sensor", "kind": "zero", "group": 2}]}
LIMITED = {"controller": {"release_max": "1.5 s"}}
CAR = {"vehicle": {"model": "SimpleTrain.Car"}}
"""One car of the train, which is built in half of the time."""


def test_a_release_that_lasts_too_long_ends_in_a_stop():
    """A sensor that reads zero releases its group for good; with the limit it brakes for 1 s after each 1.5 s."""
    endless, limited = freight(CAR, ZERO), freight(CAR, ZERO, LIMITED)
    braked = [np.mean(stop.trace["demand"].values[:, 1] == 3.2e5) for stop in (endless, limited)]
    assert braked[0] < 0.05  # at the end, where protection is off
    assert braked[1] == pytest.approx(1.0 / 2.5, abs=0.05)
    assert limited.metrics.distance < endless.metrics.distance


class InPython:
    """The law of the freight train's file as a user's class."""

    def start(self, formation: Formation) -> None:
        self.law = SlipTwoState(formation.brakes, SlipTwoState.load_tuning("ideal", "read", "paper"))

    def decide(self, observation: Observation) -> tuple[float, ...]:
        return self.law.decide(observation)


@pytest.mark.parametrize("change", [SHARED_VALVES, PARTLY | {"controller": {"redistribute": True}}, ZERO | LIMITED])
def test_a_controller_class_of_a_user_also_has_what_follows_a_law(change: dict[str, Any]):
    """Bit-identical to the same law compiled, also where the caller of `step` is the controller."""
    slow = {"start": {"speed": "30 km/h"}, "estimator": {"kind": "none"}}
    compiled = freight(change, slow)
    in_python = freight(change, slow, controller=InPython())
    assert np.array_equal(in_python.trace["demand"], compiled.trace["demand"])
    law = InPython()
    with Bench(freight_scenario(change, slow), CustomParts()) as bench:
        observation = bench.reset()
        law.start(bench.formation)
        while not bench.ended:
            observation = bench.step(law.decide(observation))
        assert np.array_equal(bench.stop.trace["demand"], compiled.trace["demand"])


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"controller": {"redistribute": True}}, r"write a \[demand\] below it"),
        ({"vehicle": {"formation": {"groups_per_valve": [2]}}}, "groups_per_valve has 2 groups"),
        (
            PARTLY | {"vehicle": {"formation": {"groups_per_valve": [2, 2]}}, "controller": {"redistribute": True}},
            "leave out redistribute",
        ),
    ],
)
def test_an_impossible_train_level_control_is_refused_in_a_sentence(change: dict[str, Any], sentence: str):
    with pytest.raises(ScenarioError, match=sentence):
        freight(CAR, change)
