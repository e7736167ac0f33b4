"""The train's prediction FMUs are the functions of their Modelica classes, Jacobians included.

The FMU's directional derivatives and central differences of the same FMU against the equations written out below, on
states all over a stop.
"""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from railgrip.base.names import state_name
from railgrip.fmi import Description, FmuPrediction, describe
from railgrip.fmus.native import package
from railgrip.fmus.native.dae import read
from railgrip.fmus.native.system import explicit

LIBRARY = Path(__file__).parents[2] / "modelica" / "RailBraking"


@pytest.fixture(scope="module", params=[
    "TrainPrediction", "TrainPredictionReduced", "TrainPredictionDisturbed", "TrainPredictionReducedDisturbed"
])  # fmt: skip
def catalogue(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Description:
    name = f"RailBraking.Predictions.{request.param}"
    file = tmp_path_factory.mktemp("prediction") / f"{request.param}.fmu"
    source = package.sources(
        explicit(read(name, LIBRARY)), interfaces=("me",), solver="rodas4", tolerance=1e-6, step=1e-3
    )
    package.pack(source, file)
    return describe(file)


def opened(description: Description, differentiation: str) -> FmuPrediction:
    """Return the prediction with the FMU's own derivatives, or as if it had none."""
    assert description.model_exchange is not None
    own = replace(description.model_exchange, directional_derivatives=differentiation == "directional")
    return FmuPrediction(
        replace(description, model_exchange=own),
        parameters={},
        states=[state_name(symbol) for symbol in description.states],
        inputs=description.names("input"),
        outputs=[name for name in description.names("output") if name not in description.states],
    )


def points(start: np.ndarray, states: tuple[str, ...]) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Yield states and inputs of braking at 1 to 60 m/s, with up to 20 % slip and moving bogies."""
    rng = np.random.default_rng(20)
    for speed in (60.0, 22.0, 5.0, 1.0):
        x = start.copy()
        for i, name in enumerate(states):
            if name == "speed":
                x[i] = speed
            elif name.startswith("wheelset_speed["):
                x[i] *= speed / start[states.index("speed")] * rng.uniform(0.8, 1.0)
            elif name.startswith(("dz", "ddz")):
                x[i] = rng.normal(scale=2e-3)
            elif name.startswith("group_adhesion["):
                x[i] = rng.uniform(0.02, 0.2)
            elif name in ("d", "bias"):
                x[i] = rng.normal(scale=0.1)
            else:
                x[i] *= rng.uniform(0.7, 1.3)
        yield x, np.array([*rng.uniform(0.5e5, 3.4e5, size=4), rng.normal(scale=5e3)])


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
    ("differentiation", "relative", "of_the_largest"),
    # A central difference keeps two thirds of the digits of the larger entries.
    [("directional", 1e-12, 1e-12), ("central", 1e-6, 1e-8)],
)
def test_the_fmu_is_the_equations_written_out(
    catalogue: Description, differentiation: str, relative: float, of_the_largest: float
):
    """Derivatives, outputs and Jacobians, at random states of a stop."""
    with opened(catalogue, differentiation) as fmu:
        names = [
            "speed",
            *(f"{name}[{i}]" for name in ("wheelset_speed", "pad_friction", "group_adhesion") for i in range(1, 5)),
        ]
        names += [f"{name}[{i}]" for name in ("dz", "ddz") for i in range(1, 7)] if len(fmu.states) > 15 else []
        names += ["d", "bias"] if len(fmu.states) in (15, 27) else []
        assert sorted(fmu.states) == sorted(names)
        deflections = [f"deflection[{i}]" for i in range(1, 7)] if len(names) > 15 else []
        assert fmu.inputs == (*(f"cylinder_pressure[{i}]" for i in range(1, 5)), "track_force")
        assert fmu.outputs == ("speed", *(f"wheelset_speed[{i}]" for i in range(1, 5)), *deflections, "acceleration")
        order, back = [fmu.states.index(name) for name in names], [names.index(name) for name in fmu.states]
        for at, inputs in points(fmu.start, fmu.states):
            f, h = closed_form(at[order], inputs)
            df, dh = complex_step(at[order], inputs)
            for own, expected in ((fmu.derivative(at, inputs), f[back]), (fmu.output(at, inputs), h)):
                np.testing.assert_allclose(own, expected, rtol=1e-12, atol=1e-12 * np.abs(expected).max())
            for own, expected in (
                (fmu.derivative_jacobian(at, inputs), df[back][:, back]),
                (fmu.output_jacobian(at, inputs), dh[:, back]),
            ):
                atol = of_the_largest * np.abs(expected).max()
                np.testing.assert_allclose(own, expected, rtol=relative, atol=atol)
