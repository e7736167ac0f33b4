"""The train's prediction FMUs are the functions of their Modelica classes, Jacobians included.

The FMU and its directional derivatives against the equations written out below, on states all over a stop; central
differences of an FMU are compared with directional derivatives in test_fmu_exchange.py.
"""

import numpy as np
import pytest
from synthetic import TYPICAL

from railgrip.estimation.models import of_class


def closed_form(state: np.ndarray, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return derivative and outputs of the two-part train, from equation (7) of the paper and its data, one by one.

    Of 13 states (loads are static), 15, 25, or 27 (d and bias last); complex numbers go through, for derivatives.
    """
    size, is_disturbed = state.size, state.size in (15, 27)
    v, w, mu_b, alpha = state[0], state[1:5], state[5:9], state[9:13]
    dz, ddz = (state[13:19], state[19:25]) if size > 15 else (np.zeros(6), np.zeros(6))
    d, bias = state[-2:] if is_disturbed else (0.0, 0.0)
    r, g, mass = 0.38, 9.81, np.array([13400, 14100, 14500, 14500, 14100, 13400])
    spring = 2.4e6 * dz + 2.4e4 * ddz
    static = g * mass
    load = np.array([sum(static[:2]) + sum(spring[:2]), static[2] + spring[2], static[3] + spring[3],
                     sum(static[4:]) + sum(spring[4:])])  # fmt: skip
    force = alpha * load
    piston = u[:4] * 0.0324 - 1200
    pads = 0.95 * 6 * (piston + np.sqrt(piston**2 + 50**2)) / 2
    torque = np.array([3, 2, 2, 3]) * mu_b * np.array([0.235, 0.22, 0.22, 0.235]) * pads
    bearings = 1 / np.sqrt((r / (0.0018 * 0.065)) ** 2 * (1 + 0.0018**2) - 1)
    spin = (r * force - torque - (r * bearings + 0.0004) * load) / np.array([222, 209, 209, 222])
    a = (u[4] - sum(force) - 0.5 * 1.2 * 0.9 * 10 * v**2) / 84000 + d
    heave = np.zeros(6, dtype=np.result_type(state, u))
    braking, brake = (np.array([q[0], q[1] + q[2], q[3]]) for q in (force, torque))
    for b, (unsprung, frame, inertia, base) in enumerate(
        [(3000, 3500, 2200, 1.9), (2600, 2800, 2300, 2.65), (3000, 3500, 2200, 1.9)]
    ):
        front, rear = spring[2 * b : 2 * b + 2]
        axles = braking[b] + unsprung * a
        nose_down = brake[b] + axles * (0.55 - r) - (axles + frame * a) * (0.55 - 0.40)
        bounce, pitch = -(front + rear) / frame, (nose_down - (front - rear) * base / 2) / inertia
        heave[2 * b : 2 * b + 2] = bounce + pitch * base / 2, bounce - pitch * base / 2
    moving, none = ([ddz, heave], np.zeros(4)) if size > 15 else ([], np.zeros(4))
    derivative = np.concatenate([[a], spin, none, none, *moving, np.zeros(2 if is_disturbed else 0)])
    return derivative, np.concatenate([[v], w, *([dz] if size > 15 else []), [a + bias]])


def complex_step(x: np.ndarray, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return both Jacobians of the closed form by the states, to rounding."""
    columns = [closed_form(x + 1e-30j * unit, u) for unit in np.eye(x.size)]
    f, h = (np.column_stack([column[k].imag / 1e-30 for column in columns]) for k in (0, 1))
    return f, h


@pytest.mark.parametrize(
    "name", [f"TrainPrediction{kind}" for kind in ("", "Reduced", "Disturbed", "ReducedDisturbed")]
)
def test_the_fmu_is_the_equations_written_out(name: str):
    """Derivatives, outputs and Jacobians, at random states of a stop."""
    of_groups, wheelsets = range(1, 5), [] if "Reduced" in name else range(1, 7)
    wheel_speeds = [f"wheelset_speed[{i}]" for i in of_groups]
    names = [
        "speed",
        *wheel_speeds,
        *(f"{base}[{i}]" for base in ("pad_friction", "group_adhesion") for i in of_groups),
    ]
    names += [f"{base}[{i}]" for base in ("dz", "ddz") for i in wheelsets]
    names += ["d", "bias"] if "Disturbed" in name else []
    rng, typical = np.random.default_rng(20), [TYPICAL[each.partition("[")[0]] for each in names]
    with of_class(name).prediction({}) as fmu:
        assert sorted(fmu.states) == sorted(names)
        assert fmu.inputs == (*(f"cylinder_pressure[{i}]" for i in of_groups), "track_force")
        assert fmu.outputs == ("speed", *wheel_speeds, *(f"deflection[{i}]" for i in wheelsets), "acceleration")
        back = [names.index(each) for each in fmu.states]
        for share in (3.0, 1.0, 0.3, 0.05):  # of 20 m/s
            x = rng.uniform(0.5, 1.5, len(names)) * typical * np.where(np.arange(len(names)) < 5, share, 1.0)
            u = np.array([*rng.uniform(0.5e5, 3.4e5, size=4), rng.normal(scale=5e3)])
            at, (f, h), (df, dh) = x[back], closed_form(x, u), complex_step(x, u)
            for own, expected in (
                (fmu.derivative(at, u), f[back]),
                (fmu.output(at, u), h),
                (fmu.derivative_jacobian(at, u), df[back][:, back]),
                (fmu.output_jacobian(at, u), dh[:, back]),
            ):
                np.testing.assert_allclose(own, expected, rtol=1e-12, atol=1e-12 * np.abs(expected).max())
