"""Every train of the library stops with every mechanics and contact: loads, energy and outcome are those of physics.

`make fuzz` runs all of them; RAILGRIP_FUZZ is their number. The tests run one train on an even and an uneven rail.
"""

import os
from functools import cache
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from maxima_stops import energy_error

import railgrip as rg
from railgrip.base.registry import shelf
from railgrip.base.units import GRAVITY
from railgrip.rolling_stock.schema import load_train
from railgrip.scenario.file import merge
from railgrip.scenario.load import scenario_of
from railgrip.scenario.outcome import Outcome
from railgrip.studies.type_test.entrants import train_of

TRAINS = {
    "TwoPartTrain": 160, "TwoPartTrainPneumatic": 160, "Wagon": 100, "tram": 70, "vt642": 120, "emu387": 160,
    "loco_coaches": 160,
}  # fmt: skip
"""Train → largest speed of its stops [km/h]."""

TWO_PARTS = (13400.0, 14100.0, 14500.0, 14500.0, 14100.0, 13400.0)
MASSES = {"TwoPartTrain": TWO_PARTS, "TwoPartTrainPneumatic": TWO_PARTS, "Wagon": (20e3, 20e3)}
"""Mass on each wheelset of the trains that are classes of the library [kg]."""

MECHANICS = ("simple", "detailed")
"""The rail of the detailed one is uneven, except under the wagon, whose wheelsets have no springs."""

CONTACTS = ("dry", "wet", "wet_two_maxima", "leaves_two_maxima")
"""Creep curves; friction of those with two maxima falls with heat and recovers where slip cleans the rail."""

SPEEDS = (0.2, 0.4, 0.6, 0.8, 1.0)
"""Speeds at the start, as shares of the largest."""

BRAKE = {"kind": "full_brake"}
RELEASE = {"phases": [{"pressure": "1.5 bar", "until": {"duration": "2 s"}}, {"pressure": 0}]}

CASES = {
    "dry": {"adhesion": {"mu0": 0.3}, "controller": BRAKE, "limits": {"horizon": "150 s"}},
    "slippery": {
        "adhesion": {"mu0": 0.08},
        "controller": {"kind": "slip_two_state"},
        "limits": {"horizon": "12 s"},
    },
    "release": {"adhesion": {"mu0": 0.3}, "controller": BRAKE, "demand": RELEASE, "limits": {"horizon": "9 s"}},
    "standstill": {"adhesion": {"mu0": 0.15}, "controller": BRAKE, "limits": {"horizon": "150 s"}},
}
"""Case → tables; the last one begins at a tenth of the speed."""

COACHES = 2
"""Coaches of the locomotive: the FMU of all ten takes a quarter of an hour to build, and they are alike."""

ALL = sorted(product(TRAINS, MECHANICS, CONTACTS, SPEEDS, CASES), key=repr)
SAMPLE = [
    ("TwoPartTrain", "simple", "wet", 0.6, "slippery"),
    ("TwoPartTrain", "detailed", "wet", 0.6, "slippery"),
    ("TwoPartTrain", "detailed", "dry", 1.0, "release"),
    ("TwoPartTrain", "detailed", "dry", 0.4, "standstill"),
]


def drawn():
    """Return the stops to run: the sample, or as many of all as RAILGRIP_FUZZ says."""
    number = int(os.environ.get("RAILGRIP_FUZZ", "0"))
    order = np.random.default_rng(1).permutation(len(ALL))[:number]
    # In the order of the trains, so that each of them is compiled once while it is in use.
    return [ALL[place] for place in sorted(order)] or SAMPLE


@cache
def train_table(train, folder):
    """Return tables of the train, and the mass on each wheelset [kg]."""
    if train in MASSES:
        return train_of(train), np.array(MASSES[train])
    text = shelf("trains")[train].read_text(encoding="utf-8")
    if train == "loco_coaches":
        text = text[: text.index(f'[[cars]]\nname = "Bpmz-{COACHES + 1}"')]
        before, _, after = text.rpartition('coupler = "screw"\n')
        text = before + after
    path = Path(folder) / f"{train}.toml"
    path.write_text(text, encoding="utf-8")
    return train_of(str(path)), np.array([axle.mass for axle in load_train(path).axles])


def stop_of(folder, train, mechanics, contact, share, case):
    """Return a stop, and the static load of each wheelset [N]."""
    table, masses = train_table(train, folder)
    speed = TRAINS[train] * share * (0.1 if case == "standstill" else 1.0)
    changes = {
        "name": "stop",
        "start": {"speed": f"{speed} km/h"},
        "truth": {"mechanics": mechanics},
        "adhesion": {"kind": "constant", "polach": contact},
        "estimator": {"kind": "none"},
        "sensors": {"kind": "ideal"},
    }
    if train != "TwoPartTrainPneumatic":
        changes["actuation"] = {"kind": "ideal"}
    tables = merge(merge(table, changes), CASES[case])
    return rg.run(scenario_of(tables, directory=Path(), origin="test")), masses * GRAVITY


@pytest.mark.parametrize("stop", drawn(), ids=lambda stop: "-".join(map(str, stop)))
def test_loads_and_energy_of_a_stop_are_those_of_physics(stop, tmp_path_factory):
    folder = tmp_path_factory.getbasetemp()
    result, static = stop_of(str(folder), *stop)
    check(result, static, mechanics=stop[1], case=stop[4], has_energy=stop[0] != "Wagon")


def check(result, static, *, mechanics, case, has_energy):
    """Check outcome, loads and energy of a stop; the wagon does not count its energy."""
    assert result.outcome in {Outcome.STANDSTILL, Outcome.HORIZON}, result.outcome
    assert case in {"release", "slippery"} or result.outcome is Outcome.STANDSTILL
    time, load = result.trace["time"].values, result.trace["wheelset_load"].values
    assert load.min() > 0
    if has_energy:
        # The tolerance of the solver is 1e-5 per step, with errors of either sign; a train of many cars sums them.
        assert energy_error(result) < 5e-5
    # Momentum: the impulse of the loads over the weight is that of frames and wheelsets moving vertically, a third of
    # the mass, at up to 0.15 m/s on the uneven rail. On an even one nothing moves them up or down.
    moved = 0.33 * 2 * 0.15 / GRAVITY / time[-1] if mechanics == "detailed" else 0.0
    total = np.trapezoid(load.sum(axis=1), time) / time[-1]
    assert total == pytest.approx(static.sum(), rel=1e-6 + moved)
    if case == "release" and time[-1] > 6.0:  # a slow tram stands before its brakes are released
        # The running resistance still loads the front, and the impulse of the uneven rail over 3 s adds 0.4 %.
        released = load[time > time[-1] - 3.0].mean(axis=0)
        assert released == pytest.approx(static, rel=0.01)
