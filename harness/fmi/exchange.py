"""A Model Exchange FMU as a pure function of state and input, for the prediction of a filter.

The FMU is initialised once and then only evaluated, at time zero: a prediction model is autonomous, smooth and without
events; one with events is refused. Its Jacobians come from fmi2GetDirectionalDerivative if the FMU provides it, else
from central differences. `kernel/prediction.c` makes the calls; `stepped.py` has the same by Co-Simulation.
"""

import ctypes
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import ExitStack
from importlib.resources import files
from math import nan
from pathlib import Path
from typing import ClassVar, Final, Literal, Self
from weakref import finalize

import numpy as np
from numpy.typing import NDArray

from railgrip.base.arrays import Matrix, Vector
from railgrip.base.errors import FmuError, PlantFailed
from railgrip.base.names import state_name
from railgrip.estimators.model_in_c import ModelInC, Pattern
from railgrip.fmi.description import Description, FmuVariable, Interface
from railgrip.fmi.instance import Instance, Values, assignments, unpack
from railgrip.fmus.native.toolchain import Struct, kernel_library

KERNEL: Final = ("railgrip.fmi", "prediction")

# Cube root of the rounding error: truncation (h²) and cancellation (ε/h) of a central difference balance.
_RELATIVE_STEP: Final = float(np.finfo(float).eps) ** (1 / 3)

_CALLS: Final[Mapping[str, str]] = {
    "SETTING_STATES": "fmi2SetContinuousStates",
    "SETTING_INPUTS": "fmi2SetReal",
    "GETTING_DERIVATIVES": "fmi2GetDerivatives",
    "GETTING_OUTPUTS": "fmi2GetReal",
    "DIFFERENTIATING": "fmi2GetDirectionalDerivative",
    "RESTORING": "fmi2SetFMUstate",
    "INITIALISING": "fmi2ExitInitializationMode",
    "STEPPING": "fmi2DoStep",
    "GETTING_STATES": "fmi2GetReal",
}
"""The FMI call behind a return value of `prediction.c`, by its name in the header."""


def column_groups(pattern: Pattern, columns: int) -> list[list[int]]:
    """Return the columns of a sparse matrix in groups of which no two columns have an entry in one row.

    One directional derivative gives all entries of a group. Columns without entries are omitted; the others are sorted
    by their number of entries, and each goes to the first group without a conflict.

    Source: Curtis, Powell and Reid, On the estimation of sparse Jacobian matrices (1974).
    """
    rows_of: list[set[int]] = [set() for _ in range(columns)]
    for row, entries in enumerate(pattern):
        for column in entries:
            rows_of[column].add(row)
    groups: list[tuple[list[int], set[int]]] = []
    for column in sorted((c for c in range(columns) if rows_of[c]), key=lambda c: -len(rows_of[c])):
        free = next((group for group in groups if group[1].isdisjoint(rows_of[column])), None)
        if free is None:
            groups.append(free := ([], set()))
        free[0].append(column)
        free[1].update(rows_of[column])
    return [members for members, _ in groups]


class FmuPrediction:
    """Implements the Prediction protocol of the estimators by a Model Exchange FMU in this process; used inside `with`.

    States, inputs and outputs are in the requested order, whatever order the compiler of the FMU chose.

    Attributes:
        parameters: For a filter in C: the addresses for evaluating the FMU; see estimators/kernel/addressed.h.
    """

    _calls: ClassVar[Mapping[str, str]] = _CALLS

    def __init__(
        self,
        description: Description,
        *,
        parameters: Values,
        states: Sequence[str],
        inputs: Sequence[str],
        outputs: Sequence[str],
        readings: Sequence[str] = (),
    ) -> None:
        """Check the arguments; nothing is loaded before `with`.

        Args:
            description: Description of the FMU; variables in SI.
            parameters: Values by FMU variable.
            states: All states of the FMU, in the requested order, by their names or by those of
                `railgrip.base.names.STATE_NAMES`.
            inputs: All inputs of the FMU, in the requested order.
            outputs: Outputs that the filter reads, in the requested order.
            readings: Names of these outputs as readings, if they differ from those in the FMU.

        Raises:
            FmuError: A parameter is wrong, or the FMU has other states, lacks a variable or has one that is not Real,
                has events, or is not in SI.
        """
        if description.fmi != 2:
            raise FmuError(
                f"{description.file}: a prediction is evaluated by FMI 2.0, this is FMI 3.0; export it as FMI 2.0."
            )
        # The FMU may have the symbols of the equations for its states.
        symbols = {state_name(symbol): symbol for symbol in description.states}
        theirs = [name if name in description.states else symbols.get(name, name) for name in states]
        if sorted(theirs) != sorted(description.states):
            lacks = [name for name, symbol in zip(states, theirs, strict=True) if symbol not in description.states]
            extra = [symbol for symbol in description.states if symbol not in theirs]
            raise FmuError(
                f"{description.file}: the prediction's states are not those expected; "
                f"missing: {', '.join(lacks) or 'none'}; unexpected: {', '.join(extra) or 'none'}."
            )
        for name in (*theirs, *inputs, *outputs):
            _require_si(description, description.variable(name, "prediction"))
        self.states, self.inputs, self.outputs = tuple(states), tuple(inputs), tuple(readings or outputs)
        self._description, self._symbols = description, theirs
        self._nominal = np.array([description.variables[name].nominal for name in theirs])
        self._assignments = assignments(description, parameters)
        self._references = (
            references_of(description.variables[name] for name in theirs),
            references_of(_real(description, name, "input") for name in inputs),
            references_of(_real(description, name, "output") for name in outputs),
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
        derivative_of = dict(zip(description.states, description.derivatives, strict=True))
        self._derivatives = [derivative_of[name] for name in theirs]
        self._slope_pattern = self._derivative_pattern = self._pattern(self._derivatives)
        self._output_pattern = self._pattern(outputs)
        self.parameters = np.zeros(3)
        self._stack = ExitStack()
        self._instance: Instance | None = None

    def __enter__(self) -> Self:
        with ExitStack() as stack:
            folder = stack.enter_context(unpack(self._description))
            self._instance = instance = self._begin(folder, stack)
            self._prepare(instance)
            self._stack = stack.pop_all()
        return self

    def _begin(self, folder: Path, stack: ExitStack) -> Instance:
        """Return an initialised instance, which the stack closes."""
        instance = Instance(self._description, "model exchange", folder, name="prediction")
        stack.callback(instance.close)
        instance.assign(self._assignments, 0.0)
        instance.enter_initialization()
        instance.exit_initialization()
        if (event := instance.settle(0.0)) is not None:
            raise FmuError(
                f"{self.file}: a prediction must be smooth, this FMU announces an event at {event:g} s; remove the "
                "condition on time from its equations."
            )
        instance.call("fmi2SetTime", 0.0, time=0.0)
        return instance

    def open(self) -> Self:
        """Open the FMU without `with`; it is closed with the last reference to this object, or at exit."""
        self.__enter__()
        finalize(self, self._stack.close)
        return self

    def __exit__(self, *_: object) -> None:
        self._instance = None
        self._stack.close()

    @property
    def file(self) -> Path:
        """Path of the FMU."""
        return self._description.file

    @property
    def has_directional_derivatives(self) -> bool:
        """Whether the FMU provides its Jacobians; otherwise they are central differences."""
        interface = self._interface
        return interface is not None and interface.directional_derivatives

    @property
    def _interface(self) -> Interface | None:
        return self._description.model_exchange

    def _pattern(self, unknowns: Sequence[str]) -> Pattern:
        # By FMI, an unknown without declared dependencies depends on all states.
        known = self._description.dependencies
        return tuple(
            tuple(i for i, state in enumerate(self._symbols) if name not in known or state in known[name])
            for name in unknowns
        )

    def _prepare(self, instance: Instance) -> None:
        n = len(self.states)
        _, inputs, outputs = self._references
        unknowns, pattern = self._differentiated
        self._struct = kernel_library(*KERNEL).struct(
            "Prediction", fmu=instance.component,
            set_real=instance.address("fmi2SetReal"), get_real=instance.address("fmi2GetReal"),
            get_directional=(
                instance.address("fmi2GetDirectionalDerivative") if self.has_directional_derivatives else None
            ),
            input_references=inputs, output_references=outputs, states=np.zeros(n), moved=np.zeros(n),
            inputs=np.zeros(inputs.size), ones=np.ones(n), by_state=self._jacobian(pattern, unknowns),
            of_output=self._jacobian(self._output_pattern, outputs), n_states=n, n_inputs=inputs.size,
            n_outputs=outputs.size, nominal=self._nominal, **self._fields(instance),
        )  # fmt: skip
        self._plan = self._struct.pointer
        addresses = [kernel_library(*KERNEL).address(name) for name in ("derivative", "output")]
        self.parameters[:] = np.array([*addresses, self._struct.address], dtype=np.uint64).view(np.float64)

    @property
    def _differentiated(self) -> tuple[NDArray[np.uint32], Pattern]:
        """References of the variables whose Jacobian by the states is requested, and its pattern."""
        return references_of(self._description.variables[name] for name in self._derivatives), self._slope_pattern

    def _fields(self, instance: Instance) -> dict[str, object]:
        """Return the fields of `Prediction` that depend on the interface."""
        theirs = {name: place for place, name in enumerate(self._description.states)}
        return {
            "set_states": instance.address("fmi2SetContinuousStates"),
            "get_derivatives": instance.address("fmi2GetDerivatives"),
            "place_of_state": np.array([theirs[name] for name in self._symbols], dtype=np.longlong),
            "derivatives": np.zeros(len(self.states)),
            "relative_step": _RELATIVE_STEP,
        }

    def _jacobian(self, pattern: Pattern, unknowns: NDArray[np.uint32]) -> Struct:
        n, groups = len(self.states), column_groups(pattern, len(self.states))
        starts = np.cumsum([0, *map(len, pattern)])
        entries = [
            (column, row, starts[row] + pattern[row].index(column))
            for members in groups
            for column in members
            for row in range(len(pattern))
            if column in pattern[row]
        ]
        columns, rows, places = np.array(entries, dtype=np.longlong).reshape(-1, 3).T
        of = np.array([column for members in groups for column in members], dtype=np.longlong)
        size = np.bincount(columns, minlength=n)
        counts = [int(size[members].sum()) for members in groups]
        buffer = max(len(pattern), *counts, 1) if counts else max(len(pattern), 1)
        return kernel_library(*KERNEL).struct(
            "Jacobian", first_column=np.cumsum([0, *map(len, groups)], dtype=np.longlong),
            known=np.ascontiguousarray(self._references[0][of]), state=of,
            first_entry=np.cumsum([0, *counts], dtype=np.longlong), unknown=np.ascontiguousarray(unknowns[rows]),
            column=np.ascontiguousarray(columns), row=np.ascontiguousarray(rows), place=np.ascontiguousarray(places),
            ahead=np.zeros(buffer), behind=np.zeros(buffer), n_groups=len(groups), n_entries=len(entries),
        )  # fmt: skip

    @property
    def start(self) -> Vector:
        """Initial state of the FMU, shape (n,).

        Raises:
            PlantFailed: A value is not finite.
        """
        instance = self._open()
        values = np.zeros(len(self.states))
        address = values.ctypes.data_as(ctypes.POINTER(ctypes.c_double))
        instance.call("fmi2GetContinuousStates", address, values.size, time=0.0)
        states = values[[self._description.states.index(name) for name in self._symbols]]
        if (bad := np.flatnonzero(~np.isfinite(states))).size:
            doing = f"{self.states[bad[0]]} is {states[bad[0]]}"
            raise PlantFailed(instance.failure("not_finite", "fmi2GetContinuousStates", 0.0, doing=doing))
        return states

    def in_c(self) -> ModelInC:
        """Return the C code by which a filter evaluates this FMU, valid inside `with`."""
        return ModelInC(
            derivative_pattern=self._derivative_pattern,
            output_pattern=self._output_pattern,
            inputs=len(self.inputs),
            parameters=self.parameters.size,
            sizes=(),
            text=(files("railgrip.estimators") / "kernel" / "addressed.h").read_text(encoding="utf-8"),
        )

    def failure(self) -> str:
        """Return the reason why the last evaluation failed; '' if it did not."""
        try:
            self._require_fine(self._plan.call)
        except PlantFailed as error:
            return str(error)
        return ""

    def derivative(self, x: Vector, u: Vector) -> Vector:
        """Return dx/dt at (x, u), shape (n,).

        Raises:
            PlantFailed: The FMU cannot be evaluated there, or the result is not finite.
        """
        return self._evaluate("derivative", x, u, None)

    def output(self, x: Vector, u: Vector) -> Vector:
        """Return y at (x, u), shape (m,); raise `PlantFailed` if it cannot be evaluated."""
        return self._evaluate("output", x, u, None)

    def derivative_jacobian(self, x: Vector, u: Vector) -> Matrix:
        """Return d(dx/dt)/dx at (x, u), shape (n, n); raise `PlantFailed` if it cannot be evaluated."""
        return self._differentiate("derivative", x, u, self._derivative_pattern)

    def output_jacobian(self, x: Vector, u: Vector) -> Matrix:
        """Return dy/dx at (x, u), shape (m, n); raise `PlantFailed` if it cannot be evaluated."""
        return self._differentiate("output", x, u, self._output_pattern)

    def require_true_jacobians(self, x: Vector, u: Vector) -> None:
        """Compare the Jacobians at (x, u), along one direction, with central differences.

        An FMU may declare too few dependencies, or provide the directional derivatives of another point.

        Raises:
            FmuError: They differ by more than one percent for any width of the differences: a wide one may exceed a
                smoothed corner of the equations, and rounding errors may exceed a narrow one.
        """
        random, size = np.random.default_rng(1), np.maximum(np.abs(x), self._nominal)
        x, direction = x + 1e-3 * size * random.random(x.size), size * random.uniform(0.5, 1.5, x.size)
        rates, outputs = self._rates(x, u), (lambda at: self.output(at, u), self.output_jacobian(x, u))
        for (function, jacobian), names in ((rates, self._derivatives), (outputs, self.outputs)):
            given, expected = jacobian @ direction, np.full(len(names), np.nan)
            wrong = np.full(len(names), True)
            for width in (1e-3, 1e-5, 1e-7):
                ahead, behind = (function(x + step * direction) for step in (width, -width))
                difference = (ahead - behind) / (2 * width)
                margin = 0.01 * (np.abs(jacobian) @ direction + np.abs(difference)) + 1e-14 / width * np.abs(ahead)
                expected = np.where(wrong, difference, expected)
                wrong &= np.abs(given - difference) > margin
            if wrong.any():
                row = int(np.argmax(wrong))
                raise FmuError(
                    f"{self.file}: along one direction of the states, {names[row]} changes by {expected[row]:.6g}, and "
                    f"by {given[row]:.6g} according to its directional derivatives or dependencies; correct these, or "
                    "export it without providesDirectionalDerivative and dependencies."
                )

    def _rates(self, x: Vector, u: Vector) -> tuple[Callable[[Vector], Vector], Matrix]:
        """Return the function of the states whose Jacobian the FMU provides, and this Jacobian at x."""
        return lambda at: self.derivative(at, u), self.derivative_jacobian(x, u)

    def _differentiate(self, what: Literal["derivative", "output"], x: Vector, u: Vector, pattern: Pattern) -> Matrix:
        entries = np.zeros(sum(map(len, pattern)))
        self._evaluate(what, x, u, entries)
        return self._matrix(entries, pattern)

    def _matrix(self, entries: Vector, pattern: Pattern) -> Matrix:
        matrix, entry = np.zeros((len(pattern), len(self.states))), 0
        for row, columns in enumerate(pattern):
            matrix[row, list(columns)] = entries[entry : entry + len(columns)]
            entry += len(columns)
        return matrix

    def _evaluate(self, what: Literal["derivative", "output"], x: Vector, u: Vector, entries: Vector | None) -> Vector:
        self._open()
        if x.shape != (len(self.states),) or u.shape != (len(self.inputs),):
            raise ValueError(
                f"a point of {self._description.file.name} has {len(self.states)} states and {len(self.inputs)} "
                f"inputs, got shapes {x.shape} and {u.shape}"
            )
        value = np.zeros(len(self.states if what == "derivative" else self.outputs))
        x, u = (np.ascontiguousarray(part, dtype=np.float64) for part in (x, u))
        # A call releases the interpreter's lock, which threads of the FMU may need.
        library = kernel_library(*KERNEL)
        code = getattr(library.functions, what)(self._plan, *map(library.doubles, (x, u, value, entries)))
        self._require_fine(code)
        return value

    def _require_fine(self, code: int) -> None:
        if not code:
            return
        instance = self._open()
        codes = kernel_library(*KERNEL).functions
        if code not in (codes.VALUE_NOT_FINITE, codes.ENTRY_NOT_FINITE):
            call = next(call for name, call in self._calls.items() if getattr(codes, name) == code)
            instance.check(self._plan.status, call, nan, "evaluating the prediction")
        names = self.outputs if self._plan.is_output else self._derivatives
        pattern = self._output_pattern if self._plan.is_output else self._differentiated[1]
        if code == codes.VALUE_NOT_FINITE:
            variable = names[self._plan.at]
        else:
            row, column = [(row, column) for row, columns in enumerate(pattern) for column in columns][self._plan.at]
            variable = f"d({names[row]})/d({self.states[column]})"
        raise PlantFailed(instance.failure("not_finite", "", nan, variable=variable, doing="a prediction"))

    def _open(self) -> Instance:
        if self._instance is None:
            raise RuntimeError("an FmuPrediction is used inside 'with'")
        return self._instance


def _real(description: Description, name: str, causality: Literal["input", "output"]) -> FmuVariable:
    variable = description.variable(name, "prediction")
    if variable.kind != "Real":
        raise FmuError(f"{description.file}: '{name}' is {variable.kind}, a prediction is made of Real variables.")
    if causality == "input" and variable.causality != "input":
        raise FmuError(f"{description.file}: '{name}' is not an input but {variable.causality}.")
    return variable


def _require_si(description: Description, variable: FmuVariable) -> None:
    stated_unit = variable.defined_unit
    if stated_unit is not None and (stated_unit.factor != 1.0 or stated_unit.offset != 0.0):
        raise FmuError(
            f"{description.file}: '{variable.name}' of a prediction is in '{stated_unit.name}', but must be in SI; "
            "correct the model."
        )


def references_of(variables: Iterable[FmuVariable]) -> NDArray[np.uint32]:
    """Return the value references of variables."""
    return np.array([v.reference for v in variables], dtype=np.uint32)
