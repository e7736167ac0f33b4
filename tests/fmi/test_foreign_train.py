"""A plant with other names and units runs through its mapping table and stops according to its own physics."""

import math
import re
import tomllib
from pathlib import Path

import numpy as np
import pytest
from synthetic import LAYOUT, TWO_PART_TRAIN

from railgrip.base.errors import FmuError
from railgrip.fmi import Binding, CoSimulation, Description, Port, bind, describe
from railgrip.fmus.native import package
from railgrip.fmus.native.system import System
from railgrip.scenario.load import load
from railgrip.scenario.outcome import Outcome
from railgrip.simulate.run import run_stop
from railgrip.vehicle.signals import PLANT

ROOT = Path(__file__).parents[2]
SCENARIO = ROOT / "harness" / "scenario" / "library" / "foreign_train.toml"
PERIOD = 1e-3

MASS, INERTIA, RADIUS, BRAKE = 84e3, 6 * 111.0, 0.38, 6 * 1.9e3 / 1e5  # kg, kg.m2, m, N.m/Pa
SHAPE = 1.5

PLANT_INPUTS = (
    Port(name="pressure_command", unit="Pa", size=4, needed=True),
    Port(name="mu0", unit="1", size=6, needed=True),
    Port(name="track_force", unit="N", size=0, needed=True),
)
NEEDED = ("speed", "distance", "acceleration", "wheelset_speed", "cylinder_pressure")
ANSWERED = tuple(
    Port(
        name=s.name,
        unit=s.unit,
        size=0 if s.extent == "train" else TWO_PART_TRAIN.width(s.extent),
        needed=s.name in NEEDED,
    )
    for s in PLANT
)
"""The loop's outputs, of which those for every stop are needed."""


@pytest.fixture(scope="module")
def foreign(foreign_train: System, tmp_path_factory: pytest.TempPathFactory) -> Description:
    source = package.sources(foreign_train, interfaces=("cs",), solver="rodas3", tolerance=1e-5, step=PERIOD)
    return describe(package.pack(source, tmp_path_factory.mktemp("foreign") / "ForeignTrain.fmu"))


@pytest.fixture(scope="module")
def binding(foreign: Description) -> Binding:
    table = tomllib.loads(SCENARIO.read_text())["vehicle"]["map"]
    return bind(
        foreign,
        inputs=PLANT_INPUTS,
        outputs=ANSWERED,
        parameters=[Port(name="start_speed", unit="m/s", size=0, needed=True)],
        table=table,
        where=f"{SCENARIO.name}: [vehicle.map]",
    )


def stop(
    foreign: Description, binding: Binding, *, pressure: float, grip: float, force: float, duration: float
) -> np.ndarray:
    """Return the outputs of each millisecond of a braking with constant inputs, from 20 m/s."""
    inputs = np.zeros(LAYOUT.inputs)
    inputs[LAYOUT.input["command"]], inputs[LAYOUT.input["mu0"]], inputs[LAYOUT.input["track_force"]] = (
        pressure,
        grip,
        force,
    )
    parameters = binding.translate({"start_speed": 20.0})
    with CoSimulation(foreign, binding, period=PERIOD, parameters=parameters) as plant:
        rows = [plant.start(inputs)]
        rows += [plant.step(inputs) for _ in range(round(duration / PERIOD))]
    return np.array(rows)


def column(rows: np.ndarray, name: str) -> np.ndarray:
    return rows[:, LAYOUT.output[name]]


def test_outputs_are_in_the_units_of_railgrip(foreign: Description, binding: Binding):
    first = stop(foreign, binding, pressure=0.0, grip=0.3, force=0.0, duration=0.0)
    assert column(first, "speed")[0, 0] == pytest.approx(20.0, rel=1e-12), "72 km/h"
    np.testing.assert_allclose(column(first, "wheelset_speed")[0], 20.0 / RADIUS, rtol=1e-12)
    np.testing.assert_allclose(column(first, "wheelset_load")[0], MASS * 9.81 / 6, rtol=1e-12)
    assert column(first, "distance")[0, 0] == 0.0


def test_missing_signals_are_nan_and_the_others_have_values(foreign: Description, binding: Binding):
    assert binding.outputs.absent == (
        *("deflection", "pad_force", "pad_friction", "disc_temperature", "air_used", "contact_heat", "pad_heat"),
        *("damper_heat", "resistance_work", "kinetic_energy", "standstill"),
    )
    rows = stop(foreign, binding, pressure=2e5, grip=0.3, force=0.0, duration=0.1)
    assert rows.shape == (101, LAYOUT.outputs)
    for name, where in LAYOUT.output.items():
        assert np.isnan(rows[:, where]).all() == (name in binding.outputs.absent), name
        assert np.isnan(rows[:, where]).any() == (name in binding.outputs.absent), name


def test_rolling_wheels_brake_according_to_newton(foreign: Description, binding: Binding):
    """All torque reaches the rail and the rotating masses: −a (m + ΣJ (1−s)/r²) = Στ/r."""
    rows = stop(foreign, binding, pressure=3.4e5, grip=0.4, force=0.0, duration=4.0)
    slip = column(rows, "slip")[-1, 0]
    torque = BRAKE * 3.4e5
    expected = -torque / RADIUS / (MASS + INERTIA * (1 - slip) / RADIUS**2)
    # Slip changes slowly with speed, which the quasi-steady formula leaves out: 1e-3 of the rotating 5 % and less.
    assert column(rows, "acceleration")[-1, 0] == pytest.approx(expected, rel=1e-4)
    np.testing.assert_allclose(column(rows, "cylinder_pressure")[-1], 3.4e5, rtol=1e-6)
    np.testing.assert_allclose(column(rows, "brake_torque")[-1].sum(), torque, rtol=1e-6)


def test_distance_is_the_integral_of_speed(foreign: Description, binding: Binding):
    rows = stop(foreign, binding, pressure=2e5, grip=0.3, force=0.0, duration=5.0)
    # Trapezoidal rule at 1 ms: curvature of the speed over the first 0.15 s gives less than 1e-7 m.
    assert column(rows, "distance")[-1, 0] == pytest.approx(
        np.trapezoid(column(rows, "speed")[:, 0], dx=PERIOD), rel=1e-6
    )


def test_a_downhill_force_has_the_right_sign_and_unit(foreign: Description, binding: Binding):
    """A free train gains force/(m + ΣJ/r²); the FMU has the opposite sign and kN."""
    rows = stop(foreign, binding, pressure=0.0, grip=0.3, force=10e3, duration=2.0)
    expected = 10e3 / (MASS + INERTIA / RADIUS**2)
    # Wheels that are pulled along creep by 1e-4.
    assert column(rows, "acceleration")[-1, 0] == pytest.approx(expected, rel=1e-3)


def test_overbraked_wheels_lock_and_slide_at_the_end_of_the_curve(foreign: Description, binding: Binding):
    rows = stop(foreign, binding, pressure=3.4e5, grip=0.05, force=0.0, duration=3.0)
    # At 100 % creep the argument of the sine is within 4 % of its limit.
    residual = 0.05 * math.sin(SHAPE * math.atan(math.tan(math.pi / 2 / SHAPE) / 0.06))
    assert column(rows, "locked")[-1].tolist() == [1.0] * 4
    np.testing.assert_allclose(column(rows, "slip")[-1], 1.0, atol=2e-3)
    np.testing.assert_allclose(column(rows, "adhesion")[-1], residual, rtol=1e-3)
    np.testing.assert_allclose(column(rows, "group_adhesion")[-1], residual, rtol=1e-3)
    assert column(rows, "acceleration")[-1, 0] == pytest.approx(-9.81 * residual, rel=1e-3)


def test_without_its_table_the_plant_is_refused_with_its_variables(foreign: Description):
    with pytest.raises(FmuError, match=r"no input 'pressure_command\[1\]'.*; it has demand\[1\], demand\[2\]"):
        bind(foreign, inputs=PLANT_INPUTS, outputs=ANSWERED, where="city.toml: [vehicle.map]")


def test_its_scenario_runs_from_file_to_stop_in_a_separate_process(foreign: Description, tmp_path: Path):
    """Slip control on a wet rail; the result is bit-identical when the FMU is trusted."""
    path = tmp_path / "foreign_train.toml"
    written = re.sub(r'plant = ".*"', f'plant = "{foreign.file}"', SCENARIO.read_text())
    path.write_text(written)
    messages: list[str] = []
    stops = [
        run_stop(load(path, [f"vehicle.trust={trust}", "start.speed=20 km/h"]), notify=messages.append)
        for trust in ("false", "true")
    ]
    assert len(messages) == 1
    assert "ForeignTrain.fmu is foreign" in messages[0]
    assert "set trust = true under [vehicle]" in messages[0]
    alone, here = stops
    assert alone.outcome is Outcome.STANDSTILL
    assert alone.fmus["ForeignTrain.fmu"] == foreign.digest
    np.testing.assert_array_equal(alone.trace["speed"], here.trace["speed"])
    # Between sliding throughout at the end of the curve (0.70 of its peak here) and using the peak throughout.
    speed, peak = 20 / 3.6, 0.08 * 9.81
    assert speed**2 / 2 / peak < alone.metrics.distance < speed**2 / 2 / (0.7 * peak) + 2.0
