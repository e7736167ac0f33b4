"""A model-exchange FMU as a pure function of state and input: what a filter predicts with.

The FMU is initialised once and then only evaluated, at time zero: a prediction model is autonomous, smooth
and without events, and one that has events is refused. Its Jacobians come from fmi2GetDirectionalDerivative
where the FMU offers it, else from central differences.
"""

import ctypes
from collections.abc import Iterable, Sequence
from contextlib import ExitStack
from math import isfinite
from types import TracebackType
from typing import Final, Literal, Self

import numpy as np
from fmpy.fmi2 import fmi2EventInfo
from numpy.typing import NDArray

from railgrip.errors import FmuError, PlantFailed
from railgrip.fmu.description import Description, Variable
from railgrip.fmu.instance import OK_OR_WARNING, Instance, unpack
from railgrip.fmu.parameters import Values, assignments

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]

# Cube root of the rounding error: truncation (h²) and cancellation (ε/h) of a central difference balance.
_RELATIVE_STEP: Final = float(np.finfo(float).eps) ** (1 / 3)


class FmuPrediction:
    """The Prediction protocol of the estimators, by a model-exchange FMU in this process; used inside `with`.

    States, inputs and outputs are in the order asked for, whatever order the compiler of the FMU chose. The values of
    one point are sent once, and anew after its derivatives were read.
    """

    def __init__(
        self,
        description: Description,
        *,
        parameters: Values,
        states: Sequence[str],
        inputs: Sequence[str],
        outputs: Sequence[str],
    ) -> None:
        """Check the question; nothing is loaded before `with`.

        Args:
            description: Of the FMU; variables in SI.
            parameters: Values by FMU variable.
            states: All of the FMU's states, in the order wanted.
            inputs: All of its inputs, in the order wanted.
            outputs: What the filter reads, in the order wanted.

        Raises:
            FmuError: A parameter is wrong, the FMU has other states, lacks a variable or has one that is not Real, has
                events, or is not in SI.
        """
        if sorted(states) != sorted(description.states):
            lacks = [s for s in states if s not in description.states]
            extra = [s for s in description.states if s not in states]
            raise FmuError(
                f"{description.file}: the prediction's states are not those expected; "
                f"missing: {', '.join(lacks) or 'none'}; unexpected: {', '.join(extra) or 'none'}."
            )
        for name in (*states, *inputs, *outputs):
            _require_si(description, description.variable(name, "prediction"))
        self.states, self.inputs, self.outputs = tuple(states), tuple(inputs), tuple(outputs)
        self._description = description
        self._assignments = assignments(description, parameters)
        self._references = (
            _references(description.variables[name] for name in states),
            _references(_real(description, name, "input") for name in inputs),
            _references(_real(description, name, "output") for name in outputs),
        )
        rest = sorted(set(description.names("input")) - set(inputs))
        if rest:
            raise FmuError(f"{description.file}: the prediction leaves inputs undriven: {', '.join(rest)}.")
        if description.event_indicators:
            raise FmuError(
                f"{description.file}: a prediction must be smooth, this FMU has "
                f"{description.event_indicators} event indicators; write its equations without if, when, "
                "abs, sign, min or max."
            )
        interface = description.model_exchange
        self._has_directional = interface is not None and interface.directional_derivatives
        # theirs[k] is our index of their k-th state; ours[i] their index of our i-th.
        self._theirs = np.array([self.states.index(s) for s in description.states], dtype=np.intp)
        self._ours = np.array([description.states.index(s) for s in self.states], dtype=np.intp)
        self._jacobians: tuple[bytes, Matrix, Matrix] | None = None
        self._stack = ExitStack()
        self._instance: Instance | None = None

    def __enter__(self) -> Self:
        """Unpack, load, instantiate, set the parameters and initialise."""
        with ExitStack() as stack:
            folder = stack.enter_context(unpack(self._description))
            instance = Instance(self._description, "model exchange", folder, name="prediction")
            stack.callback(instance.close)
            instance.assign(self._assignments, 0.0)
            instance.enter_initialization()
            instance.exit_initialization()
            _settle(instance)
            self._instance = instance
            self._prepare(instance)
            self._stack = stack.pop_all()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        """Free everything, whatever happened."""
        self._instance = self._jacobians = None
        self._stack.close()

    def _prepare(self, instance: Instance) -> None:
        """Make the buffers, addresses and functions of the hot path."""
        n, nu, m = len(self.states), len(self.inputs), len(self.outputs)
        pointer, size = ctypes.c_void_p, ctypes.c_size_t
        self._component = pointer(instance.component)
        self._set_states = instance.function("fmi2SetContinuousStates", pointer, pointer, size)
        self._set_real = instance.function("fmi2SetReal", pointer, pointer, size, pointer)
        self._get_derivatives = instance.function("fmi2GetDerivatives", pointer, pointer, size)
        self._get_real = instance.function("fmi2GetReal", pointer, pointer, size, pointer)
        self._get_directional = instance.function(
            "fmi2GetDirectionalDerivative", pointer, pointer, size, pointer, size, pointer, pointer
        )
        derivatives = np.array(self._description.derivatives)[self._ours] if n else ()
        states, inputs, outputs = self._references
        self._unknowns = np.concatenate(
            [_references(self._description.variables[str(name)] for name in derivatives), outputs]
        )
        # States and derivatives in the FMU's order, which its functions take and give them in.
        self._x, self._u, self._dx, self._y = np.zeros(n), np.zeros(nu), np.zeros(n), np.zeros(m)
        self._seed = np.ones(1)
        # One row per state, so that the FMU writes each directional derivative where it stays.
        self._columns = np.zeros((n, n + m))
        self._at = b""
        arrays = {
            "x": self._x, "u": self._u, "dx": self._dx, "y": self._y, "inputs": inputs, "outputs": outputs,
            "unknowns": self._unknowns, "seed": self._seed,
        }  # fmt: skip
        self._pointers = {name: pointer(array.ctypes.data) for name, array in arrays.items()}
        self._state_pointers = [pointer(states.ctypes.data + 4 * j) for j in range(n)]
        self._column_pointers = [pointer(self._columns.ctypes.data + j * self._columns.strides[0]) for j in range(n)]
        # Without states OpenModelica's FMUs write into the first element all the same.
        nominal = self._read(instance, "fmi2GetNominalsOfContinuousStates") if n else np.zeros(0)
        self._nominal = np.where(np.isfinite(nominal) & (nominal > 0), nominal, 1.0)

    def _read(self, instance: Instance, call: str) -> Vector:
        """Return a value of each state, shape (n,)."""
        values = np.zeros(len(self.states))
        instance.call(call, values.ctypes.data_as(ctypes.POINTER(ctypes.c_double)), values.size, time=0.0)
        return values[self._ours]

    @property
    def start(self) -> Vector:
        """The FMU's own initial state, shape (n,)."""
        return self._read(self._open(), "fmi2GetContinuousStates")

    def derivative(self, x: Vector, u: Vector) -> Vector:
        """Return dx/dt at (x, u), shape (n,).

        Raises:
            PlantFailed: The FMU cannot be evaluated there, or the result is not finite.
        """
        self._move(x, u)
        p = self._pointers
        # OpenModelica's FMUs (to 1.27.0) evaluate the derivatives alone and then take everything for evaluated: outputs
        # and Jacobians would be those of an earlier point, unless the point is sent anew.
        self._at = b""
        self._check(self._get_derivatives(self._component, p["dx"], self._dx.size), "fmi2GetDerivatives")
        return self._finite(self._dx, self._description.derivatives)[self._ours]

    def output(self, x: Vector, u: Vector) -> Vector:
        """Return y at (x, u), shape (m,); `PlantFailed` where there is none."""
        self._move(x, u)
        p = self._pointers
        self._check(self._get_real(self._component, p["outputs"], self._y.size, p["y"]), "fmi2GetReal")
        return self._finite(self._y, self.outputs).copy()

    def derivative_jacobian(self, x: Vector, u: Vector) -> Matrix:
        """Return d(dx/dt)/dx at (x, u), shape (n, n); `PlantFailed` where there is none."""
        return self._both(x, u)[0].copy()

    def output_jacobian(self, x: Vector, u: Vector) -> Matrix:
        """Return dy/dx at (x, u), shape (m, n); `PlantFailed` where there is none."""
        return self._both(x, u)[1].copy()

    def _both(self, x: Vector, u: Vector) -> tuple[Matrix, Matrix]:
        """Return both Jacobians; the calls that give one give the other, so the last pair is kept."""
        point = x.tobytes() + u.tobytes()
        if self._jacobians is None or self._jacobians[0] != point:
            columns = self._directional(x, u) if self._has_directional else self._central(x, u)
            if not isfinite(columns.sum()) and not np.all(np.isfinite(columns)):
                raise self._failure(f"d/d({self.states[int(np.argwhere(~np.isfinite(columns))[0][0])]})", "a Jacobian")
            n = len(self.states)
            self._jacobians = (point, columns[:, :n].T.copy(), columns[:, n:].T.copy())
        return self._jacobians[1], self._jacobians[2]

    def _directional(self, x: Vector, u: Vector) -> Matrix:
        """Return the derivatives of dx/dt and y by each state from the FMU, one call a row, shape (n, n + m)."""
        self._move(x, u)
        unknowns, size, seed = self._pointers["unknowns"], self._unknowns.size, self._pointers["seed"]
        component, get = self._component, self._get_directional
        for state, column in zip(self._state_pointers, self._column_pointers, strict=True):
            status = get(component, unknowns, size, state, 1, seed, column)
            if status not in OK_OR_WARNING:
                self._check(status, "fmi2GetDirectionalDerivative")
        return self._columns

    def _central(self, x: Vector, u: Vector) -> Matrix:
        """Return the same by central differences; the step of each state is scaled by its value and its nominal one."""
        columns = np.zeros_like(self._columns)
        shifted_state = np.array(x, dtype=float)
        for j in range(x.size):
            step = _RELATIVE_STEP * max(abs(x[j]), self._nominal[j])
            above, below = x[j] + step, x[j] - step
            shifted_state[j] = above
            ahead = np.concatenate([self.derivative(shifted_state, u), self.output(shifted_state, u)])
            shifted_state[j] = below
            behind = np.concatenate([self.derivative(shifted_state, u), self.output(shifted_state, u)])
            shifted_state[j] = x[j]
            # The difference of the rounded points, not twice the step that was meant.
            columns[j] = (ahead - behind) / (above - below)
        return columns

    def _move(self, x: Vector, u: Vector) -> None:
        """Set state and inputs, unless the FMU is there already."""
        self._open()
        point = x.tobytes() + u.tobytes()
        if point == self._at:
            return
        self._at = b""
        if x.shape != self._x.shape or u.shape != self._u.shape:
            raise ValueError(
                f"a point of {self._description.file.name} has {self._x.size} states and {self._u.size} "
                f"inputs, got shapes {x.shape} and {u.shape}"
            )
        self._x[:] = x[self._theirs]
        self._u[:] = u
        p = self._pointers
        self._check(self._set_states(self._component, p["x"], self._x.size), "fmi2SetContinuousStates")
        if self._u.size:
            self._check(self._set_real(self._component, p["inputs"], self._u.size, p["u"]), "fmi2SetReal")
        self._at = point

    def _check(self, status: int, call: str) -> None:
        if status not in OK_OR_WARNING:
            self._open().check(status, call, 0.0, "evaluating the prediction")

    def _finite(self, values: Vector, names: Sequence[str]) -> Vector:
        if not isfinite(values.sum()) and not np.all(np.isfinite(values)):
            worst = int(np.flatnonzero(~np.isfinite(values))[0])
            raise self._failure(names[worst], "a prediction")
        return values

    def _failure(self, variable: str, doing: str) -> PlantFailed:
        return PlantFailed(self._open().failure("not_finite", "", 0.0, variable=variable, doing=doing))

    def _open(self) -> Instance:
        if self._instance is None:
            raise RuntimeError("an FmuPrediction is used inside 'with'")
        return self._instance


def _settle(instance: Instance) -> None:
    """Iterate the initial event and enter continuous time."""
    event = fmi2EventInfo()
    for _ in range(100):  # far more than any model needs; one that never settles is broken
        instance.call("fmi2NewDiscreteStates", ctypes.byref(event), time=0.0)
        if event.terminateSimulation:
            raise PlantFailed(instance.failure("ended", "fmi2NewDiscreteStates", 0.0))
        if not event.newDiscreteStatesNeeded:
            break
    else:
        raise PlantFailed(instance.failure("error", "fmi2NewDiscreteStates", 0.0, doing="its events never settle"))
    if event.nextEventTimeDefined:
        raise FmuError(
            f"{instance.description.file}: a prediction must be smooth, this FMU announces an event at "
            f"{event.nextEventTime:g} s; remove the condition on time from its equations."
        )
    instance.call("fmi2EnterContinuousTimeMode", time=0.0)
    instance.call("fmi2SetTime", 0.0, time=0.0)


def _real(description: Description, name: str, causality: Literal["input", "output"]) -> Variable:
    variable = description.variable(name, "prediction")
    if variable.kind != "Real":
        raise FmuError(f"{description.file}: '{name}' is {variable.kind}, a prediction is made of Real variables.")
    if causality == "input" and variable.causality != "input":
        raise FmuError(f"{description.file}: '{name}' is not an input but {variable.causality}.")
    return variable


def _require_si(description: Description, variable: Variable) -> None:
    stated_unit = variable.unit
    if stated_unit is not None and (stated_unit.factor != 1.0 or stated_unit.offset != 0.0):
        raise FmuError(
            f"{description.file}: '{variable.name}' of a prediction is in '{stated_unit.name}', SI is wanted; "
            "correct the model."
        )


def _references(variables: Iterable[Variable]) -> NDArray[np.uint32]:
    return np.array([v.reference for v in variables], dtype=np.uint32)
