"""A plant with other names and units runs through its mapping table and stops according to its own physics.

test_mistakes_in_maps.py requires that each signal of it arrives in the right unit and with the right sign.
"""

import math
import re
from pathlib import Path

import numpy as np
import pytest

from railgrip.fmi import Description, describe
from railgrip.fmus.native import package
from railgrip.fmus.native.system import System
from railgrip.report.stop import Stop
from railgrip.scenario.load import load
from railgrip.scenario.outcome import Outcome
from railgrip.simulate.run import run_stop

SCENARIO = Path(__file__).parents[2] / "harness" / "scenario" / "library" / "foreign_train.toml"
MASS, INERTIA, RADIUS, BRAKE = 84e3, 111.0, 0.38, 1.9e3 / 1e5  # kg, kg.m2 and m of an axle, N.m/Pa on an axle
AXLES = np.array([2, 1, 1, 2])
SHAPE = 1.5


@pytest.fixture(scope="module")
def foreign(foreign_train: System, tmp_path_factory: pytest.TempPathFactory) -> Description:
    source = package.sources(foreign_train, interfaces=("cs",), solver="rodas3", tolerance=1e-5, step=1e-3)
    return describe(package.pack(source, tmp_path_factory.mktemp("foreign") / "ForeignTrain.fmu"))


def stop(foreign: Description, *changes: str, **notified: object) -> Stop:
    """Return the stop of the library's scenario with the plant's FMU."""
    path = foreign.file.with_name("foreign_train.toml")
    path.write_text(re.sub(r'plant = ".*"', f'plant = "{foreign.file}"', SCENARIO.read_text()))
    return run_stop(load(path, changes), **notified)


def full_brake(foreign: Description, friction: float, duration: float) -> dict[str, np.ndarray]:
    """Return the last values of all signals after braking from 20 m/s for some seconds."""
    changes = ("vehicle.trust=true", "controller.kind=full_brake", "start.speed=20 m/s")
    trace = stop(foreign, *changes, f"adhesion.mu0={friction}", f"limits.horizon={duration} s").trace
    return {name: values.values[-1] for name, values in trace.data_vars.items() if "time" in values.dims}


def test_rolling_wheels_brake_according_to_newton(foreign: Description):
    """All torque reaches the rail and the rotating masses: −a (m + ΣJ (1−s)/r²) = Στ/r."""
    last = full_brake(foreign, 0.4, 4.0)
    torque = AXLES * BRAKE * last["cylinder_pressure"]
    expected = -torque.sum() / RADIUS / (MASS + (AXLES * INERTIA * (1 - last["slip"])).sum() / RADIUS**2)
    # Slip changes slowly with speed, which the quasi-steady formula leaves out: 1e-3 of the rotating 5 % and less.
    assert last["acceleration"] == pytest.approx(expected, rel=1e-4)
    np.testing.assert_allclose(last["cylinder_pressure"], last["command"], rtol=1e-6)
    np.testing.assert_allclose(last["brake_torque"], torque, rtol=1e-6)


def test_overbraked_wheels_lock_and_slide_at_the_end_of_the_curve(foreign: Description):
    last = full_brake(foreign, 0.025, 4.0)
    # At 100 % creep the argument of the sine is within 4 % of its limit.
    residual = 0.025 * math.sin(SHAPE * math.atan(math.tan(math.pi / 2 / SHAPE) / 0.06))
    assert last["locked"].tolist() == [1.0] * 4
    np.testing.assert_allclose(last["slip"], 1.0, atol=2e-3)
    np.testing.assert_allclose(last["adhesion"], residual, rtol=1e-3)
    np.testing.assert_allclose(last["group_adhesion"], residual, rtol=1e-3)
    assert last["acceleration"] == pytest.approx(-9.81 * residual, rel=1e-3)


def test_its_scenario_runs_from_file_to_stop_in_a_separate_process(foreign: Description):
    """Slip control on a wet rail; the result is bit-identical when the FMU is trusted."""
    messages: list[str] = []
    alone, here = (
        stop(foreign, f"vehicle.trust={trust}", "start.speed=20 km/h", notify=messages.append)
        for trust in ("false", "true")
    )
    assert len(messages) == 1
    assert "ForeignTrain.fmu is foreign" in messages[0]
    assert "set trust = true under [vehicle]" in messages[0]
    assert alone.outcome is Outcome.STANDSTILL
    assert alone.fmus["ForeignTrain.fmu"] == foreign.digest
    np.testing.assert_array_equal(alone.trace["speed"], here.trace["speed"])
    # Between sliding throughout at the end of the curve (0.70 of its peak here) and using the peak throughout.
    speed, peak = 20 / 3.6, 0.08 * 9.81
    assert speed**2 / 2 / peak < alone.metrics.distance < speed**2 / 2 / (0.7 * peak) + 2.0
