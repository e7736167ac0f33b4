"""Gradients and curves act on each wheelset at its place, checked against balances of energy and of forces by hand."""

import math

import numpy as np
import pytest
from energy_balance import G, stopping_distance
from small_train import BEGINNING, halved

import railgrip as rg
from railgrip.scenario.outcome import Outcome
from railgrip.simulate.run import run_stop

SPEED = 100 / 3.6
BRAKE = 0.8
"""Deceleration by the brake [m/s2]."""
BEHIND = np.array([0.0, 20.0, 90.0, 160.0, 230.0, 300.0])
LOAD = np.array([350e3, 350e3, 200e3, 200e3, 200e3, 100e3])
"""Force of each wheelset on the rail [N]: a train of 300 m with a heavy locomotive. It has as many wheelsets as the
two-part train, so that nothing is compiled."""
SHARES = LOAD / LOAD.sum()
FORMATION = {"wheelset_position": BEHIND.tolist(), "wheelset_load": LOAD.tolist()}


class ConstantBrake:
    """A train with a constant brake force at once, and no other resistance."""

    def start(self, formation, speed, period):
        self.formation, self.period, self.v, self.s = formation, period, speed, 0.0
        return self.outputs(np.zeros(formation.groups))

    def step(self, inputs):
        share = np.asarray(inputs["pressure_command"]) / self.formation.pressure_max
        slowing = min(BRAKE, G * inputs["mu0"].min()) * share.mean()
        a = float(inputs["track_force"]) * G / self.formation.load.sum() - slowing if self.v > 0 else 0.0
        step = min(self.period, self.v / -a) if a < 0 else self.period
        self.s += step * self.v + 0.5 * step**2 * a
        self.v = max(self.v + step * a, 0.0)
        return self.outputs(np.asarray(inputs["pressure_command"]), a)

    def outputs(self, pressure, a=0.0):
        wheels = self.v / self.formation.wheel_radius
        return {
            "distance": self.s, "speed": self.v, "acceleration": a, "wheelset_speed": wheels,
            "cylinder_pressure": pressure,
        }  # fmt: skip


def scenario_on(track, **tables):
    everything = {
        "start": {"speed": SPEED}, "adhesion": {"kind": "constant", "polach": "dry", "mu0": 0.4}, "track": track,
        "controller": {"kind": "full_brake"}, "estimator": {"kind": "none"}, **tables,
    }  # fmt: skip
    return rg.Scenario.load("plain").replaced(everything)


def stop(track, **formation):
    vehicle = {"plant": "TwoPartTrain", "formation": {**FORMATION, **formation}}
    return rg.run(scenario_on(track, vehicle=vehicle, periods=COARSE), plant=ConstantBrake)


SUMMIT, SAG, FALL = ((-1e3, 0.02), (0, -0.02)), ((-1e3, -0.02), (0, 0.02)), ((-1e3, -0.02),)
LEVEL = STRAIGHT = ((-1e3, 0),)
COARSE = dict.fromkeys(("communication", "estimator", "controller", "trace"), "10 ms")
LATE, HILLS = ((-1e3, 0.015), (150, -0.02)), tuple((at, 0.02 * math.cos(at)) for at in range(-400, 1200, 37))


def line(folder, rows, direction, end=2000):
    """Return [track.line] of rows of begin [m] and slope in the direction of travel, at chainage 10 km."""
    way = 1 if direction == "rising" else -1
    ends = [*(begin for begin, _ in rows[1:]), end]
    sections = sorted(
        (10_000 + way * (begin if way > 0 else to), way * slope) for (begin, slope), to in zip(rows, ends, strict=True)
    )
    last = 10_000 + (end if way > 0 else -rows[0][0])
    text = "".join(f"{at},{slope!r}\n" for at, slope in [*sections, (last, 0.0)])
    (folder / "line.csv").write_text("distance,slope\n" + text, encoding="utf-8")
    return {"line": {"file": str(folder / "line.csv"), "origin": "10 km", "direction": direction}}


def bend(begin, end):
    return [{"begin": begin, "radius": 150}, {"begin": end, "radius": 0}]


@pytest.mark.parametrize(
    ("track", "slope", "curvature"),
    [
        *((way, rows, STRAIGHT) for way in ("rising", "falling") for rows in (SUMMIT, SAG, FALL, LATE, HILLS)),
        ({"gradient": [{"begin": 0, "slope": -0.02}]}, FALL, STRAIGHT),  # behind the start as at the start
        ({"gradient": [{"begin": 150, "slope": -0.02}]}, ((-1e3, 0), (150, -0.02)), STRAIGHT),
        ({"curve": bend(100, 350)}, LEVEL, ((-1e3, 0), (100, 1 / 150), (350, 0))),
        ({"curve": bend(0, 200)}, LEVEL, ((-1e3, 1 / 150), (200, 0))),
    ],
)
def test_a_long_train_stops_where_the_energy_balance_says(tmp_path, track, slope, curvature):
    """Forces are held for 10 ms, in which the train moves by less than 0.3 m: within 0.1 m."""
    found = stop(track if isinstance(track, dict) else line(tmp_path, slope, track)).metrics.distance
    assert found == pytest.approx(stopping_distance(SPEED, BRAKE, BEHIND, SHARES, slope, curvature), abs=0.1)


def test_the_crest_and_the_fall_differ_with_the_bound_and_the_filter_likewise(tmp_path):
    """The two-part train, 34 m long: over the crest its rear brakes it at first. The filter does not know gradients."""
    distances, errors = [], []
    for rows in (SUMMIT, FALL):
        track = line(tmp_path, rows, "rising")
        found = run_stop(scenario_on(track, estimator={"kind": "decentralised"}))
        best = run_stop(scenario_on(track, controller={"kind": "ideal_bound"}, periods=COARSE))
        assert best.metrics.distance < found.metrics.distance
        distances.append((found.metrics.distance, best.metrics.distance))
        errors.append((found.metrics.speed_rmse[0], max(found.metrics.adhesion_rmse)))
    # The wheelsets are 17 m behind the first in the mean: 2 * 0.02 g * 17 m of energy, over 0.96 m/s2.
    for crest, fall in zip(*distances, strict=True):
        assert fall - crest == pytest.approx(7.0, abs=0.7)
    assert np.all(np.array(errors[0]) <= np.array(errors[1]))


def test_a_coupler_pulls_with_the_difference_of_the_gradients_of_its_cars(tmp_path):
    """Rolling over a summit, the car in front is pulled down and the one behind back: each by 22 t g sin β.

    Each car is on one bogie; their wheelsets are 24 m apart.
    """
    two_cars = tmp_path / "pair.toml"
    two_cars.write_text(halved(BEGINNING.replace("NAME", "pair")), encoding="utf-8")
    rolling = {"demand": {"phases": [{"pressure": 0}]}, "limits": {"horizon": "4 s"}}
    track = line(tmp_path, ((-1e3, 0.02), (-12.0, -0.02)), "rising")
    trace = run_stop(scenario_on(track, vehicle={"train": str(two_cars)}, start={"speed": "2 m/s"}, **rolling)).trace
    weight = 22e3 * G * np.sin(np.arctan(0.02))
    assert trace["track_force"].values == pytest.approx(0.0, abs=1e-6)
    assert trace["car_track_force"].values[:, 0] == pytest.approx(weight)
    assert trace["car_track_force"].values[:, 1] == pytest.approx(-weight)
    assert trace["coupler_force"].values[-1, 0] == pytest.approx(weight, rel=1e-3)


@pytest.mark.parametrize(
    ("track", "formation", "sentence"),
    [
        (SUMMIT, {"wheelset_position": []}, "give [vehicle.formation] wheelset_position"),
        (((-100, 0.02), (0, -0.02)), {}, "begins 100 m behind the leading wheelset, and the last one is 300 m"),
        (((0, 0.02), (200, -0.02)), {}, "begins 0 m behind the leading wheelset, and the last one is 300 m"),
        (FALL, {"wheelset_position": []}, ""),
        (((-100, 0.02),), {}, ""),
        (SUMMIT, {}, ""),
    ],
)
def test_a_track_that_is_not_known_under_the_train_is_remarked(tmp_path, track, formation, sentence):
    found = stop(line(tmp_path, track, "rising"), **formation)
    assert found.outcome is Outcome.STANDSTILL
    remarks = [remark for remark in found.remarks if "leading wheelset" in remark]
    assert len(remarks) == bool(sentence)
    assert all(sentence in remark for remark in remarks)
