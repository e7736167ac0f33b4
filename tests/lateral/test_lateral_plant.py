"""The wheelset FMU compared with its reconstructed equations solved by scipy, and with published modes."""

import casadi as ca
import mal
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from railgrip.estimation.lateral.run_measures import adhesion
from railgrip.estimation.lateral.wheelset import (
    COLUMNS,
    CONDITIONS,
    DRY,
    PERIOD,
    PLANTS,
    TESTS,
    WORST,
    PlantVariant,
    course,
    wheelset,
)
from railgrip.fmus.native import lower


@pytest.mark.parametrize("condition", CONDITIONS, ids=lambda c: c.name)
def test_the_creep_curves_are_polachs_with_table_3(condition):
    creep, speed = np.geomspace(1e-4, 0.1, 20), 25.0
    rail = mal.Rail(condition.mu0, condition.A, condition.B)
    exact = mal.force(creep, mal.friction(creep, speed, rail)) / mal.N
    # The smallest creep speed of the falling friction subtracts 1 mm/s from the creep: 4e-4 of the largest adhesion.
    assert adhesion(condition, creep, speed) == pytest.approx(exact, rel=5e-4)


@pytest.mark.parametrize("rolling", [0.0, 1.0])
@pytest.mark.parametrize("condition", [DRY, WORST], ids=lambda c: c.name)
def test_the_fmu_solves_the_reconstructed_equations(rolling, condition):
    """A lateral step of the track by 3 mm: both creepages, saturation on the worst rail, and twist of the axle."""
    speed, period, steps, track = 25.0, 50e-6, 1600, 3e-3
    with wheelset(speed, PlantVariant(title="", rolling_creep=rolling)) as plant:
        inputs = np.array([track, condition.mu0, condition.A, condition.B, 0.0])
        plant.start(inputs)
        rows = np.array([plant.step(inputs) for _ in range(steps)])
    rail = mal.Rail(condition.mu0, condition.A, condition.B)
    exact = solve_ivp(
        lambda t, x: mal.wheelset(x, track, rail, rolling), (0, steps * period),
        [0, 0, 0, 0, speed, speed / mal.R0, speed / mal.R0, 0], method="Radau", rtol=1e-9, atol=1e-13,
        t_eval=period * np.arange(1, steps + 1),
    ).y  # fmt: skip
    for row, name in enumerate(("lateral_position", "lateral_velocity", "yaw_angle", "yaw_rate", "speed")):
        simulated = rows[:, COLUMNS[name]][:, 0]
        # Solver tolerance 1e-6 for each step of 50 µs; rounding of the falling friction subtracts 1 mm/s from the creep
        # speed, 4e-4 of the friction, and saturated forces are proportional to friction.
        assert simulated == pytest.approx(exact[row], abs=2e-3 * np.max(np.abs(exact[row]))), name


@pytest.mark.parametrize(
    ("speed", "dominant", "hertz", "fastest"), [(10.0, -1.8, 1.0, -1900.0), (55.0, -6.8, 5.5, -350.0)]
)
def test_the_modes_are_those_in_the_literature_on_this_model(speed, dominant, hertz, fastest):
    """Kinematic mode and fastest mode of the linearised lateral dynamics, computed independently."""
    model = lower("RailBraking.Predictions.LateralPrediction")
    x = ca.SX.sym("x", 5)
    u = [speed, 0.0] if model.inputs[0].name == "speed" else [0.0, speed]
    rates = model.derivative(0, x, u, [p.start for p in model.parameters])
    at_rest = ca.Function("A", [x], [ca.jacobian(rates, x)])([0, 0, 0, 0, np.log(DRY.mu0)])
    poles = np.linalg.eigvals(np.array(at_rest)[:4, :4])
    kinematic = poles[np.argmax(poles.real)]
    # The reference values have two digits.
    assert kinematic.real == pytest.approx(dominant, rel=0.03)
    assert abs(kinematic.imag) / (2 * np.pi) == pytest.approx(hertz, rel=0.05)
    assert np.min(poles.real) == pytest.approx(fastest, rel=0.03)


def test_the_slope_of_the_force_is_that_of_hertz_and_kalker():
    """a = 6.76 mm, b = 4.81 mm by elliptic integrals, c11 = 4.53 from Kalker's table: G a b c11 a creep."""
    values = {"displacement": 1e-9 * 0.5 / 0.15, "speed": 25.0, "mu0": 0.46, "stiffness": 1.0}
    model = lower("RailBraking.FMUs.LateralContact")
    inputs = [values.get(v.name, 0.0) for v in model.inputs]
    creep, force, _ = np.array(model.output(0, [], inputs, [p.start for p in model.parameters])).ravel()
    exact = 2.1e11 / (2 * 1.28) * 6.76e-3 * 4.81e-3 * 4.53
    # Greenwood's ellipse is within 0.1 % in area, the parabola through Kalker's table within 0.2 %, three digits given.
    assert force / creep == pytest.approx(exact, rel=0.006)


def test_the_force_never_exceeds_friction_times_load():
    with wheelset(25.0) as plant:
        inputs = np.array([0.02, WORST.mu0, WORST.A, WORST.B, 0.0])
        plant.start(inputs)
        rows = np.array([plant.step(inputs) for _ in range(2000)])
    forces = rows[:, COLUMNS["creep_force"]]
    assert forces.max() < WORST.mu0 * mal.N
    assert forces.max() > 0.95 * WORST.mu0 * mal.N


@pytest.mark.parametrize("name", ["braking", "hard_braking", "traction"])
def test_torque_of_the_motor_accelerates_train_and_wheels(name):
    """Force divided by mass with the wheels' inertia: the wheels roll, and hunting consumes no force."""
    variant = PLANTS[name]
    drawn = course(TESTS[0].shorten(0.5), 1, variant)
    with wheelset(25.0, variant) as plant:
        plant.start(drawn.inputs[0])
        rows = plant.follow(drawn.inputs)
    v = rows[:, COLUMNS["speed"]][:, 0]
    mass = mal.MV + (mal.IR + mal.IL) / mal.R0**2
    expected = variant.utilisation * mal.MV * 9.81 / mass
    # The twist settles within a few of 500 ms, and hunting takes some 1e-3 of the force.
    assert (v[-1] - 25.0) / (len(v) * PERIOD) == pytest.approx(expected, rel=0.02)


def test_plants_unlike_the_filters_differ_in_the_parameters_of_their_titles():
    """Compared with Table 1 as written for the tests."""
    table = {"m_unsprung": mal.MW, "I_yaw": mal.IW, "conicity": mal.CONICITY, "m_wheelset": mal.MV, "k_A": 1, "k_S": 1}
    percent = {"softer": -5, "slightly_softer": -1, "heavier": 5, "yaw_inertia": 5, "conicity": 10, "loaded": 10}
    assert {name for name, variant in PLANTS.items() if variant.parameters} == set(percent)
    for name, share in percent.items():
        for parameter, value in PLANTS[name].parameters.items():
            assert value == pytest.approx(table[parameter] * (1 + share / 100))
        assert f"{abs(share)} %" in PLANTS[name].title
