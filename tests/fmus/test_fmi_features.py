"""Directional derivatives, FMU state, tunable parameters, and the contents of modelDescription.xml."""

import xml.etree.ElementTree as ET

import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from small_fmus import check_directional_derivatives

from railgrip.fmus.native.package import HEADERS, platform_folder
from railgrip.fmus.native.toolchain import binary


@pytest.mark.parametrize("name", ["NonlinearLoop", "Mechanics", "Redeclared", "Elementary", "Matrices", "Driven"])
def test_directional_derivatives_are_central_differences(feature, run, name):
    """Along states, inputs and parameters."""
    fmu = feature(name)
    instance = run(fmu, "me")
    states = [u.variable.derivative.name for u in fmu.description.derivatives]
    known = states + [n for n in fmu.names("parameter", "Real") if not n.startswith("_")] + fmu.names("input", "Real")
    unknown = [f"der({s})" for s in states] + [n for n in fmu.names("output", "Real") if n not in states]
    check_directional_derivatives(instance, unknown, known)


@pytest.mark.parametrize("name", ["NonlinearLoop", "Redeclared"])
def test_several_states_at_once_are_the_sum_of_one_at_a_time(feature, run, name):
    """Also after evaluating another point and after restoring a saved state: the Jacobian is that of the point."""
    fmu = feature(name)
    instance = run(fmu, "me")
    states = [u.variable.derivative.name for u in fmu.description.derivatives]
    known = [fmu.reference(name) for name in states]
    unknown = [fmu.reference(name) for name in (*(f"der({s})" for s in states), *fmu.names("output", "Real"))]
    along = [0.5 + k for k in range(len(known))]

    def columns():
        return [instance.fmu.getDirectionalDerivative(unknown, [k], [1.0]) for k in known]

    state = instance.fmu.getFMUState()
    first = columns()
    together = instance.fmu.getDirectionalDerivative(unknown, known, along)
    assert together == pytest.approx(np.array(first).T @ along, rel=1e-14, abs=1e-14)  # the same sum
    instance.set(**{states[0]: instance.get(states[0])[0] + 0.7})
    assert columns() != first
    instance.fmu.setFMUState(state)
    assert columns() == first
    instance.fmu.freeFMUState(state)


def test_a_restored_state_gives_the_same_future(feature, run):
    """Also after events, from bytes, and in another instance."""
    fmu = feature("Sampled")
    instance, other = run(fmu), run(fmu)
    instance.steps(37, 0.01)
    state = instance.fmu.getFMUState()
    data = instance.fmu.serializeFMUState(state)

    def future(of):
        of.steps(200, 0.01, first=37)
        return of.get("x", "u")

    first = future(instance)
    instance.fmu.setFMUState(state)
    assert future(instance) == first
    instance.fmu.freeFMUState(state)
    for restored in (instance, other):
        restored.fmu.setFMUState(restored.fmu.deSerializeFMUstate(data))
        assert future(restored) == first


def test_bytes_of_another_fmu_are_not_a_state(feature, run):
    a, b = run(feature("Sampled")), run(feature("Oscillator"))
    data = a.fmu.serializeFMUState(a.fmu.getFMUState())
    with pytest.raises(FMICallException):
        b.fmu.deSerializeFMUstate(data)


def test_reset_restores_the_initial_state(feature, run):
    fmu = feature("BouncingBall")
    instance = run(fmu, start={"e": 0.5})
    instance.steps(100, 0.01)
    instance.fmu.reset()
    instance.fmu.setupExperiment(startTime=0)
    instance.fmu.enterInitializationMode()
    instance.fmu.exitInitializationMode()
    assert instance.get("h", "v", "e") == [1.0, 0.0, 0.7]
    assert instance.count("bounces") == 0


@pytest.mark.parametrize("begin", [-1e7, 1e7, 1.7e9])
def test_the_time_may_be_the_product_of_the_steps(feature, run, begin):
    """Seconds since 1970 are rounded to 2e-7 s, a millionth of a step to 1e-9 s; the state has the same rounding."""
    fmu = feature("Driven")
    near, far = (run(fmu, time=time) for time in (0.0, begin))
    for instance, time in ((near, 0.0), (far, begin)):
        instance.set(k=5.0, u=10.0)
        for k in range(200):
            instance.fmu.doStep(time + k * 1e-3, 1e-3)
    assert far.get("x")[0] == pytest.approx(near.get("x")[0], abs=1e-5)


def test_a_parameter_tuned_between_steps_takes_effect(feature, run):
    """der(x) = u − k x settles at u/k."""
    instance = run(feature("Driven"))
    instance.set(k=5.0, u=10.0)
    instance.steps(100, 0.1)
    assert instance.get("x")[0] == pytest.approx(2.0, rel=1e-4)


def test_start_values_follow_parameters_until_they_are_set(feature, run):
    fmu = feature("Dependent")
    assert run(fmu, start={"m": 4.0}).get("weight", "y", "x[2]") == pytest.approx([39.24, 13.08, 3.924])
    assert run(fmu, start={"m": 4.0, "y": 1.0}).get("y") == [1.0]


def test_the_description_matches_the_model(feature):
    description = feature("Driven").description
    v = {v.name: v for v in description.modelVariables}
    assert (v["u"].unit, v["u"].min, v["u"].max, v["u"].start, v["u"].causality) == (
        "m/s",
        "-10.0",
        "10.0",
        "1.0",
        "input",
    )
    assert (v["frozen"].type, v["gear"].type) == ("Boolean", "Integer")
    assert (v["y"].nominal, v["y"].description) == ("5.0", "Position")
    assert (v["der(x)"].unit, v["der(x)"].derivative.name) == ("m/s", "x")
    assert (v["k"].variability, v["k"].initial, v["k"].min) == ("tunable", "exact", "0.0")
    assert [o.variable.name for o in description.outputs] == ["x", "y", "beyond", "count"]
    (derivative,) = description.derivatives
    assert {d.name for d in derivative.dependencies} == {"x", "u", "frozen", "gear"}
    units = {u.name: u for u in description.unitDefinitions}
    assert (units["m/s"].baseUnit.m, units["m/s"].baseUnit.s) == (1, -1)
    assert description.coSimulation.canGetAndSetFMUstate
    assert description.modelExchange.providesDirectionalDerivative


def test_outputs_in_a_protected_part_are_no_outputs_of_the_fmu(feature, run):
    """They belong to the equations of the class alone (Modelica 4.4.2.2: the prefix output acts at an interface)."""
    fmu = feature("HiddenOutputs")
    assert fmu.names("output") == ["y"]
    assert [unknown.variable.name for unknown in fmu.description.outputs] == ["y"]
    instance = run(fmu, "me")
    assert instance.get("y") == [2.0]


def test_protected_variables_are_hidden_except_for_states(modelica):
    """As in omc (getExportVar in its SimCodeUtil.mo, with --fmiFilter=protected, its default)."""
    spring = "model Spring parameter Real c = 2; Real x(start=1, fixed=true); equation der(x) = -c*x; end Spring;"
    fmu = modelica(f"model M {spring} parameter Real k = 3; output Real y = k*s.x; protected Spring s; end M;")
    names = {variable.name for variable in fmu.description.modelVariables}
    assert {"k", "y", "s.x", "der(s.x)"} <= names
    assert "s.c" not in names


def test_the_listed_sources_are_those_of_the_library(feature):
    """A tool that compiles them, with the headers of FMI, has the same library."""
    fmu = feature("Driven")
    files = {file.name: file.read_text() for file in (fmu.folder / "sources").iterdir()}
    (library,) = (fmu.folder / "binaries" / platform_folder()).iterdir()
    root = ET.parse(fmu.folder / "modelDescription.xml").getroot()
    for interface in ("CoSimulation", "ModelExchange"):
        listed = [file.attrib["name"] for file in root.findall(f"{interface}/SourceFiles/File")]
        assert library.read_bytes() == binary(files, library.stem, units=listed, include=[HEADERS], flags=("-O0",))
