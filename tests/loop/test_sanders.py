"""Sand raises friction for the wheelset that is sanded, and less for each one behind."""

import numpy as np
import pytest
from rails import constant_rail, outputs
from synthetic import LAYOUT, LIBRARY, TWO_PART_TRAIN

from railgrip.scenario.load import load
from railgrip.scenario.outcome import Outcome
from railgrip.scenario.surface import Sand, SandedRail, Sander
from railgrip.simulate.run import run_stop, trace_of

KG_PER_MIN = 1 / 60
SAND = {"mu0": 0.2, "density": 6e-3, "left": 0.8}
FIXED = Sander(wheelset=3, rate=2 * KG_PER_MIN, delay=0.0)
VARIABLE = Sander(wheelset=3, rate=5 * KG_PER_MIN, density=4e-3, delay=0.0)
SPEED = 20.0
LAW = "adhesion.sand={mu0=0.2, density='6 g/m', left=0.8}"
WRITTEN = (LAW, "sanders=[{wheelset=2, rate='2 kg/min', delay='1 s'}]")
LOW = ("adhesion.mu0=0.03", "adhesion.polach=low", "estimator.kind=none", "controller.kind=slip_two_state")


def rail(*sanders, sand=SAND, mu0=0.02, reach=400.0):
    return constant_rail(mu0, sand=SandedRail(LAYOUT, sanders, reach, Sand(**sand)))


def truth(distance, speed=SPEED):
    return outputs(distance=distance, speed=speed)


def rolled(track, to, speed=SPEED, period=1e-3):
    for time in np.arange(round(to / speed / period) + 1) * period:
        track.advance(time, truth(speed * time, speed))
    return track


def law(density, mu0=0.02, sand=SAND):
    return mu0 + (1 - np.exp(-np.asarray(density) / sand["density"])) * (sand["mu0"] - mu0)


def behind(density, first):
    """Friction under each of six wheelsets with sand for one of them."""
    return np.array([density * SAND["left"] ** (w - first) if w >= first else 0.0 for w in range(6)])


def test_sand_of_two_sanders_adds_up():
    density = behind(2 * KG_PER_MIN / SPEED, first=2) + behind(2 * KG_PER_MIN / SPEED, first=4)
    track = rolled(rail(FIXED, Sander(wheelset=5, rate=2 * KG_PER_MIN, delay=0.0)), 100.0)
    assert track.mu0 == pytest.approx(law(density), rel=1e-12)


@pytest.mark.parametrize("speed", [5.0, 15.0, 20.8, 22.0, 40.0])
def test_a_variable_rate_keeps_sand_per_metre_constant_up_to_its_limit(speed):
    density = behind(min(4e-3, 5 * KG_PER_MIN / speed), first=2)
    assert rolled(rail(VARIABLE), 100.0, speed, 1e-3).mu0 == pytest.approx(law(density), rel=1e-12)


def test_all_sand_that_left_the_nozzles_is_on_the_rail():
    """With all of it remaining, on one rail: rate times time."""
    track = rolled(rail(FIXED, sand=SAND | {"left": 1.0}), 300.0)
    cell = 0.1
    assert cell * track.sand.deposited.sum() == pytest.approx(2 * KG_PER_MIN * 300.0 / SPEED, rel=1e-3)


def test_sand_starts_and_ends_and_stays_in_place():
    sander = Sander(wheelset=1, rate=2 * KG_PER_MIN, begin=1.0, end=2.0, delay=0.5)
    density = behind(2 * KG_PER_MIN / SPEED, first=0)
    track = rail(sander)
    found = {}
    for k in range(5000):
        track.advance(k * 1e-3, truth(SPEED * k * 1e-3))
        found[k] = track.mu0.copy()
    first, last = 1500, 2500
    position = np.array(TWO_PART_TRAIN.wheelset_position)
    for w in range(6):
        arrives, leaves = (round(k + position[w] / SPEED * 1e3) for k in (first, last))
        a_cell = 6  # samples
        assert found[arrives - a_cell][w] == pytest.approx(0.02)
        assert found[arrives + a_cell][w] == pytest.approx(law(density)[w])
        assert found[leaves - a_cell][w] == pytest.approx(law(density)[w])
        assert found[leaves + a_cell][w] == pytest.approx(0.02)


def test_friction_better_than_that_of_sand_does_not_change():
    assert rolled(rail(FIXED, mu0=0.3), 50.0).mu0 == pytest.approx(np.full(6, 0.3))


def test_friction_stays_finite_at_standstill_and_beyond_the_table():
    track = rolled(rail(FIXED, reach=20.0), 100.0)
    for _ in range(10):
        track.advance(6.0, truth(100.0, 0.0))
    assert np.isfinite(track.mu0).all()


def test_sand_arrives_a_second_later_and_each_wheelset_gets_less():
    trace = trace_of(load(LIBRARY / "plain.toml", [*LOW, *WRITTEN, "limits.horizon=4 s", "periods.trace=1 ms"]))
    last = trace.mu0.values[-1]
    assert last[0] == 0.03
    assert np.all(np.diff(last[1:]) < 0)
    assert last[-1] > 0.03
    assert np.all(trace.mu0.values[:1000] == 0.03)  # the sand takes a second to reach the rail
    assert trace.mu0.values[1010, 1] > 0.03


def test_sand_shortens_a_stop_and_half_the_period_changes_little():
    changes = (*LOW, "limits.horizon=100 s", "start.speed=50 km/h")
    plain, one, half, two = (
        run_stop(load(LIBRARY / "plain.toml", [*changes, *more]))
        for more in (
            (),
            WRITTEN,
            (*WRITTEN, "periods.communication=0.5 ms"),
            (LAW, "sanders=[{wheelset=2, rate='2 kg/min', delay='1 s'}, {wheelset=4, rate='2 kg/min', delay='1 s'}]"),
        )
    )
    assert all(stop.outcome is Outcome.STANDSTILL for stop in (plain, one, half, two))
    assert two.metrics.distance < one.metrics.distance < 0.8 * plain.metrics.distance
    assert half.metrics.distance == pytest.approx(one.metrics.distance, rel=2e-3)
    assert one.metrics.utilisation <= 1.0


def test_sand_follows_the_demand_of_a_controller_after_the_delay():
    """Sand lies from 1 s after the begin of the demand to 1 s after its end, and not after a pulse below that delay."""
    delay, demand = 1.0, np.zeros(1)
    track = rail(Sander(wheelset=1, rate=2 * KG_PER_MIN, delay=delay), reach=400.0)
    track.sand.follow(demand)
    for time in np.arange(8000) * 1e-3:
        demand[0] = 2.0 <= time < 4.0 or 6.0 <= time < 6.5
        track.advance(time, truth(SPEED * time))
    laid = np.flatnonzero(track.sand.deposited) * 0.1 + track.sand.origin
    position = LAYOUT.formation.position[0]
    # A cell of 0.1 m, and one sample of 2 cm.
    assert laid.min() + position == pytest.approx(SPEED * 3.0, abs=0.2)
    assert laid.max() + position == pytest.approx(SPEED * 5.0, abs=0.2)
