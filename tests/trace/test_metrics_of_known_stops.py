"""Each figure of a stop, on traces with results known by hand."""

from dataclasses import asdict, replace

import numpy as np
import pytest
from scipy.stats import chi2
from synthetic import BRAKES, LOAD, parabola, uniform_stop

from railgrip.scenario.outcome import Outcome
from railgrip.trace import measures
from railgrip.trace.bound import brake_limit, regained_adhesion, with_bound
from railgrip.trace.metrics import FIGURES, Metrics, actuations, measure

TIME = uniform_stop()["time"].values


def test_uniform_braking_has_the_textbook_figures():
    trace = uniform_stop(speed=20.0, deceleration=1.0)
    assert measures.distance_travelled(trace) == pytest.approx(200.0)
    assert measures.duration(trace) == pytest.approx(20.0)
    assert measures.mean_deceleration(trace) == pytest.approx(1.0)
    assert measures.jerk(trace) == pytest.approx({"jerk_mean": 0.0, "jerk_rms": 0.0})
    assert measures.energy_residual(trace) == pytest.approx(0.0, abs=1e-12)


def test_jerk_is_the_slope_of_a_ramp_of_acceleration():
    assert list(measures.jerk(uniform_stop(acceleration=-0.3 * TIME)).values()) == pytest.approx([0.3, 0.3])


def test_missing_energy_is_detected():
    trace = uniform_stop(speed=20.0, pad_heat=0.0)
    assert measures.energy_residual(trace) == pytest.approx(1.0)


def test_slip_classes_and_deep_slide_count_the_time():
    slip = np.where(TIME[:, None] < 4.0, [[0.01, 0.12, 0.4, 1.0]], 0.01)
    trace = uniform_stop(slip=slip)
    histogram = np.array(measures.slip_histogram(trace))
    assert histogram.sum(axis=1) == pytest.approx(np.full(4, 20.0))
    assert histogram[1, 3] == pytest.approx(4.0)  # 10 to 15 %
    assert histogram[2, 6] == pytest.approx(4.0)  # 30 to 50 %
    assert histogram[3, 8] == pytest.approx(4.0)  # above 90 %
    assert measures.time_in_deep_slide(trace) == pytest.approx((0.0, 0.0, 4.0, 4.0))


def test_the_maximum_adhesion_of_a_group_is_that_of_any_instant():
    of_groups = np.stack([0.1 + 0.05 * (TIME == 3.0), 0.12 - 0.02 * (TIME > 9.0), 0 * TIME, 0.2 * (TIME > 9.0)], axis=1)
    assert _measured(group_adhesion=of_groups).adhesion_peak == pytest.approx((0.15, 0.12, 0.0, 0.2))


def test_the_longest_lock_is_one_lock_and_not_their_sum():
    locks = ((TIME >= 1) & (TIME < 3)) | ((TIME >= 5) & (TIME < 8))
    trace = uniform_stop(locked=np.stack([locks, 0 * TIME, 0 * TIME, 0 * TIME], axis=1))
    assert measures.longest_lock(trace) == pytest.approx((3.0, 0, 0, 0))
    # 20 t − t²/2 over 1…3 and 5…8 s: 36 m and 40.5 m
    assert measures.locked_distance(trace) == pytest.approx((76.5, 0, 0, 0))


def test_tread_energy_is_force_times_creep_path():
    trace = uniform_stop(speed=20.0, deceleration=0.981, adhesion=0.1, slip=0.05)
    distance = measures.distance_travelled(trace)
    assert measures.tread_energy(trace) == pytest.approx((0.1 * LOAD * 0.05 * distance,) * 6, rel=1e-6)
    assert measures.tread_power(trace).max() == pytest.approx(0.1 * LOAD * 0.05 * 20.0)


NEVER, ONCE = TIME < 0, (TIME >= 2) & (TIME < 6)


@pytest.mark.parametrize(
    ("locked", "metres"),
    [(NEVER, 0.0), (ONCE, 64.0), (ONCE | ((TIME >= 8) & (TIME < 9)), 64.0), (NEVER | (TIME < 0.005), 0.2)],
    ids=["no lock", "one lock", "two locks have two flats", "one sample"],
)
def test_the_volume_of_a_flat_is_the_energy_of_its_lock_times_the_rate_of_wear(locked, metres):
    """Locked over 64 m, 20 t - t²/2 from 2 to 6 s, with a tenth of the load, half of which is on each wheel.

    The volume is that of a cap between wheel and rail, by midpoints of a grid.
    """
    slip = np.where(locked, 1.0, 0.05)[:, None] * [1, 0, 0, 1] + [0, 0.05, 0.05, 0]
    speed = uniform_stop()["speed"].values[:, None]
    trace = uniform_stop(
        adhesion=0.1, slip=slip, wheelset_speed=(1 - slip) * speed / 0.4, locked=(slip == 1).astype(float)
    )
    lengths = np.array(measures.flat_length(trace))
    assert not lengths[[2, 3]].any()
    for length in lengths[[0, 1, 4, 5]]:
        depth, grid = length**2 / (8 * 0.4), np.linspace(-1, 1, 801) * max(length, 1e-9)
        x, y = np.meshgrid(grid, grid)
        cap = np.maximum(depth - x**2 / (2 * 0.4) - y**2 / (2 * 0.3), 0).mean() * (2 * max(length, 1e-9)) ** 2
        assert cap == pytest.approx(5.3e-9 / 7850 * 0.1 * LOAD / 2 * metres, rel=0.01)


@pytest.mark.parametrize(("force", "metres", "within"), [(2e3, 100, 0.01), (8e3, 100, 0.06), (8e3, 5, 0.4)])
def test_a_flat_of_all_regimes_of_wear_is_shorter_by_little_after_a_long_slide(force, metres, within):
    """Wear of 5.3 Tγ/A, 55 and 55 + 61.9 (Tγ/A - 77.2) µg/m/mm² on the area of the flat, not below that of Hertz."""
    steps, volume, factor = 4000, 0.0, 64 * 0.4**2 / (np.pi * np.sqrt(0.4 * 0.3))
    for _ in range(steps):
        area = max(120.0, np.pi / 4 * 1e6 * np.sqrt(factor * volume * 0.3 / 0.4))
        pressure = force / area
        rate = 5.3 * pressure if pressure < 10.4 else 55 + 61.9 * max(pressure - 77.2, 0)
        volume += rate * area * 1e-9 / 7850 * metres / steps
    speed = np.sqrt(2.0 * metres)  # at 1 m/s2
    trace = uniform_stop(
        speed=speed, adhesion=2 * force / LOAD, slip=1.0, locked=1.0,
        wheelset_speed=np.where(np.arange(round(speed * 100) + 1) < 1, speed / 0.4, 0.0)[:, None],
    )  # fmt: skip
    trace["slip"].values[0] = 0.0
    assert 1 - within < (factor * volume) ** 0.25 / measures.flat_length(trace)[0] < 1.002


def test_a_wheelset_that_never_turns_or_has_no_adhesion_has_no_estimate():
    assert np.isnan(measures.flat_length(uniform_stop(wheelset_speed=0.0, locked=1.0))).all()
    assert np.isnan(measures.flat_length(uniform_stop(adhesion=np.nan, locked=1.0))).all()
    assert not any(measures.flat_length(uniform_stop(adhesion=np.nan)))


def test_valve_strokes_are_changes_of_position():
    command = np.select([TIME < 5, TIME < 10, TIME < 15], [0.9, 0.0, -1.0], 0.2)
    trace = uniform_stop(command=np.stack([command, np.ones_like(TIME), 0.4 * np.sin(TIME), command], axis=1))
    assert actuations(trace, "pneumatic") == (3, 0, 0, 3)


def test_pressure_reversals_are_counted_without_the_holds_between():
    command = np.interp(TIME, [0, 2, 4, 6, 8, 20], [0, 3e5, 3e5, 1e5, 2e5, 2e5])
    trace = uniform_stop(command=np.stack([command, 0 * TIME, TIME, -TIME], axis=1))
    assert actuations(trace, "ideal") == (2, 0, 0, 0)


def test_air_is_counted_from_the_demand():
    assert measures.change(uniform_stop(air_used=3.0 + 0.01 * TIME), "air_used") == pytest.approx(0.2)


def test_the_bound_is_the_minimum_of_rail_brake_and_limit():
    # 2 units · 0.35 · 5·(9000 − 1000) N · 0.25 m = 7 kN·m on 200 kN·0.4 m → 0.0875; a single unit the same
    for brake in BRAKES:
        assert brake_limit(brake, np.array([0.35]), np.array([brake.load]), np.zeros(1)) == pytest.approx(0.0875)
    mu0 = np.array([0.06, 0.06, 0.2, 0.08, 0.2, 0.2])
    bound = with_bound(uniform_stop(mu0=mu0), parabola, BRAKES, alpha_max=0.15)
    assert bound["ideal_adhesion"].values[0] == pytest.approx([0.06, 0.0875, 0.08, 0.0875], abs=1e-9)
    assert with_bound(uniform_stop(mu0=mu0), parabola, BRAKES, alpha_max=0.05)["ideal_adhesion"].values == (
        pytest.approx(0.05)
    )
    assert bound["peak_slip"].values == pytest.approx(0.05, abs=1e-3)


def test_other_brakes_on_the_wheelsets_are_in_the_bound_and_need_adhesion():
    """Pads draw 3.5 kN.m of each wheelset, and other brakes 1.2 kN.m, which is 0.03 of 100 kN at 0.4 m."""
    wheelsets = np.array([2.0, 1.0, 1.0, 2.0])
    pads = wheelsets * 0.35 * 4e4 * 0.25
    mu0 = np.array([0.2, 0.2, 0.2, 0.1, 0.2, 0.2])
    stop = {"pad_force": 4e4, "brake_torque": pads + 1.2e3 * wheelsets, "mu0": mu0}
    bound = with_bound(uniform_stop(**stop), parabola, BRAKES, alpha_max=0.15)
    assert bound["brake_limit"].values[0] == pytest.approx(0.0875 + 0.03)
    assert bound["ideal_adhesion"].values[0, 2] == pytest.approx(0.1, abs=1e-9)  # the rail limits other brakes, too
    less = with_bound(uniform_stop(**stop | {"brake_torque": pads / 2}), parabola, BRAKES, alpha_max=0.15)
    assert less["brake_limit"].values[0] == pytest.approx(0.0875)  # as of a locked wheelset
    # What holds a standing wheelset is a reaction, which may exceed the friction of sliding pads.
    held = with_bound(uniform_stop(**stop).assign(wheelset_speed=0.0 * bound["wheelset_speed"]), parabola, BRAKES, 0.15)
    assert held["brake_limit"].values[0] == pytest.approx(0.0875)


def test_coupled_wheelsets_share_the_limit_of_their_group():
    mu0 = np.array([0.05, 0.10, 0.2, 0.2, 0.2, 0.2])
    bound = with_bound(uniform_stop(mu0=mu0), parabola, BRAKES, alpha_max=0.15)
    assert bound["ideal_adhesion"].values[:, 0] == pytest.approx(0.075)
    assert bound["ideal_share"].values[0, :2] == pytest.approx([0.05, 0.10])
    with_limit = with_bound(uniform_stop(mu0=mu0), parabola, BRAKES, alpha_max=0.06)
    assert with_limit["ideal_share"].values[0, :2] == pytest.approx([0.04, 0.08])


def test_part_of_the_brake_torque_decelerates_the_wheelset_itself():
    friction, load, deceleration = np.array([0.35]), np.array([LOAD]), np.ones(1)
    light, heavy = (replace(BRAKES[0], inertia=inertia) for inertia in (1e-9, 222.0))
    difference = brake_limit(light, friction, load, deceleration) - brake_limit(heavy, friction, load, deceleration)
    # J a/r² over the load
    assert difference == pytest.approx(222.0 / 0.16 / LOAD)


def test_a_wheelset_regains_the_momentum_lost_in_a_slide():
    """Rail below the brake limit for 5 s, above it afterwards: the surplus of the brakes, or the lock, is regained."""
    time = np.arange(0.0, 10.0, 0.001)
    ones = np.ones((len(time), 1))
    usable = np.where(time[:, None] < 5.0, 0.06, 0.3)
    arguments = {"time": time, "speed": np.full(len(time), 20.0), "load": LOAD * ones}
    surplus = 5.0 * 0.06 * LOAD
    for mass, momentum in ((1400.0, 20.0 * 1400.0), (1e4, min(surplus, 20.0 * 1e4))):
        regained = regained_adhesion(usable=usable, limit=0.12 * ones, rotating_mass=np.array([mass]), **arguments)
        assert np.trapezoid(regained[:, 0] * LOAD, time) == pytest.approx(momentum, rel=2e-3)
        assert not regained[time < 5.0].any()
        assert (regained + 0.12 <= usable + 1e-12)[time >= 5.0].all()
    without_slide = regained_adhesion(
        usable=0.3 * ones, limit=0.12 * ones, rotating_mass=np.array([1400.0]), **arguments
    )
    assert not without_slide.any()


def test_an_isolated_brake_limits_its_group_to_zero():
    bound = with_bound(uniform_stop(), parabola, (None, *BRAKES[1:]), alpha_max=0.15)
    assert bound["brake_limit"].values[0] == pytest.approx([0.0, 0.0875, 0.0875, 0.0875])
    assert bound["ideal_adhesion"].values[:, 0] == pytest.approx(0.0)


def test_utilisation_is_used_over_possible_impulse():
    trace = with_bound(uniform_stop(adhesion=0.07, mu0=0.0875), parabola, BRAKES, alpha_max=0.15)
    train, each = measures.utilisation(trace).values()
    assert train == pytest.approx(0.8)
    assert each == pytest.approx((0.8,) * 6)


def test_an_isolated_group_has_no_utilisation_and_does_not_change_that_of_the_train():
    """The force of its contacts still counts for the train."""
    trace = with_bound(uniform_stop(adhesion=0.07, mu0=0.0875), parabola, (None, *BRAKES[1:]), alpha_max=0.15)
    train, each = measures.utilisation(trace).values()
    isolated = np.isnan(each)
    assert 0 < isolated.sum() < len(each)
    assert np.array(each)[~isolated] == pytest.approx(0.8)
    load = trace["wheelset_load"].values[0]
    assert train == pytest.approx(0.8 * load.sum() / load[~isolated].sum())


def test_the_permitted_adhesion_is_the_peak_of_the_creep_curve():
    """Also with uniform friction and with isolated brakes."""
    for brakes in (BRAKES, (None, *BRAKES[1:])):
        trace = with_bound(uniform_stop(adhesion=0.07, mu0=0.0875), parabola, brakes, alpha_max=0.05)
        assert measures.adhesion_allowed(trace) == pytest.approx(0.0875)
        half = trace.isel(time=slice(0, 1))
        assert np.isnan(measures.adhesion_allowed(half))
    assert np.isnan(measures.adhesion_allowed(uniform_stop()))


def test_the_adhesion_at_the_first_slide_is_that_of_the_group_that_slides_first():
    """Group 3 passes 5 % slip after 4 s, group 1 later; later slides and those below 15 km/h do not count."""
    trace = uniform_stop(speed=20.0, deceleration=1.0)
    time = trace["time"].values[:, None]
    begins = np.array([6.0, 99.0, 4.0, 99.0])
    slip = np.where(time < begins, 0.049, 0.051)
    adhesion = np.array([0.05, 0.06, 0.07, 0.08]) + 0.001 * time
    sliding = uniform_stop(speed=20.0, deceleration=1.0, slip=slip, group_adhesion=adhesion)
    assert measures.adhesion_at_slide(sliding) == pytest.approx(0.074, abs=2e-5)
    steady = uniform_stop(speed=20.0, deceleration=1.0, slip=np.where(time < 16.0, 0.049, 1.0))
    assert np.isnan(measures.adhesion_at_slide(steady))


def test_time_over_the_limit_counts_each_group():
    trace = uniform_stop(group_adhesion=np.where(TIME[:, None] < 3, [[0.16, 0.14, 0.14, 0.2]], 0.1))
    assert measures.time_over_limit(trace, 0.15) == pytest.approx((3.0, 0, 0, 3.0))


def test_a_perfect_estimator_has_no_error_and_no_delay():
    errors = measures.adhesion_errors(uniform_stop(estimate_adhesion_sd=0.02))
    assert errors.pop("adhesion_sd") == pytest.approx((0.02,) * 4)
    assert len(errors) == 6
    assert set(errors.values()) == {(0.0,) * 4}


def test_bias_deviation_and_nees_of_a_known_error():
    error = np.where(np.arange(len(TIME)) % 2, 0.03, -0.01)[:, None] * np.ones(4)
    errors = measures.adhesion_errors(uniform_stop(estimate_adhesion=1 / 9.81 + error, estimate_adhesion_sd=0.02))
    # above 10 km/h an odd number of samples remains, so that halves are not quite halves
    assert errors["adhesion_bias"] == pytest.approx((0.01,) * 4, abs=2e-5)
    assert errors["adhesion_rmse"] == pytest.approx((np.sqrt(5e-4),) * 4, rel=1e-3)
    assert errors["adhesion_nees"] == pytest.approx((5e-4 / 4e-4,) * 4, rel=2e-3)
    assert errors["adhesion_error_95"] == pytest.approx((0.03,) * 4)


def test_errors_of_readings_are_relative_to_the_true_values():
    """A speed falling from v0 to 0 at constant deceleration has the RMS v0/√3."""
    trace = uniform_stop()
    speed = trace["speed"].values
    alternating = np.where(np.arange(len(speed)) % 2, 0.2, -0.2)
    trace["reading_speed"] = ("time", speed + alternating)
    gaps = trace["acceleration"].values * 1.05
    gaps[::3] = np.nan
    trace["reading_acceleration"] = ("time", gaps)
    errors = measures.reading_errors(trace)
    # The samples of a trace end at standstill: rel covers the one sample by which sum and integral differ.
    assert errors["speed_error"] == pytest.approx(0.2 * np.sqrt(3) / speed[0], rel=1e-3)
    assert errors["acceleration_error"] == pytest.approx(0.05)


def test_a_delayed_estimate_has_that_delay():
    truth = 0.1 + 0.02 * np.sin(2 * TIME)
    late = 0.1 + 0.02 * np.sin(2 * (TIME - 0.12))
    trace = uniform_stop(group_adhesion=truth[:, None] * np.ones(4), estimate_adhesion=late[:, None] * np.ones(4))
    assert measures.adhesion_errors(trace)["adhesion_delay"] == pytest.approx((0.12,) * 4)


def test_errors_below_walking_pace_do_not_count():
    v = uniform_stop()["speed"].values
    wrong_when_slow = 1 / 9.81 + np.where(v < 2.7, 1.0, 0.0)[:, None] * np.ones(4)
    assert measures.adhesion_errors(uniform_stop(estimate_adhesion=wrong_when_slow))["adhesion_rmse"] == (0.0,) * 4


def test_a_stop_without_estimator_has_no_estimator_figures():
    metrics = _measured(estimates=False)
    assert metrics.adhesion_rmse is None
    assert metrics.speed_rmse is None
    np.testing.assert_equal(asdict(Metrics.from_plain(metrics.to_plain())), asdict(metrics))  # NaN equals NaN


def test_a_stop_that_failed_at_once_still_has_its_figures():
    trace = uniform_stop().isel(time=slice(0, 1))
    trace = with_bound(trace, parabola, BRAKES, alpha_max=0.15)
    metrics = measure(trace, outcome=Outcome.CONTROLLER_FAILED, alpha_max=0.15, actuation="ideal")
    assert np.isnan(metrics.distance)
    assert metrics.distance_travelled == 0.0
    assert np.isnan(metrics.utilisation)
    assert metrics.adhesion_rmse is None


def test_every_figure_has_a_unit_and_a_meaning():
    undeclared = sorted(Metrics.__dataclass_fields__.keys() - FIGURES.keys())
    assert not undeclared, (
        f"Metrics.{', Metrics.'.join(undeclared)} has no Figure(unit, meaning, formula) in its Annotated type"
    )
    for name, figure in FIGURES.items():
        assert figure.unit, f'Metrics.{name}: give its SI unit in Figure, "1" for a number'
        assert len(figure.meaning) > 10, f"Metrics.{name}: give its definition in Figure; tables of results show it"


def test_a_consistent_estimator_is_not_reported():
    metrics = _measured()
    assert metrics.nis_ratio == pytest.approx(1.0)
    assert metrics.estimator_lost is None
    assert metrics.adhesion_outside == metrics.pad_friction_outside == (0.0,) * 4
    assert metrics.doubts() == ()


def test_a_truth_mostly_beyond_two_deviations_is_reported_with_its_group():
    metrics = _measured(estimate_pad_friction=0.35 + np.array([0.021, 0.019, 0.0, -0.021]))
    assert metrics.pad_friction_outside == (1.0, 0.0, 0.0, 1.0)
    (sentence,) = metrics.doubts()
    assert "true pad friction" in sentence
    assert "1 (100 %), 4 (100 %)" in sentence


def test_a_truth_that_a_plant_does_not_output_is_not_inside():
    metrics = _measured(pad_friction=np.nan)
    assert np.isnan(metrics.pad_friction_outside).all()
    assert metrics.doubts() == ()


def test_inconsistent_innovations_are_reported():
    (sentence,) = _measured(estimate_nis=3.0 * chi2.median(17)).doubts()
    assert "3.0 times the expected one" in sentence
    diverging = _measured(estimate_nis=np.where(TIME < 5.0, 17.0, 1e6))
    period = TIME[1] - TIME[0]
    assert diverging.estimator_lost == pytest.approx(5.0 + 50 * period, abs=2 * period)
    assert diverging.doubts()[0].startswith("The estimator is lost from 5.")


def _measured(**changes):
    trace = with_bound(uniform_stop(**changes), parabola, BRAKES, alpha_max=0.15)
    return measure(trace, outcome=Outcome.STANDSTILL, alpha_max=0.15, actuation="ideal")
