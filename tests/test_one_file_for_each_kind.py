"""A new law, creep curve, kind of sensors, fault or filter is one file in its folder: the registry finds it by name."""

import importlib
import sys
from textwrap import dedent

import pytest

import railgrip as rg
from railgrip.base import registry

LAW = '''
    """A share of full pressure."""

    from dataclasses import dataclass
    from typing import Annotated, ClassVar

    from railgrip.controllers.law import GroupLaw, Tuning


    @dataclass(frozen=True, slots=True, kw_only=True)
    class ShareTuning(Tuning):
        share: Annotated[float, "1", "of full pressure"]

        LAW: ClassVar[str] = "Share"


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
                site.change_reading("scaled", place, 1.0 - self.share)
'''

FILTER = '''
    """A filter that believes its first reading for good."""

    import numpy as np

    from railgrip.estimators.design import FilterKind


    class Stubborn(FilterKind):
        squared_innovation = 0.0

        @classmethod
        def start(cls, task):
            self = cls()
            self.mean, self.covariance = np.array(task.mean), np.diag(np.ones(task.mean.size))
            self.inputs = np.zeros(len(task.prediction.inputs))
            self.readings = np.full(len(task.prediction.outputs), np.nan)
            self.selection = np.zeros(self.readings.size)
            return self

        def advance(self):
            pass
'''

FILES = {
    (registry.LAWS, "share.py"): LAW,
    (registry.LAWS, "share.toml"): "[ideal.read]\nshare = 0.4\n",
    (registry.CREEP_CURVES, "moss.toml"): 'k_A = 0.2\nk_S = 0.1\nA = 0.4\nB = 0.1\nsource = "made up"\n',
    (registry.SENSORS, "coarse.py"): SENSORS,
    (registry.FAULTS, "belt.py"): FAULT,
    (registry.FILTERS, "stubborn.py"): FILTER,
}


@pytest.fixture
def more(tmp_path, monkeypatch):
    """An additional folder in each package, with one file for each kind."""
    for (package, name), text in FILES.items():
        folder = tmp_path / package
        folder.mkdir(exist_ok=True)
        (folder / name).write_text(dedent(text).lstrip(), encoding="utf-8")
        module = importlib.import_module(package)
        if str(folder) not in module.__path__:
            monkeypatch.setattr(module, "__path__", [*module.__path__, str(folder)])
    yield
    for package, name in FILES:
        sys.modules.pop(f"{package}.{name.partition('.')[0]}", None)


PLAIN = {"start.speed": "30 km/h", "controller.kind": "share", "estimator.kind": "none", "adhesion.polach": "dry"}


def run(**changes):
    return rg.run(rg.Scenario.load("plain").changed({**PLAIN, **changes}))


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


def test_a_wrong_key_is_refused_with_the_keys_of_its_kind(more):
    with pytest.raises(rg.RailgripError, match=r"\[sensors\] has no key 'stp'; did you mean 'step'"):
        run(sensors={"kind": "coarse", "stp": 0.5})
    with pytest.raises(rg.RailgripError, match=r"has no parameter 'sharr'; did you mean 'share'"):
        run(**{"controller.parameters.sharr": 0.8})
    with pytest.raises(rg.RailgripError, match=r"\[faults\[1\]\] has no 'share'"):
        run(faults=[{"part": "belt", "kind": "slack"}])


def test_without_its_file_a_kind_does_not_exist():
    with pytest.raises(rg.RailgripError, match=r"\[controller\] kind is 'share'; there is adhesion_based"):
        run()
