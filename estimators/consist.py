"""A prediction of any train, composed of parts that share only its speed and acceleration."""

from collections.abc import Sequence
from dataclasses import dataclass

import casadi as ca
import numpy as np

from railgrip.base.errors import EstimatorError
from railgrip.estimators.belief import Vector
from railgrip.fmus.native import Model


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Part:
    """Wheelsets that are coupled to others only by the speed and acceleration of the train: a bogie or a group.

    Attributes:
        model: Equations of the part. Its last input is `acceleration`, in which the equations are linear; its only
            output is the braking force.
        parameters: Parameters of the model, in its order.
        states: Names of the states in the whole train, in the model's order.
        inputs: Names of the inputs in the whole train, without the acceleration.
        readings: Pairs of a reading and the state that it measures, by their names in the whole train.
    """

    model: Model
    parameters: Vector
    states: tuple[str, ...]
    inputs: tuple[str, ...]
    readings: tuple[tuple[str, str], ...]


@dataclass(frozen=True, kw_only=True, eq=False)
class Consist:
    """Parts and the body that they brake.

    States are the speed, then those of each part. Readings are the speed, then those of each part, then the
    acceleration.

    Attributes:
        body: Model with one state v, inputs force and track_force, and the output acceleration.
        body_parameters: Parameters of the body, in its order.
        parts: Parts, leading one first.
    """

    body: Model
    body_parameters: Vector
    parts: Sequence[Part]

    @property
    def states(self) -> tuple[str, ...]:
        """Names of the states."""
        return ("speed", *(name for part in self.parts for name in part.states))

    @property
    def inputs(self) -> tuple[str, ...]:
        """Names of the inputs: pressures, then the force of the track."""
        return (*(name for part in self.parts for name in part.inputs), "track_force")

    @property
    def readings(self) -> tuple[tuple[str, str | None], ...]:
        """Name of each reading and of the state that it measures, None for the acceleration."""
        return (("speed", "speed"), *(pair for part in self.parts for pair in part.readings), ("acceleration", None))

    @property
    def outputs(self) -> tuple[str, ...]:
        """Names of the readings."""
        return tuple(name for name, _ in self.readings)

    @property
    def parameters(self) -> Vector:
        """Parameters of the body, then those of each part, shape (np,)."""
        return np.concatenate([self.body_parameters, *(part.parameters for part in self.parts)])


def part_equations(model: Model, kind: int) -> dict[str, ca.Function]:
    """Return the equations of a part for the decentralised filter, as functions of (x, u, p) whose names end in `kind`.

    `slope` returns ẋ at zero acceleration and the braking force; `linear` returns the same, and the derivatives of ẋ by
    the acceleration, of the force by x and of ẋ by x; `force` returns the braking force and its derivative by x.

    Raises:
        EstimatorError: The equations are not linear in the acceleration, or the force depends on it.
    """
    t = 0.0
    x, u, p = (ca.SX.sym(s, len(v)) for s, v in (("x", model.states), ("u", model.inputs), ("p", model.parameters)))
    slope, force = model.derivative(t, x, u, p), model.output(t, x, u, p)
    push = ca.jacobian(slope, u[-1])
    if ca.depends_on(push, ca.vertcat(x, u)) or ca.depends_on(force, u[-1]):
        raise EstimatorError(f"{model}: a part of a train is linear in its acceleration, and its force free of it.")
    pull = ca.jacobian(force, x)
    each = {
        "slope": [slope, force],
        "linear": [slope, force, push, pull, ca.jacobian(slope, x).T],
        "force": [force, pull],
    }
    # Dense, as the C code expects; transposed, because CasADi stores matrices by columns.
    return {
        name: ca.Function(f"{name}_{kind}", [x, u, p], [ca.densify(value) for value in values])
        for name, values in each.items()
    }
