"""A CasADi step function becomes a co-simulation FMU that other tools can step."""

import casadi as ca
import pytest
from sampled_systems import sampled
from slave import Slave

from railgrip.base.errors import InputError
from railgrip.fmus.native.discrete import sources
from railgrip.fmus.native.package import pack

PERIOD = 1 / 5120


def leaky_sum(period=PERIOD):
    """x' = a x + u, y = {x', u²}."""
    x, u, a = ca.SX.sym("x"), ca.SX.sym("u"), ca.SX.sym("a")
    following = a * x + u
    return sampled(
        ca.Function("step", [x, u, a], [following, ca.vertcat(following, u**2)]),
        period,
        states=[("memory", "m/s2", 2.0)],
        inputs=[("acceleration", "m/s2", 0.0)],
        parameters=[("kept", "1", 0.5)],
        outputs=[("sum", "m/s2", -1.0), ("square", "m2/s4", 0.0)],
    )


@pytest.fixture(scope="module")
def packed(tmp_path_factory):
    return pack(sources(leaky_sum()), tmp_path_factory.mktemp("discrete") / "leaky.fmu")


@pytest.fixture
def slave(packed):
    with Slave(packed) as slave:
        yield slave


def test_outputs_are_those_of_the_function(packed):
    with Slave(packed, {"kept": 0.25}) as slave:
        assert slave.get("sum", "memory") == [-1.0, 2.0]
        memory = 2.0
        for k, u in enumerate([1.0, -3.0, 0.5]):
            slave.step(k, PERIOD, acceleration=u)
            memory = 0.25 * memory + u
            assert slave.get("sum", "square") == [memory, u**2]


def test_a_longer_step_holds_the_input_over_whole_periods(slave):
    slave.step(0, 3 * PERIOD, acceleration=1.0)
    assert slave.get("memory") == [0.5 * (0.5 * (0.5 * 2 + 1) + 1) + 1]


def test_parts_of_a_period_call_the_function_once(slave):
    """An input set between two samples takes effect at the next sample."""
    seen = []
    for k in range(8):
        slave.step(k, PERIOD / 4, acceleration=float(k))
        seen += slave.get("memory")
    first = 0.5 * 2.0 + 0.0
    assert seen == [first] * 4 + [0.5 * first + 4.0] * 4
    assert slave.fmu.getReal([0])[0] == 2 * PERIOD


@pytest.mark.parametrize(("start", "step"), [(0.0, 1.5 * PERIOD), (0.3 * PERIOD, PERIOD), (0.0, 0.0)])
def test_a_step_that_is_not_a_multiple_of_the_sample_is_refused(slave, start, step):
    with pytest.raises(Exception, match="fmi2DoStep"):
        slave.fmu.doStep(start, step)


def test_a_million_summed_steps_stay_on_the_sample_grid(slave):
    """A caller that sums its period drifts by less than a hundredth of a period during a run of minutes."""
    time = 0.0
    for _ in range(20_000):
        slave.fmu.doStep(time, PERIOD)
        time += PERIOD
    assert slave.fmu.getReal([0])[0] == 20_000 * PERIOD


def test_the_same_function_gives_the_same_source():
    assert sources(leaky_sum()).digest == sources(leaky_sum()).digest
    assert sources(leaky_sum()).digest != sources(leaky_sum(period=1e-3)).digest


X, U = ca.SX.sym("x", 2), ca.SX.sym("u")


@pytest.mark.parametrize(
    ("inputs", "step", "sentence"),
    [
        ((), ca.Function("f", [X], [X]), r"takes \[2\] and gives \[2\]"),
        ([("a", "1", 0.0)], ca.Function("f", [X[0], U], [X[0], ca.SX(0, 1)]), "more than one variable is named a"),
    ],
)
def test_a_function_that_does_not_fit_its_variables_is_refused(inputs, step, sentence):
    with pytest.raises(InputError, match=sentence):
        sources(sampled(step, 1.0, states=[("a", "1", 0.0)], inputs=inputs))
