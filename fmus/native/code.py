"""The C file of an FMU: sizes, tables and model functions, followed by the static FMI side in `runtime/`."""

from collections.abc import Iterable, Mapping, Sequence
from itertools import accumulate
from pathlib import Path

import casadi as ca

from railgrip.fmus.native.arrays import SX
from railgrip.fmus.native.c_source import (
    FACTOR,
    SOLVE,
    eliminate,
    fits,
    interpreter,
    string_literal,
    strings,
    table,
    tape,
)
from railgrip.fmus.native.loops import with_loops
from railgrip.fmus.native.structure import Loops
from railgrip.fmus.native.system import WHEN, Assertion, System, column
from railgrip.fmus.native.variables import Scalar, vector

RUNTIME = Path(__file__).parent / "runtime"
SHARED = ("layout.h", "instance.c", "evaluate.c", "events.c", "fmi2.c")
PARTS = {"me": ("modelexchange.c",), "cs": ("rosenbrock.c", "advance.c", "cosimulation.c", "status.c")}
"""Further files of each interface besides `SHARED`."""

RARE = frozenset({
    "f_locals", "f_parameters", "f_start", "f_start_loop", "f_directional", "f_assertion_values", "f_parameter_checks",
    "f_start_checks",
})  # fmt: skip
"""Functions that no step calls. An estimator requests directional derivatives along the states of a Model Exchange FMU
at every sample, but these use f_state_jacobian and f_output_jacobian; only others use f_directional."""

_OF_ONE_INTERFACE = {"f_jacobian": "cs", "f_state_jacobian": "me", "f_output_jacobian": "me"}
"""Functions that only one interface calls."""

ELIMINATION = "elimination.c"
"""The elimination of a long train, a translation unit of its own, which is compiled at the same time as the others."""

LARGEST_INCLUDED = 3000
"""Entries of LU up to which the elimination is a part of `model.c`; below, another compiler takes longer to start."""

_RETURNING = frozenset((ca.OP_FLOOR, ca.OP_CEIL, ca.OP_SIN, ca.OP_COS))
"""Operations of functions that may take a value again and again: floor, mod, sin, ..."""

LEVELS = ("warning", "error", "domain")
"""Levels of assertions, numbered as in `runtime/layout.h`."""

SOLVERS = {"rodas3": 3, "rodas4": 4}


def groups_of(system: System) -> dict[str, list[Scalar]]:
    """Return the variables of an FMU by group, in the order of their value references.

    Among the parameters those that may be set come first; outputs are the algebraic variables declared so.
    """
    return {
        "states": system.states,
        "derivatives": system.states,
        "inputs": system.variables.inputs,
        "parameters": [*system.variables.free, *system.variables.dependent],
        "outputs": [s for s in system.algebraics if s.causality == "output"],
        "locals": [s for s in system.algebraics if s.causality != "output"],
        "discretes": system.variables.discretes,
    }


def first_references(groups: Mapping[str, Sequence[Scalar]]) -> dict[str, int]:
    """Return the value reference of the first variable of each group, and of the settings and counters at the end.

    A value reference is an index in one array of doubles.
    """
    return dict(zip([*groups, "settings"], accumulate(map(len, groups.values()), initial=1), strict=True))


def split_algebraics(system: System) -> tuple[SX, SX]:
    """Return the expressions of the outputs and of the other algebraic variables."""
    values = ca.vertsplit(system.algebraic) if system.algebraics else []
    outputs, others = list[SX](), list[SX]()
    for s, value in zip(system.algebraics, values, strict=True):
        (outputs if s.causality == "output" else others).append(value)
    return column(outputs), column(others)


def functions(system: System, interfaces: Sequence[str]) -> list[ca.Function]:
    """Return the functions that the runtime calls, as listed in `runtime/layout.h`."""
    v = system.variables
    here = [system.time, system.x, system.u, system.p, system.d, system.relation, system.guesses]
    at_start = [system.time, system.x, system.u, system.p, system.d, system.relation, system.start_guesses,
                system.previous]  # fmt: skip
    outputs, locals_ = split_algebraics(system)
    free, dependent = vector(v.free), column(v.dependent_values)
    along_x, along_u, along_p = (SX.sym(n, s.shape) for n, s in (("dx", system.x), ("du", system.u), ("dp", free)))
    along_dependent = ca.jtimes(dependent, free, along_p) if v.dependent and v.free else SX.zeros(dependent.shape)
    both = column([system.derivative, outputs])
    knowns, seed = ca.vertcat(system.x, system.u, system.p), ca.vertcat(along_x, along_u, along_p, along_dependent)
    direction = ca.densify(ca.jtimes(both, knowns, seed)) if both.numel() and knowns.numel() else SX.zeros(both.shape)
    nx = len(system.states)
    by_states = ca.jacobian(outputs, system.x)
    loops, start, discretes = system.loops, system.start_loops, system.start_discretes
    checks = {when: _checks(system.checks(when)) for when in WHEN}
    event = [system.time, system.x, system.u, system.p, system.previous, system.relation,
             system.last_conditions, system.ticks, system.guesses]  # fmt: skip
    ft = ca.densify(ca.jacobian(system.derivative, system.time)) if nx else SX(0, 1)
    slope = [system.derivative, ca.jacobian(system.derivative, system.x), ft]
    definitions: list[tuple[str, list[SX], list[SX]]] = [
        ("f_ode", here, [system.derivative]),
        ("f_jacobian", here, [*slope, system.indicators]),
        ("f_state_jacobian", here, slope[:2]),
        ("f_output_jacobian", here, [outputs, system.indicators, by_states]),
        ("f_outputs", here, [outputs, system.indicators]),
        ("f_locals", here, [locals_]),
        ("f_loop", here, _newton(loops)),
        ("f_assertions", here, checks["running"][:1]),
        ("f_assertion_values", here, checks["running"][1:]),
        ("f_parameter_checks", [system.p], checks["parameters"]),
        ("f_start_checks", [*here, system.previous], checks["start"]),
        ("f_event_checks", event, checks["event"]),
        ("f_directional", [*here, along_x, along_u, along_p], [direction[:nx], direction[nx:]]),
        (
            "f_event",
            event,
            [system.event_discretes, system.event_states, system.event_relations, system.event_conditions],
        ),
        ("f_parameters", [free], [dependent, _substitute_dependent(system.instants, v.dependent, dependent)]),
        ("f_instants", [system.time, system.p, system.d, system.relation], [system.moving_instants]),
        ("f_start", at_start, [system.start, *([column([*discretes.values()])] if discretes else [])]),
        ("f_start_loop", at_start, _newton(start)),
    ]  # fmt: skip
    omitted = {name for name, interface in _OF_ONE_INTERFACE.items() if interface not in interfaces}
    omitted |= set() if system.moving_instants.numel() else {"f_instants"}
    return [
        ca.Function(name, arguments, results, {"cse": True})
        for name, arguments, results in definitions
        if name not in omitted
    ]


def repeating_discretes(system: System) -> list[int]:
    """Return the places of the discretes whose change at an event requires another pass over the event equations.

    The others keep their value while no clock ticks, and only their own equations read them then: a second pass, in
    which no clock ticks, would repeat the first. This holds only if nothing else is clocked and without loops, which
    another Newton step would change.
    """
    every, before = list(range(system.d.numel())), system.previous
    if not system.clocks or system.loops.guesses:
        return every
    results = column([system.event_discretes, system.event_states, system.event_relations, system.event_conditions])
    still = ca.substitute(results, system.ticks, SX.zeros(system.ticks.shape))
    holds = {i for i in every if still[i].element_hash() == before[i].element_hash()}
    if set(ca.jacobian_sparsity(results, system.ticks[:-1]).row()) - holds:
        return every
    rows, columns = ca.jacobian_sparsity(still, before).get_triplet()
    readers = {j for i, j in zip(rows, columns, strict=True) if i != j}
    return [i for i in every if i not in holds or i in readers]


def _may_return(indicators: SX, derivative: SX, time: SX) -> bool:
    # Whether an indicator may become zero twice in a step that is accurate. The error of a step is that of the states:
    # what their derivatives contain as well is resolved.
    if ca.depends_on(indicators, time):
        return True
    if not _count_returning(indicators):  # this is most often so, and of all three expressions takes least time
        return False
    return _count_returning(ca.vertcat(indicators, derivative)) > _count_returning(derivative)


def _count_returning(expressions: SX) -> int:
    if not expressions.numel():
        return 0
    symbols = ca.symvar(expressions)
    program = ca.Function("program", [ca.vertcat(*symbols)] if symbols else [], [expressions], {"cse": True})
    return sum(program.instruction_id(k) in _RETURNING for k in range(program.n_instructions()))


def _checks(assertions: Sequence[Assertion]) -> list[SX]:
    texts = [piece for a in assertions for piece in a.message if isinstance(piece, SX)]
    return [column([a.holds for a in assertions]), column(texts)]


def _newton(loops: Loops) -> list[SX]:
    return [column([table[name] for name in loops.guesses]) for table in (loops.updates, loops.residuals)]


def _substitute_dependent(expressions: SX, dependent: Sequence[Scalar], values: SX) -> SX:
    return ca.substitute(expressions, vector(dependent), values) if dependent and expressions.numel() else expressions


def c_sources(system: System, *, interfaces: Sequence[str], solver: str, tolerance: float) -> dict[str, str]:
    """Return the C files of an FMU, its GUID empty.

    `model.c` includes the others except `ELIMINATION`, which is there if it takes long to compile.

    Args:
        system: The system.
        interfaces: "me", "cs" or both.
        solver: "rodas3" or "rodas4", the default of the parameter `_solver`.
        tolerance: Relative error of an internal step, the default of the parameter `_tolerance`.
    """
    groups = groups_of(system)
    every = {f.name(): f for f in functions(system, interfaces)}
    jacobians = {"jacobian": ("f_jacobian", 1), "state": ("f_state_jacobian", 1), "output": ("f_output_jacobian", 2)}
    patterns = {
        name: every[function].sparsity_out(result).get_triplet() if function in every else ([], [])
        for name, (function, result) in jacobians.items()
    }
    elimination = None
    if "cs" in interfaces:
        elimination = eliminate(len(groups["states"]), list(zip(*patterns["jacobian"], strict=True)))
    is_apart = elimination is not None and elimination.entries > LARGEST_INCLUDED
    parts = [*SHARED, *(part for i in PARTS if i in interfaces for part in PARTS[i])]
    repeating = repeating_discretes(system)
    sizes = _sizes(system, groups) | {
        "NJ": len(patterns["jacobian"][0]),
        "BY_STATE": int("me" in interfaces),
        "NSJ": len(patterns["state"][0]),
        "NOJ": len(patterns["output"][0]),
        "N_REPEATING": len(repeating),
        "ND_CALCULATED": len(system.start_discretes),
        "NLU": elimination.entries if elimination else 0,
        "DISCRETE_INPUTS": int(any(s.type != "real" for s in groups["inputs"])),
        "DEFAULT_SOLVER": SOLVERS[solver],
        "DEFAULT_TOLERANCE": repr(float(tolerance)),
        "MODEL_GUID": string_literal(""),
    }
    body = [
        "/* Generated from Modelica; do not edit. */",
        *(f"#define {name} {value}" for name, value in sizes.items()),
        *_value_tables(system, groups),
        table("int", "repeating", repeating),
        table("int", "d_calculated", [*system.start_discretes]),
        table("int", "indicator_relation", system.indicator_relation),
        table("char", "indicator_inclusive", [int(system.relation_inclusive[k]) for k in system.indicator_relation]),
        *(
            table("int", f"{name}_{axis}", places)
            for name, pattern in patterns.items()
            for axis, places in zip(("row", "column"), pattern, strict=True)
        ),
        *_text_tables(system, groups),
        _model_functions(system, every.values()),
        '#include "layout.h"',
        # Their linkage is that of the declarations: FMUs may be linked into one program.
        *(f"{'' if is_apart else 'static '}{head};" for head in (FACTOR, SOLVE) if elimination),
        *([elimination.code] if elimination and not is_apart else []),
        *(f'#include "{part}"' for part in parts[1:]),
        "",
    ]
    included = {part: (RUNTIME / part).read_text(encoding="utf-8") for part in ["tape.c", *parts]}
    apart = {ELIMINATION: f"#include <math.h>\n{elimination.code}\n"} if elimination and is_apart else {}
    return {"model.c": "\n".join(body)} | apart | included


def _sizes(system: System, groups: Mapping[str, list[Scalar]]) -> dict[str, int]:
    return {
        "NX": len(groups["states"]),
        "NU": len(groups["inputs"]),
        "NP": len(groups["parameters"]),
        "NF": len(system.variables.free),
        "NO": len(groups["outputs"]),
        "NL": len(groups["locals"]),
        "ND": len(groups["discretes"]),
        "NR": system.relation.numel(),
        "NZ": system.indicators.numel(),
        "NC": system.last_conditions.numel(),
        "NT": len(system.clocks),
        "NI": system.instants.numel(),
        "SEARCHED": int(_may_return(system.indicators, system.derivative, system.time)),
        "N_MOVING": system.moving_instants.numel(),
        "NG": len(system.loops.guesses),
        "NQ": len(system.start_loops.guesses),
        "NA": len(system.assertions),
        **{f"NA_{when.upper()}": len(system.checks(when)) for when in WHEN},
        "NM": sum(isinstance(piece, SX) for a in system.assertions for piece in a.message),
    }


def _value_tables(system: System, groups: Mapping[str, list[Scalar]]) -> list[str]:
    by_name = {s.name: s for of_variable in system.variables.of_id.values() for s in of_variable}
    guesses, start_guesses = ([by_name.get(k) for k in q.guesses] for q in (system.loops, system.start_loops))
    scalars = dict[str, Sequence[Scalar | None]](x=groups["states"], u=groups["inputs"], p=groups["parameters"])
    scalars.update(d=groups["discretes"], g=guesses, q=start_guesses)
    return [
        *(table("double", f"start_{name}", [s.start if s else 0.0 for s in of]) for name, of in scalars.items()),
        *(table("double", f"nominal_{k}", [nominal(s) if s else 1.0 for s in scalars[k]]) for k in "xgq"),
        table("char", "x_calculated", [int(c) for c in system.calculated]),
        table("double", "clock_phase", [phase for phase, _ in system.clocks]),
        table("double", "clock_period", [period for _, period in system.clocks]),
    ]


def _text_tables(system: System, groups: Mapping[str, list[Scalar]]) -> list[str]:
    assertions = system.assertions
    return [
        table("char", "assertion_level", [LEVELS.index(a.level) for a in assertions]),
        table("int", "first_assertion", [0, *accumulate(len(system.checks(when)) for when in WHEN)]),
        strings("x_name", [s.name for s in groups["states"]]),
        strings("d_name", [s.name for s in groups["discretes"]]),
        strings("assertion_place", [a.where for a in assertions]),
        strings("message_piece", [None if isinstance(piece, SX) else piece for a in assertions for piece in a.message]),
        table("int", "message_begin", [0, *accumulate(len(a.message) for a in assertions)]),
        strings("loop_names", [", ".join(loops.guesses) for loops in (system.loops, system.start_loops)]),
    ]


def nominal(s: Scalar) -> float:
    """Return the nominal value of a variable, 1 if the model does not declare it."""
    return abs(s.bounds.get("nominal") or 1.0)


def _model_functions(system: System, every: Iterable[ca.Function]) -> str:
    # Rare functions are interpreted, which compiles faster. With clocks f_event is not rare: each tick calls it.
    rare = RARE if system.clocks else RARE | {"f_event", "f_event_checks"}
    texts = [tape(f) if f.name() in rare and fits(f) else with_loops(f) for f in every]
    return "\n".join(["#include <math.h>", *interpreter(), *texts])
