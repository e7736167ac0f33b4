"""Failures of a running FMU are reported through its logger, with variable and time."""

import ctypes
import math

import pytest
from fmpy.fmi1 import FMICallException
from wrong import table


def test_an_assertion_ends_the_step_with_the_models_message(feature, run):
    instance = run(feature("Driven"), start={"limit": 0.8, "k": 0.1})
    with pytest.raises(FMICallException):
        instance.steps(10, 0.1)
    (message,) = [m for m in instance.messages if "assertion" in m]
    assert "is 100 %% beyond its limit" in message
    assert "Driven.mo:" in message
    assert float(message.split("x = ")[1].split(" ")[0]) == pytest.approx(instance.get("x")[0], rel=1e-4)


def test_an_assertion_that_fails_at_the_start_fails_initialisation(feature, run):
    with pytest.raises(FMICallException):
        run(feature("Driven"), start={"limit": 0.1})


def test_a_derivative_that_is_not_a_number_names_its_state(modelica, run):
    fmu = modelica("model M Real depth(start=1,fixed=true); equation der(depth) = -sqrt(depth) - 0.1; end M;")
    instance = run(fmu)
    with pytest.raises(FMICallException):
        instance.steps(40, 0.1)
    assert any("depth" in m and "time = " in m for m in instance.messages)
    # It reached the time that the closed form 2(√x + a ln(a/(√x + a))) with a = 0.1 allows.
    empty = 2 * (1 - 0.1 * math.log(1.1 / 0.1))
    reached = instance.get("time")[0]
    assert reached == pytest.approx(empty, abs=1e-3)


@pytest.mark.parametrize(
    ("variables", "equations", "words"),
    table(__file__, "tables.toml")["without_solution"],
    ids=["loop without solution", "infinite at 1 s", "chattering"],
)
def test_a_model_without_solution_is_reported_with_the_failing_equation(modelica, run, variables, equations, words):
    instance = run(modelica(f"model M {variables} equation {equations} end M;"))
    with pytest.raises(FMICallException):
        instance.steps(20, 0.1)
    assert any(all(word in m for word in words) for m in instance.messages)


def test_calls_out_of_order_are_refused_with_a_sentence(feature, run):
    instance = run(feature("Oscillator"))
    with pytest.raises(FMICallException):
        instance.fmu.doStep(0.5, 0.1)
    assert any("a step was requested from 0.5 s, but this FMU is at 0 s" in m for m in instance.messages)
    with pytest.raises(FMICallException):
        instance.set(x=1.0)
    with pytest.raises(FMICallException):
        instance.set(_tolerance=-1.0)


def test_a_model_that_chatters_ends_the_step_instead_of_hanging(modelica, run):
    """It alternates between two events 0.2 µs apart: five million in a second."""
    fmu = modelica(
        "model M parameter Real d=1e-7; Real x(start=0,fixed=true); discrete Real s(start=1,fixed=true);"
        " equation der(x) = s; when x > d or x < -d then s = if x > 0 then -1 else 1; end when; end M;"
    )
    instance = run(fmu)
    with pytest.raises(FMICallException):
        instance.steps(1000, 1e-3)
    assert any("too many internal steps, more than 300000 in a second, at time = " in m
               for m in instance.messages)  # fmt: skip
    # Five thousand in a second occur in valid models.
    patient = run(fmu, start={"d": 1e-4})
    patient.steps(1000, 1e-3)
    assert patient.get("time")[0] == pytest.approx(1.0)


# Words of the message → the model. Overflows have no place; undefined operations are in test_domains.py.
NOT_NUMBERS = table(__file__, "tables.toml")["not_numbers"]


@pytest.mark.parametrize("words", NOT_NUMBERS)
def test_a_singularity_is_an_error_that_names_variable_and_time(modelica, run, words):
    """FMPy repeats a discarded step for ever, so the status must be an error.

    Without fmpy.simulate_fmu: it leaves its logger, which it deletes, to the next instance of the process.
    """
    messages = []
    with pytest.raises(FMICallException, match=r"status 3 \(error\)"):
        run(modelica(f"model M {NOT_NUMBERS[words]} end M;"), messages=messages).fmu.doStep(0.0, 1.0)
    assert any(words in m for m in messages)


def test_model_exchange_discards_trial_steps_only(modelica, run):
    """At a point of the trajectory itself no smaller step of the importer avoids the singularity: an error."""
    instance = run(modelica("model M Real x(start=1,fixed=true); equation der(x) = exp(2000*(1 - x)); end M;"), "me")
    instance.fmu.newDiscreteStates()
    values, derivative = (ctypes.c_double * 1)(0.5), (ctypes.c_double * 1)()
    instance.fmu.setTime(0.1)
    instance.fmu.setContinuousStates(values, 1)
    with pytest.raises(FMICallException, match="status 2"):
        instance.fmu.getDerivatives(derivative, 1)
    instance.fmu.completedIntegratorStep()
    with pytest.raises(FMICallException, match="status 3"):
        instance.fmu.getDerivatives(derivative, 1)
    assert "der(x) is not a number at time = 0.1 s" in instance.messages


def test_a_warning_is_given_at_each_violation_and_counted(modelica, run):
    """sin(2πt) exceeds 0.5 in each of three periods."""
    fmu = modelica(
        "model M Real x(start=0,fixed=true); equation der(x) = 1;"
        ' assert(sin(6.283185307179586*x) < 0.5, "too large", AssertionLevel.warning); end M;'
    )
    instance = run(fmu)
    instance.steps(300, 0.01)
    warnings = [m for m in instance.messages if "too large" in m]
    assert len(warnings) == 3
    assert ["occurrence 2" in m for m in warnings] == [False, True, False]
    assert "occurrence 3" in warnings[2]
