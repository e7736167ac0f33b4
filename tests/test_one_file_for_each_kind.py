"""A new law, creep curve, kind of sensors, fault, filter or dynamic brake is one file, found by its name."""

import importlib
import sys
import tomllib
from textwrap import dedent

import pytest

import railgrip as rg
from railgrip.base import registry
from railgrip.rolling_stock.calculation import mean_stop
from railgrip.rolling_stock.calculation_page import calculation_page
from railgrip.rolling_stock.check import findings
from railgrip.rolling_stock.modelica import class_text
from railgrip.rolling_stock.schema import load_train, train_of
from railgrip.rolling_stock.stopping import developed_forces
from railgrip.rolling_stock.tables import sentence_of_equipment
from railgrip.simulate.estimator import body_force_of

LAW = '''
    """A share of full pressure."""

    from dataclasses import dataclass
    from typing import Annotated

    from railgrip.controllers.law import GroupLaw, Tuning


    @dataclass(frozen=True, slots=True, kw_only=True)
    class ShareTuning(Tuning):
        share: Annotated[float, "1", "of full pressure"]


    class Share(GroupLaw):
        description = "A share of full pressure"
        tuning = ShareTuning

        @classmethod
        def demand(cls, draft, tuning, group):
            return tuning["share"] * group.brake["pressure_max"]
'''

SENSORS = '''
    """Speeds in whole steps."""

    from typing import Literal

    import numpy as np

    from railgrip.simulate.sensors.ideal import Ideal


    class Coarse(Ideal):
        kind: Literal["coarse"]
        step: float

        def open(self, scenario, layout, wheel_radius):
            places, step = super().open(scenario, layout, wheel_radius).places, self.step

            class Rounded:
                def read(self, sample, truth):
                    reading = truth.take(places)
                    at = layout.reading["speed"]
                    reading[at] = np.round(reading[at] / step) * step
                    return reading

            return Rounded()
'''

FAULT = '''
    """A wheel speed that is too low by as much for all."""

    from typing import Literal

    from railgrip.scenario.faults import Fault


    class Slack(Fault):
        part: Literal["belt"]
        kind: Literal["slack"]
        share: float

        def act_on(self, site):
            at = site.layout.reading["wheelset_speed"]
            for place in range(at.start, at.stop):
                site.change_reading("scaled", place, value=1.0 - self.share)
'''

FILTER = '''
    """A filter that believes its first reading for good."""

    import numpy as np

    from railgrip.estimators.design import FilterKind


    class Stubborn(FilterKind):
        form, squared_innovation = "equations", 0.0

        @classmethod
        def of_context(cls, task):
            self = cls()
            self.mean, self.covariance = np.array(task.mean), np.diag(np.ones(task.mean.size))
            self.inputs = np.zeros(len(task.prediction.inputs))
            self.readings = np.full(len(task.prediction.outputs), np.nan)
            self.selection = np.zeros(self.readings.size)
            return self

        def advance(self):
            pass
'''

HYDRODYNAMIC = '''
    """Hydrodynamic brakes: force over the square of the speed."""

    from typing import ClassVar, Literal

    import numpy as np

    from railgrip.rolling_stock.brakes import AxleBrake


    class Hydrodynamic(AxleBrake):
        component: ClassVar[str] = "HydrodynamicBrake"
        kind: Literal["hydrodynamic"]
        speed_rise: float
        speed_of_force = property(lambda self: self.speed_rise)

        def law(self, units):
            return f"v_rise={self.speed_rise}"

        def force_at(self, speed, units=1.0, load=np.inf):
            return units * self.force * np.minimum((speed / self.speed_rise) ** 2, 1.0) * self.fade(speed)
'''

AERODYNAMIC = '''
    """Aerodynamic brakes: air resistance of flaps."""

    from typing import ClassVar, Literal

    from railgrip.rolling_stock.brakes import DynamicBrake, RailBrake


    class Aerodynamic(DynamicBrake, RailBrake):
        component: ClassVar[str] = "AerodynamicBrake"
        instance: ClassVar[str] = "flaps"
        kind: Literal["aerodynamic"]
        drag_area: float
        performance = property(lambda self: f"{self.drag_area:g} m2")
        parameters = property(lambda self: f"A={self.drag_area}, T={self.time_constant}")

        def force_at(self, speed, *, within=None):
            return 0.6 * self.drag_area * speed**2

        def largest(self):
            return self.force_at(100.0)
'''

FILES = {
    (registry.LAWS, "share.py"): LAW,
    (registry.LAWS, "share.toml"): "[ideal.read]\nshare = 0.4\n",
    (registry.CREEP_CURVES, "moss.toml"): 'k_A = 0.2\nk_S = 0.1\nA = 0.4\nB = 0.1\nsource = "made up"\n',
    (registry.SENSORS, "coarse.py"): SENSORS,
    (registry.FAULTS, "belt.py"): FAULT,
    (registry.FILTERS, "stubborn.py"): FILTER,
    (registry.DYNAMIC_BRAKES, "hydrodynamic.py"): HYDRODYNAMIC,
    (registry.DYNAMIC_BRAKES, "aerodynamic.py"): AERODYNAMIC,
}


@pytest.fixture
def more(tmp_path, monkeypatch):
    """An additional folder in each package, with one file for each kind."""
    for (package, name), text in FILES.items():
        folder = tmp_path / package
        folder.mkdir(exist_ok=True)
        for file in (name, f"copy of {name}"):
            (folder / file).write_text(dedent(text).lstrip(), encoding="utf-8")
        module = importlib.import_module(package)
        if str(folder) not in module.__path__:
            monkeypatch.setattr(module, "__path__", [*module.__path__, str(folder)])
    yield
    for package, name in FILES:
        sys.modules.pop(f"{package}.{name.partition('.')[0]}", None)


PLAIN = {"start.speed": "30 km/h", "controller.kind": "share", "estimator.kind": "none", "adhesion.polach": "dry"}


def run(**changes):
    return rg.run(rg.Scenario.load("plain").changed({**PLAIN, **changes}))


def test_copies_that_an_editor_leaves_are_no_kinds(more):
    found = [name for kind in registry.SECTIONS for name in registry.names(kind)]
    assert {"share", "coarse", "moss"} <= {*found, *registry.modules(registry.SENSORS)}
    assert [name for name in found if name.startswith("copy of")] == []


def test_each_kind_is_used_in_a_stop_by_its_name(more):
    plain = run()
    assert plain.outcome is rg.Outcome.STANDSTILL
    assert plain.scenario.resolved()["controller"]["kind"] == "share"
    harder = run(**{"controller.parameters.share": 0.8})
    assert harder.metrics.distance < plain.metrics.distance
    assert run(**{"adhesion.polach": "moss"}).scenario.adhesion.polach.k_A == 0.2

    coarse = run(sensors={"kind": "coarse", "step": 0.5}).trace["reading_speed"].values
    assert set(coarse % 0.5) == {0.0}
    slack = run(faults=[{"part": "belt", "kind": "slack", "share": 0.1, "end": "1 s"}]).trace
    shares = slack["reading_wheelset_speed"] / slack["wheelset_speed"]
    assert shares.sel(time=0.5, method="nearest").values == pytest.approx(0.9)
    assert shares.sel(time=1.5, method="nearest").values == pytest.approx(1.0)
    speeds = run(**{"estimator.kind": "stubborn"}).trace["estimate_speed"].values
    assert speeds[-1] == pytest.approx(30 / 3.6)


BRAKE = {"time_constant": "0.5 s", "estimated": True}
FLAPS = BRAKE | {"kind": "aerodynamic", "drag_area": 8.0}
RETARDER = BRAKE | {
    "kind": "hydrodynamic", "force": "12 kN", "speed_full": "10 km/h", "speed_end": "4 km/h", "speed_rise": 9.0,
    "blending": "added", "slide_limit": 0.1,
}  # fmt: skip
TRAM = registry.shelf("trains")["tram"]


def train_with(**brakes):
    """Return a tram, whose two bogies have magnets, with dynamic brakes in the bogies of these names."""
    tables = tomllib.loads(TRAM.read_text(encoding="utf-8"))
    for (name, brake), bogie in zip(brakes.items(), tables["cars"][0]["bogies"], strict=False):
        tables.setdefault("dynamic_brakes", {})[name] = brake
        tables["bogies"][name] = tables["bogies"]["motor"] | {"dynamic_brake": name}
        bogie["kind"] = name
    return train_of(tables, "tram.toml")


def test_kinds_of_brakes_are_in_plant_calculation_page_check_and_filter(more):
    train = train_with(retarder=RETARDER, flaps=FLAPS)
    equipment = "retarder on 1 bogies: hydrodynamic, 12 kN up to or at 32 km/h, off at 4 km/h; flaps on 1 bogies: "
    assert f"{equipment}aerodynamic, 8 m2" in sentence_of_equipment(train)
    assert not any("[dynamic_brakes" in str(found) for found in findings(train))
    text = class_text(train, pneumatic=True)
    assert "HydrodynamicBrake dynamic2(\n    F_max=12000.0, v_rise=9.0, v_full=" in text
    assert "AerodynamicBrake flaps3(\n    A=8.0, T=0.5);" in text
    assert "flaps3.demand = noEvent(if applied and brake_demand >= 1 then flaps3.available else 0);" in text
    assert "der(dynamic_work) = motor1.power + motor2.power + flaps3.force*body1.v;" in text
    found, magnets = (developed_forces(each, 20.0)(20.0) for each in (train, load_train(TRAM)))
    assert found.dynamic.sum() == pytest.approx(2 * 12e3)
    assert found.rail.sum() - magnets.rail.sum() == pytest.approx(0.6 * 8.0 * 20.0**2)
    stop = mean_stop(train, 50 / 3.6)
    assert stop.distance < stop.distance_without_dynamic
    calculation_page(train, [stop], origin="tram.toml", digest="")
    force = body_force_of(train, 0.02)
    assert [force.call([20.0, 1.0, 1.0, 1.0])[0] for _ in range(500)][-1] == pytest.approx(found.rail.sum(), rel=1e-4)


def test_a_wrong_key_is_refused_with_the_keys_of_its_kind(more):
    with pytest.raises(rg.RailgripError, match=r"\[dynamic_brakes.new\] has no key 'drag'; did you mean 'drag_area'"):
        train_with(new=FLAPS | {"drag": 1.0})
    with pytest.raises(rg.RailgripError, match=r"has no key 'hydrodynamic'; brakes of the kind 'hydrodynamic' under"):
        run(hydrodynamic={})
    with pytest.raises(rg.RailgripError, match=r"\[sensors\] has no key 'stp'; did you mean 'step'"):
        run(sensors={"kind": "coarse", "stp": 0.5})
    with pytest.raises(rg.RailgripError, match=r"has no parameter 'sharr'; did you mean 'share'"):
        run(**{"controller.parameters.sharr": 0.8})
    with pytest.raises(rg.RailgripError, match=r"\[faults\[1\]\] has no 'share'"):
        run(faults=[{"part": "belt", "kind": "slack"}])


def test_without_its_file_a_kind_does_not_exist():
    with pytest.raises(rg.RailgripError, match=r"\[dynamic_brakes.new\] kind is 'aerodynamic'; there is eddy_current"):
        train_with(new=FLAPS)
    with pytest.raises(rg.RailgripError, match=r"\[controller\] kind is 'share'; there is adhesion_based"):
        run()
