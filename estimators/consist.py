"""A prediction of any train, made of parts that share its speed and acceleration only."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property

import casadi as ca
import numpy as np

from railgrip.errors import EstimatorError
from railgrip.estimators.belief import Vector
from railgrip.estimators.prediction import CasadiPrediction
from railgrip.fmus.native import Model, Variable


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Part:
    """Wheelsets that nothing but the speed and the acceleration of the train couples to others: a bogie or a group.

    Attributes:
        model: Its equations: inputs end with `acceleration`, in which they are linear; the only output is its braking
            force.
        parameters: Of the model, in its order.
        states: Names in the whole train, in the model's order.
        inputs: Likewise, without the acceleration.
        readings: Which readings show which of its states, by their names in the whole train.
    """

    model: Model
    parameters: Vector
    states: tuple[str, ...]
    inputs: tuple[str, ...]
    readings: tuple[tuple[str, str], ...]


@dataclass(frozen=True, kw_only=True, eq=False)
class Consist:
    """Parts and the body that they brake; one prediction of them all, for a central filter.

    States are v, then those of each part; readings speed, those of each part, acceleration.

    Attributes:
        body: Model of one state v with inputs force and track_force and the output acceleration.
        body_parameters: In its order.
        parts: Leading one first.
    """

    body: Model
    body_parameters: Vector
    parts: Sequence[Part]

    @property
    def states(self) -> tuple[str, ...]:
        """Names of the states."""
        return ("v", *(name for part in self.parts for name in part.states))

    @property
    def inputs(self) -> tuple[str, ...]:
        """Names of the inputs: pressures, then the force of the track."""
        return (*(name for part in self.parts for name in part.inputs), "track_force")

    @property
    def readings(self) -> tuple[tuple[str, str | None], ...]:
        """Name of each reading and of the state that it shows, None for the acceleration."""
        return (("speed", "v"), *(pair for part in self.parts for pair in part.readings), ("acceleration", None))

    @property
    def outputs(self) -> tuple[str, ...]:
        """Names of the readings."""
        return tuple(name for name, _ in self.readings)

    @property
    def parameters(self) -> Vector:
        """Those of the body, then those of each part, shape (np,)."""
        return np.concatenate([self.body_parameters, *(part.parameters for part in self.parts)])

    @cached_property
    def prediction(self) -> CasadiPrediction:
        """All parts together, for a central filter."""
        model = model_of(self)
        return CasadiPrediction(model, {v.name: x for v, x in zip(model.parameters, self.parameters, strict=True)})


def _variables(names: Iterable[str]) -> tuple[Variable, ...]:
    return tuple(
        Variable(name=name, unit="", start=0.0, description="", minimum=None, maximum=None, nominal=1.0)
        for name in names
    )


def model_of(of: Consist) -> Model:
    """Return the equations of a consist; parameters are named p[1], p[2], … in its order."""
    parameters = tuple(f"p[{i + 1}]" for i in range(of.parameters.size))
    sizes = len(of.states), len(of.inputs), len(parameters)
    t, (x, u, p) = ca.SX.sym("t"), (ca.SX.sym(name, size) for name, size in zip("xup", sizes, strict=True))
    at_x, at_u, at_p = 1, 0, of.body_parameters.size
    forces, slopes = [], []
    for part in of.parts:
        n, m, k = len(part.states), len(part.inputs), part.parameters.size
        slopes.append((part.model.derivative, x[at_x : at_x + n], u[at_u : at_u + m], p[at_p : at_p + k]))
        own = ca.vertcat(u[at_u : at_u + m], 0.0)
        forces.append(part.model.output(t, x[at_x : at_x + n], own, p[at_p : at_p + k]))
        at_x, at_u, at_p = at_x + n, at_u + m, at_p + k
    force = ca.vertcat(sum(forces[1:], forces[0]), u[-1])
    acceleration = of.body.output(t, x[0], force, p[: of.body_parameters.size])
    rates = [slope(t, xs, ca.vertcat(us, acceleration), ps) for slope, xs, us, ps in slopes]
    readings = [acceleration if state is None else x[of.states.index(state)] for _, state in of.readings]
    return Model(
        class_name="consist",
        states=_variables(of.states),
        inputs=_variables(of.inputs),
        parameters=_variables(parameters),
        outputs=_variables(of.outputs),
        derivative=ca.Function("derivative", [t, x, u, p], [ca.vertcat(acceleration, *rates)]),
        output=ca.Function("output", [t, x, u, p], [ca.vertcat(*readings)]),
        initial=ca.Function("initial", [p], [ca.SX.zeros(sizes[0])]),
    )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PartEquations:
    """Equations of one kind of part for the decentralised filter, as CasADi functions of (x, u, p).

    Attributes:
        slope: ẋ without acceleration, and the braking force.
        linear: The same, and the derivatives: of ẋ and of the force by the acceleration and x.
        force: The braking force and its derivative by x.
    """

    slope: ca.Function
    linear: ca.Function
    force: ca.Function


def part_equations(model: Model, kind: int) -> PartEquations:
    """Return the equations of a part, with names that end in `kind`.

    Raises:
        EstimatorError: They are not linear in the acceleration, or the force depends on it.
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
    # Dense, for the tables of C; transposed, because CasADi counts down columns.
    return PartEquations(
        **{
            name: ca.Function(f"{name}_{kind}", [x, u, p], [ca.densify(one) for one in values])
            for name, values in each.items()
        }
    )
