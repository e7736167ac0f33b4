"""Variables at the interface of a model, and sampled functions with states."""

from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True, slots=True, kw_only=True)
class Variable:
    """A scalar variable at the interface of a model, a law or an FMU.

    Attributes:
        name: Name as in Modelica and FMI; `slip[2]` is an element of an array.
        unit: Unit in Modelica's syntax, "1" for ratios; empty if none is declared.
        description: One line.
        start: Start or default value.
        minimum, maximum: Limits of its validity; None without a limit.
        nominal: Nominal value, 1.0 if none is declared.
        visible: For a state of a law, whether traces record it because it explains the outputs.
    """

    name: str
    unit: str
    description: str
    start: float = 0.0
    minimum: float | None = None
    maximum: float | None = None
    nominal: float = 1.0
    visible: bool = False


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SampledSystem:
    """A function with states that is called once in each period.

    Attributes:
        name: Name of the law or estimator; the C identifier of an FMU is derived from it.
        description: One line.
        states, inputs, parameters, outputs: In the order of the vectors of `step`; in an FMU, outputs have their start
            values until the first call, and parameters are set before it.
        step: casadi.Function (state, input, parameter) → (state, output) with dense columns, whose last argument may be
            omitted without parameters; or a `railgrip.fmus.native.discrete.WrittenStep`.
        period: Time between calls [s]; 0 if the caller chooses it.
    """

    name: str
    description: str
    states: tuple[Variable, ...] = ()
    inputs: tuple[Variable, ...] = ()
    parameters: tuple[Variable, ...] = ()
    outputs: tuple[Variable, ...]
    step: Any
    period: float = 0.0
