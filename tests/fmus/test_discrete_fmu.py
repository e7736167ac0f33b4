"""A CasADi step function becomes a co-simulation FMU that other tools can step."""

import casadi as ca
import numpy as np
import pytest
from fmpy import extract, read_model_description, simulate_fmu
from fmpy.fmi2 import FMU2Slave
from fmpy.validation import validate_fmu

from railgrip.base.errors import InputError
from railgrip.base.system import SampledSystem, Variable
from railgrip.fmus.native.discrete import sources
from railgrip.fmus.native.package import pack

PERIOD = 1 / 5120


def variable(name, unit="1", start=0.0):
    return Variable(name=name, unit=unit, start=start, description=f"About {name}")


def leaky_sum(period=PERIOD):
    """x' = a x + u, y = {x', u²}."""
    x, u, a = ca.SX.sym("x"), ca.SX.sym("u"), ca.SX.sym("a")
    following = a * x + u
    return SampledSystem(
        name="Leaky sum",
        description="For tests",
        period=period,
        states=(variable("memory", "m/s2", start=2.0),),
        inputs=(variable("acceleration", "m/s2"),),
        parameters=(variable("kept", start=0.5),),
        outputs=(variable("sum", "m/s2", start=-1.0), variable("square", "m2/s4")),
        step=ca.Function("step", [x, u, a], [following, ca.vertcat(following, u**2)]),
    )


@pytest.fixture(scope="module")
def packed(tmp_path_factory):
    return pack(sources(leaky_sum()), tmp_path_factory.mktemp("discrete") / "leaky.fmu")


@pytest.fixture
def slave(packed, tmp_path):
    description = read_model_description(packed)
    folder = extract(str(packed), unzipdir=str(tmp_path / "unpacked"))
    slave = FMU2Slave(
        guid=description.guid, unzipDirectory=folder, instanceName="one",
        modelIdentifier=description.coSimulation.modelIdentifier,
    )  # fmt: skip
    slave.instantiate()
    slave.setupExperiment(startTime=0.0)
    slave.enterInitializationMode()
    slave.references = {v.name: v.valueReference for v in description.modelVariables}
    yield slave
    slave.freeInstance()


def test_the_fmu_is_valid(packed):
    assert validate_fmu(str(packed)) == []


def test_outputs_are_those_of_the_function(slave):
    of = slave.references
    slave.setReal([of["kept"]], [0.25])
    slave.exitInitializationMode()
    assert slave.getReal([of["sum"], of["memory"]]) == [-1.0, 2.0]
    memory = 2.0
    for k, u in enumerate([1.0, -3.0, 0.5]):
        slave.setReal([of["acceleration"]], [u])
        slave.doStep(k * PERIOD, PERIOD)
        memory = 0.25 * memory + u
        assert slave.getReal([of["sum"], of["square"]]) == [memory, u**2]


def test_a_longer_step_holds_the_input_over_whole_periods(slave):
    of = slave.references
    slave.exitInitializationMode()
    slave.setReal([of["acceleration"]], [1.0])
    slave.doStep(0.0, 3 * PERIOD)
    assert slave.getReal([of["memory"]]) == [0.5 * (0.5 * (0.5 * 2 + 1) + 1) + 1]


def test_parts_of_a_period_call_the_function_once(slave):
    """An input set between two samples takes effect at the next sample."""
    of = slave.references
    slave.exitInitializationMode()
    seen = []
    for k in range(8):
        slave.setReal([of["acceleration"]], [float(k)])
        slave.doStep(k * PERIOD / 4, PERIOD / 4)
        seen += slave.getReal([of["memory"]])
    first = 0.5 * 2.0 + 0.0
    assert seen == [first] * 4 + [0.5 * first + 4.0] * 4
    assert slave.getReal([0])[0] == 2 * PERIOD


@pytest.mark.parametrize(("start", "step"), [(0.0, 1.5 * PERIOD), (0.3 * PERIOD, PERIOD), (0.0, 0.0)])
def test_a_step_that_is_not_a_multiple_of_the_sample_is_refused(slave, start, step):
    slave.exitInitializationMode()
    with pytest.raises(Exception, match="fmi2DoStep"):
        slave.doStep(start, step)


def test_a_run_can_be_restored(slave):
    of = slave.references
    slave.exitInitializationMode()
    slave.setReal([of["acceleration"]], [1.0])
    state = slave.getFMUState()
    slave.doStep(0.0, PERIOD)
    after = slave.getReal([of["memory"]])
    slave.setFMUState(state)
    slave.doStep(0.0, PERIOD)
    assert slave.getReal([of["memory"]]) == after
    slave.freeFMUState(state)


def test_a_million_summed_steps_stay_on_the_sample_grid(slave):
    """A caller that sums its period drifts by less than a hundredth of a period during a run of minutes."""
    slave.exitInitializationMode()
    time = 0.0
    for _ in range(20_000):
        slave.doStep(time, PERIOD)
        time += PERIOD
    assert slave.getReal([0])[0] == 20_000 * PERIOD


def test_the_same_function_gives_the_same_source():
    assert sources(leaky_sum()).digest == sources(leaky_sum()).digest
    assert sources(leaky_sum()).digest != sources(leaky_sum(period=1e-3)).digest


def test_a_function_of_the_wrong_size_is_refused():
    x = ca.SX.sym("x", 2)
    with pytest.raises(InputError, match=r"takes \[2\] and gives \[2\]"):
        sources(
            SampledSystem(
                name="wrong", description="", period=1.0, states=(variable("x"),), outputs=(),
                step=ca.Function("f", [x], [x]),
            )
        )  # fmt: skip


def test_two_variables_with_the_same_name_are_refused():
    x, u = ca.SX.sym("x"), ca.SX.sym("u")
    with pytest.raises(InputError, match="more than one variable is named a"):
        sources(
            SampledSystem(
                name="twice", description="", period=1.0, states=(variable("a"),), inputs=(variable("a"),),
                outputs=(), step=ca.Function("f", [x, u], [x, ca.SX(0, 1)]),
            )
        )  # fmt: skip


def test_numpy_and_the_fmu_agree_on_a_nonlinear_step(tmp_path):
    x, u = ca.SX.sym("x", 2), ca.SX.sym("u", 2)
    f = ca.Function("f", [x, u], [ca.tanh(x + u), ca.if_else(u[0] > 0, x[0], x[1])])
    system = SampledSystem(
        name="bend", description="", period=0.1, states=(variable("x[1]"), variable("x[2]")),
        inputs=(variable("u[1]"), variable("u[2]")), parameters=(), outputs=(variable("y"),), step=f,
    )  # fmt: skip
    packed = pack(sources(system), tmp_path / "bend.fmu")
    assert validate_fmu(str(packed)) == []
    signals = np.array([(0.0, 1.0, 2.0), (10.0, 1.0, 2.0)], dtype=[("time", float), ("u[1]", float), ("u[2]", float)])
    result = simulate_fmu(
        str(packed), stop_time=0.3, step_size=0.1, output_interval=0.1, input=signals, output=["x[2]"]
    )
    state = np.zeros(2)
    for _ in range(3):
        state = np.tanh(state + np.array([1.0, 2.0]))
    assert result["x[2]"][-1] == pytest.approx(state[1], rel=1e-15)
