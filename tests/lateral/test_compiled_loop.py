"""The loop in C against the same loop in Python, and how it says no."""

import numpy as np
import pytest

from railgrip.errors import LoopError
from railgrip.loop.compiled import Observer, Source, run
from railgrip.studies.lateral.filters import FURTHER, party
from railgrip.studies.lateral.wheelset import DRY, PERIOD, READINGS, TESTS, Irregularity, course, wheelset

STEPS = 300
SPEED = 25.0


@pytest.fixture
def drawn():
    return course(TESTS[0].shortened(STEPS * PERIOD), 5, Irregularity())


@pytest.fixture
def table(drawn):
    return np.column_stack([drawn.inputs, drawn.track_rate, np.full(STEPS, SPEED)])


def parties():
    names = ("literal", "known_track", "unknown_track")
    return [party(name, DRY, Irregularity()) for name in names]


def in_c(table, noise, observers, pieces=((0, STEPS),), **options):
    with wheelset(SPEED, {"rolling_creep": 0.0}) as plant:
        plant.start(table[0, :5])
        return [
            run(plant, table[a:b], further=FURTHER, readings=tuple(READINGS), noise=noise[a:b], observers=observers,
                **options)
            for a, b in pieces
        ]  # fmt: skip


def test_c_and_python_agree_to_the_last_bit(drawn, table):
    (record,) = in_c(table, drawn.noise, parties())
    others = parties()
    beliefs = [None] * 3
    with wheelset(SPEED, {"rolling_creep": 0.0}) as plant:
        plant.start(table[0, :5])
        for k in range(STEPS):
            outputs = plant.step(table[k, :5])
            assert np.array_equal(outputs, record.outputs[k])
            for i, one in enumerate(others):
                filter_ = one.filter
                values = dict(
                    zip(("track", "mu0", "A_falling", "B_falling", "motor_torque", *FURTHER), table[k], strict=True)
                )
                for j, name in enumerate(filter_.design.inputs):
                    source = one.sources[name]
                    if source.kind == "column":
                        filter_.inputs[j] = values[source.name]
                    else:
                        state = filter_.design.states.index(source.name)
                        filter_.inputs[j] += PERIOD * filter_.mean[state]
                filter_.readings[:] = outputs[:2] + drawn.noise[k]
                filter_.advance()
                beliefs[i] = filter_.mean.copy()
                assert np.array_equal(beliefs[i], record.beliefs[one.name].mean[k]), (one.name, k)


def test_a_run_in_pieces_is_the_run(drawn, table):
    (whole,) = in_c(table, drawn.noise, parties(), every=10)
    pieces = in_c(table, drawn.noise, parties(), ((0, 120), (120, STEPS)), every=10)
    assert np.array_equal(whole.sample, np.concatenate([piece.sample for piece in pieces]))
    assert np.array_equal(whole.outputs, np.concatenate([piece.outputs for piece in pieces]))
    for name, belief in whole.beliefs.items():
        assert np.array_equal(belief.covariance, np.concatenate([piece.beliefs[name].covariance for piece in pieces]))


def test_a_filter_that_diverges_is_a_result_and_the_others_go_on(drawn, table):
    noise = drawn.noise.copy()
    noise[100, 1] = np.inf
    two = parties()[1:]
    clean = Observer(name="again", filter=parties()[1].filter, sources=two[0].sources)
    (record,) = in_c(table, noise, [two[0]])
    belief = record.beliefs["known_track"]
    assert belief.failure == 3
    assert belief.failure_sample == 101
    assert np.isfinite(belief.mean[99]).all()
    assert np.isnan(belief.mean[100:]).all()
    assert np.isfinite(record.outputs).all()
    assert clean.name == "again"


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (lambda s: {**s, "track": Source(kind="column", name="trakc")}, "no column 'trakc'"),
        (lambda s: {"speed": s["speed"]}, "wants a source for each of"),
    ],
)
def test_a_source_that_is_none_is_refused(drawn, table, change, sentence):
    one = parties()[1]
    wrong = Observer(name="wrong", filter=one.filter, sources=change(dict(one.sources)))
    with pytest.raises(LoopError, match=sentence):
        in_c(table, drawn.noise, [wrong])


def test_tables_that_do_not_fit_are_refused(drawn, table):
    with pytest.raises(LoopError, match="inputs of shape"):
        in_c(table[:, :-1], drawn.noise, [])
    with pytest.raises(LoopError, match="not a finite number"):
        in_c(np.where(table == SPEED, np.nan, table), drawn.noise, [])
    with pytest.raises(LoopError, match="1 or more"):
        in_c(table, drawn.noise, [], every=0)
