"""Classes of a user: where they are imported from, their parameters, and the checks of their values."""

import json
import sys
from functools import partial
from inspect import getsource
from pathlib import Path

import numpy as np
import pytest
from test_api import rolling
from users_parts import SHORT, Drag, Exact, Hold, install_part
from wrong import table

import railgrip as rg
from railgrip.base import registry
from railgrip.base.errors import ScenarioError
from railgrip.estimation.spec import LIBRARY

LAWS = f"""
import pathlib
import numpy as np

pathlib.Path(__file__).with_name("imported").touch()

{getsource(Hold)}

class Leaves(Hold):
    def decide(self, observation):
        raise SystemExit(0)

class NoLaw:
    def start(self, formation):
        pathlib.Path(__file__).with_name("called").touch()

def function(**parameters):
    pathlib.Path(__file__).with_name("called").touch()
"""


@pytest.fixture(scope="module")
def scenario():
    return rg.Scenario.load("trapezoid", SHORT)


@pytest.fixture
def laws(tmp_path, request):
    """A module with a unique name for each test: Python caches modules by name."""
    name = f"laws_{abs(hash(request.node.nodeid))}"
    (tmp_path / f"{name}.py").write_text(LAWS)
    return name


class Rolling(rolling()):
    """The plant of the page, with a share of the pressure in its cylinders."""

    def __init__(self, full=1.0):
        self.full = full

    def step(self, inputs):
        return super().step(inputs | {"pressure_command": self.full * inputs["pressure_command"]})


class Absolute(Rolling):
    """The same, whose cylinder pressures include that of the air."""

    def shown(self, a):
        return super().shown(a) | {"cylinder_pressure": self.p + 1.013e5}


def test_absolute_pressures_of_a_plant_are_refused(scenario):
    assert rg.run(scenario, controller="full_brake", plant=Rolling()).outcome == "horizon"
    with pytest.raises(ScenarioError, match=r"is 101300 Pa with the brake released, as an absolute pressure is"):
        rg.run(scenario, controller="full_brake", plant=Absolute())


# Parameters of classes that are passed in


def test_a_sweep_passes_parameters_to_a_given_class(scenario):
    """The share changes only the pressure in the cylinders."""
    axes = {"controller.parameters.share": [0.1, 0.9], "seed": [1]}
    swept = rg.sweep(scenario, axes, controller=Hold)
    alone = [rg.run(scenario.changed({"seed": 1}), controller=Hold(share)) for share in (0.1, 0.9)]
    found = [result.metrics.distance_travelled for result in swept.results]
    assert found == [stop.metrics.distance_travelled for stop in alone]
    assert found[0] > found[1]


@pytest.mark.parametrize(
    ("name", "table", "kind", "parameter"),
    [
        ("sensors", "sensors", Exact, "factor"),
        ("plant", "vehicle", Rolling, "full"),
        ("controller", "controller", Hold, "share"),
    ],
)
def test_an_unknown_parameter_and_one_of_an_object_are_refused_before_anything_runs(
    scenario, name, table, kind, parameter
):
    whole = scenario.changed({"controller.kind": "full_brake"})
    swept = rg.sweep(whole, {f"{table}.parameters.{parameter}": [1.0]}, **{name: kind})
    assert swept.results[0].outcome == "horizon"
    with pytest.raises(ScenarioError, match=f"{kind.__name__} cannot be made with parameters .*bogus"):
        rg.sweep(whole, {f"{table}.parameters.bogus": [1]}, **{name: kind})
    with pytest.raises(ScenarioError, match=f"{name} is an object already; pass the class {kind.__name__}"):
        rg.sweep(whole, {f"{table}.parameters.{parameter}": [1.0]}, **{name: kind()})
    for key in (table, f"{table}.kind", f"{table}.parameters"):
        with pytest.raises(ScenarioError, match=rf"'{key}' has no effect: {name}= replaces \[{table}\]"):
            rg.sweep(whole, {key: [1]}, **{name: kind})


def test_an_object_that_cannot_be_copied_is_refused(scenario):
    held = Hold()
    held.file = (n for n in ())
    with pytest.raises(ScenarioError, match=r"controller: each stop of a sweep needs its own copy .* pass its class"):
        rg.sweep(scenario, {"seed": [1, 2]}, controller=held)


# Where classes are imported from


@pytest.mark.parametrize("changes", table(__file__, "tables.toml")["no_code"])
@pytest.mark.parametrize("folders", [False, True])
def test_a_scenario_alone_runs_no_code(scenario, changes, folders, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    before = set(sys.modules)
    table = scenario.changed({"controller.kind": "full_brake", **changes})
    with pytest.raises(
        ScenarioError, match=r"is not the name of a module|a class that a file names comes from a folder"
    ):
        rg.run(table, import_from=[tmp_path] if folders else [])
    assert not (tmp_path / "done").exists()
    assert "antigravity" not in set(sys.modules) - before


def test_a_module_of_the_same_name_elsewhere_is_not_imported(scenario, tmp_path):
    """For a folder `json` without a module Python finds its own."""
    (tmp_path / "json").mkdir()
    with pytest.raises(ScenarioError, match=r"another module named json\.decoder is loaded already"):
        rg.run(scenario.changed({"controller.kind": "json.decoder:JSONDecoder"}), import_from=[tmp_path])


@pytest.mark.parametrize("name", ["NoLaw", "function", "pathlib.Path", "missing"])
def test_the_class_and_its_methods_are_checked_before_any_call(scenario, tmp_path, laws, name):
    with pytest.raises(ScenarioError, match=r"has no method decide|has no class|has no method start and decide"):
        rg.run(scenario.changed({"controller.kind": f"{laws}:{name}"}), import_from=tmp_path)
    assert (tmp_path / "imported").exists()
    assert not (tmp_path / "called").exists()


def test_an_entry_point_of_an_installed_package_requires_no_folder(scenario, tmp_path, laws, monkeypatch, request):
    install_part(tmp_path, "controllers", f"{laws}:Hold")
    monkeypatch.syspath_prepend(tmp_path)
    request.addfinalizer(registry.installed_names.cache_clear)
    registry.installed_names.cache_clear()
    monkeypatch.chdir(tmp_path)  # the current folder is not installed
    with pytest.raises(ScenarioError, match="kind is 'mine'; there is"):
        scenario.changed({"controller.kind": "mine"})
    registry.installed_names.cache_clear()
    monkeypatch.chdir(Path(__file__).parent)
    stop = rg.run(scenario.changed({"controller.kind": "mine"}))
    assert stop.classes["controller"]["class"] == f"{laws}:Hold"
    rg.run(scenario.changed({"controller.kind": f"{laws}:Hold"}))


def test_an_exit_in_a_part_is_its_failure(scenario, tmp_path, laws):
    stop = rg.run(scenario.changed({"controller.kind": f"{laws}:Leaves"}), import_from=tmp_path)
    assert stop.outcome is rg.Outcome.CONTROLLER_FAILED
    assert "SystemExit: 0" in stop.reason
    (tmp_path / f"{laws}_gone.py").write_text("raise SystemExit(0)\n")
    with pytest.raises(ScenarioError, match="cannot be imported: SystemExit"):
        rg.run(scenario.changed({"controller.kind": f"{laws}_gone:Law"}), import_from=tmp_path)


CAMPAIGN = """
name = "named"
scenarios = ["wagon.toml"]
conditioning = "named.json"
panels = "none"
"""


def commands(folder, laws):
    """Commands by name; their files name a class of the folder `laws`."""
    wagon = registry.shelf("scenarios")["wagon"].read_text()
    assert 'kind = "slip_two_state"' in wagon
    (folder / "wagon.toml").write_text(wagon.replace('kind = "slip_two_state"', f'kind = "{laws}:Hold"'))
    (folder / "conditioning.toml").write_text(CAMPAIGN)
    (folder / "campaign.toml").write_text(CAMPAIGN.replace("conditioning =", "# conditioning ="))
    short, repeats = ["--set", "limits.horizon=0.2 s"], ["--repeats", "2"]
    return {
        "run": ["run", str(folder / "wagon.toml"), *short],
        "campaign": ["campaign", str(folder / "campaign.toml"), "--workers", "1", *short],
        "conditioning": ["tools", "conditioning", str(folder / "conditioning.toml"), "--workers", "1", *repeats],
        "estimate": ["estimate", str(LIBRARY / "wagon.toml"), "--scenario", str(folder / "wagon.toml"), "--json"],
        "observability": ["observability", str(LIBRARY / "wagon.toml"), "--scenario", str(folder / "wagon.toml")],
    }


@pytest.mark.parametrize("name", ["run", "campaign", "conditioning", "estimate", "observability"])
def test_commands_import_from_the_folders_on_their_command_line(name, laws, tmp_path, monkeypatch, command):
    """Workers of a campaign follow the same rule as the process that starts them."""
    monkeypatch.chdir(tmp_path)
    arguments = [*commands(tmp_path, laws)[name], "--out", str(tmp_path / "out")]
    assert command(*arguments).refuses("a class that a file names comes from a folder")
    assert not (tmp_path / "imported").exists()
    ended = command(*arguments, "--import-from", ".")
    assert (tmp_path / "imported").exists()
    if name == "estimate":
        units = {each["state"]: each["unit"] for each in json.loads(ended.out)["states"]}
        assert (units["group_adhesion"], units["wheelset_speed[1]"]) == ("1", "rad/s")


# Values in a wrong unit, and out of range


def long(scenario, **changes):
    return scenario.changed({"limits.horizon": "1.5 s", "controller.kind": "full_brake", **changes})


def test_sensors_that_never_read_end_the_stop(scenario):
    stop = rg.run(long(scenario), sensors=type("Blind", (Exact,), {"read": lambda self, time, truth: {}}))
    assert stop.outcome is rg.Outcome.SENSORS_FAILED
    assert "gives no reading at all" in stop.reason


class Mistaken:
    """An estimator of all from readings, with a mistake in one quantity."""

    provides = ("speed", "slip", "adhesion", "pad_friction")

    def __init__(self, **mistakes):
        self.mistakes = mistakes

    def start(self, first, formation):
        self.radius = np.array([brake.wheel_radius for brake in formation.brakes])

    def step(self, observation):
        speed = observation.speed
        slip = 1.0 - self.radius * observation.wheelset_speed / max(speed, 1.0)
        found = {"speed": speed, "slip": slip, "adhesion": 0.1 + 0.1 * slip, "pad_friction": 0.35 + 0.0 * slip}
        return rg.Estimate(
            **{name: self.mistakes.get(name, lambda value: value)(value) for name, value in found.items()}
        )


@pytest.mark.parametrize(
    ("role", "make", "words"),
    [
        # Full brake in bar, kPa, mbar, and as a share
        *(("controller", partial(Hold, factor), "it looks like") for factor in (1e-5, 1e-3, 1e-2, 1 / 3.4e5)),
        ("sensors", partial(Exact, 3.6), "it looks like km/h for m/s"),
        ("sensors", partial(Exact, -1.0), "it looks like the other sign"),
        ("estimator", partial(Mistaken, speed=lambda speed: 3.6 * speed), "it looks like km/h for m/s"),
        ("estimator", partial(Mistaken, adhesion=lambda adhesion: 100 * adhesion), "it looks like percent for a ratio"),
        # A release for a long time, and a scale error that is among the largest of radars
        ("controller", partial(Hold, 0.0), ""),
        ("controller", partial(Hold, 0.05), ""),
        ("sensors", partial(Exact, 1.05), ""),
        ("estimator", Mistaken, ""),
    ],
)
def test_a_value_in_another_unit_ends_the_stop(scenario, role, make, words):
    stop = rg.run(long(scenario), **{role: make()})
    if not words:
        assert stop.outcome is rg.Outcome.HORIZON
        return
    assert stop.outcome.value == {"estimator": "diverged"}.get(role, f"{role}_failed")
    assert words in stop.reason
    if role != "estimator":
        with pytest.raises(rg.testing.ContractBroken, match=words):
            getattr(rg.testing, f"check_{role}")(make)


@pytest.mark.parametrize(
    ("mistakes", "words"),
    [
        ({"slip": lambda slip: -slip}, "slip is 1 - r w/v, positive in braking"),
        ({"slip": lambda slip: 0.0 * slip + 0.1}, "it has not changed since the start"),
        ({"adhesion": lambda adhesion: -adhesion}, "adhesion is positive in braking"),
        ({"pad_friction": lambda friction: -friction}, "friction of pads is positive"),
        ({}, None),
    ],
)
def test_an_estimate_of_another_sign_or_that_never_changes_ends_the_stop(scenario, mistakes, words):
    """Full brake on a rail of 0.1 locks the wheels, which read a slip of 1 by then."""
    slippery = scenario.changed({"controller.kind": "full_brake", "limits.horizon": "12 s"})
    stop = rg.run(slippery, estimator=Mistaken(**mistakes))
    if words is None:
        assert stop.outcome is rg.Outcome.HORIZON, stop.reason
    else:
        assert stop.outcome is rg.Outcome.DIVERGED
        assert words in stop.reason


def test_a_train_that_speeds_up_before_it_brakes_has_a_negative_estimate(scenario):
    """A light brake on a steep fall: adhesion from the deceleration is below zero for longer than a second."""
    falling = scenario.changed(
        {"controller.kind": "full_brake", "truth.gradient": -0.04, "limits.horizon": "2 s",
         "demand.phases": [{"pressure": "0.3 bar"}]}
    )  # fmt: skip

    stop = rg.run(falling, estimator=Drag)
    assert stop.outcome is rg.Outcome.HORIZON, stop.reason
    assert stop.trace["estimate_adhesion"].values[-1].max() < -0.02


@pytest.mark.parametrize(
    "value",
    [
        np.full(4, 1e5 + 1j),
        [1e5 + 0j] * 4,
        np.ma.masked_array(np.full(4, 1e5), [1, 0, 0, 0]),
        [np.ma.masked, 1e5, 1e5, 1e5],
        ["1e5"] * 4,
        [True] * 4,
        [None] * 4,
        [10**400] * 4,
        np.full(4, 1e5).astype("m8[s]"),
        {},
    ],
)
def test_a_demand_that_is_not_a_real_number_is_refused(scenario, value):
    law = type("Law", (Hold,), {"decide": lambda self, observation: value})
    stop = rg.run(scenario, controller=law)
    assert stop.outcome is rg.Outcome.CONTROLLER_FAILED
    assert "not the demanded pressures" in stop.reason


def test_demands_beyond_the_cylinders_are_limited_counted_and_reported(scenario, tmp_path):
    full, beyond, below = (rg.run(scenario, controller=Hold(share)) for share in (1.0, 1.5, -0.5))
    decisions = full.trace.sizes["time"]
    assert full.limited_demands == 0
    assert beyond.limited_demands == below.limited_demands == decisions
    assert f"In {decisions} of {decisions} decisions" in beyond.reason
    assert "between 0 and 510000 Pa" in beyond.reason  # 1.5 times 3.4 bar
    assert np.array_equal(beyond.trace["demand"], full.trace["demand"])
    assert beyond.metrics.distance_travelled == full.metrics.distance_travelled
    beyond.write(tmp_path)
    assert json.loads((tmp_path / "stop.json").read_text())["limited_demands"] == decisions
    with rg.open(scenario) as bench:
        bench.reset()
        while not bench.ended:
            bench.step([1e6] * 4)
        assert bench.stop.limited_demands == decisions
