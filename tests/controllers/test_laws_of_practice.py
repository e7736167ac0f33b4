"""The laws of practice, each on its own controlled quantity."""

from dataclasses import replace

import numpy as np
import pytest
from wheelset import GROUP, SPEED, observed, simulate, state_of

from railgrip.controllers.laws.constant_slip import ConstantSlip, ConstantSlipTuning
from railgrip.controllers.laws.extremum_seeking import ExtremumSeeking, ExtremumSeekingTuning
from railgrip.controllers.laws.fuzzy_slip import FuzzySlip, FuzzySlipTuning
from railgrip.controllers.laws.perturb_observe import PerturbObserve, PerturbObserveTuning
from railgrip.controllers.laws.recursive_slope import RecursiveSlope, RecursiveSlopeTuning
from railgrip.controllers.laws.wheel_reference import WheelReference, WheelReferenceTuning

FULL = GROUP.pressure_max
PERIOD = 10e-3
REFERENCE = WheelReferenceTuning(
    period=PERIOD, filter_time=0.03, slip_low=0.03, slip_high=0.1, deceleration=2.0, deceleration_max=1.5, rise=0.5,
    test_after=5.0, test_time=0.6, vent_max=7.0, apply_time=1.0, speed_min=1.4,
)  # fmt: skip
STEADY = ConstantSlipTuning(period=1e-3, slip=0.03, gain=0.2, integral_time=0.2, speed_min=0.5)
SEEKING = ExtremumSeekingTuning(
    period=1e-3, slip_start=0.04, slip_least=0.005, slip_most=0.3, dither=0.2, frequency=1.0, washout_time=0.5,
    climb=1.0, gain=0.2, integral_time=0.2, adhesion_small=0.01, speed_min=0.5,
)  # fmt: skip
STEPPING = PerturbObserveTuning(
    period=1e-3, slip_start=0.04, step=0.1, interval=0.4, settling=0.5, gain=0.2, integral_time=0.2
)
TRACKING = RecursiveSlopeTuning(
    period=1e-3, slip_start=0.04, washout_time=0.8, memory=1.0, dither=0.15, climb=0.6, gain=0.2, integral_time=0.2
)
FUZZY = FuzzySlipTuning(period=1e-3, slip_medium=0.05, slip_ratio=2.0, deceleration=1.0, fill_rate=0.5, vent_rate=1.5)


def wheels(law, *speeds, pressure=FULL, count=1):
    """Return the last demands after a number of periods with wheels of these rolling speeds [m/s]."""
    demands = ()
    for _ in range(count):
        slip = tuple(1 - speed / SPEED for speed in speeds)
        demands = law.decide(observed(0.0, SPEED, 0.0, slip, None, None, (pressure,) * len(speeds)))
    return demands


@pytest.fixture
def reference():
    """Wheel-speed reference control that has seen both wheels roll."""
    law = WheelReference([GROUP, GROUP], REFERENCE)
    assert wheels(law, SPEED, SPEED) == (FULL, FULL)
    return law


@pytest.mark.parametrize("slip", [0.02, 0.05, 0.1])
def test_constant_slip_control_holds_the_set_slip(slip):
    """On a curve whose peak is beyond, where the wheel is stable at any slip."""
    found, _ = simulate(ConstantSlip([GROUP], replace(STEADY, slip=slip)), 4.0, peak_slip=0.2)
    assert found[3000:].mean() == pytest.approx(slip, rel=0.02)


def test_constant_slip_control_starts_and_ends_with_full_pressure():
    law = ConstantSlip([GROUP], STEADY)
    assert wheels(law, SPEED) == (FULL,)
    assert law.decide(observed(0, 0.3, 0, (0.9,), None, None, (0.0,))) == (FULL,)
    unknown = float("nan")
    assert law.decide(observed(0, unknown, 0, (unknown,), None, None, (0.0,))) == (FULL,)


def test_extremum_seeking_stays_where_adhesion_does_not_respond():
    law = ExtremumSeeking([GROUP], SEEKING)
    for _ in range(5000):
        law.decide(observed(0.0, SPEED, 0.0, (0.04,), (0.05,), (0.35,), (FULL,)))
    assert state_of(law, "set_slip[1]") == pytest.approx(0.04, rel=1e-9)


@pytest.mark.parametrize(
    ("law", "tuning", "seconds"),
    [(ExtremumSeeking, SEEKING, 12.0), (PerturbObserve, STEPPING, 15.0), (RecursiveSlope, TRACKING, 15.0)],
)
@pytest.mark.parametrize("peak_slip", [0.02, 0.04, 0.1])
def test_laws_that_track_the_maximum_reach_the_peak_from_either_side(law, tuning, seconds, peak_slip):
    """From 4 % slip; adhesion at 30 % from the peak's slip is 4 % below the peak."""
    controller = law([GROUP], tuning)
    simulate(controller, seconds, peak_slip=peak_slip)
    assert state_of(controller, "set_slip[1]") == pytest.approx(peak_slip, rel=0.3)


def test_perturb_and_observe_turns_back_when_adhesion_falls():
    law, slips = PerturbObserve([GROUP], STEPPING), []
    for adhesion in (0.05, 0.06, 0.05, 0.04):
        for _ in range(400):
            law.decide(observed(0.0, SPEED, 0.0, (0.04,), (adhesion,), (0.35,), (FULL,)))
        slips.append(state_of(law, "set_slip[1]") / 0.04)
    assert slips == pytest.approx([1.1, 1.21, 1.1, 1.21])


def test_the_recursion_finds_the_elasticity_of_a_power_law():
    """α = 0.05 (s/0.04)^0.5 around s = 0.04."""
    law = RecursiveSlope([GROUP], replace(TRACKING, climb=0.0))
    for k in range(8000):
        slip = 0.04 * (1 + 0.05 * np.sin(2 * np.pi * k * 1e-3))
        law.decide(observed(0.0, SPEED, 0.0, (slip,), (0.05 * (slip / 0.04) ** 0.5,), (0.35,), (FULL,)))
    assert state_of(law, "elasticity[1]") == pytest.approx(0.5, rel=0.03)


def test_the_rules_fill_below_the_medium_slip_hold_at_it_and_vent_above():
    for slip, change in ((0.0, FUZZY.fill_rate), (0.05, 0.0), (0.1, -0.5 * FUZZY.vent_rate)):
        law = FuzzySlip([GROUP], FUZZY)
        law.state[[quantity.name.startswith("share") for quantity in law.formula.states]] = 0.5
        wheels(law, SPEED * (1 - slip), count=100)
        assert state_of(law, "share[1]") == pytest.approx(0.5 + 0.1 * change, abs=1e-9)


def test_a_wheel_that_loses_speed_is_vented_at_the_medium_slip():
    law = FuzzySlip([GROUP], FUZZY)
    for k in range(300):  # 3 m/s² more than the train
        wheels(law, 0.95 * SPEED - 3.0e-3 * k)
    assert state_of(law, "share[1]") < 0.9


def test_the_reference_is_the_fastest_wheel_with_a_limited_deceleration(reference):
    """Both wheels drop by 2 m/s at once: 0.2 s later the reference has fallen by 0.3 m/s, and both are vented."""
    assert wheels(reference, SPEED - 2, SPEED - 2, count=20) == (0.0, 0.0)
    assert state_of(reference, "reference") == pytest.approx(SPEED - 20 * PERIOD * 1.5)
    wheels(reference, SPEED - 2, SPEED)
    assert state_of(reference, "reference") == pytest.approx(SPEED)


def test_a_wheel_is_held_above_the_low_slip_and_vented_above_the_high_one(reference):
    wheels(reference, SPEED, 0.95 * SPEED, count=30)
    assert wheels(reference, SPEED, 0.95 * SPEED, pressure=1.5e5) == (FULL, 1.5e5)
    assert wheels(reference, SPEED, 0.89 * SPEED) == (FULL, 0.0)


def test_pressure_is_restored_at_its_rate_after_a_slide(reference):
    wheels(reference, SPEED, 0.8 * SPEED, pressure=1e5, count=10)
    wheels(reference, SPEED, SPEED, pressure=1e5, count=50)  # its acceleration is uncritical again
    assert wheels(reference, SPEED, SPEED, pressure=1e5)[1] == pytest.approx(1e5 + 51 * PERIOD * 0.5 * FULL)


def test_the_watchdog_ends_venting_for_a_while(reference):
    second = [wheels(reference, SPEED, 0.0, pressure=0.0)[1] for _ in range(1000)]
    applied = np.flatnonzero(np.array(second) > 0)
    assert applied[0] == pytest.approx(700, abs=2)
    assert len(applied) == pytest.approx(100, abs=2)


def test_the_last_group_is_released_after_long_sliding(reference):
    wheels(reference, 0.95 * SPEED, 0.915 * SPEED, count=100)  # the reference still falls: more slip is computed
    last = [wheels(reference, 0.95 * SPEED, 0.915 * SPEED)[1] for _ in range(600)]
    released = np.flatnonzero(np.array(last) == 0.0)
    assert released[0] == pytest.approx(400, abs=3)
    assert len(released) == pytest.approx(60, abs=2)


def test_below_its_lowest_speed_the_reference_does_not_act_on_the_brake():
    law = WheelReference([GROUP, GROUP], REFERENCE)
    wheels(law, 1.3, 1.3)
    assert wheels(law, 1.3, 0.5, count=20) == (FULL, FULL)


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (lambda: replace(REFERENCE, slip_high=0.02), "WheelReference: slip_low < slip_high < 1 is required, got"),
        (lambda: replace(REFERENCE, rise=0.0), "WheelReference: rise must be finite and positive, got 0.0 1/s"),
        (lambda: replace(STEADY, slip=1.0), "ConstantSlip: slip < 1 is required, got slip = 1.0; .* locked wheel"),
        (lambda: replace(STEADY, gain=-1.0), "ConstantSlip: gain must be finite and not negative, got -1.0 1"),
        (
            lambda: replace(SEEKING, slip_start=0.4),
            "ExtremumSeeking: slip_least <= slip_start",
        ),
        (lambda: replace(SEEKING, frequency=300.0), "leaves less than four decisions"),
        (lambda: replace(STEPPING, slip_start=0.4), "PerturbObserve: slip_least <= slip_start"),
        (lambda: replace(STEPPING, interval=1e-3), "PerturbObserve: an interval of 0.001 s"),
        (lambda: replace(TRACKING, slip_start=0.4), "RecursiveSlope: slip_least <= slip_start"),
        (lambda: replace(TRACKING, dither=1.0), "RecursiveSlope: dither < 1 .*; it is a share"),
        (lambda: replace(FUZZY, slip_ratio=1.0), "FuzzySlip: 1 < slip_ratio is required, got slip_ratio = 1.0"),
        (lambda: replace(SEEKING, dither=1.0), "ExtremumSeeking: dither < 1 is required, got dither = 1.0"),
    ],
)
def test_an_invalid_tuning_is_refused(change, sentence):
    with pytest.raises(ValueError, match=sentence):
        change()
