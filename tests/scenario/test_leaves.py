"""Patches of leaves are positioned by a Poisson process, on the same rail for every wheelset and every horizon."""

from pathlib import Path

import numpy as np
import pytest
from sampling import FUZZ
from scipy import stats
from synthetic import TWO_PART_TRAIN

from railgrip.report.reference import creep_curves_of
from railgrip.scenario.adhesion import profile_of
from railgrip.scenario.load import scenario_of
from railgrip.vehicle.formation import Formation

LEAVES = {"kind": "leaves", "polach": "wet", "mu0": 0.2, "count": "10 1/km", "shortest": "5 m", "longest": "15 m",
          "minimum": 0.03, "maximum": 0.05}  # fmt: skip


def rail(seed=1, horizon=100.0, **leaves):
    table = {
        "name": "leaves", "description": "", "seed": seed, "start": {"speed": "100 m/s"},
        "vehicle": {"plant": "TwoPartTrain"}, "controller": {"kind": "full_brake"}, "estimator": {"kind": "none"},
        "sensors": {"kind": "ideal"}, "actuation": {"kind": "ideal"}, "adhesion": LEAVES | leaves,
        "limits": {"horizon": horizon, "alpha_max": 0.15} if horizon else {"alpha_max": 0.15},
    }  # fmt: skip
    return scenario_of(table, directory=Path(), origin="leaves")


ONE_WHEELSET = Formation((1,), (1,), (0.0,))
RAILS = 100 if FUZZ else 40
STEP = 5e-3  # m, step of the grid on which profiles over distance are tabulated


def patches_of(scenario):
    """Return starts, lengths [m] and frictions of the patches of a rail; overlapping patches are merged."""
    found = profile_of(scenario, ONE_WHEELSET)
    mu0 = found.mu0_at[:, 0]
    edges = np.flatnonzero(np.diff(mu0 < 0.2, prepend=False, append=False))
    begins, ends = edges[::2] * found.step, edges[1::2] * found.step
    return begins, ends - begins, mu0[edges[::2]]


def test_starts_are_a_poisson_process_of_the_given_count():
    """Patches of a few steps of the grid do not overlap: rails of 10 km, 10 patches/km."""
    counts, gaps = [], []
    for seed in range(RAILS):
        begins, _, _ = patches_of(rail(seed=seed, shortest="0.01 m", longest="0.02 m"))
        counts += np.histogram(begins, bins=np.arange(0.0, 10_001.0, 1000.0))[0].tolist()
        gaps += np.diff(begins).tolist()
    # n stretches of 1 km with 10 each on average: the standard error is √(10/n). Mean and variance are equal; the
    # variance of n such counts scatters by √(2.1/n), 5 % for 1000 of them. Bounds are four standard errors.
    n = len(counts)
    assert np.mean(counts) == pytest.approx(10.0, abs=4 * np.sqrt(10.0 / n))
    assert np.var(counts) == pytest.approx(10.0, rel=4 * np.sqrt(2.1 / n))
    # Gaps are exponential with mean 100 m. One of 5,000 patches merges, which is negligible.
    assert stats.kstest(gaps, stats.expon(scale=100.0).cdf).pvalue > 1e-3


def test_a_horizon_that_is_not_given_follows_from_the_lowest_friction():
    good = {"mu0": 0.9, "minimum": 0.8, "maximum": 0.9}
    assert rail(horizon=None).horizon > rail(horizon=None, **good).horizon
    assert rail(horizon=None, **good | {"minimum": 0.03}).horizon == rail(horizon=None).horizon


def test_lengths_and_frictions_are_uniform_within_their_limits():
    """Patches are few, 2 per kilometre, so that hardly any overlap; a merged one is longer than the maximum."""
    lengths, frictions = [], []
    for seed in range(100):
        begins, each, mu0 = patches_of(rail(seed=seed, count="2 1/km"))
        alone = (each <= 15.0) & (begins > 0)
        lengths += each[alone].tolist()
        frictions += mu0[alone].tolist()
    assert len(lengths) > 1500
    assert 5.0 - STEP <= min(lengths) <= max(lengths) <= 15.0
    assert stats.kstest(lengths, stats.uniform(5.0, 10.0).cdf).pvalue > 1e-3
    assert stats.kstest(frictions, stats.uniform(0.03, 0.02).cdf).pvalue > 1e-3


def test_the_covered_share_of_a_rail_is_that_of_overlapping_patches():
    """A place is free if no patch starts within its length before: e^(−count × mean length) (Hall, 1988, chapter 2)."""
    shares = [
        np.mean(profile_of(rail(seed=seed, count="100 1/km", horizon=20.0), ONE_WHEELSET).mu0_at == 0.2)
        for seed in range(40)
    ]
    # 40 rails of 2 km with some 80 free stretches each: standard error 0.006.
    assert np.mean(shares) == pytest.approx(np.exp(-1.0), abs=0.025)


def test_the_later_of_overlapping_patches_covers_the_earlier():
    """With patches of equal length none covers the last of a group: the friction before its end holds for 10 m."""
    mu0 = profile_of(
        rail(seed=3, count="200 1/km", horizon=20.0, shortest="10 m", longest="10 m"), ONE_WHEELSET
    ).mu0_at[:, 0]
    turns = np.flatnonzero(np.abs(np.diff(mu0)) > 1e-12)  # above rounding
    ends = [k for k in range(1, len(turns)) if mu0[turns[k] + 1] == 0.2]
    heaps = sum(mu0[turns[k - 1]] != 0.2 for k in ends)  # more than one patch
    assert heaps > 20
    last = np.array([turns[k] - turns[k - 1] for k in ends]) * STEP
    assert last == pytest.approx(10.0, abs=2 * STEP)


def test_every_wheelset_passes_the_same_rail_and_a_longer_horizon_moves_no_patch():
    scenario = rail(seed=5)
    found = profile_of(scenario, TWO_PART_TRAIN)
    # Both grids have 5 mm: the position of a wheelset is within half a step of a point of the first one's grid.
    steps = np.round(TWO_PART_TRAIN.position / found.step).astype(int)
    for wheelset, step in enumerate(steps):
        moved = found.mu0_at[step:, wheelset]
        assert np.mean(moved == found.mu0_at[: len(moved), 0]) > 1 - 1e-3
    longer = profile_of(rail(seed=5, horizon=150.0), TWO_PART_TRAIN).mu0_at
    assert (longer[: len(found.mu0_at) - 10_000] == found.mu0_at[:-10_000]).all()
    assert (profile_of(rail(seed=5), TWO_PART_TRAIN).mu0_at == found.mu0_at).all()
    assert (profile_of(rail(seed=6), TWO_PART_TRAIN).mu0_at != found.mu0_at).any()


def test_patches_have_edges_and_a_separate_creep_curve():
    scenario = rail(edge="1 m", polach_of_patches="leaf", count="2 1/km")
    found = profile_of(scenario, TWO_PART_TRAIN)
    inside = found.mu0_at < 0.114  # past the middle of an edge, which is at 0.115 to 0.125
    assert [curve.name for curve in scenario.adhesion.curves] == ["wet", "leaf"]
    assert (found.curve_at == 1)[inside].all()
    assert (found.curve_at == 0)[found.mu0_at == 0.2].all()
    steepest = np.abs(np.diff(found.mu0_at[:, 0])).max()
    assert steepest == pytest.approx(0.17 * found.step, rel=0.02)  # from 0.2 to 0.03 over 1 m, the maximum
    assert creep_curves_of(scenario.resolved()) == "wet, leaf"
