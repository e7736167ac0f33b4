"""Parts of a stop whose inputs and outputs are in the units and signs of a foreign plant."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import casadi as ca

from railgrip.base.system import SampledSystem, Variable
from railgrip.fmus.native.discrete import WrittenStep

Conversion = Callable[[SampledSystem], SampledSystem]
"""Function that returns a system with other units at its interface."""
_HEAD = "static int sample("


def in_other_units(system: SampledSystem, inputs: Mapping[str, float], outputs: Mapping[str, float]) -> SampledSystem:
    """Return a system that converts some of its inputs and outputs by a factor.

    Converted variables have no unit, so that no other tool converts them again.

    Args:
        system: System in SI.
        inputs: Name of an input → its value in the system per value given.
        outputs: Name of an output → value to show per value in the system.
    """
    into = [inputs.get(variable.name, 1.0) for variable in system.inputs]
    out = [outputs.get(variable.name, 1.0) for variable in system.outputs]
    if all(factor == 1.0 for factor in (*into, *out)):
        return system
    return replace(
        system,
        inputs=_variables(system.inputs, [1.0 / factor for factor in into]),
        outputs=_variables(system.outputs, out),
        step=_written(system.step, into, out)
        if isinstance(system.step, WrittenStep)
        else _formula(system.step, into, out),
    )


def _variables(variables: Sequence[Variable], factors: Sequence[float]) -> tuple[Variable, ...]:
    return tuple(
        variable
        if factor == 1.0
        else replace(
            variable,
            unit="",
            start=factor * variable.start,
            description=f"{variable.description}; in the unit and with the sign of the plant",
        )
        for variable, factor in zip(variables, factors, strict=True)
    )


def _formula(step: ca.Function, into: Sequence[float], out: Sequence[float]) -> ca.Function:
    arguments = [step.sx_in(place) for place in range(step.n_in())]
    following, output = step(*[arguments[0], arguments[1] * ca.DM(into), *arguments[2:]])
    return ca.Function("step", arguments, [following, output * ca.DM(out)])


def _written(step: WrittenStep, into: Sequence[float], out: Sequence[float]) -> WrittenStep:
    text = [
        step.text.replace(_HEAD, "static int sample_in_si("),
        f"static const double factor_of_input[] = {{ {', '.join(map(repr, (*into, 0.0)))} }};",
        f"static const double factor_of_output[] = {{ {', '.join(map(repr, (*out, 0.0)))} }};",
        f"{_HEAD}unsigned long long *memory, long long k, const double *input, const double *parameter,",
        "                  double *output)",
        "{",
        f"    double converted[{len(into) + 1}];",
        f"    for (int i = 0; i < {len(into)}; i++)",
        "        converted[i] = input[i] * factor_of_input[i];",
        "    const int status = sample_in_si(memory, k, converted, parameter, output);",
        f"    for (int i = 0; i < {len(out)}; i++)",
        "        output[i] *= factor_of_output[i];",
        "    return status;",
        "}",
    ]
    return replace(step, text="\n".join(text))
