"""The train's prediction FMUs are the functions of their Modelica classes, Jacobians included.

The FMU's directional derivatives, central differences of the same FMU, and the derivative of the CasADi function that
the compiler made of the class: three ways that share little, on states all over a stop.
"""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

from railgrip.fmu import Description, FmuPrediction, describe
from railgrip.fmus.native import Model, lower, package
from railgrip.fmus.native.dae import read
from railgrip.fmus.native.system import explicit

LIBRARY = Path(__file__).parents[2] / "modelica" / "RailBraking"


@pytest.fixture(scope="module", params=["TrainPrediction", "TrainPredictionReduced", "TrainPredictionDisturbed"])
def catalogue(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> tuple[Model, Description]:
    name = f"RailBraking.FMUs.{request.param}"
    file = tmp_path_factory.mktemp("prediction") / f"{request.param}.fmu"
    source = package.sources(
        explicit(read(name, LIBRARY)), interfaces=("me",), solver="rodas4", tolerance=1e-6, step=1e-3
    )
    package.pack(source, file)
    return lower(name, LIBRARY), describe(file)


def opened(catalogue: tuple[Model, Description], differentiation: str) -> FmuPrediction:
    """Return the prediction with the FMU's own derivatives, or as if it had none."""
    model, description = catalogue
    assert description.model_exchange is not None
    own = replace(description.model_exchange, directional_derivatives=differentiation == "directional")
    return FmuPrediction(
        replace(description, model_exchange=own),
        parameters={},
        states=[v.name for v in model.states],
        inputs=[v.name for v in model.inputs],
        outputs=[v.name for v in model.outputs],
    )


def points(start: np.ndarray, states: tuple[str, ...]) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Yield states and inputs of braking at 1 to 60 m/s, with up to 20 % slip and moving bogies."""
    rng = np.random.default_rng(20)
    for speed in (60.0, 22.0, 5.0, 1.0):
        x = start.copy()
        for i, name in enumerate(states):
            if name == "v":
                x[i] = speed
            elif name.startswith("w["):
                x[i] *= speed / start[states.index("v")] * rng.uniform(0.8, 1.0)
            elif name.startswith(("dz", "ddz")):
                x[i] = rng.normal(scale=2e-3)
            else:
                x[i] *= rng.uniform(0.7, 1.3)
        yield x, np.array([*rng.uniform(0.5e5, 3.4e5, size=4), rng.normal(scale=5e3)])


def test_the_fmu_is_the_function_of_its_class(catalogue: tuple[Model, Description]):
    model, _ = catalogue
    parameters = ca.DM([v.start for v in model.parameters])
    x, u = ca.SX.sym("x", len(model.states)), ca.SX.sym("u", len(model.inputs))
    f, h = model.derivative(0, x, u, parameters), model.output(0, x, u, parameters)
    exact = ca.Function("exact", [x, u], [f, h, ca.jacobian(f, x), ca.jacobian(h, x)])
    with opened(catalogue, "directional") as fmu:
        for at, inputs in points(fmu.start, fmu.states):
            expected = [np.array(w.full()) for w in exact(at, inputs)]
            # The same expressions, in C or in CasADi's virtual machine: rounding, of terms that cancel.
            size = [np.abs(w).max() for w in expected]
            np.testing.assert_allclose(fmu.derivative(at, inputs), expected[0].ravel(), atol=1e-12 * size[0])
            np.testing.assert_allclose(fmu.output(at, inputs), expected[1].ravel(), atol=1e-12 * size[1])
            np.testing.assert_allclose(fmu.derivative_jacobian(at, inputs), expected[2], atol=1e-12 * size[2])
            np.testing.assert_allclose(fmu.output_jacobian(at, inputs), expected[3], atol=1e-12 * size[3])


def test_directional_derivatives_agree_with_central_differences(catalogue: tuple[Model, Description]):
    with opened(catalogue, "directional") as exact, opened(catalogue, "central") as central:
        for x, u in points(exact.start, exact.states):
            for expected, derivative in (
                (exact.derivative_jacobian(x, u), central.derivative_jacobian(x, u)),
                (exact.output_jacobian(x, u), central.output_jacobian(x, u)),
            ):
                # A central difference keeps two thirds of the digits of the larger entries.
                np.testing.assert_allclose(derivative, expected, rtol=1e-6, atol=1e-8 * np.abs(expected).max())
