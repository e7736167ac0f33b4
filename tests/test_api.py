"""The public interface behaves as documented, and errors in a user's class are reported in a sentence."""

import json
import os
import re
import sys
from concurrent.futures import ThreadPoolExecutor
from contextlib import nullcontext
from pathlib import Path

import numpy as np
import pytest
import xarray
from command_line import ran
from one_process import Here
from users_parts import Drag, Exact, Hold

import railgrip as rg
from railgrip.base.errors import ScenarioError

PAGE = Path(__file__).parents[1] / "docs" / "api.md"
SHORT = {"limits.horizon": "0.5 s", "start.speed": "30 km/h"}


@pytest.fixture(scope="module")
def scenario():
    return rg.Scenario.load("trapezoid", SHORT)


class BangBang:
    """The shortest example."""

    def __init__(self, level=0.15):
        self.level = level

    def start(self, formation):
        self.p_max = formation.pressure_max

    def decide(self, observation):
        return np.where(observation.slip < self.level, self.p_max, 0.0)


class Gps(Exact):
    def read(self, time, truth):
        return super().read(time, truth) | {"speed": truth["speed"] + 0.01 * self.random.standard_normal()}


def test_every_name_of_the_interface_exists():
    for name in rg.__all__:
        assert getattr(rg, name) is not None
    with pytest.raises(AttributeError, match="has no attribute 'braek'"):
        _ = rg.braek


def test_a_built_in_law_as_an_object_stops_like_the_one_by_name(scenario):
    """Two-state control at 10/15 %, written here, with identical bits."""

    class TwoState:
        needs = ()

        def start(self, formation):
            self.demand = self.p_max = formation.pressure_max

        def decide(self, observation):
            fast = observation.speed > 0.5
            self.demand = np.where((observation.slip > 0.15) & fast, 0.0, self.demand)
            self.demand = np.where((observation.slip < 0.10) | (not fast), self.p_max, self.demand)
            return self.demand

    ours = rg.run(scenario.changed({"controller.kind": "slip_two_state", "limits.horizon": "3 s"}))
    theirs = rg.run(scenario.changed({"limits.horizon": "3 s"}), controller=TwoState)
    assert np.count_nonzero(np.diff(ours.trace["demand"], axis=0)) > 4
    for name in ("distance", "slip", "demand", "command"):
        assert ours.trace[name].values.tobytes() == theirs.trace[name].values.tobytes()


def test_an_estimate_that_an_estimator_does_not_provide_is_absent(scenario):
    datasets = []

    class Spy(BangBang):
        def decide(self, observation):
            datasets.append(observation)
            return super().decide(observation)

    stop = rg.run(scenario, controller=Spy, estimator=Drag)
    assert {name for name in stop.trace if str(name).startswith("estimate_")} == {"estimate_adhesion"}
    assert stop.metrics.adhesion_rmse is not None
    assert stop.metrics.adhesion_nees is stop.metrics.nis_ratio is None
    assert datasets[-1].pad_friction is None
    assert not datasets[-1].slip_is_estimated
    assert datasets[-1].adhesion == pytest.approx(np.full(4, -datasets[-1].acceleration / 9.81))
    assert datasets[-1].wheelset_speed.shape == (4,)


def test_a_law_that_needs_an_unavailable_estimate_is_refused(scenario):
    with pytest.raises(ScenarioError, match=r"'adhesion_based' needs estimates of pad_friction, .* provides adhesion"):
        rg.run(scenario, estimator=Drag)

    nobody = scenario.changed({"estimator.kind": "none"})
    with pytest.raises(ScenarioError, match=r"'adhesion_based' needs estimates of adhesion .* 'none' provides nothing"):
        rg.run(nobody)
    assert rg.run(nobody, controller=BangBang).outcome is rg.Outcome.HORIZON  # a replaced part is not checked

    class Needs(BangBang):
        needs = ("adhesion",)

    with pytest.raises(ScenarioError, match="needs estimates of adhesion"):
        rg.run(scenario.changed({"estimator.kind": "none", "controller.kind": "full_brake"}), controller=Needs)


SOURCE_OF_ROLLING = re.search(r"class Rolling.*?(?=rg\.testing\.check_plant)", PAGE.read_text(), re.DOTALL)[0]


def rolling():
    """The plant of the page."""
    names = {"np": np, "__name__": __name__}
    exec(compile(SOURCE_OF_ROLLING, str(PAGE), "exec"), names)
    return names["Rolling"]


PARTS = {"controller": BangBang, "estimator": Drag, "sensors": Gps, "plant": rolling()}
OUTCOMES = {name: f"{name}_failed" for name in PARTS} | {"estimator": "diverged"}


@pytest.mark.parametrize(
    ("place", "function", "words"),
    [
        ("controller.decide", lambda self, seen: 1 / 0, r"failed in .*test_api\.py, line \d+: ZeroDivisionError"),
        ("controller.decide", lambda self, seen: [1.0, 2.0], r"\(.*\) returned numbers of shape \(2,\), not the"),
        ("controller.decide", lambda self, seen: np.full(4, np.nan), r"returned \[nan, nan, nan, nan\], not"),
        ("controller.decide", lambda self, seen: "full", "returned str 'full', not"),
        ("controller.decide", lambda self: None, r"\(.*test_api\.py, line \d+\) failed: TypeError"),
        ("controller.decide", lambda self, seen: seen.slip.fill(0.0), "ValueError: assignment destination is"),
        ("estimator.step", lambda self, seen: {}["a"], "KeyError"),
        ("estimator.step", lambda self, seen: 3, "returned int 3, not an Estimate"),
        ("estimator.step", lambda self, seen: rg.Estimate(adhesion=0.1), r"gave adhesion as numbers of shape \(\)"),
        ("estimator.step", lambda self, seen: rg.Estimate(slip=np.zeros(4)), "gave slip; it provides adhesion"),
        ("estimator.step", lambda self, seen: rg.Estimate(adhesion=np.full(4, np.inf)), r"gave adhesion as \[inf"),
        ("sensors.read", lambda self, time, truth: truth["sped"], "KeyError"),
        ("sensors.read", lambda self, time, truth: {"sped": 1.0}, "not readings of speed, wheelset_speed"),
        ("sensors.read", lambda self, time, truth: {"speed": [1.0, 2.0]}, r"gave speed as numbers of shape \(2,\)"),
        ("sensors.read", lambda self, time, truth: truth["slip"].fill(0.0), "read-only"),
        ("plant.step", lambda self, inputs: 1 / 0, r"failed in .*ZeroDivisionError.* At 0\.001 s"),
        ("plant.start", lambda self, formation, speed, period: {"speed": speed}, "a plant outputs accel"),
        ("plant.step", lambda self, inputs: {"speed": 1.0}, "at the start it returned"),
        ("plant.step", lambda self, inputs: inputs["mu0"].fill(0.0), "read-only"),
    ],
)
def test_an_error_in_a_part_is_an_outcome_with_a_sentence(scenario, place, function, words):
    part, method = place.split(".")
    mine = type("Mine", (PARTS[part],), {method: function})
    stop = rg.run(scenario, **({"controller": BangBang} | {part: mine}))
    assert stop.outcome.value == OUTCOMES[part]
    assert re.search(rf"Mine\.{method}.*{words}", stop.reason)
    assert part != "controller" or stop.reason.endswith("At 0.000 s.")


def test_noise_of_own_sensors_depends_on_the_seed(scenario):
    one, same, other = (
        rg.run(scenario.changed({"seed": seed}), controller=BangBang, sensors=Gps).trace["reading_speed"].values
        for seed in (1, 1, 2)
    )
    assert one.tobytes() == same.tobytes()
    assert not np.array_equal(one, other)


def test_the_demand_is_recorded_with_units(scenario):
    """Row k has the preceding demand; ideal actuation passes it on unchanged, as a pressure."""
    trace = rg.run(scenario, controller=BangBang).trace
    assert trace["demand"].attrs["units"] == trace["command"].attrs["units"] == "Pa"
    assert trace["demand"].values[0].tolist() == [0.0] * 4
    assert np.array_equal(trace["demand"], trace["command"])


def test_a_stop_stepped_by_hand_equals_that_of_the_loop(scenario):
    ours = rg.run(scenario, controller=type("Full", (Hold,), {"decide": lambda self, observation: np.full(4, 2e5)}))
    with rg.open(scenario) as bench:
        with pytest.raises(ScenarioError, match=r"formation is known after reset\(\)"):
            _ = bench.formation
        for _ in range(2):
            observation = bench.reset()
            assert observation.time == 0.0
            while not bench.ended:
                observation = bench.step(np.full(4, 2e5))
            assert bench.stop.trace["distance"].values.tobytes() == ours.trace["distance"].values.tobytes()
        with pytest.raises(ScenarioError, match=r"reset\(\) comes before step\(\)"):
            bench.step(np.full(4, 2e5))
        bench.reset()
        with pytest.raises(ScenarioError, match=r"got numbers of shape \(3,\)"):
            bench.step([1.0, 2.0, 3.0])
        with pytest.raises(ScenarioError, match="no stop before it has ended"):
            _ = bench.stop


@pytest.mark.parametrize("use", ["step", "reset", "stop", "enter"])
@pytest.mark.parametrize("begun", [True, False])
def test_a_closed_bench_is_refused(scenario, begun, use):
    """A step would call the plant in C, whose memory is free."""
    with rg.open(scenario) as bench:
        if begun:
            bench.reset()
    uses = {
        "step": lambda: bench.step(np.full(4, 2e5)), "reset": bench.reset, "stop": lambda: bench.stop,
        "enter": bench.__enter__,
    }  # fmt: skip
    with pytest.raises(ScenarioError, match="the bench is closed"):
        uses[use]()
    bench.close()
    assert not bench.ended


def test_stops_in_threads_equal_others_and_keep_the_folder_of_the_process(scenario, monkeypatch):
    """All threads have the same current folder: one that changes it moves the relative paths of the others."""
    alone = rg.run(scenario, controller=BangBang).trace

    def forbidden(folder):
        raise AssertionError(f"changed to {folder}")

    monkeypatch.setattr(os, "chdir", forbidden)
    with ThreadPoolExecutor(8) as threads:
        stops = threads.map(lambda _: rg.run(scenario, controller=BangBang), range(8))
        assert all(stop.trace.identical(alone) for stop in stops)


def test_a_sweep_of_fifty_stops_yields_an_ordered_table(scenario):
    axes = {"start.speed": ["30 km/h", "40 km/h"], "seed": range(25)}
    sweep = rg.sweep(scenario.changed({"limits.horizon": "100 ms"}), axes, controller=BangBang, workers=2)
    table = sweep.to_pandas()
    assert len(table) == 50
    assert table.index.names == ["start.speed", "seed"]
    assert table.index.get_level_values("start.speed").tolist() == ["30 km/h"] * 25 + ["40 km/h"] * 25
    assert table.index.get_level_values("seed").tolist() == [*range(25), *range(25)]
    assert set(table["outcome"]) == {"horizon"}
    assert (table["distance_travelled"][25:].to_numpy() > table["distance_travelled"][:25].to_numpy()).all()
    grid = sweep.to_xarray()
    assert grid["distance"].dims == ("start.speed", "seed")
    assert grid["longest_lock"].dims == ("start.speed", "seed", "group")
    assert grid["distance"].attrs["units"] == "m"


def test_a_sweep_over_one_axis_is_ordered_in_whichever_order_its_stops_end(scenario, monkeypatch):
    """Tasks run in this process, at once; those of the sweep of fifty stops in others."""
    monkeypatch.setattr("railgrip.campaign.sweep.processes", lambda count, *, main: nullcontext(Here()))
    short = scenario.changed({"limits.horizon": "100 ms"})
    speeds = [4.0, 8.0, 6.0]
    table = rg.sweep(short, {"start.speed": speeds}, controller=BangBang, workers=2).to_pandas()
    assert table.index.tolist() == speeds
    assert table["distance_travelled"].tolist() == pytest.approx([0.1 * speed for speed in speeds], rel=2e-2)


def test_a_sweep_of_an_invalid_scenario_runs_nothing(scenario):
    with pytest.raises(ScenarioError, match="start"):
        rg.sweep(scenario, {"start.speed": ["30 km/h", "fast"]})
    with pytest.raises(ScenarioError, match="the axis 'seed' has no value"):
        rg.sweep(scenario, {"seed": []})


def test_a_scenario_may_name_a_class(scenario, tmp_path):
    (tmp_path / "my_laws.py").write_text(
        "import numpy as np\n"
        "class Soft:\n"
        "    def __init__(self, share): self.share = share\n"
        "    def start(self, formation): self.demand = self.share * formation.pressure_max\n"
        "    def decide(self, observation): return self.demand\n"
    )
    scenario_by_name = scenario.changed({"controller.kind": "my_laws:Soft", "controller.parameters.share": 0.5})
    stop = rg.run(scenario_by_name, import_from=[tmp_path])
    assert stop.classes["controller"]["parameters"] == {"share": 0.5}
    assert stop.trace["demand"].values[-1].tolist() == [1.7e5, 1e5, 1e5, 1.7e5]  # half of 3.4 and 2 bar
    with pytest.raises(ScenarioError, match="has no class Hard"):
        rg.run(scenario_by_name.changed({"controller.kind": "my_laws:Hard"}), import_from=[tmp_path])
    with pytest.raises(ScenarioError, match=r"Soft cannot be made with parameters \{\}: TypeError"):
        rg.run(scenario.changed({"controller.kind": "my_laws:Soft"}), import_from=[tmp_path])


def test_the_current_folder_runs_no_code_by_itself(tmp_path):
    (tmp_path / "trap.py").write_text("open('sprung', 'w')\nclass Law:\n    pass\n")
    words = ["-m", "railgrip", "run", "trapezoid", "--set", "controller.kind=trap:Law"]
    result = ran([sys.executable, *words], tmp_path)
    assert result.returncode == 2
    assert "the module trap cannot be imported" in result.stderr
    assert "--import-from DIR" in result.stderr
    assert not (tmp_path / "sprung").exists()


def test_an_estimate_of_a_recording():
    from railgrip.estimation.sources import recording_of_estimation
    from railgrip.estimation.spec import LIBRARY, load_specification

    recording = recording_of_estimation(load_specification(LIBRARY / "wagon.toml")).isel(time=slice(0, 400))
    estimated = rg.estimate(recording, "wagon")
    assert estimated["mean"].sizes["time"] == 400
    assert rg.estimate(recording, LIBRARY / "wagon.toml").equals(estimated)


def test_changes_of_an_estimation_keep_their_type():
    """A text "True" is not a number, nor is True; a whole table is one value."""
    with pytest.raises(ScenarioError, match=r"\[source\] seed is True"):
        rg.estimate(xarray.Dataset(), "wagon", {"source.seed": True})
    with pytest.raises(ScenarioError, match=r"\[start\] must be a table, got 'none'"):
        rg.estimate(xarray.Dataset(), "wagon", {"start": "none"})
    with pytest.raises(rg.RailgripError, match="expected is a trace over time"):
        rg.estimate(xarray.Dataset(), "wagon", {"source": {"scenario": "wagon", "seed": np.int64(3)}})


def test_a_plant_in_python_brakes_according_to_its_equation(scenario, tmp_path):
    """Full brake with sufficient friction: s = v0 T + v0²/(2 a), with T the lag of the cylinders."""
    whole = scenario.changed(
        {"controller.kind": "full_brake", "start.speed": 20.0, "limits.horizon": "60 s",
         "limits.stop_speed": "0.01 m/s", "adhesion": {"kind": "constant", "polach": "dry", "mu0": 0.9}}
    )  # fmt: skip
    stop = rg.run(whole, plant=rolling())
    assert stop.outcome is rg.Outcome.STANDSTILL
    a = 9.81 * np.mean([3.4e5, 2e5, 2e5, 3.4e5]) / 1e6
    assert stop.metrics.distance == pytest.approx(20.0 * 0.1 + 20.0**2 / (2 * a), rel=2e-3)
    assert np.isnan(stop.trace["adhesion"].values).all()
    assert stop.trace["slip"].values == pytest.approx(0.0, abs=1e-12)
    stop.write(tmp_path)
    content = json.loads((tmp_path / "stop.json").read_text())
    assert content["classes"]["plant"]["class"] == content["scenario"]["vehicle"]["plant"] == f"{__name__}:Rolling"
    assert "TwoPartTrain.fmu" not in content["fmus"]


@pytest.mark.parametrize(("factor", "outcome"), [(1.0, "standstill"), (1.1, "implausible")])
def test_a_plant_in_python_with_more_friction_than_the_rail_has_is_implausible(scenario, factor, outcome):
    """The trial on two rails does not find it, because friction has an effect; 10 % exceed the resistance."""

    class Grippy(rolling()):
        def step(self, inputs):
            return super().step(inputs | {"mu0": factor * inputs["mu0"]})

    poor = scenario.changed(
        {"controller.kind": "full_brake", "limits.horizon": "30 s", "estimator": {"kind": "none"},
         "adhesion": {"kind": "constant", "polach": "dry", "mu0": 0.1},
         "periods": dict.fromkeys(("communication", "estimator", "controller", "trace"), "10 ms")}
    )  # fmt: skip
    stop = rg.run(poor, plant=Grippy)
    assert stop.outcome.value == outcome
    assert np.isnan(stop.metrics.distance) == (outcome == "implausible")


def test_a_plant_may_be_named_and_have_a_separate_formation(scenario, tmp_path):
    (tmp_path / "my_train.py").write_text(f"import numpy as np\n\n{SOURCE_OF_ROLLING}")
    changes = {
        "vehicle": {
            "plant": "my_train:Rolling",
            "formation": {
                "wheelsets_per_group": [2, 2], "wheelset_load": ["100 kN"] * 4,
                "brakes": {"p_max": "3 bar", "n_units": 2, "r_friction": 0.25, "r_wheel": 0.46, "J": 120.0,
                           "A_piston": 0.03, "i_rigging": 5.0, "eta_rigging": 0.95, "F_spring": 500.0},
            },
        },
        "estimator": {"kind": "none"}, "controller": {"kind": "slip_two_state"},
    }  # fmt: skip
    table = {**scenario.resolved(), **changes}
    stop = rg.run(rg.Scenario.load(table), import_from=[tmp_path])
    assert stop.trace.sizes["group"] == 2
    assert stop.trace["cylinder_pressure"].values[-1] == pytest.approx([3e5] * 2, rel=0.2)


def test_a_plant_that_is_not_a_train_is_refused_before_its_stop(scenario):
    class Wrong(rolling()):
        def shown(self, a):
            return super().shown(a) | {"speed": 3.6 * self.v}

    with pytest.raises(ScenarioError, match=r"Wrong is not a plant: .* it looks like km/h for m/s"):
        rg.run(scenario, controller=BangBang, plant=Wrong)
    with pytest.raises(rg.testing.ContractBroken, match="it looks like km/h for m/s"):
        rg.testing.check_plant(Wrong)


def test_a_modelica_class_of_a_user_is_a_plant(scenario):
    keys = {"model": "SimpleTrain.Car", "library": PAGE.parent / "examples" / "SimpleTrain" / "package.mo"}
    law = {"controller.kind": "slip_two_state", "estimator.kind": "none"}
    stop = rg.run(scenario.changed(law), plant=keys)
    assert stop.trace.sizes["group"] == 4
    assert stop.scenario.vehicle.model == "SimpleTrain.Car"


@pytest.mark.parametrize("method", ["revised", "replaced"])
def test_a_scenario_with_other_tables_is_refused_with_sentences(method):
    """As with `changed`: no error of pydantic, and the result has the same class."""
    scenario = rg.Scenario.load("trapezoid")
    with pytest.raises(rg.RailgripError, match=r"(?s)\[start\] has no key 'sped'; did you mean 'speed'"):
        getattr(scenario, method)({"start": {"sped": 20.0}})
    slower = getattr(scenario, method)({"start": {"speed": 20.0}})
    assert isinstance(slower, rg.Scenario)
    assert slower.start.speed == 20.0
