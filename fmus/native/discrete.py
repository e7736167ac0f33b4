"""A CasADi function (state, input) → (state, output), or a step in C, as a discrete-time co-simulation FMU.

It exports an estimator or controller written in CasADi to other tools, with the same C code generator, packager and
compiler as for Modelica classes, and a small runtime (`runtime/discrete.c`). A communication step of one period calls
the function once: outputs at its end follow from the inputs set at its beginning.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from math import isnan

import casadi as ca

from railgrip.base.errors import InputError
from railgrip.base.system import SampledSystem
from railgrip.fmus.native.c_source import straight, string_literal, table
from railgrip.fmus.native.code import RUNTIME
from railgrip.fmus.native.description import Writer, document
from railgrip.fmus.native.package import Source, c_identifier

PARTS = ("discrete.c", "instance.c", "status.c")


@dataclass(frozen=True, slots=True, kw_only=True)
class WrittenStep:
    """A step in C, with its own memory.

    Attributes:
        text: C code that defines MEMORY, `lay` and `sample`; see `runtime/discrete.c`.
        files: Files that it includes, file name → text.
        units: Names of the files that are compiled separately.
    """

    text: str
    files: Mapping[str, str]
    units: tuple[str, ...] = ()


def sources(system: SampledSystem, waits: int = 0, hidden: frozenset[str] = frozenset()) -> Source:
    """Return C code and modelDescription.xml of a system, ready for `package.pack`.

    Args:
        system: A system with a period; its step is a casadi.Function or a `WrittenStep`.
        waits: Number of leading inputs of which one must be nonzero for the first period to begin; 0 begins at once.
        hidden: Names of parameters that are not listed in modelDescription.xml, in addition to those without a value.

    Raises:
        InputError: The period is not positive, names are not unique, or the step has other sizes.
    """
    _check(system)
    # The data of a vehicle that the scenario does not give; the step does not depend on them.
    hidden |= {variable.name for variable in system.parameters if isnan(variable.start)}
    identifier = c_identifier(system.name)
    files = {"model.c": _code(system, waits)}
    files |= {part: (RUNTIME / part).read_text(encoding="utf-8") for part in PARTS}
    units: tuple[str, ...] = ("model.c",)
    if isinstance(system.step, WrittenStep):
        files |= system.step.files
        units += system.step.units
    return Source.of(identifier, files, _xml(system, hidden, identifier, units), units)


def _check(system: SampledSystem) -> None:
    if not system.period > 0:
        raise InputError(f"{system.name}: the period must be a positive time, got {system.period} s.")
    names = [v.name for v in (*system.states, *system.inputs, *system.parameters, *system.outputs)]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise InputError(f"{system.name}: more than one variable is named {', '.join(twice)}.")
    step = system.step
    if isinstance(step, WrittenStep):
        return
    arguments = [step.numel_in(i) for i in range(step.n_in())]
    results = [step.numel_out(i) for i in range(step.n_out())]
    sizes = [len(system.states), len(system.inputs), len(system.parameters)]
    result_sizes = [len(system.states), len(system.outputs)]
    # The last arguments may be omitted if they are empty.
    if arguments + [0] * (3 - len(arguments)) != sizes or results != result_sizes:
        raise InputError(
            f"{system.name}: a step function takes (state, input, parameter) of {sizes} numbers and gives "
            f"(state, output) of {result_sizes}; this one takes {arguments} and gives {results}."
        )


def straight_step(name: str, step: ca.Function, sizes: Sequence[int]) -> str:
    """Return C code of a step (state, input, parameter) → (state, output), whose last arguments may be omitted.

    Args:
        name: Name of the C function.
        step: The step.
        sizes: Numbers of states, inputs and parameters.
    """
    # Expanded to scalar operations, and with all three inputs, so that no argument is a null pointer.
    every = [ca.SX.sym(argument, size) for argument, size in zip("xup", sizes, strict=True)]
    arguments = every[: step.n_in()]
    following, output = step.expand().call(arguments) if arguments else ([], [])
    return straight(ca.Function(name, every, [ca.densify(following), ca.densify(output)], {"cse": True}))


def _code(system: SampledSystem, waits: int) -> str:
    groups = {"x": system.states, "u": system.inputs, "p": system.parameters, "y": system.outputs}
    sizes = {f"N{name.upper()}": len(group) for name, group in groups.items()}
    if isinstance(system.step, WrittenStep):
        step = system.step.text
    else:
        step = straight_step("f_step", system.step, [*sizes.values()][:3])
    numbers = sizes | {
        "PERIOD": repr(float(system.period)), "WAITS": waits, "MODEL_GUID": string_literal("")
    }  # fmt: skip
    return "\n".join(
        [
            "/* Generated; do not edit. */",
            *(f"#define {name} {value}" for name, value in numbers.items()),
            "#include <math.h>",
            *(table("double", f"start_{name}", [v.start for v in group]) for name, group in groups.items()),
            "#include <string.h>",
            step,
            '#include "discrete.c"',
            "",
        ]
    )


def _xml(system: SampledSystem, hidden: frozenset[str], identifier: str, units: Sequence[str]) -> str:
    w = Writer()
    place = 0
    for group, causality, variability, initial in (
        (system.states, "local", "discrete", "exact"),
        (system.inputs, "input", "discrete", None),
        (system.parameters, "parameter", "fixed", "exact"),
        (system.outputs, "output", "discrete", "exact"),
    ):
        for v in group:
            place += 1
            if v.name in hidden:
                continue
            bounds = {"min": v.minimum, "max": v.maximum}
            attributes = {"unit": v.unit} if v.unit else {}
            attributes |= {key: repr(float(value)) for key, value in bounds.items() if value is not None}
            w.add(
                v.name, place, causality=causality, variability=variability, initial=initial, start=v.start,
                description=v.description, attributes=attributes,
            )  # fmt: skip
    every = (*system.states, *system.inputs, *system.parameters, *system.outputs)
    first = len(every) - len(system.outputs) + 1
    return document(
        {
            "fmiVersion": "2.0",
            "modelName": system.name,
            "guid": "",
            "description": system.description,
            "generationTool": f"railgrip (CasADi {version('casadi')})",
            "variableNamingConvention": "structured",
        },
        {
            "CoSimulation": {
                "modelIdentifier": identifier,
                "canHandleVariableCommunicationStepSize": "true",
                "canNotUseMemoryManagementFunctions": "true",
                "canGetAndSetFMUstate": "true",
                "canSerializeFMUstate": "true",
            }
        },
        units={"1", "s"} | {v.unit for v in every if v.unit},
        categories={"logStatusError": "Why a call failed"},
        experiment={"stepSize": repr(float(system.period))},
        rows=w.rows,
        structure={"Outputs": [f'      <Unknown index="{w.index[first + k]}"/>' for k in range(len(system.outputs))]},
        files=units,
    )
