"""The joint estimate over stops equals closed forms and its intervals hold; designs of releases are optimal."""

from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest
from fleet_stops import (
    CANDIDATES,
    STARTS,
    Releases,
    TrainStops,
    design,
    in_order,
    log_determinant,
    needed_row,
    stop_estimate,
)
from scipy.linalg import block_diag

from railgrip.estimation.fleet import Hierarchy, StopEstimate, estimate_fleet
from railgrip.studies.pad_monitor.evidence import evidence_of
from railgrip.studies.pad_monitor.life import Life, Release, braking_pressures, demand_table, live

GROUPS, TRAINS, STOPS = 4, 5, 12


def fleet(seed: int, hierarchy: Hierarchy) -> tuple[list[StopEstimate], np.ndarray, np.ndarray, np.ndarray]:
    """Draw a fleet from its prior; return its stops, lot means, quantities and offsets.

    A stop estimates pads, load and radius: the load makes pads seem worse, offsets of pressure and load add errors.
    """
    random = np.random.default_rng(seed)
    lot = hierarchy.lot_mean + hierarchy.lot_deviation * random.standard_normal(hierarchy.lot_mean.size)
    normal = random.standard_normal((TRAINS, hierarchy.train_deviation.size))
    trains = hierarchy.lots @ lot + hierarchy.train_deviation * normal
    offsets = hierarchy.offset_deviation * random.standard_normal((TRAINS, hierarchy.offset_deviation.size))
    of_quantities = np.eye(GROUPS + 2)
    of_quantities[:GROUPS, GROUPS] = -1.0
    stops: list[StopEstimate] = []
    for train in np.repeat(np.arange(TRAINS), STOPS):
        of_offsets = np.diag(np.append(random.uniform(0.5, 2.0, GROUPS), 1.0))
        of_offsets = np.vstack([of_offsets, np.zeros(GROUPS + 1)])
        root = 0.03 * random.standard_normal((GROUPS + 2, GROUPS + 2))
        x = trains[train] + hierarchy.stop_deviation * random.standard_normal(GROUPS + 2)
        y = of_quantities @ x + of_offsets @ offsets[train] + root @ random.standard_normal(GROUPS + 2)
        stops.append(
            StopEstimate(
                train=int(train),
                mean=y,
                covariance=root @ root.T,
                of_quantities=of_quantities,
                of_offsets=of_offsets,
            )
        )
    return stops, lot, trains, offsets


@pytest.fixture(scope="module")
def hierarchy() -> Hierarchy:
    """Pads of all groups are from one lot; loads and radii have separate means."""
    lots = np.zeros((GROUPS + 2, 3))
    lots[:GROUPS, 0] = lots[GROUPS, 1] = lots[GROUPS + 1, 2] = 1.0
    return Hierarchy(
        lots=lots,
        lot_mean=np.array([1.0, 0.0, 0.0]),
        lot_deviation=np.array([0.1, 0.05, 0.02]),
        train_deviation=np.array([*[0.05] * GROUPS, 0.02, 0.01]),
        stop_deviation=np.array([*[0.02] * GROUPS, 0.05, 0.0]),
        offset_deviation=np.array([*[0.02] * GROUPS, 0.01]),
    )


def test_a_fleet_equals_the_conditional_of_one_gaussian(hierarchy):
    """All quantities and offsets are linear in independent normal numbers, and so are all stops at once."""
    stops, *_ = fleet(0, hierarchy)
    found = estimate_fleet(stops, hierarchy, TRAINS)
    (n, q), c = hierarchy.lots.shape, hierarchy.offset_deviation.size
    of_train = np.diag(np.append(hierarchy.train_deviation, hierarchy.offset_deviation))
    root = block_diag(np.diag(hierarchy.lot_deviation), *[of_train] * TRAINS)
    mean, rows = np.concatenate([hierarchy.lot_mean, np.zeros(TRAINS * (n + c))]), []
    for train in range(TRAINS):
        first = q + train * (n + c)
        root[first : first + n, :q] = hierarchy.lots * hierarchy.lot_deviation
        mean[first : first + n] = hierarchy.lots @ hierarchy.lot_mean
    for stop in stops:
        before, after = q + stop.train * (n + c), (TRAINS - 1 - stop.train) * (n + c)
        rows.append(np.pad(np.hstack([stop.of_quantities, stop.of_offsets]), ((0, 0), (before, after))))
    scattered = [stop.of_quantities * hierarchy.stop_deviation for stop in stops]
    noise = block_diag(*(stop.covariance + one @ one.T for stop, one in zip(stops, scattered, strict=True)))
    prior, seen = root @ root.T, np.vstack(rows)
    gain = np.linalg.solve(seen @ prior @ seen.T + noise, seen @ prior).T
    solution = mean + gain @ (np.concatenate([stop.mean for stop in stops]) - seen @ mean)
    deviation = np.sqrt(np.diag(prior - gain @ seen @ prior))
    np.testing.assert_allclose(found.lot, solution[:q], atol=1e-10)
    np.testing.assert_allclose(found.lot_deviation, deviation[:q], rtol=1e-8)
    trains = solution[q:].reshape(TRAINS, n + c)
    np.testing.assert_allclose(np.hstack([found.trains, found.offsets]), trains, atol=1e-10)
    np.testing.assert_allclose(found.train_deviation, deviation[q:].reshape(TRAINS, n + c)[:, :n], rtol=1e-8)


def test_intervals_of_95_per_cent_hold(hierarchy):
    """One train of each of 400 synthetic fleets, so that the intervals of one quantity are independent."""
    seeds = 400
    inside = np.zeros(hierarchy.train_deviation.size + hierarchy.offset_deviation.size + hierarchy.lot_mean.size)
    for seed in range(seeds):
        stops, lot, trains, offsets = fleet(seed, hierarchy)
        found = estimate_fleet(stops, hierarchy, TRAINS)
        error = np.concatenate([found.trains[0] - trains[0], found.offsets[0] - offsets[0], found.lot - lot])
        deviation = np.concatenate([found.train_deviation[0], found.offset_deviation[0], found.lot_deviation])
        inside += np.abs(error) < 1.96 * deviation
    # Binomial: a share of 0.95 of 400 has a deviation of 0.011; three of it for each of 14 quantities.
    assert np.abs(inside / seeds - 0.95).max() < 3.0 * np.sqrt(0.95 * 0.05 / seeds)
    assert (inside / seeds).min() > 0.90
    assert (inside / seeds).max() < 0.98


def test_the_effect_of_an_offset_does_not_depend_on_the_estimate(monkeypatch):
    """Otherwise offsets explain the scatter of the stops, and the pads of a fleet are underestimated."""
    recording, temperature = next(live(Life(stops=1, seed=1)))
    evidence = evidence_of(recording, temperature)
    stops: list[StopEstimate] = []
    for factor in (1.0, 1.1):
        changed = replace(evidence, health=factor * evidence.health, offset=factor * evidence.offset)
        monkeypatch.setattr("fleet_stops.evidence_of", lambda *_, found=changed: found)
        stops.append(stop_estimate(recording, temperature))
    np.testing.assert_allclose(stops[1].of_offsets, stops[0].of_offsets, rtol=1e-12)


def test_exchanges_find_the_design_of_an_exhaustive_search():
    """All pairs of eight releases, by the information of the train's prediction."""
    candidates = [r for r in CANDIDATES if r.start in STARTS[:2] and np.isinf(r.drop)]
    pairs = [in_order(pair) for pair in combinations(candidates, 2)]
    best = max(pairs, key=log_determinant)
    assert log_determinant(design(candidates, 2)) == pytest.approx(log_determinant(best), abs=1e-12)


def test_exchanges_correct_a_greedy_choice():
    """Releases as vectors with the information x xᵀ: the best pair does not contain the best single one."""
    vectors = dict(zip(CANDIDATES[:3], np.array([[2.0, 2.0], [2.5, 0.0], [0.0, 2.5]]), strict=True))

    def criterion(releases: Releases) -> float:
        rows = np.array([vectors[release] for release in releases])
        return float(np.linalg.slogdet(1e-3 * np.eye(2) + rows.T @ rows)[1])

    assert criterion((CANDIDATES[0],)) > max(criterion((CANDIDATES[1],)), criterion((CANDIDATES[2],)))
    assert design(CANDIDATES[:3], 2, criterion) == in_order(CANDIDATES[1:3])


def test_stops_needed_and_longer_stops_have_closed_answers(monkeypatch):
    """Deviations that fall with the root of the number of stops, and distances of stops that are 40 m longer."""

    def trains(releases, *_):
        longer = 40.0 if releases != "none" else 0.0
        distances = (100.0 + longer, 102.0 + longer)
        return [TrainStops(estimates=(), distances=distances, pads=np.ones(4), radii=np.zeros(4))]

    monkeypatch.setattr("fleet_stops.simulate", trains)
    first = np.array([0.1, 0.2, 0.05, 0.5])
    monkeypatch.setattr("fleet_stops.deviation_alone", lambda _, count: first / np.sqrt(count))
    row = needed_row("each group in turn", 1, 20)
    assert row == {"longer stop": 40.0, "group 1": 4, "group 2": 16, "group 3": 1, "group 4": None}


def test_releases_may_overlap():
    full = np.array([3e5, 2e5, 2e5, 3e5])
    releases = (
        Release(group=0, start=1.0, duration=2.0, drop=1e5),
        Release(group=2, start=2.0, duration=2.0),
    )
    pressures = [braking_pressures(full, releases, time).tolist() for time in (0.5, 1.5, 2.5, 3.5, 4.5)]
    assert [row[0] for row in pressures] == [3e5, 2e5, 2e5, 3e5, 3e5]
    assert [row[2] for row in pressures] == [2e5, 2e5, 0.0, 0.0, 2e5]
    phases = demand_table(full, releases, np.zeros(4))["phases"]
    assert [phase["pressure"] for phase in phases[1:]] == pressures
