"""Every parameter of the plants can be set before initialisation and has an effect."""

from collections.abc import Mapping

import numpy as np
import pytest
from bound_fmu import bind_all

from railgrip.fmi import Binding, CoSimulation, Description, describe
from railgrip.fmus.build import fmu
from railgrip.vehicle.parameters import DESCRIPTIVE

PERIOD = 0.05

NUMERICS = {"v_rest": 20.0, "F_small": 500.0, "tau_small": 20.0, "v_small": 2.0}
"""Changes of regularisation parameters: one per cent may not change a digit of any output."""

DEAD_TIMES = {"dead_fill": 1.5, "dead_vent": 1.5}
"""They have a resolution of 2 ms."""


def plant(name: str) -> tuple[Description, Binding]:
    found = describe(fmu(name))
    return found, bind_all(found)


def course(plant: tuple[Description, Binding], parameters: Mapping[str, float]) -> np.ndarray:
    """Outputs of 15 s: braking, lock on a poor rail, release, standstill, and a pull that grows until departure."""
    found, binding = plant

    def value(name: str, t: float) -> float:
        if name.startswith("mu0"):
            return 0.03 if 1.5 < t < 3.0 else 0.25
        if name == "track_force":
            return 500.0 if t < 11.0 else 8e4 + 2e4 * (t - 11.0)
        braked = t < 1.0 or 1.3 < t < 3.0 or t > 3.5
        return (1.0 if braked else -1.0) if name.startswith("valve") else 4e5 if braked else 0.0

    inputs = [np.array([value(n, k * PERIOD) for n in found.names("input")]) for k in range(300)]
    with CoSimulation(found, binding, period=PERIOD, parameters=parameters) as running:
        return np.array([running.start(inputs[0]), *(running.step(u) for u in inputs)])


def changed(found: Description, name: str) -> float:
    """A value of the parameter that differs by one per cent."""
    variable = found.variables[name]
    value = float(variable.start or 0.0)
    factor = (NUMERICS | DEAD_TIMES).get(name, 1.01)
    if variable.maximum is not None and factor * value > variable.maximum:
        factor = 0.99
    return factor * value if value else 0.01


def numbers(found: Description) -> list[str]:
    return [n for n in found.names("parameter") if found.variables[n].kind == "Real" and not n.startswith("_")]


@pytest.fixture(scope="module")
def ideal() -> tuple[Description, Binding]:
    return plant("TwoPartTrain")


def test_the_run_includes_lock_release_standstill_and_departure(ideal: tuple[Description, Binding]) -> None:
    """Otherwise parameters of lock and standstill would have no effect."""
    outputs = ideal[0].names("output")
    rows = course(ideal, {"start_speed": 10.0})
    locked, rest = rows[:, outputs.index("locked[1]")] > 0.5, rows[:, outputs.index("standstill")] > 0.5
    moving = ~rest
    assert np.any(locked & moving)
    assert np.any(locked[:-1] & ~locked[1:] & moving[1:])
    assert np.any(rest[:-1] & ~rest[1:])


def test_every_parameter_of_the_train_has_an_effect(ideal: tuple[Description, Binding]) -> None:
    # Coupling and positions of wheelsets describe the train to the harness and do not affect the equations.
    names = [name for name in numbers(ideal[0]) if name.partition("[")[0] not in DESCRIPTIVE]
    assert len(names) > 100
    start = {"start_speed": 10.0}
    base = course(ideal, start)
    assert np.array_equal(course(ideal, start), base)
    silent = [n for n in names if np.array_equal(course(ideal, start | {n: changed(ideal[0], n)}), base)]
    assert silent == []


def test_every_parameter_of_the_valves_has_an_effect(ideal: tuple[Description, Binding]) -> None:
    """Supply pressure, leak, time constants and dead times: the parameters that exist only with valves."""
    valves = plant("TwoPartTrainPneumatic")
    names = sorted(set(numbers(valves[0])) - set(numbers(ideal[0])))
    assert {"T_fill", "T_vent", "leak", "rate_choked", "dead_fill", "dead_vent"} <= set(names)
    start = {"start_speed": 10.0}
    base = course(valves, start)
    for name in (*names, "p_max[1]"):
        assert not np.array_equal(course(valves, start | {name: changed(valves[0], name)}), base), name
