"""Stops at a target through the whole loop, and the study over draws of them."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from railgrip.base.errors import ScenarioError
from railgrip.simulate.estimator import body_force_of
from railgrip.simulate.export.c_parts import part_in_c
from railgrip.simulate.run import trace_of
from railgrip.studies.stop_at_target import stop_at_target_study as module
from railgrip.studies.stop_at_target.stop_at_target_study import (
    DECELERATION,
    LIBRARY,
    MANAGED,
    RAILS,
    SLIPPERY,
    SYSTEMS,
    TEST_SEED,
    Draw,
    StopAtTarget,
    draws_of,
    scenario_of_case,
    stop_row,
)

DRY = Draw(
    rail="good", curve="wet", friction=0.4, correlation=50.0, patch=(100.0, 50.0, 0.3), speed=18.0, ahead=40.0,
    load=1.0, pads=1.0, gradient=0.0, fault="none", group=1, seed=3,
)  # fmt: skip


def test_a_dry_stop_is_that_of_the_closed_form():
    """x₀/v₀ + v₀/a from the start to the halt, at the target."""
    row = stop_row((MANAGED, {}, DRY, True))
    assert abs(row["error"]) < 0.05  # the train stands at 0.1 m/s, 8 mm before a halt at 0.6 m/s²
    closed = DRY.ahead / DRY.speed + DRY.speed / DECELERATION
    assert row["duration"] == pytest.approx(closed, abs=1.5)  # delay and build-up of the brake are 0.9 s
    assert (row["sand"], row["magnets"]) == (0.0, 0.0)


def test_an_emergency_brake_is_that_of_slide_protection():
    """Byte by byte, magnets included: the law is never later than the emergency brake."""
    stop = scenario_of_case((MANAGED, {}, replace(DRY, friction=0.06), True)).revised({"sanders": []})
    full = {"demand": {"phases": [{"pressure": "full"}]}}
    controllers = ({"kind": "deceleration_control"}, {"kind": "slope_seeking", "parameters": {"speed_min": 1.5}})
    traces = [trace_of(stop.revised({**full, "controller": controller})) for controller in controllers]
    for name in ("distance", "command", "cylinder_pressure", "magnets"):
        assert np.array_equal(*(trace[name].values for trace in traces))


def test_magnets_are_lowered_with_full_brake_and_lifted_with_service_brake():
    """Without a law that demands them they follow the driver: kinetic energy tells whether they acted."""
    stop = scenario_of_case(("driver", {}, DRY, True))
    traces = {
        pressure: trace_of(stop.revised({"demand": {"phases": [{"pressure": pressure}]}}))
        for pressure in ("full", "1.5 bar")
    }
    assert traces["full"]["magnets"].values.max() == 1.0
    assert traces["1.5 bar"]["magnets"].values.max() == 0.0
    # Four magnets of 80 kN with friction between 0.08 and 0.15, over a train of 84 t.
    adds = np.array([0.08, 0.15]) * 4 * 80e3 / 84e3
    without = trace_of(
        scenario_of_case(("driver", {}, DRY, False)).revised({"demand": {"phases": [{"pressure": "full"}]}})
    )
    deceleration = [0.5 * DRY.speed**2 / float(trace["distance"].values[-1]) for trace in (traces["full"], without)]
    assert 0.6 * adds[0] < deceleration[0] - deceleration[1] < adds[1]  # they are lowered 1 s after the brake


def test_draws_cover_their_ranges_evenly_and_repeat():
    draws = draws_of(200, 5)
    assert draws == draws_of(200, 5)
    # Latin hypercube: each share is exact.
    slippery = [draw for draw in draws if draw.rail == "slippery"]
    assert len(slippery) == SLIPPERY * len(draws)
    assert sum(draw.fault != "none" for draw in draws) == len(draws) / 2
    low, high = RAILS["slippery"]
    assert all(low <= draw.friction <= high for draw in slippery)
    # The mean of an even distribution over its range, whose standard error with strata is far below 1 %.
    assert np.mean([draw.load for draw in draws]) == pytest.approx(1.1, rel=1e-2)


def test_the_page_compares_systems_on_the_same_draws(monkeypatch):
    """Errors rise by a centimetre from draw to draw; with adhesion management they are a tenth of the better other."""
    factors = dict(zip(SYSTEMS, (2.0, 1.0, 0.1), strict=True))
    rest = {"duration": 30.0, "sand": 0.1, "air": 0.2, "magnets": 3.0}
    monkeypatch.setattr(
        module, "stop_row", lambda case: {"error": 0.01 * factors[case[0]] * (case[2].seed - TEST_SEED + 1)} | rest
    )
    work = SimpleNamespace(map=lambda run, cases: [run(case) for case in cases])
    assert StopAtTarget(draws=1, sets=0).page(work).answer.endswith("there are too few draws on slippery rails.")
    page = StopAtTarget(draws=100, sets=0).page(work)
    answers = page.values["answers"]
    better = "to that of the better baseline, deceleration control, is "
    assert f"{better}0.10 [0.10, 0.10]; the aim of a third is reached" in answers["with magnets"]
    assert f"{better}0.10; whether the aim of a third is reached is not shown" in answers["without magnets"]
    draws = [draw.seed for draw in draws_of(100, TEST_SEED) if draw.rail == "slippery"]
    rows = {row["system"]: row for row in page.tables["errors.csv"].rows if row["rail"] == "slippery"}
    for system, factor in factors.items():
        errors = 0.01 * factor * (np.array(draws) - TEST_SEED + 1)
        assert rows[system]["draws"] == len(errors)
        assert [rows[system][name] for name in ("P50", "P95")] == pytest.approx(np.quantile(errors, (0.5, 0.95)))
        assert rows[system]["P99"] is None  # with 80 draws none is beyond it


def test_a_track_whose_sanders_are_switched_does_not_leave_as_an_fmu():
    with pytest.raises(ScenarioError, match=r"deceleration_control switches the sanders"):
        part_in_c(scenario_of_case((MANAGED, {}, DRY, True)), "track")


def test_redistribution_is_not_demanded_twice():
    stop = scenario_of_case((MANAGED, {}, DRY, True)).revised({"controller": {"redistribute": True}})
    with pytest.raises(ScenarioError, match=r"redistribute is part of deceleration_control"):
        trace_of(stop)


def test_trains_of_the_study_differ_by_their_magnets():
    from railgrip.rolling_stock.schema import load_train
    from railgrip.scenario.file import locate

    with_magnets, without = load_train(LIBRARY / "railcar.toml"), load_train(locate("vt642", "trains"))
    assert with_magnets.track_brake_force > 0.0 == without.track_brake_force
    assert with_magnets.mass == without.mass
    assert body_force_of(with_magnets, 0.01) is not None
    assert body_force_of(without, 0.01) is None
