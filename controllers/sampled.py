"""Sampled functions with states as CasADi graphs: the form of every law, of the valve logic and of `FreeWheel`.

Such a function is written once and runs in Python, in C in the loop, and as an FMU in other tools, with the same
results. Conditions select values instead of branches: `choose` takes the place of `if`.
"""

from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from functools import cached_property, reduce
from typing import Any, Literal

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from railgrip.base.names import ElementName
from railgrip.base.system import SampledSystem, Variable
from railgrip.base.units import short
from railgrip.vehicle.formation import Formation
from railgrip.vehicle.signals import Signal, names_of

Expression = Any
"""A scalar `casadi.SX`."""

Symbols = Mapping[str, Expression]
"""Expressions by name, such as the parameters of a law."""

_CONDITIONS = {ca.OP_LT, ca.OP_LE, ca.OP_EQ, ca.OP_NE, ca.OP_NOT, ca.OP_AND, ca.OP_OR}


class FormulaBuilder:
    """A formula under construction: it creates symbols of inputs, parameters and states, and collects the results.

    Example:
        >>> draft = FormulaBuilder()
        >>> slip = draft.input("slip[1]", "1", "slip")
        >>> full = draft.parameter("full", "Pa", "full pressure")
        >>> draft.output("demand[1]", "Pa", "demanded pressure", choose(slip > 0.15, 0.0, full))
        >>> formula = draft.formula("Release", "Releases the brake above 15 % slip")
    """

    def __init__(self) -> None:
        kinds = ("state", "input", "parameter", "output")
        self._variables: dict[str, list[Variable]] = {kind: [] for kind in kinds}
        self._expressions: dict[str, list[Expression]] = {kind: [] for kind in kinds}
        self._following: dict[str, Expression] = {}

    @classmethod
    def reopen(cls, formula: SampledSystem) -> tuple["FormulaBuilder", list[Expression]]:
        """Return a draft with the states, inputs and parameters of a formula, and the values of its outputs."""
        draft = cls()
        kinds = {"state": formula.states, "input": formula.inputs, "parameter": formula.parameters}
        vectors = [ca.vertcat(*(draft._symbol(kind, each) for each in of_kind)) for kind, of_kind in kinds.items()]
        following, outputs = formula.step(*map(ca.SX, vectors))
        for state, value in zip(draft._expressions["state"], ca.vertsplit(following), strict=True):
            draft.keep(state, value)
        return draft, ca.vertsplit(outputs)

    def symbols(self, kind: Literal["state", "input", "parameter"]) -> dict[str, Expression]:
        """Return the symbols of a kind by name."""
        return {symbol.name(): symbol for symbol in self._expressions[kind]}

    def input(self, name: str, unit: str, description: str) -> Expression:
        """Return the symbol of a new input."""
        return self._symbol("input", Variable(name=name, unit=unit, description=description))

    def vector(self, signals: Iterable[Signal], groups: int) -> list[list[Expression]]:
        """Return the symbols of new inputs: for each signal a list, with one symbol for the train or one per group."""
        formation = Formation((1,) * groups)
        return [
            [self.input(name, signal.unit, signal.meaning) for name in names_of(signal, formation)]
            for signal in signals
        ]

    def parameter(self, name: str, unit: str, description: str, maximum: float | None = None) -> Expression:
        """Return the symbol of a new parameter, which is not negative."""
        variable = Variable(name=name, unit=unit, description=description, minimum=0.0, maximum=maximum)
        return self._symbol("parameter", variable)

    def state(self, name: str, unit: str, description: str, start: float = 0.0) -> Expression:
        """Return the symbol of a new state, its value before the call; `keep` sets the value after it."""
        return self._symbol("state", Variable(name=name, unit=unit, description=description, start=start))

    @cached_property
    def started(self) -> Expression:
        """Symbol of a state that is 1 once there is a sample before this one, and 0 in the first call."""
        started = self.state("started", "1", "1 once there is a sample before this one")
        self.keep(started, 1.0)
        return started

    def show(self, name: str, unit: str, description: str, value: Expression) -> None:
        """Add a value that traces record, as a state that the formula itself does not use."""
        variable = Variable(name=name, unit=unit, description=description, visible=True)
        self.keep(self._symbol("state", variable), value)

    def keep(self, state: Expression, value: Expression) -> None:
        """Set the value of a state after the call."""
        self._following[state.name()] = _require_scalar(f"the next value of {state.name()}", value)

    def output(
        self, name: str, unit: str, description: str, value: Expression, within: tuple[float, float] | None = None
    ) -> None:
        """Add an output with its value; `within` declares its limits, but does not apply them."""
        low, high = within or (None, None)
        self._add(
            "output",
            Variable(name=name, unit=unit, description=description, minimum=low, maximum=high),
            _require_scalar(name, value),
        )

    def formula(self, name: str, description: str) -> SampledSystem:
        """Return the complete formula.

        Raises:
            ValueError: `keep` was not called for a state.
        """
        variables, expressions = self._variables, self._expressions
        arguments = [ca.vertcat(*expressions[kind]) for kind in ("state", "input", "parameter")]
        if forgotten := [each.name for each in variables["state"] if each.name not in self._following]:
            raise ValueError(f"`keep` gives no next value of {', '.join(forgotten)}")
        following = [self._following[variable.name] for variable in variables["state"]]
        results = [ca.densify(ca.vertcat(*each)) for each in (following, expressions["output"])]
        return SampledSystem(
            name=name,
            description=description,
            states=tuple(variables["state"]),
            inputs=tuple(variables["input"]),
            parameters=tuple(variables["parameter"]),
            outputs=tuple(variables["output"]),
            step=ca.Function("step", [ca.SX(each) for each in arguments], results, {"cse": True}),
        )

    def _symbol(self, kind: str, variable: Variable) -> Expression:
        return self._add(kind, variable, ca.SX.sym(variable.name))

    def _add(self, kind: str, variable: Variable, expression: Expression) -> Expression:
        if any(variable.name == other.name for other in self._variables[kind]):
            raise ValueError(
                f"the {kind} '{variable.name}' is declared twice; `group.label` makes a name for each group"
            )
        self._variables[kind].append(variable)
        self._expressions[kind].append(expression)
        return expression


def _require_scalar(name: str, value: Expression) -> Expression:
    with suppress(NotImplementedError):
        if ca.SX(value).is_scalar():
            return value
    raise TypeError(f"{name} is {short(value)}, but one number or scalar expression is expected")


def require_value(name: str, value: Expression) -> None:
    """Require that an expression is a value and not a condition, whose values are 0 and 1.

    Raises:
        TypeError: It is a condition.
    """
    is_condition = isinstance(value, bool) or (
        isinstance(value, ca.SX) and value.is_scalar() and value.op() in _CONDITIONS
    )
    if is_condition:
        raise TypeError(f"{name} is the condition {short(value)}; `choose` selects a value by it")


def choose(condition: Expression, this: Expression, otherwise: Expression) -> Expression:
    """Return `this` if the condition holds, else `otherwise`; the value that is not chosen may be infinite or NaN."""
    return ca.if_else(condition, this, otherwise)


def every(*conditions: Expression) -> Expression:
    """Return whether all conditions hold."""
    return reduce(ca.logic_and, conditions)


def either(*conditions: Expression) -> Expression:
    """Return whether at least one condition holds."""
    return reduce(ca.logic_or, conditions)


def within(value: Expression, low: Expression, high: Expression) -> Expression:
    """Return a value limited to its bounds; `low` for NaN."""
    return choose(value > low, choose(value < high, value, high), low)


def time_release(
    time: Expression, is_released: Expression, *, period: Expression, longest: Expression, applied: Expression
) -> Expression:
    """Return the next value of a timer [s] of a release, and of the braking that follows one that lasted too long.

    The brake is to be applied while the timer is at `longest` or above. It restarts at zero after `applied` [s], or
    when a shorter release ends.
    """
    longer = time + period
    return choose(time >= longest, choose(time >= longest + applied, 0.0, longer), choose(is_released, longer, 0.0))


def low_pass(
    draft: FormulaBuilder, tuning: Symbols, name: str, sample: Expression, unit: str = "1"
) -> tuple[Expression, Expression]:
    """Return a sample after a first-order low-pass, kept as the state `name`, and its rate per second.

    The filter has the parameters `period` and `filter_time`.
    """
    started, before = draft.started, draft.state(name, unit, "filtered value")
    step = tuning["period"] / (tuning["filter_time"] + tuning["period"]) * (sample - before)
    # Without this the first sample would look like a jump from zero.
    value = choose(started, before + step, sample)
    draft.keep(before, value)
    return value, choose(started, step / tuning["period"], 0.0)


class Sampled:
    """A formula with its parameters, which keeps the states from call to call.

    Attributes:
        formula: The formula.
        parameters: Shape (number of parameters,); may be written between calls.
        state: Shape (number of states,).
        inputs: Inputs of the next call, shape (number of inputs,).
    """

    def __init__(self, formula: SampledSystem, parameters: Mapping[str, float]) -> None:
        """Start at the start values of the states; `parameters` has the value of every parameter by name."""
        self.formula = formula
        self.parameters = np.array([parameters[variable.name] for variable in formula.parameters])
        self.state = np.array([variable.start for variable in formula.states])
        self.inputs, self._result = np.zeros(len(formula.inputs)), np.zeros(len(formula.outputs))
        self._following = np.zeros(self.state.size)
        # The buffers of arguments and results are fixed: a call with CasADi's conversions would take ten times as long.
        buffer, self._evaluate = formula.step.buffer()
        self._buffer: Any = buffer
        for place, values in enumerate((self.state, self.inputs, self.parameters)):
            if values.size:
                self._buffer.set_arg(place, values.data)
        for place, values in enumerate((self._following, self._result)):
            if values.size:
                self._buffer.set_res(place, values.data)

    @property
    def visible(self) -> tuple[tuple[int, Variable], ...]:
        """Index in `state` and variable of each visible state; elements of an array are adjacent, as in a trace."""
        visible = [(i, variable) for i, variable in enumerate(self.formula.states) if variable.visible]
        names = [ElementName.of(variable.name).array for _, variable in visible]
        return tuple(sorted(visible, key=lambda state: names.index(ElementName.of(state[1].name).array)))

    def visible_state(self, name: str) -> NDArray[np.float64] | None:
        """Return the element of `state` of a visible state, shape (1,), sharing its memory; None without it."""
        place = next((i for i, variable in self.visible if variable.name == name), None)
        return None if place is None else self.state[place : place + 1]

    @property
    def step(self) -> ca.Function:
        """Function (state, input, parameter) → (state, output) of the formula."""
        return self.formula.step

    def call(self, inputs: Sequence[float]) -> tuple[float, ...]:
        """Return the outputs for inputs in the order of the formula, and keep the states for the next call."""
        self.inputs[:] = inputs
        return self.evaluate()

    def evaluate(self) -> tuple[float, ...]:
        """Return the outputs for the values in `inputs`, and keep the states for the next call."""
        self._evaluate()
        self.state[:] = self._following
        return tuple(self._result.tolist())
