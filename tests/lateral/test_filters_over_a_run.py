"""Many steps of a plant and of filters in one call, against the same steps one by one."""

import numpy as np
import pytest

from railgrip.errors import EstimatorError, FmuError
from railgrip.studies.lateral import run
from railgrip.studies.lateral.run import NAMES, Case, observer, simulate
from railgrip.studies.lateral.wheelset import DRY, INPUTS, PERIOD, TESTS, Irregularity, course, wheelset

STEPS = 300
SPEED = 25.0
CASE = Case(test=TESTS[0].shortened(STEPS * PERIOD), speed=SPEED, plant="paper", seed=5)


def test_one_call_and_single_steps_agree_to_the_last_bit(monkeypatch):
    """The literal filter integrates two of its inputs from its own states, before each step."""
    monkeypatch.setattr(run, "EVERY", 1)
    trace, drawn = simulate(CASE), course(CASE.test, 5, Irregularity())
    with wheelset(SPEED, run.PLANTS[CASE.plant].parameters) as plant:
        plant.start(drawn.inputs[0])
        outputs = np.array([plant.step(row) for row in drawn.inputs])
    table = dict(zip(INPUTS, drawn.inputs.T, strict=True)) | {"track_rate": drawn.track_rate}
    for name in NAMES:
        one = observer(name, DRY, Irregularity())
        for k in range(STEPS):
            for j, column in enumerate(one.columns):
                if column:
                    one.filter.inputs[j] = SPEED if column == "speed" else table[column][k]
                else:
                    state = one.filter.design.states.index(one.integrals[one.filter.design.inputs[j]])
                    one.filter.inputs[j] += PERIOD * one.filter.mean[state]
            one.filter.readings[:] = outputs[k, :2] + drawn.noise[k]
            one.filter.advance()
            assert np.array_equal(one.filter.mean, trace.beliefs[name].mean[k]), (name, k)
            assert np.array_equal(one.filter.covariance, trace.beliefs[name].covariance[k]), (name, k)


def test_a_filter_that_diverges_is_a_result_and_the_others_go_on(monkeypatch):
    monkeypatch.setattr(run, "EVERY", 1)
    drawn = course(CASE.test, 5, Irregularity())
    drawn.noise[100, 1] = np.inf
    monkeypatch.setattr(run, "course", lambda *arguments, **more: drawn)
    belief = simulate(CASE, ["known_track"]).beliefs["known_track"]
    assert belief.failure_sample == 101
    assert np.isfinite(belief.mean[99]).all()
    assert np.isnan(belief.mean[100:]).all()


def test_tables_and_names_that_do_not_fit_are_refused():
    rows = np.zeros((3, len(INPUTS)))
    with wheelset(SPEED, {}) as plant:
        plant.start(rows[0])
        with pytest.raises(FmuError, match=r"rows of 5 finite inputs, got shape \(3, 4\)"):
            plant.follow(rows[:, :-1])
        with pytest.raises(FmuError, match="a value that is none"):
            plant.follow(np.where(rows == 0.0, np.nan, rows))
    one = observer("known_track", DRY, Irregularity())
    inputs, readings = np.zeros((3, one.filter.inputs.size)), np.zeros((3, 2))
    with pytest.raises(EstimatorError, match="no input or state trakc"):
        one.filter.follow(one.first, inputs, readings, integrals={"trakc": "dy"})
    with pytest.raises(EstimatorError, match="every"):
        one.filter.follow(one.first, inputs, readings, every=0)
