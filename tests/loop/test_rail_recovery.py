"""Slip changes the rail according to the published law, for the slipping wheel and for those behind it."""

import runpy
from collections import namedtuple
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image
from rails import constant_rail, outputs
from synthetic import LAYOUT, LIBRARY, TWO_PART_TRAIN

from railgrip.base.errors import ScenarioError
from railgrip.scenario.adhesion import position_of
from railgrip.scenario.load import load
from railgrip.scenario.outcome import Outcome
from railgrip.scenario.surface import Recovery, SlipEnergy
from railgrip.simulate.assembly import assemble
from railgrip.simulate.run import run_stop

Falling = namedtuple("Falling", "A B")

CLEAN = Recovery(mu0=0.3, A=0.4, B=0.6, rate=1.9e-4)
LAID = Falling(A=0.5, B=0.1)
LOAD = 1e5
CELL = 0.1
EXAMPLES = Path(__file__).parents[2] / "docs" / "examples"
WRITTEN = "adhesion.recovery={mu0=0.3, A=0.4, B=0.6, rate='1.9e-4 m/J'}"
LOW = ("adhesion.mu0=0.05", "adhesion.polach=low", "estimator.kind=none", "controller.kind=slip_two_state")


def rail(mu0=0.05, reach=200.0, clean=CLEAN):
    return constant_rail(mu0, slip_energy=SlipEnergy(LAYOUT, clean, LAID, reach))


def truth(distance, speed=20.0, slip=0.1, adhesion=0.05):
    return outputs(distance=distance, speed=speed, slip=slip, adhesion=adhesion, wheelset_load=LOAD)


def rolled(track, to, step=0.05, slip=lambda place: 0.1, **shown):
    for place in np.arange(round(to / step) + 1) * step:
        track.advance(0.0, truth(place, slip=slip(place), **shown))
    return track


def law(energy, mu0, slip_speed, clean=CLEAN):
    """The law by hand: friction at zero slip speed, for a contact whose friction falls as in LAID."""
    falling = lambda of: (1 - of.A) * np.exp(-of.B * slip_speed) + of.A
    laid = mu0 * falling(LAID)
    gained = max(clean.mu0 * falling(clean) - laid, 0.0)
    return (laid + (1 - np.exp(-clean.rate * energy)) * gained) / falling(LAID)


def test_the_product_of_shares_is_the_sum_of_energies():
    """The factors 1 − λ of successive wheels multiply, whatever the slip of each."""
    track = rail()
    slips = np.array([0.05, 0.3, 0.1, 0.2])
    for place in np.arange(0, 60, 0.05):
        outputs = truth(place)
        outputs[LAYOUT.output["slip"]] = slips
        track.advance(0.0, outputs)
    each = 0.5 * 0.05 * LOAD * slips[TWO_PART_TRAIN.group_of_wheelset]
    shares = np.cumprod(np.exp(-CLEAN.rate * each))
    speeds = 20.0 * slips[TWO_PART_TRAIN.group_of_wheelset]
    expected = [law(-np.log(share) / CLEAN.rate, 0.05, speed) for share, speed in zip(shares, speeds, strict=True)]
    assert track.mu0 == pytest.approx(expected, rel=1e-9)


@given(st.lists(st.tuples(st.floats(0.0, 3.0), st.floats(0.0, 1.0)), min_size=2, max_size=60))
def test_the_rail_stores_all_the_energy(moves):
    """For every wheel the integral of F s over its path, in strides from zero to thirty cells."""
    track, place = rail(), 0.0
    track.advance(0.0, truth(0.0, slip=0.2))
    spent, before = 0.0, 0.2
    for stride, slip in moves:
        place += stride
        track.advance(0.0, truth(place, slip=slip))
        spent += 6 * 0.5 * 0.05 * LOAD * 0.5 * (before + slip) * stride
        before = slip
    stored = CELL * track.slip_energy.energy.sum() + sum(track.slip_energy.struct.pointer.energy_own)
    assert stored == pytest.approx(spent, rel=1e-9, abs=1e-6)


def test_halving_the_stride_changes_the_rail_by_a_quarter_each_time():
    wave = lambda place: 0.1 * (1 + np.sin(place))
    strides = (0.08, 0.04, 0.02, 0.01)
    found = [rolled(rail(), 60.0, stride, wave).mu0[-1] for stride in strides]
    first, second, third = np.abs(np.diff(found))
    assert third < 0.5 * first
    assert third < 1e-4 * found[-1]
    assert second < 3e-4 * found[-1]


def test_a_rail_better_than_the_clean_one_does_not_change():
    assert rolled(rail(mu0=0.5, clean=CLEAN.model_copy(update={"B": 5.0})), 50.0).mu0 == pytest.approx(np.full(6, 0.5))


def test_slip_cleans_from_the_friction_that_passing_wheels_leave():
    """Each of `passed` wheelsets closes 0.2 of the gap to 0.15; the law of slip then starts from that friction."""
    passed = 0.15 - (0.15 - 0.05) * 0.8 ** np.arange(6)
    track = rolled(rail(mu0=passed), 60.0)
    each = 0.5 * 0.05 * LOAD * 0.1
    expected = [law((ahead + 1) * each, mu0, slip_speed=2.0) for ahead, mu0 in enumerate(passed)]
    assert track.mu0 == pytest.approx(expected, rel=1e-9)
    passing = "adhesion.conditioning={fraction=0.2, recovered=0.15, by='wheelset'}"
    scenario = load(LIBRARY / "plain.toml", [*LOW, WRITTEN, passing, "limits.horizon=1 s"])
    with assemble(scenario) as parts:
        first = parts.parts.rail.mu0.copy()
    assert first == pytest.approx(passed, rel=1e-9)


def test_rolling_driven_and_stationary_wheels_do_not_change_the_rail():
    for slip in (0.0, -0.1):
        track = rolled(rail(), 50.0, slip=lambda place, slip=slip: slip)
        assert not track.slip_energy.energy.any()
        assert track.mu0 == pytest.approx(np.full(6, 0.05))
    track = rolled(rail(), 50.0)
    before = track.slip_energy.energy.copy()
    for _ in range(1000):
        track.advance(0.0, truth(50.0, speed=0.0, slip=1.0))
    assert np.array_equal(track.slip_energy.energy, before)


def test_beyond_the_table_the_last_cell_holds():
    """A train cannot get there; if it does, no memory is overwritten."""
    track = rolled(rail(reach=20.0), 60.0)
    assert np.isfinite(track.mu0).all()
    assert track.slip_energy.energy[:-1].max() == pytest.approx(6 * 250.0)


def test_the_heat_of_the_contacts_is_on_the_rail():
    scenario = load(LIBRARY / "plain.toml", [*LOW, WRITTEN, "limits.horizon=4 s"])
    with assemble(scenario) as parts:
        ended = parts.run()
        field, trace = parts.parts.rail.slip_energy, parts.recorder.trace(ended.samples, 1e-3)
    # For both wheels of each wheelset; the plant's heat includes all slip, the rail's is sampled every 1 ms.
    stored = 2 * (CELL * field.energy.sum() + sum(field.struct.pointer.energy_own))
    assert stored == pytest.approx(float(trace.contact_heat[-1]), rel=1e-3)
    assert float(trace.mu0.max()) > 0.1


@pytest.mark.parametrize("controller", ["slip_two_state", "full_brake"])
def test_cleaning_slip_shortens_the_stop_and_half_the_period_changes_little(controller):
    """Sensors, law and valves of the ideal stop keep their periods; the rail uses the communication step."""
    changes = (*LOW[:3], f"controller.kind={controller}", "limits.horizon=100 s", "start.speed=50 km/h")
    plain = run_stop(load(LIBRARY / "plain.toml", changes))
    stops = [
        run_stop(load(LIBRARY / "plain.toml", [*changes, WRITTEN, f"periods.communication={period}"]))
        for period in ("1 ms", "0.5 ms")
    ]
    assert all(stop.outcome is Outcome.STANDSTILL for stop in (plain, *stops))
    one, half = (stop.metrics.distance for stop in stops)
    assert one < 0.8 * plain.metrics.distance
    assert half == pytest.approx(one, rel=2e-3)
    assert stops[0].metrics.utilisation <= 1.0


def test_a_plant_without_loads_or_positions_is_refused():
    outputs = truth(0.0)
    outputs[LAYOUT.output["wheelset_load"]] = np.nan
    with pytest.raises(ScenarioError, match="does not output adhesion and wheelset_load"):
        rail().check_plant(outputs)
    constant_rail(0.1).check_plant(outputs)
    nowhere = replace(TWO_PART_TRAIN, wheelset_position=())
    with pytest.raises(ScenarioError, match=r"has recovery, and the plant does not declare the positions"):
        position_of(load(LIBRARY / "plain.toml", [WRITTEN]).adhesion, nowhere)


@pytest.fixture(scope="module")
def example():
    return SimpleNamespace(**runpy.run_path(str(EXAMPLES / "rail_that_slip_cleans.py")))


def test_adhesion_falls_behind_the_peak_and_rises_again_at_large_slip(example):
    """The second maximum of contaminated rails; without cleaning, adhesion only falls behind the peak."""
    slips = np.concatenate([[0.0], np.geomspace(2e-3, 1.0, 14)])
    as_it_lies, cleaned = example.curves("low", 0.06, slips)
    peak = np.argmax(as_it_lies)
    assert np.all(np.diff(as_it_lies[peak:]) < 0)
    first = cleaned[:, 0]
    valley = peak + np.argmin(first[peak:])
    assert slips[valley] == pytest.approx(0.28, abs=0.1)
    assert first[valley] < 0.9 * first[: valley + 1].max()
    assert first[-1] > 1.5 * first[: valley + 1].max()
    assert np.all(cleaned[1:, 1:] >= cleaned[1:, :-1] - 1e-12)  # front to rear, at any slip


def test_the_figure_of_the_manual_is_drawn_by_the_example(example, tmp_path):
    example.main(str(tmp_path / "rail.png"))
    assert Image.open(tmp_path / "rail.png").size == Image.open(EXAMPLES.parent / "rail.png").size
