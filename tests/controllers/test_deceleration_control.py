"""Deceleration control on a point mass: kinematics of the curve, windup, redistribution, and the emergency brake."""

import numpy as np
import pytest
from scipy.optimize import brentq
from wheelset import GROUP, observed, state_of

from railgrip.controllers.laws.deceleration_control import DecelerationControl
from railgrip.controllers.laws.slope_seeking import SlopeSeeking
from railgrip.controllers.train_level import PAD_FRICTION

PERIOD = 1e-2
GROUPS = 4
MASS = GROUPS * GROUP.load / 9.81
ROLLING, SLIDING = 0.001, 0.5
"""Slips: the second is beyond `slip_vent`, where slide protection releases whatever its set point is."""
DECELERATION = 0.6


def controller(**parameters):
    tuning = DecelerationControl.load_tuning(
        "pneumatic", "estimated", period=PERIOD, adhesion_max=0.15, pressure_lag=0.0, **parameters
    )
    return DecelerationControl([GROUP] * GROUPS, tuning)


def force(pressure, friction=PAD_FRICTION):
    """Return the force at the rail of a group [N], as in EN 14531-1 for disc brakes."""
    pads = GROUP.rigging * np.maximum(np.asarray(pressure) * GROUP.piston_area - GROUP.spring_force, 0.0)
    return GROUP.units * friction * GROUP.friction_radius * pads / GROUP.wheel_radius


def seen(time, speed, acceleration, pressure, driver, *, slip=(ROLLING,) * GROUPS, adhesion=None, friction=0.35):
    each = force(pressure, friction) / GROUP.load if adhesion is None else adhesion
    full = observed(time, speed, acceleration, slip, tuple(each), (friction,) * GROUPS, tuple(pressure))
    return full._replace(driver_demand=np.full(GROUPS, driver))


def driver_pressure(deceleration):
    """Return the pressure at which nominal pads give a deceleration, solved from `force`."""
    return brentq(lambda pressure: GROUPS * force(pressure) - deceleration * MASS, 0.0, GROUP.pressure_max, xtol=1e-9)


@pytest.mark.parametrize(("slope", "pads"), [(0.0, 1.0), (0.012, 0.85), (-0.012, 1.15)])
def test_on_a_dry_rail_the_train_follows_the_curve_to_its_own_target(slope, pads):
    """On a curve of constant deceleration v² = 2 a (target − x), and the stop takes x₀/v₀ + v₀/a."""
    speed, target, law = 15.0, 300.0, controller(target=300.0, deceleration=DECELERATION)
    begin = target - 0.5 * speed**2 / DECELERATION
    x, v, a, time, pressure, on_curve, began = 0.0, speed, 0.0, 0.0, np.zeros(GROUPS), [], None
    while v > 0.05:
        # The pads are worse or better than the estimate, as where the load is not known.
        demand = np.array(law.decide(seen(time, v, a, pressure, GROUP.pressure_max)))
        if began is None and demand.any():
            began = x
        pressure += (demand - pressure) * PERIOD / 0.2  # first-order cylinders
        braked = float(np.sum(force(pressure, 0.35 * pads))) / MASS
        # The track is level up to the curve: coasting is not controlled.
        a = -braked - (9.81 * slope if began is not None else 0.0)
        v, x, time = v + a * PERIOD, x + v * PERIOD, time + PERIOD
        if 30.0 < target - x < 150.0:
            on_curve.append(v**2 / (2 * DECELERATION * (target - x)))
        assert time < 60.0
    assert began == pytest.approx(begin, abs=2 * speed * PERIOD)  # it decides once a period, on the distance before
    assert abs(x - target) < 0.3  # the deceleration to the target is not resolved nearer than 0.25 m
    assert time == pytest.approx(begin / speed + speed / DECELERATION, abs=1.0)  # lag of the cylinders, and the halt
    # Within the share by which 0.2 s of lag at 15 m/s lets the train run off the curve before the correction.
    assert np.ptp(on_curve) < 0.15
    assert np.mean(on_curve) == pytest.approx(1.0, abs=0.1)


def test_at_the_limit_of_adhesion_the_integral_does_not_wind_up():
    demanded, adhesion = driver_pressure(0.8), np.full(GROUPS, 0.03)
    results = {}
    for managed in (1.0, 0.0):
        law = controller(managed=managed)
        for k in range(1500):
            sliding = seen(k * PERIOD, 15.0, -0.03 * 9.81, np.full(GROUPS, 8e4), demanded,
                           slip=(SLIDING,) * GROUPS, adhesion=adhesion)  # fmt: skip
            law.decide(sliding)
        results[managed] = float(state_of(law, "integral"))
    assert abs(results[1.0]) < 0.05  # the rail withholds the force; 0.05 m/s² is a tenth of the limit
    assert results[0.0] == pytest.approx(0.5)  # integral_max


def test_groups_with_adhesion_left_replace_the_force_of_one_that_slides():
    """The forces add up to mass times deceleration; the others share the missing force evenly."""
    law, wanted, low = controller(integral_gain=0.0, reserve=0.0), 0.6, 0.02
    adhesion = np.array([low, 0.06, 0.06, 0.06])
    for k in range(500):  # 5 s, many time constants of the redistribution
        now = seen(k * PERIOD, 15.0, -wanted, np.full(GROUPS, 1.5e5), driver_pressure(wanted),
                   slip=(SLIDING, ROLLING, ROLLING, ROLLING), adhesion=adhesion)  # fmt: skip
        demands = law.decide(now)
    others = force(demands[1:])
    assert np.ptp(others) == pytest.approx(0.0, abs=1e-6)
    assert low * GROUP.load + others.sum() == pytest.approx(wanted * MASS, rel=1e-4)
    assert force(demands[0]) < force(driver_pressure(wanted))


def test_it_is_never_later_than_the_emergency_brake():
    """With full pressure demanded, or a target that is near or passed, demands are those of slide protection alone."""
    random = np.random.default_rng(4)
    slope = SlopeSeeking.load_tuning(
        "pneumatic", "estimated", period=PERIOD, adhesion_max=0.15, pressure_lag=0.0, speed_min=1.5
    )
    emergency, alone, near = controller(), SlopeSeeking([GROUP] * GROUPS, slope), controller(target=50.0)
    for k in range(300):
        slip = tuple(random.uniform(0.0, 0.3, GROUPS))
        now = seen(k * PERIOD, 20.0 - 0.01 * k, -0.5, random.uniform(0.0, 3e5, GROUPS), GROUP.pressure_max,
                   slip=slip, adhesion=random.uniform(0.0, 0.1, GROUPS))  # fmt: skip
        expected = alone.decide(now)
        assert emergency.decide(now) == expected
        # v²/(2 d) = 4 m/s² at 50 m is beyond any emergency brake.
        assert near.decide(now) == expected


def test_sand_and_magnets_are_demanded_only_where_adhesion_does_not_suffice():
    wanted = driver_pressure(0.6)
    for limit, sands, lowers in ((0.12, 0.0, 0.0), (0.03, 1.0, 1.0)):
        law = controller()
        slides = limit * 9.81 < 0.6
        for k in range(300):
            now = seen(k * PERIOD, 15.0, -min(limit * 9.81, 0.6), np.full(GROUPS, 1.2e5), wanted,
                       slip=((SLIDING if slides else ROLLING),) * GROUPS,
                       adhesion=np.full(GROUPS, min(limit, 0.6 / 9.81)))  # fmt: skip
            law.decide(now)
        assert (law.visible_state("sand"), law.visible_state("magnets")) == (sands, lowers)


def test_a_curve_steeper_than_the_emergency_brake_is_refused():
    with pytest.raises(ValueError, match=r"deceleration < emergency is required, got deceleration = 1.2"):
        controller(deceleration=1.2)
