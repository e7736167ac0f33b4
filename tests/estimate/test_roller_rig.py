"""The roller rig compared with closed forms, and its filters with the accuracy in the paper, on the first slides."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import rig_tests
import xarray

from railgrip.estimation.judgement import judge
from railgrip.estimation.roller_rig import (
    LIMIT,
    brakings,
    excursions,
    outside_events,
    recording_of_rig,
    resample,
    response,
    settling,
    slides,
)
from railgrip.estimation.spec import LIBRARY, estimate_of, load_specification
from railgrip.recording.samples import reading_of, recording_of, truth_of
from railgrip.report.style import save
from railgrip.scenario.load import load
from railgrip.studies.bench import of_rig


def estimates_by(name, recording, changes=()):
    return estimate_of(load_specification(LIBRARY / f"{name}.toml", changes), recording)


def shortened(name, horizon, **changes):
    keys = [f"{key.replace('__', '.')}={value}" for key, value in changes.items()]
    return load(Path(f"rig_{name}"), [f"limits.horizon='{horizon} s'", *keys])


@pytest.fixture(scope="module")
def sand():
    return recording_of_rig(shortened("sand", 12.0))


def test_the_roller_is_decelerated_by_contact_force_and_drag(sand):
    """m dv = -(contact force + drag) dt for the emulated wagon, from outputs of the rig alone."""
    v, time = truth_of(sand, "v"), sand["time"].values
    force = reading_of(sand, "contact_force") + 1.2 / 2 * 0.9 * 5.2 * v**2
    loss = np.trapezoid(force, time) / 20e3
    # Load cells: white noise of 100 N over 2400 samples of 5 ms is 25 N.s or 1e-3 m/s; the rest is the trapezoid rule.
    assert v[0] - v[-1] == pytest.approx(loss, abs=5e-3)


def test_load_cells_measure_adhesion_without_bias(sand):
    error = reading_of(sand, "contact_force") / reading_of(sand, "wheelset_load") - truth_of(sand, "alpha")
    # 100 N of 98 kN is 1e-3 per sample; the mean of 2400 samples 2e-5.
    assert np.std(error) == pytest.approx(1.0e-3, rel=0.1)
    assert np.mean(error) == pytest.approx(0.0, abs=1e-4)


def test_adhesion_passes_its_peak_falls_recovers_and_vanishes(sand):
    """Figure 6 of Schwarz and Keck (2020): 0.1, 0.05, after the release 0.1 again, then 0."""
    part = sand.sel(time=slice(4.0, 10.0))
    alpha, slip = truth_of(part, "alpha"), truth_of(part, "slip")
    deepest = int(np.argmax(slip))
    first, second = alpha[:deepest], alpha[deepest:]
    # Friction scatters by 5 % along the roller.
    assert first.max() == pytest.approx(0.1, abs=0.01)
    assert alpha[deepest] == pytest.approx(0.05, abs=0.005)
    assert second.max() == pytest.approx(0.1, abs=0.01)
    assert second[np.argmax(second) :].min() < 0.005
    assert slides(sand) == 1


def test_figures_are_readable(sand, tmp_path):
    """tests/conftest.py checks every saved figure. Time is stretched because the text describes tests up to 110 s."""
    estimates = {name.replace("_", "-"): estimates_by(name, sand) for name in ("rig_paper", "rig_own")}
    recording, *longer = (one.assign_coords(time=11 * one["time"].values) for one in (sand, *estimates.values()))
    for name, drawing in {
        "slide": rig_tests.record_figure("rig_slide", recording, dict(zip(estimates, longer, strict=True))),
        "sand": rig_tests.record_figure("rig_sand", recording, dict(zip(estimates, longer, strict=True))),
        "over slip": rig_tests.over_slip_figure(sand, estimates),
    }.items():
        assert save(drawing, tmp_path / f"{name}.png").is_file()


@pytest.mark.parametrize("name", ["rig_paper", "rig_own"])
def test_a_wrong_initial_adhesion_is_corrected_within_tenths_of_a_second(sand, name):
    """Figures 4 and 5: "in the first few tenths of a second"; later estimates do not depend on the start."""
    wrong, right = (estimates_by(name, sand, start) for start in (rig_tests.WRONG_START, ()))
    assert settling(sand, right) == 0.0
    assert 0.0 < settling(sand, wrong) < 0.3
    later = sand["time"].values > 1.0
    apart = (wrong["mean"] - right["mean"]).sel(state=["group_adhesion", "pad_friction"]).values[later]
    # A thousandth of the initial error.
    assert np.abs(apart).max() < 1e-4


@pytest.mark.parametrize("name", ["rig_paper", "rig_own"])
def test_the_error_of_adhesion_is_within_002_on_the_sanded_roller(sand, name):
    estimates = estimates_by(name, sand)
    counts = excursions(sand, estimates, settled=0.5)
    assert counts["kept"]
    assert estimates.attrs["ended"] == ""
    steady = sand["time"].values > 4.0
    judgement = judge(sand, estimates, "alpha", steady)
    assert judgement.rmse < 0.3 * judgement.constant
    constant = estimates.copy(deep=True)
    constant["mean"].loc[{"state": "group_adhesion"}] = truth_of(sand, "group_adhesion")[steady].mean()
    assert not excursions(sand, constant, settled=0.5)["kept"]


def test_the_filter_of_equation_20_is_underconfident_and_the_built_in_consistent(sand):
    after = sand["time"].values > 4.0
    paper, own = (estimates_by(name, sand) for name in ("rig_paper", "rig_own"))
    assert judge(sand, paper, "mu_b", after).nees < 0.01
    assert 0.1 < judge(sand, own, "mu_b", after).nees < 10.0
    assert judge(sand, own, "alpha", after).rmse < judge(sand, paper, "alpha", after).rmse


def test_short_brake_applications_under_oil_slide_at_two_to_five_percent():
    slide = recording_of_rig(shortened("slide", 22.0))
    sliding = truth_of(slide, "slip") > 0.05
    assert sliding.sum() > 100
    alpha = truth_of(slide, "alpha")[sliding]
    assert alpha.min() > 0.015
    assert alpha.max() < 0.055


def test_the_gate_holds_pad_friction_while_the_pads_are_released():
    """Readings then do not depend on it: with the gate mean and deviation stay constant, in the paper they grow."""
    coasting = recording_of_rig(shortened("slide", 10.0))
    own, paper = (estimates_by(name, coasting) for name in ("rig_own", "rig_paper"))
    assert np.ptp(own["sd"].sel(state="pad_friction").values) < 1e-12
    deviations = paper["sd"].sel(state="pad_friction").values
    # Q33 = 1e-3 is added 2000 times; load cells with 100 N of noise contribute almost no information.
    assert deviations[-1] == pytest.approx(np.sqrt(0.04**2 + 2000 * 1e-3), rel=0.05)


def test_a_period_five_times_shorter_hardly_changes_the_speed():
    """Valves switch at the same instants; the remaining difference is due to the solver of the plant."""
    coarse, fine = (
        recording_of_rig(
            shortened(
                "sand", 6.0, adhesion__scatter=0, sensors__noise__speed=0, sensors__noise__wheelset_speed=0,
                periods__communication=period, periods__estimator=period, periods__trace=period,
            )
        )
        for period in (5e-3, 1e-3)
    )  # fmt: skip
    # Holding mu0 over a period is negligible; the solver has a tolerance of 1e-5 at 55 m/s.
    assert truth_of(fine, "v")[-1] == pytest.approx(truth_of(coarse, "v")[-1], abs=5e-3)


PERIOD = 0.01


def pulses(count, ends, height=1.0):
    """Return samples of a height between each begin and end [s], elsewhere zero."""
    time, values = np.arange(count) * PERIOD + 1e-9, np.zeros(count)
    for begin, end in ends:
        values[(time >= begin) & (time < end)] = height
    return values


def protected(error, busy):
    """Return a recording with active protection where `busy` is set, and an estimate with a given error."""
    truth = {"group_adhesion": (np.full(len(error), 0.05), "1")}
    recording = recording_of({"protecting": (busy, "1")}, period=PERIOD, truth=truth)
    estimates = xarray.Dataset(
        {"mean": (("time", "state"), (0.05 + np.asarray(error))[:, None])},
        coords={"time": recording["time"], "state": ["group_adhesion"]},
    )
    return recording, estimates


BUSY = pulses(100, [(0.4, 0.5)])


def test_an_event_ends_a_tenth_of_a_second_after_the_intervention():
    recording, _ = protected(np.zeros(100), BUSY)
    inside = pulses(100, [(0.0, 0.1), (0.4, 0.6)])
    assert outside_events(recording, settled=0.1).tolist() == (inside == 0).tolist()


def test_excursions_inside_and_outside_events_are_counted_and_timed():
    error = np.full(100, 0.001)
    error[42:47] = -0.05  # in the event: 5 samples
    error[80] = 0.03  # outside
    counts = excursions(*protected(error, BUSY), settled=0.1)
    assert (counts["excursions"], counts["samples_outside"]) == (2, 1)
    assert counts["longest"] == pytest.approx(5 * PERIOD)
    assert counts["largest"] == pytest.approx(0.05)
    assert counts["outside"] == pytest.approx(0.03)
    assert not counts["kept"]


@pytest.mark.parametrize(
    ("length", "error", "busy", "is_kept"), [(10, 0.05, 1.0, True), (11, 0.05, 1.0, False), (50, np.nan, 0.0, False)]
)
def test_a_short_excursion_in_an_event_is_allowed_and_a_long_one_or_nan_is_not(length, error, busy, is_kept):
    errors = np.zeros(100)
    errors[50 : 50 + length] = error
    assert excursions(*protected(errors, np.full(100, busy)), settled=0.0)["kept"] is is_kept


def test_the_benchmark_steps_the_filter_of_the_rig():
    """In microseconds: more than a Python call, less than a hundredth of a second on any machine."""
    ((_, figure, _),) = of_rig(share=0.0025)
    assert 0.1 <= float(figure.removesuffix(" µs")) < 1e4


def test_encoder_errors_have_the_variance_of_equation_20():
    """Rounding to steps of √(12 R) has the variance R if the speed passes many steps; 1e5 samples give it to 1 %."""
    speed = np.linspace(33.0, 1.0, 100_000)
    for encoder in rig_tests.ENCODERS[1:]:
        first, second = (rig_tests.encode(speed, encoder, draw) - speed for draw in (0, 1))
        assert np.var(first) == pytest.approx(rig_tests.R_OF_SPEED, rel=0.02)
        assert not np.array_equal(first, second)
    assert np.array_equal(rig_tests.encode(speed, rig_tests.ENCODERS[0], 0), speed)


@pytest.mark.parametrize("name", ["rig_slide", "rig_sand"])
@pytest.mark.parametrize("period", [5e-3, 10e-3, 12e-3, 16e-3, 20e-3, 30e-3])
def test_every_period_of_the_study_is_a_scenario_whose_samples_have_that_distance(name, period):
    """The plant takes at most 10 ms a step; readings are sampled every period."""
    scenario = resample(name, period, 1e-4).revised({"limits": {"horizon": "1 s"}})
    assert scenario.periods.communication <= 10e-3
    time = recording_of_rig(scenario)["time"].values
    assert np.diff(time) == pytest.approx(np.full(time.size - 1, period), abs=1e-9)
    assert time.size >= 1.0 / period - 1


def test_brake_applications_before_the_long_pause_are_the_short_ones():
    begins = (18.0, 24.0, 30.0, 42.0, 44.0, 46.0, 48.0)
    force = pulses(6000, [(begin, begin + 1.0) for begin in begins], 2e4)
    short, stop, rate = brakings(recording_of({"pad_force": (force, "N")}, period=PERIOD))
    assert stop == pytest.approx(42.0, abs=2 * PERIOD)
    assert np.ravel(short) == pytest.approx([18.0, 19.0, 24.0, 25.0, 30.0, 31.0], abs=2 * PERIOD)
    # Four brake applications until the end, at 60 s.
    assert rate == pytest.approx(4 / 18, rel=1e-3)


def test_errors_above_the_limit_count_once_per_interval_in_the_deep_slide():
    error = pulses(1300, [(1.0, 1.1), (4.0, 4.2), (6.0, 6.01), (12.0, 12.5)], -1.1 * LIMIT)
    error += pulses(1300, [(8.0, 8.5)], 0.9 * LIMIT)
    counts = excursions(*protected(error, np.zeros(1300)), settled=0.5)
    assert (counts["peaks"], counts["excursions"]) == (2, 4)


@pytest.mark.parametrize(
    ("begin", "end", "expected"),
    [(0.0, 0.3, 0.3), (0.2, 0.4, 0.4), (0.0, 0.0, 0.0), (0.0, 1.5, np.inf), (2.5, 2.6, 0.0)],
)
def test_the_start_is_corrected_when_the_error_stays_within_the_limit(begin, end, expected):
    found = settling(*protected(pulses(300, [(begin, end)], 1.5 * LIMIT), np.zeros(300)))
    assert found == pytest.approx(expected, abs=PERIOD / 10)


def test_the_response_of_a_lag_is_its_time_constant():
    """Pad force with a lag of 0.2 s behind two interventions."""
    busy, force = pulses(2000, [(4.0, 7.0), (12.0, 15.0)]), np.full(2000, 4e4)
    for begin in (400, 1200):
        force[begin : begin + 300] *= np.exp(-PERIOD * np.arange(300) / 0.2)
    recording = recording_of({"pad_force": (force, "N"), "protecting": (busy, "1")}, period=PERIOD)
    assert response(recording) == pytest.approx(0.2, abs=2 * PERIOD)


@pytest.fixture(scope="module")
def slide():
    """Points and lines of figure 3: part → slips and adhesions."""
    return pd.DataFrame(rig_tests.slide_rows("rig_sand"))


def test_the_release_is_beyond_the_peak_and_the_wheelset_returns_over_it(slide):
    peak, released, rolling = (slide[slide["part"] == part].iloc[0] for part in ("peak", "released", "rolling"))
    assert rolling.slip < peak.slip < released.slip
    assert max(released.adhesion, rolling.adhesion) < 0.7 * peak.adhesion
    way = slide[slide["part"] == "way"]
    assert way["slip"].iloc[0] == way["slip"].max() == released.slip
    assert np.mean(np.diff(way["slip"]) < 0) > 0.99
    # Friction scatters by 5 % along the roller.
    assert way["adhesion"].max() == pytest.approx(peak.adhesion, rel=0.1)
    assert 0.3 * peak.slip < way["slip"][way["adhesion"].idxmax()] < 3 * peak.slip
    # The curve has 60 points between 0.1 and 50 %; the friction of a row holds until the next one.
    curve = slide[slide["part"] == "curve"]
    assert np.interp(released.slip, curve["slip"], curve["adhesion"]) == pytest.approx(released.adhesion, rel=0.01)
