"""A sampled function with states: the form of every law here, as a CasADi graph.

It is written once and runs in Python, in C in the loop, and as an FMU in other tools, with the same results.
"""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from railgrip.base.system import SampledSystem, Variable
from railgrip.vehicle.formation import Formation
from railgrip.vehicle.signals import Signal, names_of

Vector = NDArray[np.float64]
Expression = Any
"""A scalar `casadi.SX`."""


class FormulaBuilder:
    """A formula under construction: symbols are created by name, and results are assigned to names.

    draft = FormulaBuilder()
    slip = draft.input("slip[1]", "1", "slip")
    ...
    draft.output("demand[1]", "Pa", "demanded pressure", choose(slip > high, 0.0, full))
    return draft.formula("SlipBased", "two-level control")
    """

    def __init__(self) -> None:
        self._symbols: dict[str, tuple[list[Variable], list[Expression]]] = {
            kind: ([], []) for kind in ("state", "input", "parameter")
        }
        self._following: dict[str, Expression] = {}
        self._outputs: tuple[list[Variable], list[Expression]] = ([], [])

    def input(self, name: str, unit: str, description: str) -> Expression:
        """Return the symbol of a new input."""
        return self._symbol("input", Variable(name=name, unit=unit, description=description))

    def vector(self, signals: Iterable[Signal], groups: int) -> list[list[Expression]]:
        """Return the symbols of new inputs, one for the train or for each group, for each signal."""
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
        """Return the symbol of a new state, which has its value before the call."""
        return self._symbol("state", Variable(name=name, unit=unit, description=description, start=start))

    def show(self, name: str, unit: str, description: str, value: Expression) -> None:
        """Add a value that traces record and the formula itself does not use."""
        symbol = Variable(name=name, unit=unit, description=description, visible=True)
        self.keep(self._symbol("state", symbol), value)

    def keep(self, state: Expression, value: Expression) -> None:
        """Set the value of a state after the call."""
        self._following[state.name()] = value

    def output(
        self, name: str, unit: str, description: str, value: Expression, within: tuple[float, float] | None = None
    ) -> None:
        """Add an output."""
        low, high = within or (None, None)
        self._outputs[0].append(Variable(name=name, unit=unit, description=description, minimum=low, maximum=high))
        self._outputs[1].append(value)

    def formula(self, name: str, description: str) -> SampledSystem:
        """Return the complete formula."""
        arguments = [ca.vertcat(*self._symbols[kind][1]) for kind in ("state", "input", "parameter")]
        following = [self._following[variable.name] for variable in self._symbols["state"][0]]
        results = [ca.densify(ca.vertcat(*each)) for each in (following, self._outputs[1])]
        return SampledSystem(
            name=name,
            description=description,
            states=tuple(self._symbols["state"][0]),
            inputs=tuple(self._symbols["input"][0]),
            parameters=tuple(self._symbols["parameter"][0]),
            outputs=tuple(self._outputs[0]),
            step=ca.Function("step", [ca.SX(each) for each in arguments], results, {"cse": True}),
        )

    def _symbol(self, kind: str, variable: Variable) -> Expression:
        symbol = ca.SX.sym(variable.name)
        variables, symbols = self._symbols[kind]
        variables.append(variable)
        symbols.append(symbol)
        return symbol


def choose(condition: Expression, this: Expression, otherwise: Expression) -> Expression:
    """Return `this` if the condition holds, else `otherwise`; the value that is not chosen may be infinite or NaN."""
    return ca.if_else(condition, this, otherwise)


def every(*conditions: Expression) -> Expression:
    """Return whether all conditions hold."""
    result = conditions[0]
    for condition in conditions[1:]:
        result = ca.logic_and(result, condition)
    return result


def within(value: Expression, low: Expression, high: Expression) -> Expression:
    """Return a value limited to its bounds; `low` for NaN."""
    return choose(value > low, choose(value < high, value, high), low)


def either(*conditions: Expression) -> Expression:
    """Return whether at least one condition holds."""
    result = conditions[0]
    for condition in conditions[1:]:
        result = ca.logic_or(result, condition)
    return result


class Sampled:
    """A formula with its parameters, which keeps the states from call to call.

    Attributes:
        formula: The formula.
        parameters: Shape (number of parameters,); may be written between calls.
        state: Shape (number of states,).
        inputs: Inputs of the next call, shape (number of inputs,).
    """

    def __init__(self, formula: SampledSystem, parameters: Mapping[str, float]) -> None:
        """Start at the start values of the states; `parameters` maps the name of every parameter to its value."""
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
        """Index in `state` and description of each visible state; elements of an array are adjacent."""
        visible = [(i, variable) for i, variable in enumerate(self.formula.states) if variable.visible]
        names = [variable.name.partition("[")[0] for _, variable in visible]
        return tuple(
            variable for _, variable in sorted(zip(names, visible, strict=True), key=lambda pair: names.index(pair[0]))
        )

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
