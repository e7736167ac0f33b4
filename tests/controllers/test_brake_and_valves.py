from dataclasses import asdict

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from wheelset import GROUP

from railgrip.controllers.law import pressure_for
from railgrip.controllers.valves import DUMP, FILL, HOLD, ValveLogic, ValveModel
from railgrip.vehicle.brake import Brake

JACOBS = asdict(GROUP) | {"pressure_max": 2e5}


@given(pressure=st.floats(0.4e5, 2e5), friction=st.floats(0.1, 0.6))
def test_pressure_is_the_inverse_of_the_brake_equation(pressure, friction):
    """Schwarz, Lüdicke, Heckmann (2019), eq. (3): F_B = μ_B η i_B (p A − F_S), written out here independently."""
    torque = 2 * friction * 5.7 * (pressure * 0.0324 - 1200.0) * 0.22
    assert pressure_for(torque, friction, JACOBS) == pytest.approx(pressure, rel=1e-12)


def test_pressure_stays_between_zero_and_full():
    assert pressure_for(1e9, 0.35, JACOBS) == 2e5
    assert pressure_for(-1e9, 0.35, JACOBS) == 0.0


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"inertia": 0.0}, "inertia must be positive, got 0.0"),
        ({"spring_force": 1e5}, "holds the piston back"),
        ({"spring_force": -1.0}, "spring_force must not be negative, got -1.0"),
    ],
)
def test_impossible_brake_data_are_refused(change, sentence):
    with pytest.raises(ValueError, match=sentence):
        Brake(**(JACOBS | change))


VALVES = ValveModel(period=0.01, dead_time=0.05, fill_time=0.4, vent_time=0.2, band=6e3, pulse_min=0.02)


def track(demand: float, seconds: float, start: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Run the logic against the valve equations of the plant, integrated here with a true dead time."""
    logic, pressure = ValveLogic([3.4e5], VALVES), start
    line, pressures, commands = [HOLD] * 5, [], []
    for _ in range(round(seconds / 0.01)):
        command = logic.command([demand], [pressure])[0]
        line.append(command)
        acting = line.pop(0)
        if acting == FILL:
            pressure += (3.4e5 - pressure) * (1 - np.exp(-0.01 / 0.4))
        elif acting == DUMP:
            pressure *= np.exp(-0.01 / 0.2)
        pressures.append(pressure)
        commands.append(command)
    return np.array(pressures), np.array(commands)


@given(demand=st.floats(0.8e5, 3.0e5), start=st.floats(0.0, 3.3e5))
def test_valves_bring_the_pressure_to_the_demand_and_then_stay_closed(demand, start):
    """After 3 s the error is below the band plus the shortest pulse (20 ms, up to 17 kPa), without a limit cycle.

    The prediction prevents a limit cycle over the dead time.
    """
    pressures, commands = track(demand, 4.0, start)
    assert np.abs(pressures[300:] - demand).max() < 6e3 + 17e3
    assert np.count_nonzero(np.diff(commands[300:])) <= 2


def test_full_and_zero_demands_are_sent_at_once():
    logic = ValveLogic([3.4e5], VALVES)
    assert logic.command([3.4e5], [3.39e5])[0] == FILL
    logic = ValveLogic([3.4e5], VALVES)
    assert logic.command([0.0], [10.0])[0] == DUMP


@given(demands=st.lists(st.floats(0, 3.4e5), min_size=50, max_size=50))
def test_no_pulse_is_shorter_than_the_minimum(demands):
    logic = ValveLogic([3.4e5], VALVES)
    commands = [logic.command([demand], [1.7e5])[0] for demand in demands]
    changes = np.flatnonzero(np.diff(commands)) + 1
    assert np.all(np.diff(changes) >= 2)
