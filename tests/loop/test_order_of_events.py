"""The order of events in a stop: the loop is bit-identical to `reference`.

Also where parts fail, and where blocks of samples end.
"""

import math
from dataclasses import replace
from fractions import Fraction
from itertools import product

import kernel_calls
import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from kernel_calls import along_track, holds, phase_of, service_sensors
from rails import outputs
from reference import brake
from sampling import FUZZ
from synthetic import FULL, GROUP, LAYOUT, TWO_PART_TRAIN
from wrong import table

from railgrip.base.errors import Failure, LoopError, PlantFailed
from railgrip.controllers.law import Law, law
from railgrip.controllers.laws.slip_three_state import SlipThreeState
from railgrip.controllers.laws.slip_two_state import SlipTwoState
from railgrip.controllers.sampled import choose
from railgrip.controllers.train_level import pass_through, with_redistribution
from railgrip.controllers.valves import ValveLogic, ValveModel
from railgrip.scenario.adhesion import FrictionTable, TabulatedRail
from railgrip.scenario.demand import Driver
from railgrip.scenario.outcome import Outcome
from railgrip.scenario.surface import Recovery, SlipEnergy
from railgrip.scenario.track import TrackForce
from railgrip.simulate.faults.site import Faults
from railgrip.simulate.loop import loop
from railgrip.simulate.loop.interfaces import Clock, Parts, StateEstimator
from railgrip.simulate.loop.loop import Loop
from railgrip.simulate.loop.plausible import Plausibility, Slowing, slowing_of
from railgrip.simulate.sensors import service, white
from railgrip.simulate.sensors.ideal import IdealSensors
from railgrip.simulate.sensors.white import WhiteSensors
from railgrip.simulate.value_checks import DemandLimits
from railgrip.trace.recorder import Recorder
from railgrip.vehicle import signals

BLOCK = 256
"""Samples in a block: fewer than in a stop, so that a few hundred samples reach over its end."""


@pytest.fixture(autouse=True, scope="module")
def _short_blocks():
    with pytest.MonkeyPatch.context() as patch:
        for module in (kernel_calls, loop, service, white):
            patch.setattr(module, "BLOCK", BLOCK)
        yield


RADIUS = (0.38,) * 4
LAID = 0.5, 0.1
GROUPS = (GROUP,) * 4


def in_service():
    """Return service sensors of all errors, on a slope and an uneven rail."""
    factor, heights = np.array([1.003, 1.002, np.nan, 1.001]), np.random.default_rng(7).normal(0.0, 1e-3, 2200)
    return service_sensors(
        {
            "speed_factor": factor, "speed_factors": 4, "acceleration_bias": 0.05,
            "gravity": along_track(-1.0, 0.5, np.linspace(-0.2, 0.2, 9)), "rail": along_track(-40.0, 0.02, heights),
            "position": np.array(TWO_PART_TRAIN.wheelset_position), "forward": np.array([0.9, -1.8, 0.9]),
            "back": np.array([-1.8, 0.85]), "filter_state": np.zeros((6, 2)),
            "offset_steps": np.array([1e3, -2e3, 30.0, 4e3]) / 244.0,
        }
    )  # fmt: skip


ANY_TRAIN = Slowing(lightest=1e9, heaviest=np.inf, constant=12.0, quadratic=0.0)
"""Bounds of the deceleration that any friction and force satisfy."""
TRAIN = slowing_of(84e3, is_known=True)


class Plant:
    """Decelerates uniformly, rolls back a little at first, slides now and then; noisy.

    `wrong` is a function of sample and truth that modifies the outputs.
    """

    def __init__(self, *, speed=20.0, slowing=0.8, fails_at=None, lacks=(), wrong=None):
        self.speed, self.slowing, self.fails_at, self.wrong = speed, slowing, fails_at, wrong
        self.random, self.sample, self.given = np.random.default_rng(7), 0, []
        here = np.ones(LAYOUT.outputs, dtype=bool)
        for name in lacks:
            here[LAYOUT.output[name]] = False
        self.present = np.flatnonzero(here)

    def start(self, inputs):
        return self._truth(inputs)

    def step(self, inputs):
        if self._moves(inputs):
            return self._truth(inputs)
        raise self._failure()

    def _moves(self, inputs):
        self.given.append(inputs.copy())
        self.sample += self.sample + 1 != self.fails_at
        return len(self.given) == self.sample

    def _failure(self):
        return PlantFailed(Failure(file="made.fmu", time=self.sample * 1e-3, reason="error", call="fmi2DoStep"))

    def _truth(self, inputs):
        k, truth = self.sample, np.zeros(LAYOUT.outputs)
        time = 1e-3 * k
        speed = self.speed - self.slowing * time
        rolled = self.speed * time - self.slowing * time**2 / 2
        truth[LAYOUT.output["distance"]] = rolled + 1e-3 * inputs[LAYOUT.input["mu0"]].sum() - (5e-3 if k < 3 else 0.0)
        truth[LAYOUT.output["speed"]] = speed
        truth[LAYOUT.output["acceleration"]] = -self.slowing + 0.1 * self.random.standard_normal()
        truth[LAYOUT.output["wheelset_speed"]] = speed / 0.38 * (1 - 0.2 * np.abs(np.sin(0.01 * k + np.arange(4))))
        truth[LAYOUT.output["cylinder_pressure"]] = (
            1e5 + 0.3 * inputs[LAYOUT.input["command"]] + 1e3 * self.random.standard_normal(4)
        )
        if self.wrong:
            self.wrong(k, truth)
        whole = np.full(LAYOUT.outputs, np.nan)
        whole[self.present] = truth[self.present]
        return whole


class Filter:
    """Counts calls, records its inputs, and fails, or returns a negative variance, at a given call."""

    def __init__(self, fails_at=None, negative_at=None):
        self.fails_at, self.negative_at, self.calls = fails_at, negative_at, 0
        self.mean, self.covariance = 0.1 * np.arange(1.0, 14.0), np.eye(13)
        self.inputs, self.readings, self.selection = np.zeros(5), np.zeros(6), np.zeros(6)

    @property
    def squared_innovation(self):
        return 0.1 * self.calls

    def advance(self):
        self.calls += 1
        if self.calls == self.fails_at:
            raise ArithmeticError("Made up: no.")
        known = np.where(np.isnan(self.readings), -1.0, self.readings)
        self.selection[:] = ~np.isnan(self.readings)
        self.mean[:6] += 1e-3 * (known - self.mean[:6])
        self.mean[6:10] += 1e-9 * self.inputs[:4]
        self.covariance[12, 12] = -1.0 if self.calls == self.negative_at else 2.0


def state_estimator(filter_):
    names = "speed", "wheelset_speed", "acceleration"
    seen = np.concatenate([np.arange(LAYOUT.reading[name].start, LAYOUT.reading[name].stop) for name in names])
    places = {"wheelset_speed": 1, "pad_friction": 5, "adhesion": 9}
    return StateEstimator(
        filter=filter_,
        reading_places=seen,
        speed=0,
        wheel_radius=RADIUS,
        load_deviation=0.1,
        **{n: at + np.arange(4) for n, at in places.items()},
    )


def law_that_ends(calls):
    """Return a law that returns numbers for a given number of calls, and then NaN."""

    def demands(draft, tuning, train):
        left = draft.state("left", "1", "calls", start=float(calls))
        draft.keep(left, left - 1.0)
        return [choose(left > 0.0, 1e5, float("nan")) for _ in train]

    return Law(law("Ending", "Gives up", 4, demands), GROUPS, {})


STEPS = TrackForce(
    begins=np.array([-np.inf, 0.5, 3.0, 3.0001]),
    forces=np.array([0.0, 1e3, -2e3, 5e2]),
    rates=np.array([0, 0, 7e3, -3e2]),
)


SLIP = lambda: SlipTwoState(GROUPS, SlipTwoState.load_tuning("ideal", "read", "paper"))
HOLD = lambda: SlipThreeState(GROUPS, SlipThreeState.load_tuning("ideal", "read", "paper"))
VALVES = ValveModel(period=1e-3, dead_time=0.004, fill_time=0.4, vent_time=0.2, band=6e3, pulse_min=0.02)


SENSORS = {
    "ideal": lambda: IdealSensors(LAYOUT),
    "white": lambda: WhiteSensors(
        IdealSensors(LAYOUT).places,
        np.linspace(0.99, 1.01, LAYOUT.readings),
        np.full(LAYOUT.readings, 1e-3),
        np.full(LAYOUT.readings, 1e-2),
        np.random.default_rng(5),
    ),
    "service": in_service,
}


def parts_of(
    plant, controller, filter_, *, samples, sensors, valves, every, over_time, start_speed=None, phases=None,
    slip_energy=lambda: None, broken=((), ()), sensing=1, bounds=ANY_TRAIN,
):  # fmt: skip
    recorder = Recorder(
        (
            *(*signals.PLANT, *signals.PLANT_INPUTS, *signals.READINGS, *signals.CONTROLLER_DEMAND),
            *(() if phases is None else signals.DRIVER_DEMAND),
            *(signals.ESTIMATES if filter_ else ()),
        ),
        TWO_PART_TRAIN,
        samples + 1,
    )
    faults = Faults(LAYOUT, valves=valves, noise_rate=1)
    for add, changes in zip((faults.add_reading, faults.add_command), broken, strict=True):
        for change in changes:
            add(**change)
    friction = np.random.default_rng(3).uniform(0.02, 0.2, (200, 6))
    table = FrictionTable(over_time=over_time, step=5e-3, mu0_at=friction)
    return Parts(
        layout=LAYOUT,
        plant=plant,
        rail=TabulatedRail(LAYOUT, table, STEPS, slip_energy()),
        sensors=SENSORS[sensors](),
        estimator=state_estimator(filter_) if filter_ else None,
        controller=controller,
        valves=ValveLogic([3.4e5] * 4, VALVES) if valves else None,
        full=FULL,
        driver=None
        if phases is None
        else Driver(LAYOUT, 1e-3, full=FULL, release_pressure=np.full(4, 3e4), phases=phases),
        faults=faults or None,
        wheel_radius=RADIUS,
        clock=Clock(period=1e-3, estimator=every[0], controller=every[1], samples=samples, sensors=sensing),
        plausibility=Plausibility(LAYOUT, 1e-3, start_speed or plant.speed, bounds),
        stop_speed=0.1,
        recorder=recorder,
    )


class InPython:
    """A law that the loop does not call from C."""

    def __init__(self, law):
        self.law = law

    def decide(self, observation):
        return self.law.decide(observation)


def by_the_loop(parts):
    try:
        end = Loop(parts).run()
    except PlantFailed as failed:
        return Outcome.PLANT_FAILED, str(failed), parts.recorder.written
    assert end.samples == parts.recorder.written
    return end.outcome, end.reason, end.samples


def same(plant=Plant, controller=SLIP, filter_=None, keep=None, **changed):
    """Return how a stop ends: in the loop with its law in C, with it in Python, and in the reference."""
    setup = dict(samples=BLOCK + 40, sensors="service", valves=False, every=(1, 1), over_time=True) | changed
    ends, bits = [], []
    for run, wrap in ((by_the_loop, lambda law: law), (by_the_loop, InPython), (brake, lambda law: law)):
        train, law = plant(), controller()
        parts = parts_of(train, wrap(law), filter_() if filter_ else None, **setup)
        ends.append(run(parts))
        recorder, written = parts.recorder, ends[-1][-1]
        bits.append(
            [recorder.rows[:written, place].tobytes() for place in recorder.columns.values()]
            + [np.array(train.given).tobytes(), law.state.tobytes()]
        )
        if keep and run is not brake:
            keep(recorder)
    assert ends[0] == ends[1]
    assert (ends[0][0], ends[0][2]) == ends[2]
    assert bits[0] == bits[1] == bits[2]
    return ends[0]


@pytest.mark.parametrize("every", [(1, Fraction(5, 2)), (Fraction(5, 2), Fraction(7, 3)), (Fraction(40, 3), 13)])
@pytest.mark.parametrize("controller", [SLIP, lambda: law_that_ends(10**6)])
def test_periods_that_are_not_whole_numbers_of_samples(every, controller):
    samples = 300
    calls = []

    class Counting(InPython):
        def decide(self, observation):
            calls.append(round(observation.time / 1e-3))
            return super().decide(observation)

    setup = dict(samples=samples, sensors="service", valves=True, every=every, over_time=True)
    same(controller=controller, filter_=Filter, **setup)
    Loop(parts_of(Plant(), Counting(controller()), Filter(), **setup)).run()
    assert calls == sorted({math.ceil(n * every[1]) for n in range(samples + 1)} & set(range(samples + 1)))


@pytest.mark.parametrize("samples", [1, BLOCK - 1, BLOCK, BLOCK + 1, 2 * BLOCK])
def test_horizons_at_the_seams_of_a_block(samples):
    outcome, _, written = same(samples=samples)
    assert (outcome, written) == (Outcome.HORIZON, samples + 1)


@pytest.mark.parametrize("sample", [1, 100, BLOCK - 1, BLOCK, BLOCK + 1])
def test_a_plant_that_fails(sample):
    """The rows before are kept; the failing call is the step from the sample before."""
    outcome, reason, written = same(lambda: Plant(fails_at=sample))
    assert (outcome, written) == (Outcome.PLANT_FAILED, sample)
    assert f"at {(sample - 1) * 1e-3:.9g} s" in reason


@pytest.mark.parametrize("sample", [0, 1, BLOCK - 1, BLOCK, BLOCK + 1])
def test_a_train_at_standstill(sample):
    outcome, _, written = same(lambda: Plant(speed=0.1 + 0.8e-3 * (sample - 0.5)), filter_=Filter)
    assert (outcome, written) == (Outcome.STANDSTILL, sample + 1)


@pytest.mark.parametrize("valves", [False, True])
@pytest.mark.parametrize("calls", [0, 100, BLOCK, BLOCK + 1])
def test_a_law_that_returns_nan(calls, valves):
    """Also where valve logic could hold the pressure."""
    outcome, reason, written = same(controller=lambda: law_that_ends(calls), valves=valves)
    assert (outcome, written) == (Outcome.CONTROLLER_FAILED, calls + 1)
    assert "is (nan, nan, nan, nan), not 4 numbers" in reason


class Wild:
    """Demands far below zero and above the maximum cylinder pressure."""

    def __init__(self):
        self.random = np.random.default_rng(5)

    def decide(self, observation):
        return self.random.uniform(-2e5, 6e5, 4)


@pytest.mark.parametrize("every", [(1, 1), (2, 3)])
def test_demands_are_limited_before_the_train_level_decides(every):
    demands, limits = [], DemandLimits(replace(TWO_PART_TRAIN, brakes=GROUPS))
    demand = phase_of(pressure=2e5)
    setup = dict(samples=BLOCK, sensors="ideal", valves=False, every=every, over_time=True, phases=demand)
    for run in (by_the_loop, brake):
        over = with_redistribution(pass_through(GROUPS), GROUPS, period=1e-3, adhesion_max=0.2)
        parts = replace(parts_of(Plant(), Wild(), None, **setup), limits=limits, train_level=over)
        run(parts)
        demands.append(parts.recorder.rows[:, parts.recorder.columns["demand"]])
    assert np.array_equal(*demands)
    assert demands[0].min() >= 0.0
    assert demands[0].max() <= 3.4e5
    assert 0.9 < limits.limited / len(range(0, BLOCK + 1, every[1])) < 1.0  # 1 − (3.4/8)⁴ of them, 97 %


@pytest.mark.parametrize("call", [1, 100, BLOCK - 1, BLOCK, BLOCK + 1])
@pytest.mark.parametrize("way", ["fails_at", "negative_at"])
def test_a_filter_that_diverges(call, way):
    """The first step is that of sample 1; its row is not kept."""
    outcome, reason, written = same(filter_=lambda: Filter(**{way: call}))
    assert (outcome, written) == (Outcome.DIVERGED, call)
    assert reason.startswith("Made up: no. At" if way == "fails_at" else "The estimator diverged: a variance")


CHOICES = (
    [(), ("deflection", "locked", "group_adhesion")],
    ["ideal", "white", "service"],
    [None, Filter],
    [(SLIP, False, (1, 1), False), (HOLD, True, (5, 10), True), (HOLD, False, (2, 3), False)],
)
COMBINATIONS = [
    [choice[k] for choice, k in zip(CHOICES, number, strict=True)]
    for number in product(*(range(len(choice)) for choice in CHOICES))
    if FUZZ or sum(number) % 2 == 0
]
"""Half of the combinations, in which any two choices occur together, or all of them."""


@pytest.mark.parametrize(("lacks", "sensors", "filter_", "law"), COMBINATIONS)
def test_combinations_of_parts(lacks, sensors, filter_, law):
    """Sensors without a new reading, missing plant outputs, parts with different periods.

    The stops reach into the fifth block and beyond the end of the table of friction, which is 1 s or 1 m long.
    """
    controller, valves, every, over_time = law
    outcome, _, _ = same(
        lambda: Plant(speed=12.0, slowing=10.6, lacks=lacks), controller, filter_,
        sensors=sensors, valves=valves, every=every, over_time=over_time, samples=1400,
    )  # fmt: skip
    assert outcome is Outcome.STANDSTILL


@pytest.mark.parametrize("reach", [20.0, 5.0])
def test_a_rail_changed_by_slip(reach):
    """Slip and adhesion of either sign, a train that rolls back or travels farther than expected."""

    def slides(k, truth):
        truth[LAYOUT.output["slip"]] = 0.5 + 0.5 * np.sin(0.01 * k + np.arange(4))
        truth[LAYOUT.output["adhesion"]] = 0.018 * np.sin(0.01 * k + np.arange(6))
        truth[LAYOUT.output["wheelset_load"]] = 1e5

    clean, rows = Recovery(mu0=0.3, A=0.4, B=0.6, rate=1e-2), []
    ended, _, _ = same(
        lambda: Plant(speed=12.0, slowing=10.6, wrong=slides), samples=1400,
        slip_energy=lambda: SlipEnergy(LAYOUT, clean, LAID, reach),
        keep=lambda recorder: rows.append(recorder.rows[: recorder.written, recorder.columns["mu0"]].copy()),
    )  # fmt: skip
    assert ended is Outcome.STANDSTILL
    assert rows[0].max() > 0.25


span = st.tuples(st.integers(0, BLOCK), st.integers(1, 400)).map(lambda at: {"begin": at[0], "end": sum(at)})
broken_sensors = st.builds(
    lambda kind, place, span, value: dict(
        kind=kind, place=place, value=value, noise=np.linspace(-1, 1, 77) if kind == "noisy" else None, **span
    ),
    st.sampled_from(["dead", "stuck", "scaled", "biased", "noisy"]),
    st.integers(0, LAYOUT.readings - 1), span, st.sampled_from([0.0, 0.5, 2.0, -1.0]),
)  # fmt: skip
broken_brakes = st.builds(
    lambda kind, group, span, delay, value: dict(
        kind=kind, group=group, delay=delay, value=value, pressure=1e5, **span
    ),
    st.sampled_from(["fixed", "kept", "late", "limited"]),
    st.integers(0, 3), span, st.integers(0, 50), st.sampled_from([1e-3, 1.0]),
)  # fmt: skip


@given(
    broken=st.tuples(st.lists(broken_sensors, max_size=5), st.lists(broken_brakes, max_size=4)),
    sensors=st.sampled_from(["ideal", "white", "service"]),
    valves=st.booleans(),
    filter_=st.sampled_from([None, Filter]),
    sensing=st.integers(1, 3),
)
def test_any_faults(broken, sensors, valves, filter_, sensing):
    same(
        lambda: Plant(speed=12.0, slowing=8.0), filter_=filter_, sensors=sensors, valves=valves, every=(2, 5),
        broken=broken, sensing=sensing, samples=3 * BLOCK + 40,
    )  # fmt: skip


until = st.one_of(
    st.tuples(st.sampled_from(["time", "duration"]), st.floats(0.0, 1.0)),
    st.tuples(st.just("distance"), st.floats(0.0, 10.0)),
    st.tuples(st.sampled_from(["speed_below", "speed_above"]), st.floats(1.0, 12.0)),
)
pressures = st.tuples(*[st.floats(0.0, 3.4e5)] * 4)


@st.composite
def driven(draw):
    """Phases of every kind, in any order."""
    phases, ends = [], draw(st.lists(until, max_size=5))
    for kind, end in [*ends, ("end", np.nan)]:
        aim = {"target": draw(st.floats(1.0, 8.0)), "deceleration": 8.0, "full_deceleration": 10.6}
        phase = dict(until=kind, end=end, begin=draw(st.floats(0.0, 1.0)), pressure=draw(pressures))
        phase |= dict(slope=draw(st.tuples(*[st.sampled_from([0.0, 1e4])] * 4)))
        phase |= dict(force=draw(st.floats(0.0, 1e5)), power=draw(st.sampled_from([np.inf, 1e5])))
        phases.append(phase_of(rate=draw(st.sampled_from([np.inf, 1e5])), **phase, **draw(st.sampled_from([aim, {}]))))
    return np.concatenate(phases)


@given(phases=driven(), every=st.sampled_from([(1, 1), (2, 3)]))
def test_commands_never_exceed_the_driver_demand(phases, every):
    """For any phases."""
    rows, columns = [], {}

    def keep(recorder):
        rows.append(recorder.rows[: recorder.written].copy())
        columns.update(recorder.columns)

    same(lambda: Plant(speed=12.0, slowing=10.6), every=every, phases=phases, keep=keep)
    command, limit, demand = (rows[0][:, columns[name]] for name in ("command", "driver_demand", "demand"))
    assert np.array_equal(command, np.minimum(limit, demand))


def showing(signal, change, element=0):
    """Return a function that makes a plant modify a signal by `change`(sample, value)."""

    def wrong(sample, truth):
        at = LAYOUT.output[signal].start + element
        truth[at] = change(sample, truth[at])

    return wrong


@pytest.mark.parametrize("sample", [1, 100, BLOCK - 1, BLOCK, BLOCK + 1])
@pytest.mark.parametrize(("signal", "element", "value", "words"), table(__file__, "tables.toml")["implausible"])
def test_a_plant_with_impossible_outputs_is_implausible(sample, signal, element, value, words):
    """The sample is discarded, and the message names signal, time, value and expectation."""
    shown = showing(signal, lambda k, true: value if k == sample else true, element)
    outcome, reason, written = same(lambda: Plant(wrong=shown), filter_=Filter)
    assert (outcome, written) == (Outcome.IMPLAUSIBLE, sample)
    assert f"At {sample * 1e-3:.3f} s the plant outputs {words}" in reason


@pytest.mark.parametrize(
    ("signal", "change", "latest"),
    [
        ("speed", lambda k, true: 3.6 * true, 0),
        ("speed", lambda k, true: -true, 0),
        ("distance", lambda k, true: true + 1.0, 0),
        ("distance", lambda k, true: -true, 3),
        ("distance", lambda k, true: 1e-3 * true, 3),
        ("distance", lambda k, true: 1.01 * true, 200),  # until 1 % is more than two samples of travel
        ("distance", lambda k, true: min(true, 10.0), 510),  # 10 m at 20 m/s are 0.5 s
        ("adhesion", lambda k, true: 8.0, 0),
        # 0.09 m/s in a millisecond is nine times the acceleration of gravity; the first jump is detected.
        ("speed", lambda k, true: true - 0.09 * k, 1),
        ("speed", lambda k, true: true + 0.09 * k, 1),
    ],
    ids=["km/h", "backwards", "begins elsewhere", "other sign", "km", "odometer", "stuck", "percent", "falls", "rises"],
)
def test_a_plant_with_wrong_units_or_signs(signal, change, latest):
    """It ends early."""
    outcome, reason, written = same(lambda: Plant(wrong=showing(signal, change)), samples=550)
    assert outcome is Outcome.IMPLAUSIBLE
    assert written <= latest
    assert f"outputs {signal}" in reason


def test_a_plant_that_starts_with_another_speed_than_the_scenario():
    outcome, reason, written = same(start_speed=72.0)
    assert (outcome, written) == (Outcome.IMPLAUSIBLE, 0)
    assert "At 0.000 s the plant outputs speed = 20 m/s, but [start] speed requires 71.927 to 72.073 m/s" in reason


@given(
    speed=st.floats(0.2, 80.0),
    slowing=st.floats(-2.0, 11.7),
    late=st.booleans(),
    grid=st.sampled_from([0.0, 1e-3, 5e-3]),
    rounding=st.sampled_from([0.0, 0.01 / 3.6, 0.1 / 3.6]),
)
def test_a_correct_plant_is_never_implausible(speed, slowing, late, grid, rounding):
    """For any speed and deceleration; its speed may be of the previous sample, and both may be rounded.

    The speed to 0.1 % of the initial speed, that is twice the resulting error of the braking distance.
    """
    assume(rounding <= 1e-3 * speed)

    def honest(k, truth):
        output = speed - slowing * 1e-3 * (k - late if k else 0)
        gone = speed * 1e-3 * k - slowing * (1e-3 * k) ** 2 / 2
        truth[LAYOUT.output["speed"]] = rounding * round(output / rounding) if rounding else output
        truth[LAYOUT.output["distance"]] = grid * round(gone / grid) if grid else gone

    plausibility = Plausibility(LAYOUT, 1e-3, speed, ANY_TRAIN)
    truth, inputs = np.full(LAYOUT.outputs, np.nan), np.zeros(LAYOUT.inputs)
    for k in range(400):
        honest(k, truth)
        if truth[LAYOUT.output["speed"]][0] <= 0.1 and k:
            break
        assert holds(plausibility, k, truth, inputs), plausibility.reason(1e-3 * k)


def braked(deceleration, *, friction=0.1, force=0.0, bounds=TRAIN, speed=20.0, period=1e-2, shown=1.0):
    """Brake to 0.2 m/s with a deceleration of speed; return how far it came, 0 to 1, before it was implausible."""
    inputs = np.zeros(LAYOUT.inputs)
    inputs[LAYOUT.input["mu0"]], inputs[LAYOUT.input["track_force"]] = friction, force
    plausibility, v, s, k = Plausibility(LAYOUT, period, speed, bounds), speed, 0.0, 0
    a = -deceleration(speed)
    while v > 0.2:
        if not holds(plausibility, k, outputs(speed=v, distance=s, acceleration=shown * a), inputs):
            assert plausibility.reason(k * period).startswith(f"At {k * period:.3f} s the plant outputs ")
            return (speed - v) / speed
        a = -deceleration(v)
        s, v, k = s + period * (v + 0.5 * period * a), v + period * a, k + 1
    return 1.0


@pytest.mark.parametrize("friction", [0.01, 0.1, 0.4])
@pytest.mark.parametrize("force", [0.0, -15e3, 3e3], ids=["level", "uphill", "downhill"])
def test_deceleration_is_limited_by_friction_gradient_and_resistance(friction, force):
    """A plant that uses all of it stops; one with 0.5 % more does not come down to 60 % of its speed."""

    def most(share):
        return lambda v: share * (9.81 * friction + TRAIN.maximum(v) - force / 84e3)

    assert braked(most(1.0), friction=friction, force=force) == 1.0
    assert braked(most(1.005), friction=friction, force=force) < 0.6


MAGNETS = slowing_of(84e3, is_known=True, track_brakes=50e3)
UNKNOWN = slowing_of(84e3, is_known=False)


@pytest.mark.parametrize(
    ("bounds", "friction", "force", "other", "latest"),
    [
        (MAGNETS, 0.03, 0.0, 50e3 / 84e3, 1.0),
        (TRAIN, 0.03, 0.0, 50e3 / 84e3, 0.01),
        (UNKNOWN, 0.05, 20e3, 0.0, 1.0),
        (UNKNOWN, 0.05, -20e3, 20e3 / 42e3, 1.0),
        (UNKNOWN, 0.05, -20e3, 20e3 / 28e3, 0.1),
    ],
    ids=["track brakes", "none", "any push", "a pull on half of the mass", "on a third of it"],
)
def test_more_than_friction_needs_track_brakes_or_an_unknown_mass(bounds, friction, force, other, latest):
    """On a gradient the force is known and the mass may not be: half of the assumed mass, or arbitrarily large."""
    came = braked(lambda v: 9.81 * friction + other, friction=friction, force=force, bounds=bounds)
    assert came < latest or came == latest == 1.0


@pytest.mark.parametrize("shown", [-1.0, 0.98, 1.02, 3.6])
def test_the_acceleration_is_that_of_the_speed_throughout(shown):
    """2 % is more than 0.1 % of the speed and one sample of the acceleration before standstill."""
    assert braked(lambda v: 0.8, shown=1.0) == 1.0
    assert braked(lambda v: 0.8, shown=shown) < 0.9


@pytest.mark.parametrize(("share", "fits"), [(0.9992, True), (1.0008, True), (0.998, False), (1.002, False)])
def test_the_initial_speed_is_that_of_the_scenario_to_0_1_percent(share, fits):
    plausibility = Plausibility(LAYOUT, 1e-3, 20.0, TRAIN)
    truth = outputs(speed=20.0 * share, distance=0.0, acceleration=0.0)
    assert holds(plausibility, 0, truth, np.zeros(LAYOUT.inputs)) is fits


@given(scale=st.floats(-1e3, 1e3).filter(lambda scale: abs(scale - 1) > 0.004), offset=st.floats(-20, 20))
def test_a_wrong_distance_never_yields_a_braking_distance(scale, offset):
    """A stop of 25 m from 20 m/s: 0.1 %, one sample of travel and a centimetre add up to 5.5 cm."""

    def wrong(k, truth):
        truth[LAYOUT.output["distance"]] = scale * truth[LAYOUT.output["distance"]] + offset

    plausibility, plant = Plausibility(LAYOUT, 1e-3, 20.0, ANY_TRAIN), Plant(slowing=8.0, wrong=wrong)
    inputs = np.zeros(LAYOUT.inputs)
    rows = [holds(plausibility, 0, plant.start(inputs), inputs)]
    rows += [holds(plausibility, k, plant.step(inputs), inputs) for k in range(1, 2480)]
    assert not all(rows)


def test_a_law_for_fewer_groups_is_not_called_from_c():
    """C would write four numbers into an array of one."""
    with pytest.raises(LoopError, match="takes 8 inputs, and 26 belong to 4 groups"):
        same(
            controller=lambda: SlipTwoState(GROUPS[:1], SlipTwoState.load_tuning("ideal", "read", "paper")),
            sensors="ideal",
        )
