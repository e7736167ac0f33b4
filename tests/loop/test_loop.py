"""The loop with minimal parts: when each of them acts, and how a stop ends."""

from dataclasses import replace

import numpy as np
import pytest
from synthetic import FULL, LAYOUT, TWO_PART_TRAIN

from railgrip.scenario.adhesion import FrictionTable, TabulatedRail
from railgrip.scenario.outcome import Outcome
from railgrip.scenario.track import TrackForce
from railgrip.simulate.loop.interfaces import Clock, Parts, StateEstimator
from railgrip.simulate.loop.loop import Loop
from railgrip.simulate.loop.plausible import UNBOUNDED, Plausibility
from railgrip.simulate.sensors.ideal import IdealSensors
from railgrip.trace.recorder import Recorder
from railgrip.vehicle import signals

PERIOD = 0.01


class Block:
    """A block that brakes with 1 m/s² for every 100 kPa of mean command, over exact parabolas."""

    def __init__(self, speed: float):
        self.speed, self.distance = speed, 0.0

    def start(self, inputs):
        return self._outputs(0.0)

    def step(self, inputs):
        a = -inputs[LAYOUT.input["command"]].mean() / 1e5
        self.distance += self.speed * PERIOD + 0.5 * a * PERIOD**2
        self.speed += a * PERIOD
        return self._outputs(a)

    def _outputs(self, a):
        truth = np.zeros(LAYOUT.outputs)
        truth[LAYOUT.output["speed"]] = self.speed
        truth[LAYOUT.output["distance"]] = self.distance
        truth[LAYOUT.output["acceleration"]] = a
        truth[LAYOUT.output["wheelset_speed"]] = self.speed / 0.4
        return truth


def rail():
    """Friction that rises by 1e-6 per metre, and a force."""
    friction = np.linspace(0.1, 0.1 + 1e-4, 101)[:, None].repeat(6, axis=1)
    force = TrackForce(begins=np.array([-np.inf]), forces=np.array([5.0]), rates=np.zeros(1))
    return TabulatedRail(LAYOUT, FrictionTable(over_time=False, step=1.0, mu0_at=friction), force)


class Constant:
    def decide(self, observation):
        return (1e5,) * 4


def brake(plant, *, sensors=None, estimator=None, samples=5000, every=1):
    recorder = Recorder(
        (*signals.PLANT, *signals.PLANT_INPUTS, *signals.READINGS, *(signals.ESTIMATES if estimator else ())),
        TWO_PART_TRAIN,
        samples + 1,
    )
    parts = Parts(
        layout=LAYOUT,
        plant=plant,
        rail=rail(),
        sensors=sensors or IdealSensors(LAYOUT),
        estimator=estimator,
        controller=Constant(),
        valves=None,
        full=FULL,
        wheel_radius=(0.4,) * 4,
        clock=Clock(period=PERIOD, estimator=every, controller=1, samples=samples),
        plausibility=Plausibility(LAYOUT, PERIOD, plant.speed, UNBOUNDED),
        stop_speed=0.05,
        recorder=recorder,
    )
    return Loop(parts).run(), recorder


def test_a_block_stops_after_the_textbook_distance():
    """v²/(2a) = 50 m at 1 m/s² from 10 m/s, to one sample of travel at the stop speed and the first command's delay."""
    plant = Block(10.0)
    ended, _ = brake(plant)
    assert ended.outcome is Outcome.STANDSTILL
    assert plant.distance == pytest.approx(50.0, abs=10.0 * PERIOD + 0.05)


class Spy:
    """An estimator that stores its readings and whose first state grows by one per step."""

    def __init__(self):
        self.read = []
        self.mean, self.covariance = np.zeros(13), np.eye(13)
        self.inputs, self.readings, self.selection = np.zeros(5), np.full(6, np.nan), np.zeros(6)
        self.squared_innovation = 0.0

    def advance(self):
        self.read.append(self.readings.copy())
        self.mean[0] += 1.0
        self.mean[1:5] = 2.0 * self.mean[0]
        self.covariance[9, 9] = 4.0
        self.selection[:] = ~np.isnan(self.readings)


def state_estimator(spy):
    return StateEstimator(
        filter=spy,
        reading_places=np.array([0, 1, 2, 3, 4, 11]),
        speed=0,
        wheelset_speed=np.arange(1, 5),
        pad_friction=np.arange(5, 9),
        adhesion=np.arange(9, 13),
        wheel_radius=(0.4,) * 4,
    )


class Sparse:
    """Sensors whose train speed arrives every third sample."""

    def read(self, sample, truth):
        reading = np.zeros(LAYOUT.readings)
        reading[0] = sample if sample % 3 == 0 else np.nan
        return reading


def test_a_reading_is_used_once_and_never_lost():
    """Estimator every two samples, train speed every three: readings at 3, 9, 15 … fall between the steps.

    They arrive at the next step; a step without a new reading receives NaN.
    """
    spy = Spy()
    brake(Block(10.0), estimator=state_estimator(spy), sensors=Sparse(), samples=24, every=2)
    speeds = [readings[0] for readings in spy.read]
    assert [s for s in speeds if not np.isnan(s)] == [3, 6, 9, 12, 15, 18, 21, 24]
    assert np.isnan(speeds[0])


def test_a_row_has_the_estimate_of_its_sample():
    """Wheels turn twice as many rad/s as the train does m/s, on radii of 0.4 m: slip 0.2, but zero at standstill."""
    _, recorder = brake(Block(10.0), estimator=state_estimator(Spy()), samples=3)
    assert recorder.rows[:4, recorder.at["estimate_speed"]].tolist() == [0.0, 1.0, 2.0, 3.0]
    slips = recorder.rows[:4, recorder.columns["estimate_slip"]]
    assert slips == pytest.approx(np.array([[0.0] * 4] + [[0.2] * 4] * 3))
    assert recorder.rows[:4, recorder.at["estimate_adhesion_sd"]].tolist() == [1.0, 2.0, 2.0, 2.0]


def test_an_unknown_load_increases_the_deviation_of_adhesion():
    """The filter estimates 0.04 ± 1 for the first group, and 2 from the first step; a load wrong by half adds 0.02."""
    spy = Spy()
    spy.mean[9:13] = [0.04, 3.0, 0.0, -3.0]
    believing = replace(state_estimator(spy), load_deviation=0.5)
    _, recorder = brake(Block(10.0), estimator=believing, samples=3)
    deviations = recorder.rows[:4, recorder.columns["estimate_adhesion_sd"]]
    others = [np.hypot(1.0, 1.5), 1.0, np.hypot(1.0, 1.5)]
    assert deviations[:, 0] == pytest.approx(np.hypot([1.0, 2.0, 2.0, 2.0], 0.02), rel=1e-12)
    assert deviations[:, 1:] == pytest.approx(np.array([others] * 4), rel=1e-12)
