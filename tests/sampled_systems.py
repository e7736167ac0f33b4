"""Step functions in CasADi with their variables, for tests of FMUs in discrete time."""

from collections.abc import Iterable

import casadi as ca

from railgrip.base.system import SampledSystem, Variable


def sampled(step: ca.Function, period: float, **tables: Iterable[tuple[str, str, float]]) -> SampledSystem:
    """Return a system whose states, inputs, parameters and outputs are rows of name, unit and start value."""
    variables = {"outputs": ()} | {
        kind: tuple(Variable(name=n, unit=unit, start=start, description=f"About {n}") for n, unit, start in rows)
        for kind, rows in tables.items()
    }
    return SampledSystem(name="Law", description="For tests", period=period, step=step, **variables)
