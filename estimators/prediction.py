"""The model of a filter: its interface, and an implementation with CasADi functions."""

from collections.abc import Mapping
from dataclasses import replace
from functools import cached_property, lru_cache
from typing import Protocol, runtime_checkable

import casadi as ca
import numpy as np

from railgrip.base.errors import EstimatorError
from railgrip.base.names import state_name
from railgrip.estimators.belief import Matrix, Vector
from railgrip.estimators.model_in_c import ModelInC, model_in_c
from railgrip.fmus.native import Model


@lru_cache(maxsize=64)
def with_state_names(model: Model) -> Model:
    """Return the model of a prediction whose states have names in place of symbols; see `base.names.state_name`."""
    return replace(model, states=tuple(replace(state, name=state_name(state.name)) for state in model.states))


class FilterVariables(Protocol):
    """Names of the n states, nu inputs and m outputs of a model."""

    @property
    def states(self) -> tuple[str, ...]:
        """Names of the states."""
        ...

    @property
    def inputs(self) -> tuple[str, ...]:
        """Names of the inputs."""
        ...

    @property
    def outputs(self) -> tuple[str, ...]:
        """Names of the outputs, in the order of the readings."""
        ...


@runtime_checkable
class Prediction(FilterVariables, Protocol):
    """A smooth, time-invariant model ẋ = f(x, u), y = h(x, u).

    Outputs may depend on inputs: an accelerometer responds to the brakes at once. Every call returns a new array that
    the caller may keep.
    """

    def derivative(self, x: Vector, u: Vector) -> Vector:
        """Return f(x, u), shape (n,), in units of the states per second."""
        ...

    def output(self, x: Vector, u: Vector) -> Vector:
        """Return h(x, u), shape (m,)."""
        ...

    def derivative_jacobian(self, x: Vector, u: Vector) -> Matrix:
        """Return ∂f/∂x, shape (n, n)."""
        ...

    def output_jacobian(self, x: Vector, u: Vector) -> Matrix:
        """Return ∂h/∂x, shape (m, n)."""
        ...


@runtime_checkable
class PredictionInC(Prediction, Protocol):
    """A prediction that a filter in C can evaluate, too.

    Attributes:
        parameters: Values that its C code reads at `block + PARAMETERS`.
    """

    parameters: Vector

    def in_c(self) -> ModelInC:
        """Return the C code."""
        ...

    def failure(self) -> str:
        """Return a sentence on why its C code did not return 0."""
        ...


class Equations:
    """f, h and their sparse Jacobians as CasADi expressions of x, u and p.

    Attributes:
        x: Symbols of the states, shape (n, 1); `u` and `p` likewise.
        derivative: f, shape (n, 1).
        output: h, shape (m, 1).
        derivative_jacobian: ∂f/∂x, sparse, shape (n, n).
        output_jacobian: ∂h/∂x, sparse, shape (m, n).

    Raises:
        EstimatorError: The model depends on time, or its functions do not match its variables.
    """

    def __init__(self, model: Model) -> None:
        t = ca.SX.sym("t")
        self.x = ca.SX.sym("x", len(model.states))
        self.u = ca.SX.sym("u", len(model.inputs))
        self.p = ca.SX.sym("p", len(model.parameters))
        symbols = (t, self.x, self.u, self.p)
        for what, function, count in (
            ("derivative", model.derivative, len(model.states)),
            ("output", model.output, len(model.outputs)),
        ):
            sizes = [function.numel_in(i) for i in range(function.n_in())]
            if sizes != [symbol.numel() for symbol in symbols] or function.numel_out(0) != count:
                raise EstimatorError(
                    f"Prediction: {what} must map (t, x, u, p) of sizes {[s.numel() for s in symbols]} "
                    f"to {count} values; it maps {sizes} to {function.numel_out(0)}."
                )
        self.derivative = ca.densify(model.derivative(*symbols))
        self.output = ca.densify(model.output(*symbols))
        if ca.depends_on(ca.vertcat(self.derivative, self.output), t):
            raise EstimatorError(
                "Prediction: the model depends on time; a prediction is a function of states and inputs only: "
                "declare the time-dependent quantity as an input."
            )
        self.derivative_jacobian = ca.jacobian(self.derivative, self.x)
        self.output_jacobian = ca.jacobian(self.output, self.x)

    @cached_property
    def in_c(self) -> ModelInC:
        """The functions and their Jacobians as C code."""
        return model_in_c(
            self.x, self.u, self.p, self.derivative, self.output, self.derivative_jacobian, self.output_jacobian
        )


@lru_cache(maxsize=16)
def equations_of(model: Model) -> Equations:
    """Return the equations of a model, cached, because a process simulates the same train hundreds of times."""
    return Equations(model)


class _BufferedFunction:
    """An expression as a fast numeric function with fixed buffers for arguments and result.

    CasADi reads and writes the buffers through their addresses; the attributes keep them alive.
    """

    def __init__(self, of: Equations, expression: ca.SX, parameters: Vector) -> None:
        self._function = ca.Function("evaluate", [of.x, of.u, of.p], [ca.densify(expression)])
        self._x, self._u, self._parameters = np.zeros(of.x.numel()), np.zeros(of.u.numel()), parameters
        self._result = np.zeros(expression.shape, order="F")  # CasADi stores matrices by columns
        self._buffer, self._run = self._function.buffer()
        for place, array in enumerate((self._x, self._u, self._parameters)):
            # CasADi's stub describes the C++ overload, with a size; the Python one takes a memoryview.
            self._buffer.set_arg(place, array.data)  # pyright: ignore[reportCallIssue]
        self._buffer.set_res(0, self._result.T.data)  # pyright: ignore[reportCallIssue]

    def __call__(self, x: Vector, u: Vector) -> Matrix:
        self._x[:] = x
        self._u[:] = u
        self._run()
        return self._result.copy()


class CasadiPrediction:
    """A prediction from the CasADi functions of a model, with exact Jacobians.

    Args:
        model: The model.
        parameters: Value of every parameter of the model by name, in its SI unit.

    Raises:
        EstimatorError: A parameter is missing or unknown, or the model is not a prediction (see `Equations`).
    """

    def __init__(self, model: Model, parameters: Mapping[str, float]) -> None:
        """Match parameters by name and create the numeric functions."""
        self.states = tuple(variable.name for variable in model.states)
        self.inputs = tuple(variable.name for variable in model.inputs)
        self.outputs = tuple(variable.name for variable in model.outputs)
        names = tuple(variable.name for variable in model.parameters)
        missing = [name for name in names if name not in parameters]
        unknown = [name for name in parameters if name not in names]
        if missing:
            raise EstimatorError(f"Prediction: no value for the parameters {', '.join(missing)}; give every one.")
        if unknown:
            raise EstimatorError(
                f"Prediction: the model has no parameters {', '.join(unknown)}; it has {', '.join(names) or 'none'}."
            )
        self.parameters = np.array([parameters[name] for name in names], dtype=np.float64)
        self.equations = equations_of(model)
        of = self.equations
        self._derivative = _BufferedFunction(of, of.derivative, self.parameters)
        self._output = _BufferedFunction(of, of.output, self.parameters)
        self._derivative_jacobian = _BufferedFunction(of, of.derivative_jacobian, self.parameters)
        self._output_jacobian = _BufferedFunction(of, of.output_jacobian, self.parameters)

    def in_c(self) -> ModelInC:
        """Return the same functions as C code."""
        return self.equations.in_c

    def failure(self) -> str:
        """Return a sentence for a failed evaluation, which CasADi's functions never report."""
        return "Filter: the prediction cannot be evaluated."

    def derivative(self, x: Vector, u: Vector) -> Vector:
        """Return f(x, u), shape (n,)."""
        return self._derivative(x, u)[:, 0]

    def output(self, x: Vector, u: Vector) -> Vector:
        """Return h(x, u), shape (m,)."""
        return self._output(x, u)[:, 0]

    def derivative_jacobian(self, x: Vector, u: Vector) -> Matrix:
        """Return ∂f/∂x, shape (n, n)."""
        return self._derivative_jacobian(x, u)

    def output_jacobian(self, x: Vector, u: Vector) -> Matrix:
        """Return ∂h/∂x, shape (m, n)."""
        return self._output_jacobian(x, u)
