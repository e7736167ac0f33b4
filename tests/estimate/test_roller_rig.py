"""The roller rig obeys its closed forms, and its filters keep what the paper reports, on the first slides."""

from pathlib import Path

import numpy as np
import pytest

from railgrip.estimation.judge import judge
from railgrip.estimation.spec import LIBRARY, estimate_of, load_specification
from railgrip.scenario.load import load
from railgrip.studies.roller_rig import excursions, recording_of_rig
from railgrip.trace.samples import reading_of, truth_of


def shortened(name, horizon, **changes):
    keys = [f"{key.replace('__', '.')}={value}" for key, value in changes.items()]
    return load(Path(f"rig_{name}"), [f"limits.horizon='{horizon} s'", *keys])


@pytest.fixture(scope="module")
def sand():
    return recording_of_rig(shortened("sand", 12.0))


def test_the_roller_loses_what_contact_and_drag_take(sand):
    """m dv = -(contact force + drag) dt: the imitated wagon, from outputs of the rig alone."""
    v, time = truth_of(sand, "v"), sand["time"].values
    force = reading_of(sand, "contact_force") + 1.2 / 2 * 0.9 * 5.2 * v**2
    loss = np.trapezoid(force, time) / 20e3
    # Load cells: 100 N of white noise over 2400 samples of 5 ms are 25 N.s, 1e-3 m/s; the rest is the trapezoid rule.
    assert v[0] - v[-1] == pytest.approx(loss, abs=5e-3)


def test_load_cells_show_the_adhesion_without_bias(sand):
    error = reading_of(sand, "contact_force") / reading_of(sand, "wheelset_load") - truth_of(sand, "alpha")
    # 100 N on 98 kN is 1e-3 a sample; the mean over 2400 of them 2e-5.
    assert np.std(error) == pytest.approx(1.0e-3, rel=0.1)
    assert np.mean(error) == pytest.approx(0.0, abs=1e-4)


def test_adhesion_passes_its_peak_falls_comes_back_and_goes_to_zero(sand):
    """Figure 6 of Schwarz and Keck (2020): 0.1, 0.05, after release 0.1 again, then 0."""
    part = sand.sel(time=slice(3.0, 8.0))
    alpha, slip = truth_of(part, "alpha"), truth_of(part, "slip")
    deepest = int(np.argmax(slip))
    first, second = alpha[:deepest], alpha[deepest:]
    assert first.max() == pytest.approx(0.095, abs=0.01)
    assert alpha[deepest] == pytest.approx(0.052, abs=0.006)
    assert second.max() == pytest.approx(0.09, abs=0.01)
    assert second[np.argmax(second) :].min() < 0.005


@pytest.mark.parametrize("name", ["rig_paper", "rig_own"])
def test_adhesion_is_kept_within_002_on_the_sanded_roller(sand, name):
    estimates = estimate_of(load_specification(LIBRARY / f"{name}.toml"), sand)
    counts = excursions(sand, estimates, settled=0.5)
    assert counts["kept"]
    assert estimates.attrs["ended"] == ""
    steady = sand["time"].values > 4.0
    judgement = judge(sand, estimates, "alpha", steady)
    assert judgement.rmse < 0.3 * judgement.constant
    constant = estimates.copy(deep=True)
    constant["mean"].loc[{"state": "alpha"}] = truth_of(sand, "alpha")[steady].mean()
    assert not excursions(sand, constant, settled=0.5)["kept"]


def test_equation_20_claims_far_less_than_it_knows_and_ours_about_what_it_knows(sand):
    after = sand["time"].values > 4.0
    paper, own = (estimate_of(load_specification(LIBRARY / f"{n}.toml"), sand) for n in ("rig_paper", "rig_own"))
    assert judge(sand, paper, "mu_b", after).nees < 0.01
    assert 0.1 < judge(sand, own, "mu_b", after).nees < 10.0
    assert judge(sand, own, "alpha", after).rmse < judge(sand, paper, "alpha", after).rmse


def test_short_brakings_under_oil_slide_at_two_to_five_hundredths():
    slide = recording_of_rig(shortened("slide", 22.0))
    sliding = truth_of(slide, "slip") > 0.05
    assert sliding.sum() > 100
    alpha = truth_of(slide, "alpha")[sliding]
    assert alpha.min() > 0.015
    assert alpha.max() < 0.055


def test_pad_friction_holds_still_while_the_pads_are_released():
    """The gate of our filter: no reading tells it, so neither mean nor spread moves; the paper's spread grows."""
    coasting = recording_of_rig(shortened("slide", 10.0))
    own, paper = (estimate_of(load_specification(LIBRARY / f"{n}.toml"), coasting) for n in ("rig_own", "rig_paper"))
    assert np.ptp(own["sd"].sel(state="mu_b").values) < 1e-12
    deviations = paper["sd"].sel(state="mu_b").values
    # Q33 = 1e-3 is added 2000 times; 100 N of load cell noise takes next to nothing of it back.
    assert deviations[-1] == pytest.approx(np.sqrt(0.04**2 + 2000 * 1e-3), rel=0.05)


def test_the_same_seed_gives_the_same_recording_and_another_seed_another_one():
    short = shortened("sand", 1.0)
    first, again, other = (
        recording_of_rig(short),
        recording_of_rig(short),
        recording_of_rig(shortened("sand", 1.0, seed=1)),
    )
    assert first.identical(again)
    assert not np.array_equal(reading_of(first, "speed"), reading_of(other, "speed"))


def test_a_fifth_of_the_period_moves_the_speed_by_little():
    """Valves are switched at the same instants; the plant's own solver decides the rest."""
    coarse, fine = (
        recording_of_rig(
            shortened(
                "sand", 6.0, adhesion__scatter=0, sensors__noise__speed=0, sensors__noise__wheelset_speed=0,
                periods__communication=period, periods__estimator=period, periods__trace=period,
            )
        )
        for period in (5e-3, 1e-3)
    )  # fmt: skip
    # mu0 is held over a period: a period of its slowest ramp is nothing; tolerance 1e-5 of the solver over 55 m/s.
    assert truth_of(fine, "v")[-1] == pytest.approx(truth_of(coarse, "v")[-1], abs=5e-3)


# Seconds to the stop, mean and deviation over ten seeds, of the loop that the rig once had. With the draws of that one
# and with friction of the end of a step in place of its beginning, this loop gives its recordings bit by bit.
ONCE = {"slide": (133.50, 0.70), "sand": (97.68, 1.36)}


@pytest.mark.parametrize("name", ONCE)
def test_a_run_lasts_as_long_as_it_did_in_a_loop_of_its_own(name):
    """Four deviations of one run; another demand, law, surface or mass is off by ten and more."""
    mean, deviation = ONCE[name]
    durations = [float(recording_of_rig(shortened(name, 170.0, seed=seed))["time"][-1]) for seed in (1, 2)]
    assert np.mean(durations) == pytest.approx(mean, abs=4 * deviation / np.sqrt(2))
