"""A system in explicit form as CasADi functions of time, states, inputs and the parameters that may be set."""

from collections.abc import Sequence

import casadi as ca

from railgrip.base.errors import TranslationError
from railgrip.base.system import Variable
from railgrip.fmus.native.arrays import SX
from railgrip.fmus.native.model import Model
from railgrip.fmus.native.system import System, column
from railgrip.fmus.native.variables import Scalar, vector


def model_of(system: System) -> Model:
    """Return a system as a plain differential equation.

    Raises:
        TranslationError: It has events, discrete variables or nonlinear loops.
    """
    unsupported = {
        "relations that cause events (write noEvent(...) or smooth(...))": system.relation.numel(),
        "discrete variables": system.d.numel(),
        "time events": system.instants.numel() + len(system.clocks),
        "nonlinear algebraic loops": len(system.loops.guesses) + len(system.start_loops.guesses),
    }
    parts = [f"{count} {what}" for what, count in unsupported.items() if count]
    if parts:
        raise TranslationError(f"{system.class_name} is not a plain differential equation: it has {', '.join(parts)}.")
    v = system.variables
    free = vector(v.free)
    arguments = [system.time, system.x, system.u, free]
    # In one column, because each substitution has a fixed cost.
    values = column([system.derivative, output_values(system), system.start])
    if v.dependent:
        values = ca.substitute(values, vector(v.dependent), column(v.dependent_values))
    nx, ny = len(system.states), len(output_scalars(system))
    names = ["t", "x", "u", "p"]
    return Model(
        class_name=system.class_name,
        states=_variables(system.states),
        inputs=_variables(v.inputs),
        parameters=_variables(v.free),
        outputs=_variables(output_scalars(system)),
        derivative=ca.Function("derivative", arguments, [values[:nx]], names, ["dx"]),
        output=ca.Function("output", arguments, [values[nx : nx + ny]], names, ["y"]),
        initial=ca.Function("initial", [free], [values[nx + ny :]], ["p"], ["x"]),
    )


def output_scalars(system: System) -> list[Scalar]:
    """Return the variables declared `output`, in declaration order."""
    every = [s for scalars in system.variables.of_id.values() for s in scalars]
    return [s for s in every if s.causality == "output"]


def output_values(system: System) -> SX:
    """Return the expressions of `output_scalars`."""
    expressions = {s.name: s.symbol for s in [*system.states, *system.variables.discretes]}
    expressions |= {s.name: system.algebraic[i] for i, s in enumerate(system.algebraics)}
    return column([expressions[s.name] for s in output_scalars(system)])


def _variables(scalars: Sequence[Scalar]) -> tuple[Variable, ...]:
    return tuple(
        Variable(
            name=s.name,
            unit=s.attributes.get("unit") or "",
            start=s.start,
            description=s.attributes.get("description") or "",
            minimum=s.bound("minimum"),
            maximum=s.bound("maximum"),
            nominal=s.bound("nominal") or 1.0,
        )
        for s in scalars
    )
