"""The ideal bound where slip cleans the rail: against dynamic programming, the plant, and stops on random rails."""

from functools import partial

import numpy as np
import pytest
import xarray
from sampling import sample
from scipy.ndimage import map_coordinates
from synthetic import LIBRARY

from railgrip.scenario.file import merge
from railgrip.scenario.load import load, read_toml, scenario_of
from railgrip.scenario.surface import Recovery
from railgrip.simulate.contact import SLIPS_OF_TWO_MAXIMA, CleanedContact, with_energy
from railgrip.simulate.ideal import tracking_stop
from railgrip.simulate.run import run_stop
from railgrip.simulate.vehicle_data import VehicleData
from railgrip.trace.bound import peak

WRITTEN = "adhesion.recovery={mu0=0.3, A=0.4, B=0.6, rate='1.9e-4 m/J'}"
COARSE = {"periods": dict.fromkeys(("communication", "estimator", "controller", "trace"), "10 ms")}
"""Of the bound, whose distance hardly depends on the grid (test_ideal_bound.py)."""
LOAD, MASS, APART, SPEED, END = 14e3 * 9.81, 14e3, 4.0, 12.0, 0.5
"""A train of wheelsets: load [N] and mass [kg] of each, spacing [m], speed at start and end [m/s]."""


def scenario(*changes):
    fixed = ["estimator.kind=none", "limits.alpha_max=1", "adhesion.mu0=0.05", "controller.kind=full_brake"]
    return load(LIBRARY / "plain.toml", [*fixed, *changes])


def contact_of(rate):
    vehicle = VehicleData(scenario())
    return CleanedContact(vehicle.contact, Recovery(mu0=0.3, A=0.4, B=0.6, rate=rate), vehicle.curves[0])


def by_bound(contact, mu0, wheelsets, period=0.01):
    """Return the distance of the bound, of wheelsets in groups of one with brakes of any strength."""
    time = np.arange(3000) * period
    speed, before = np.maximum(SPEED - 0.3 * time, 0.0), 0.0
    while True:
        count = int(np.argmax(speed <= END)) or len(speed)
        distance = np.concatenate([[0.0], np.cumsum((speed[1:] + speed[:-1]) / 2 * period)])
        if abs(distance[count - 1] - before) < 1e-3:
            return before
        before, same = distance[count - 1], np.ones((count, wheelsets))
        of_all = ("time", "wheelset")
        trace = xarray.Dataset(
            {
                "speed": ("time", speed[:count]), "distance": ("time", distance[:count]),
                "wheelset_load": (of_all, LOAD * same), "mu0": (of_all, mu0 * same),
                "wheelset_position": ("wheelset", APART * np.arange(wheelsets)),
            },
            coords={"time": time[:count]},
        )  # fmt: skip
        energy, one = with_energy(trace, contact)["energy_ahead"].values, same[:, :1]
        slowing = sum(
            peak(partial(contact, energy=each[:, None]), speed[:count], LOAD * one, mu0 * one, SLIPS_OF_TWO_MAXIMA)[1]
            for each in energy.T
        )[:, 0] * LOAD / (MASS * wheelsets)  # fmt: skip
        slowing = np.concatenate([slowing, np.full(len(speed) - count, slowing[-1])])
        lost = np.cumsum((slowing[1:] + slowing[:-1]) / 2 * period)
        speed = np.maximum(SPEED - np.concatenate([[0.0], lost]), 0.0)


def by_dynamic_programming(contact, mu0, wheelsets, energies, levels=12, slips=30):
    """Return the shortest distance of one or two wheelsets on a grid of kinetic energies and slip energies.

    The step is the spacing. The state is the kinetic energy, and the slip energy on the step between the wheelsets; the
    second wheelset uses its best slip, because no wheelset follows it.
    """
    grid, slip = np.linspace(END**2 / 2, SPEED**2 / 2, energies), np.geomspace(2e-3, 1.0, slips)
    speed, slip = np.meshgrid(np.sqrt(2 * grid), slip, indexing="ij")
    same = np.ones(speed.shape)
    first = contact(slip, speed, LOAD * same, mu0 * same) * LOAD
    left = np.linspace(0.0, (first * slip / 2).max(), levels)
    second = np.zeros((energies, levels))
    if wheelsets == 2:
        met = [contact(slip, speed, LOAD * same, mu0 * same, energy=energy * same) for energy in left]
        second = np.max(met, axis=2).T * LOAD
    distance = np.tile((grid - END**2 / 2)[:, None] / (0.02 * 9.81), levels)
    while True:
        options = []
        for force, energy in zip(first.T, (first * slip / 2).T, strict=True):
            fall = APART * (force[:, None] + second) / (MASS * wheelsets)
            place = (grid[:, None] - fall - grid[0]) / (grid[1] - grid[0])
            level = np.broadcast_to(energy[:, None] / left[1], place.shape)
            rest = map_coordinates(distance, [place, level], order=1, mode="nearest")
            share = np.minimum((grid[:, None] - grid[0]) / fall, 1.0)
            options.append(np.where(share < 1.0, APART * share, APART + rest))
        before, distance = distance, np.min(options, axis=0)
        if np.abs(distance - before).max() < 1e-6:
            return distance[-1, 0]


@pytest.mark.parametrize(("rate", "mu0"), [(1.9e-4, 0.05), (5e-5, 0.08)])
def test_for_one_wheelset_the_bound_is_the_optimum(rate, mu0):
    """Dynamic programming of the first order in its grid, extrapolated from a grid and one twice as fine.

    The bound has no error by that: the best slip of a wheelset with none behind it is that of the highest adhesion.
    """
    contact, distances = contact_of(rate), []
    for factor in (1, 2):
        steps = dict(energies=60 * factor, levels=2)
        with pytest.MonkeyPatch.context() as patch:
            patch.setitem(globals(), "APART", 4.0 / factor)
            distances.append(by_dynamic_programming(contact, mu0, 1, **steps))
    extrapolated = 2 * distances[1] - distances[0]
    assert by_bound(contact, mu0, 1) == pytest.approx(extrapolated, rel=5e-3)


@pytest.mark.parametrize(
    ("rate", "mu0", "gap"), sample([(1.9e-4, 0.05, 0.015), (1e-4, 0.08, 0.058), (5e-5, 0.08, 0.175)], 2)
)
def test_for_two_wheelsets_the_optimum_is_not_shorter(rate, mu0, gap):
    """Where locked wheels have the highest adhesion the bound is close; elsewhere cleaning costs adhesion."""
    contact = contact_of(rate)
    best = by_dynamic_programming(contact, mu0, 2, 60)
    assert best == pytest.approx(by_dynamic_programming(contact, mu0, 2, 120, levels=24), rel=3e-3)
    assert best / by_bound(contact, mu0, 2) - 1.0 == pytest.approx(gap, abs=5e-3)


def drawn(number):
    """Return a random scenario, the same one in each run."""
    draw = np.random.default_rng((21, number))
    mean, gap = float(draw.uniform(0.03, 0.12)), int(draw.choice([5, 15, 50]))
    points = (draw.uniform(0.4, 1.6, draw.integers(2, 12)) * mean).tolist()
    rails = (
        {"kind": "constant", "mu0": mean},
        {"kind": "points", "over": "distance", "points": [[f"{gap * i} m", mu0] for i, mu0 in enumerate(points)]},
    )  # fmt: skip
    clean = [{"mu0": 0.3, "A": 0.4, "B": 0.6, "rate": 1.9e-4}, {"mu0": 0.2, "A": 0.4, "B": 0.2, "rate": 1.9e-5},
             {"mu0": 0.25, "A": 1.0, "B": 0.0, "rate": float(draw.uniform(1e-5, 4e-4))}]  # fmt: skip
    curve = str(draw.choice(["dry", "soap", "leaf", "poor_wheelset_study", "wet_two_maxima", "leaves_two_maxima"]))
    recovery = {} if curve.endswith("maxima") else {"recovery": clean[draw.integers(3)]}
    rail = rails[draw.integers(2)] | {"polach": curve} | recovery
    return rail, float(draw.uniform(30.0, 120.0)), float(draw.uniform(-0.01, 0.02))


@pytest.mark.parametrize("number", sample([14, *range(14), *range(15, 30)], 1))
def test_no_stop_is_shorter_than_the_bound(number):
    """By more than 0.1 %, with slips below the first maximum, above it, and locked wheels."""
    rail, speed, gradient = drawn(number)
    changes = {
        "adhesion": rail, "start": {"speed": f"{speed} km/h"}, "estimator": {"kind": "none"},
        "limits": {"alpha_max": 1.0, "horizon": "300 s"}, "truth": {"gradient": gradient},
        "periods": dict.fromkeys(("communication", "estimator", "controller", "trace"), "2 ms"),
    }  # fmt: skip
    table = merge({k: v for k, v in read_toml(LIBRARY / "plain.toml").items() if k != "adhesion"}, changes)

    def distance(controller, periods=()):
        changed = merge(table, {"controller": controller, **dict(periods)})
        stop = run_stop(scenario_of(changed, directory=LIBRARY, origin="test"))
        assert stop.outcome.value == "standstill"
        return stop.metrics.distance

    bound = distance({"kind": "ideal_bound"}, COARSE)
    for low, high in sample([(0.03, 0.05), (0.2, 0.3), (0.5, 0.7)], 2):
        assert distance({"kind": "slip_two_state", "parameters": {"low": low, "high": high}}) > 0.999 * bound
    assert distance({"kind": "full_brake"}) > 0.999 * bound


def test_no_held_slip_is_shorter_than_the_bound_of_the_named_case():
    """The dry curve of low friction, cleaned: groups with locked wheels, and the last one below the first maximum."""
    coarse = scenario(WRITTEN).revised(COARSE)
    bound = run_stop(coarse.revised({"controller": {"kind": "ideal_bound"}})).metrics.distance
    locked, mixed = (
        tracking_stop(coarse, slips=slips).metrics.distance for slips in ([1.0] * 4, [1.0, 1.0, 1.0, 0.02])
    )
    assert bound < mixed < locked
    assert mixed < 1.15 * bound
    assert locked == pytest.approx(run_stop(coarse).metrics.distance, rel=1e-6)


def test_the_contact_is_that_of_the_plant_on_the_rail_of_the_kernel():
    """The adhesion of each wheelset of a stop, with the energy that those ahead left in the same stop."""
    stop = run_stop(scenario(WRITTEN, "periods.trace=1 ms"))
    vehicle = VehicleData(stop.scenario)
    contact = CleanedContact(vehicle.contact, stop.scenario.adhesion.cleaning, vehicle.curves[0])
    distance, position = stop.trace["distance"].values, vehicle.formation.position
    used, load_, slips = (stop.trace[name].values for name in ("adhesion", "wheelset_load", "slip"))
    slips = slips[:, vehicle.formation.group_of_wheelset]
    left, some = used * load_ * slips / 2, slice(3000, -3000, 500)
    highest = with_energy(stop.trace.assign(mu0=(("time", "wheelset"), np.full(used.shape, 0.05))), contact)
    for w in (0, 1, 5):
        energy = sum(
            np.interp(distance - (position[w] - position[j]), distance, left[:, j], left=0.0) for j in range(w)
        ) * np.ones(len(distance))
        # Loads of the stop oscillate about those of its deceleration.
        assert np.all(energy <= 1.005 * highest["energy_ahead"].values[:, w])
        speed = stop.trace["speed"].values
        found = contact(slips[some, w], speed[some], load_[some, w], 0.05 * np.ones(len(speed[some])),
                        energy=energy[some])  # fmt: skip
        assert found == pytest.approx(used[some, w], rel=0.02)


def test_a_rail_that_slip_does_not_clean_at_all_has_the_same_bound():
    at_rest = "adhesion.recovery={mu0=0.3, A=0.4, B=0.6, rate='0 m/J'}"
    pointwise, cleaned = (
        run_stop(scenario("controller.kind=ideal_bound", "start.speed=40 km/h", *changes).revised(COARSE))
        for changes in ((), (at_rest,))
    )
    assert cleaned.metrics.distance == pytest.approx(pointwise.metrics.distance, rel=1e-4)
