"""The checked DAE as explicit expressions: derivatives, algebraic variables, events, initial values."""

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

import casadi as ca
import numpy as np

from railgrip.base.errors import TranslationError
from railgrip.fmus.native.arrays import SX, Array, as_sx, choose, is_number
from railgrip.fmus.native.conditions import EventConditions, Relations, TimeEvents, find_relations, includes_initial
from railgrip.fmus.native.dae import Dae, Node
from railgrip.fmus.native.expressions import ExpressionBuilder
from railgrip.fmus.native.language import refuse
from railgrip.fmus.native.structure import RELUCTANCE, Equation, IndexOne, Loops, reduce_index, solve
from railgrip.fmus.native.variables import ModelVariables, Scalar, declare, settle, vector

Message = tuple[str | SX, ...]
"""Text of an assertion, with expressions for the values that it contains."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Assertion:
    """A condition that must hold while the model runs.

    Attributes:
        holds: Expression that is nonzero if the condition holds.
        level: "warning" or "error" for an assertion of the model, "domain" for an operation that must be defined.
        when: When it is checked: "running" at communication points, "parameters" after a parameter was set, "start"
            after initialisation, "event" when discrete variables are computed.
    """

    holds: SX
    message: Message
    level: str
    where: str
    when: str = "running"


@dataclass(slots=True, kw_only=True)
class System:
    """A class in explicit form. All expressions are functions of `time` and the symbols below.

    Attributes:
        variables: Scalar variables of the class.
        states: States, shape (nx,).
        algebraics: Algebraic variables.
        derivative: Derivatives of `states`.
        algebraic: Values of `algebraics`.
        start: Initial values of `states`.
        calculated: Whether each initial value depends on parameters or initial equations.
        start_discretes: Place of a discrete variable → its value before the start, if it depends on these.
        relation: Values of relations since the last event.
        relation_inclusive: Whether they hold where their indicator is zero.
        indicators: Expressions that are zero where a relation changes.
        indicator_relation: Place of the relation of each indicator.
        instants: Times of events, as expressions of parameters.
        moving_instants: Next times of further events, as expressions of time, parameters, discretes and relations.
        clocks: (phase, period) of sample clocks [s]; `ticks` has a symbol for each and one for initialisation.
        previous: Values of discretes before the event.
        event_discretes, event_states, event_relations, event_conditions: Values after one pass of the event iteration.
        last_conditions: Values of `event_conditions` in the previous pass.
        loops: Nonlinear loops of the running model.
        start_loops: Nonlinear loops of the initial equations.
        assertions: Assertions of the class.
    """

    class_name: str
    time: SX
    variables: ModelVariables
    states: list[Scalar]
    algebraics: list[Scalar]
    derivative: SX
    algebraic: SX
    start: SX
    calculated: list[bool]
    start_discretes: dict[int, SX]
    relation: SX
    relation_inclusive: list[bool]
    indicators: SX
    indicator_relation: list[int]
    instants: SX
    moving_instants: SX
    clocks: list[tuple[float, float]]
    ticks: SX
    previous: SX
    event_discretes: SX
    event_states: SX
    event_relations: SX
    event_conditions: SX
    last_conditions: SX
    loops: Loops
    start_loops: Loops
    assertions: list[Assertion] = field(default_factory=list)

    def checks(self, when: str) -> list[Assertion]:
        """Return the assertions that are checked at a time."""
        return [a for a in self.assertions if a.when == when]

    @property
    def x(self) -> SX:
        """States, shape (nx, 1)."""
        return vector(self.states)

    @property
    def u(self) -> SX:
        """Inputs, shape (nu, 1)."""
        return vector(self.variables.inputs)

    @property
    def p(self) -> SX:
        """Parameters, free ones first, then dependent ones."""
        return ca.vertcat(vector(self.variables.free), vector(self.variables.dependent))

    @property
    def d(self) -> SX:
        """Discrete variables."""
        return vector(self.variables.discretes)

    @property
    def guesses(self) -> SX:
        """Last values of the unknowns of nonlinear loops."""
        return column(list(self.loops.guesses.values()))

    @property
    def start_guesses(self) -> SX:
        """Last values of the unknowns of nonlinear initial loops."""
        return column(list(self.start_loops.guesses.values()))


def column(expressions: Sequence[SX]) -> SX:
    """Return a dense column, which may be empty."""
    return ca.densify(ca.vertcat(*expressions)) if expressions else SX(0, 1)


def explicit(dae: Dae) -> System:
    """Return a flat class in explicit form.

    Raises:
        TranslationError: It has an unsupported construct; the message names it with file and line.
    """
    _refuse_unsupported(dae)
    time = SX.sym("time")
    of_id, symbols = declare(dae)
    evaluate = ExpressionBuilder(dae, symbols, time)
    v = settle(dae, of_id, symbols, evaluate)
    values = {s.name: s.start for scalars in of_id.values() for s in scalars}
    misread = (sentence for name, default, sentence in dae.doubtful if values.get(name) != default)
    refuse(f"{dae.class_name} has Modelica that the built-in compiler does not translate", misread)
    evaluate.know(v.numbers())
    with evaluate.for_relations():
        relations = find_relations(dae, evaluate, v.with_numbers)
    clocks = _clocks(dae, v)
    ticks = [SX.sym(f"tick{k}") for k in range(len(clocks))] + [SX.sym("initial")]
    conditions = EventConditions(dae=dae, evaluate=evaluate, relations=relations, ticks=ticks)
    evaluate.conditions = conditions.level

    equations = _with_numbers(v, _equations(evaluate, "continuous"))
    # First of all equations together, because each call has a fixed cost.
    for equation in equations if ca.depends_on(column([e.residual for e in equations]), column(ticks)) else ():
        if ca.depends_on(equation.residual, column(ticks)):
            raise TranslationError(
                f"{equation.where}: {dae.class_name}: initial() and sample() are supported in when clauses only; "
                "write an initial equation"
            )

    # Demoting a state with a fixed start costs twice as much, because its initial condition would be lost.
    index_one = reduce_index(
        equations, time, vector(v.inputs),
        [s.symbol for s in v.states], v.derivatives, [s.symbol for s in v.algebraics],
        [RELUCTANCE[s.attributes["state_select"]] * (2 if s.fixed else 1) for s in v.states], dae.class_name,
    )  # fmt: skip
    states, algebraics = _split_states(v, index_one.states, index_one.former_states)
    _require_state_select(dae, states, algebraics)
    _require_solvable(dae, v, index_one, [*states, *algebraics])
    started = frozenset(s.symbol.name() for s in algebraics if s.start != 0)
    loops, start_loops = Loops(started), Loops(started)
    derivative, algebraic, indicators, steps = solve(
        index_one.equations, index_one.unknowns,
        [column([derivative for _, derivative in index_one.states]), vector(algebraics),
         column(relations.indicator), column([*relations.steps.values()])], loops, dae.class_name,
    )  # fmt: skip
    # Between events pre(d) is d.
    derivative, algebraic, indicators, steps = _between_events(v, [derivative, algebraic, indicators, steps])
    for table in (loops.updates, loops.residuals):
        table.update(zip(table, _between_events(v, [*table.values()]), strict=True))
    coefficients = _between_events(v, [coefficient for coefficient, _ in loops.divisors.values()])
    events, crossings = _time_events(v, time, relations, indicators, steps)
    divisors = _coefficients(loops.divisors, coefficients, v)
    start, calculated, start_discretes = _solve_start(evaluate, v, states, algebraics, index_one, start_loops)
    (discretes, reinitialised, live, levels), assertions = _at_events(v, conditions, states, index_one, loops)
    return System(
        class_name=dae.class_name,
        time=time,
        variables=v,
        states=states,
        algebraics=algebraics,
        derivative=column([derivative]),
        algebraic=column([algebraic]),
        start=start,
        calculated=calculated,
        start_discretes=start_discretes,
        relation=column(relations.memory),
        relation_inclusive=relations.inclusive,
        indicators=column([indicators[k] for k in crossings]),
        indicator_relation=crossings,
        instants=column(events.instants),
        moving_instants=column(events.moving),
        clocks=clocks,
        ticks=column(ticks),
        previous=column(v.previous),
        event_discretes=column([discretes]),
        event_states=column([reinitialised]),
        event_relations=column([live]),
        event_conditions=column([levels]),
        last_conditions=column(conditions.last),
        loops=loops,
        start_loops=start_loops,
        assertions=sorted([*assertions, *divisors], key=lambda a: WHEN.index(a.when)),
    )


def _between_events(v: ModelVariables, expressions: list[SX]) -> list[SX]:
    previous = column(v.previous)
    if not expressions or not previous.numel() or not ca.depends_on(ca.vertcat(*expressions), previous):
        return expressions
    return list(ca.substitute(expressions, [previous], [vector(v.discretes)]))


def _time_events(
    v: ModelVariables, time: SX, relations: Relations, indicators: SX, steps: SX
) -> tuple[TimeEvents, list[int]]:
    # The time events, and the places of the relations whose zeros must be searched for.
    parameters = frozenset(p.name for p in (*v.free, *v.dependent))
    held = parameters | {d.name for d in v.discretes} | {r.name() for r in relations.memory}
    events = TimeEvents(time=time, parameters=parameters, held=held)
    step_of = dict(zip(relations.steps, ca.vertsplit(steps) if relations.steps else [], strict=True))
    return events, [
        k
        for k in range(len(relations.memory))
        if not (events.add_whole_numbers(step_of[k]) if k in step_of else events.add_zeros(indicators[k]))
    ]


_SOLVED_FOR = "the equation is solved for {}, whose coefficient must not be zero, but it is "


def _coefficients(divisors: dict[str, tuple[SX, str]], coefficients: list[SX], v: ModelVariables) -> list[Assertion]:
    # An equation that is solved for an unknown divides by the coefficient of the unknown.
    parameters = {s.symbol.name() for s in [*v.free, *v.dependent]}
    return [
        Assertion(
            holds=coefficient != 0,
            message=(_SOLVED_FOR.format(name), coefficient, "."),
            level="domain",
            where=where,
            when="parameters" if {s.name() for s in ca.symvar(coefficient)} <= parameters else "running",
        )
        for (name, (_, where)), coefficient in zip(divisors.items(), coefficients, strict=True)
    ]


def _at_events(
    v: ModelVariables, conditions: EventConditions, states: list[Scalar], index_one: IndexOne, loops: Loops
) -> tuple[list[SX], list[Assertion]]:
    # The event system and the assertions have the same loops again; `loops` must list each once.
    dae, blocks, running = conditions.dae, list(loops.blocks), set(loops.guesses)
    event_equations, event_states = _event_equations(v, conditions, states)
    assertions = _assertions(conditions) + _requirements(v, conditions)
    assertions.sort(key=lambda a: WHEN.index(a.when))  # in the order of their values below
    # `conditions.edge_conditions` is complete only now: the event equations add to it.
    targets = v.with_numbers([
        vector(v.discretes),
        column(event_states),
        column(conditions.relations.live),
        column([conditions.level(i) for i in conditions.edge_conditions]),
    ])  # fmt: skip
    between, at_start, at_event = (
        v.with_numbers([
            e
            for a in assertions if a.when in group
            for e in (a.holds, *(piece for piece in a.message if isinstance(piece, SX)))
        ])
        for group in (("running", "parameters"), ("start",), ("event",))
    )  # fmt: skip
    event_values = solve(
        [*index_one.equations, *_with_numbers(v, event_equations)],
        [*index_one.unknowns, *(s.symbol for s in v.discretes)], [*targets, *at_event], loops, dae.class_name,
    )  # fmt: skip
    # Other assertions are checked between events, with the present values of discrete variables.
    values = solve(index_one.equations, index_one.unknowns, [*between, *at_start], loops, dae.class_name)
    values = iter([
        *_between_events(v, values[: len(between)]), *values[len(between) :], *event_values[len(targets) :]
    ])  # fmt: skip
    assertions = [
        replace(a, holds=next(values), message=tuple(next(values) if isinstance(p, SX) else p for p in a.message))
        for a in assertions
    ]
    through_events = [name for name in loops.guesses if name not in running]
    if through_events:
        raise TranslationError(
            f"{dae.class_name}: a nonlinear loop through discrete variables is not supported: "
            f"{', '.join(through_events)}; break it with pre()."
        )
    loops.blocks = blocks
    return event_values[: len(targets)], assertions


WHEN = ("running", "parameters", "start", "event")
"""Times when assertions are checked, see `Assertion`."""


def _requirements(v: ModelVariables, conditions: EventConditions) -> list[Assertion]:
    # Most divisors are parameters, which are checked once.
    every = conditions.evaluate.requirements()
    values = iter(v.with_numbers([e for _, r in every for e in (r.holds, r.found)]))
    parameters = {s.symbol.name() for s in [*v.free, *v.dependent]}
    before = {s.name() for s in v.previous}
    of_events = {s.name() for s in [*conditions.last, *conditions.ticks]}
    out: list[Assertion] = []
    for when, r in every:
        holds, found = as_sx(next(values)), as_sx(next(values))
        if is_number(holds):
            if not float(holds):
                raise TranslationError(f"{r.where}: {conditions.dae.class_name}: {r.sentence}{float(found):g}.")
            continue
        used = {s.name() for s in ca.symvar(ca.vertcat(holds, found))}
        times = [when]
        if used <= parameters:
            times = ["parameters"]
        elif when == "watched":  # it is also required at events
            times = [] if used & (before | of_events) else ["running"]
        elif when == "running" and used & of_events:
            times = ["event"]
        elif when == "running" and used & before:
            times = ["running", "event"]
        message = (r.sentence, found, ".")
        out += [Assertion(holds=holds, message=message, level="domain", where=r.where, when=time) for time in times]
    return out


def _require_state_select(dae: Dae, states: list[Scalar], algebraics: list[Scalar]) -> None:
    for scalars, forbidden, what in ((states, "Never", "is a state"), (algebraics, "Always", "cannot be a state")):
        for s in scalars:
            if s.attributes["state_select"] == forbidden:
                raise dae.refuse(
                    f"{s.name}(stateSelect=StateSelect.{forbidden.lower()}) {what} (4.9.7.1)", s.provenance
                )


def _require_solvable(dae: Dae, v: ModelVariables, index_one: IndexOne, unknowns: list[Scalar]) -> None:
    # States are chosen once, at the build. Where an equation between states is nonlinear, such as that of a pendulum in
    # Cartesian coordinates, another choice may be necessary, at least at the start values.
    former = [s for s in unknowns if s.kind == "algebraic"]
    columns = column([vector(former), *v.derivatives])
    residuals = column([e.residual for e in index_one.constraints])
    matrix = ca.jacobian(residuals, columns)
    if not index_one.constraints or not ca.depends_on(matrix, vector(unknowns)):
        return
    parameters = {s.symbol.name() for s in (*v.free, *v.dependent)}
    rows = [
        {s.name().removeprefix("der(").removesuffix(")") for s in ca.symvar(e.residual)} - parameters
        for e in index_one.constraints
    ]
    group = set[str]().union(*(r for i, r in enumerate(rows) if ca.depends_on(matrix[i, :], vector(unknowns))))
    for _ in rows:  # with the equations that are connected to nonlinear ones
        group = group.union(*(r for r in rows if r & group))
    kept = [s for s in v.states if s.kind == "state" and s.symbol.name() in group]
    values = {s.symbol.name(): SX(s.start) for s in (*unknowns, *v.free)}
    values |= {s.symbol.name(): value for s, value in zip(v.dependent, v.dependent_values, strict=True)}
    for _ in range(2):  # dependent parameters first
        symbols = [s for s in ca.symvar(matrix) if s.name() in values]
        matrix = ca.substitute(matrix, column(symbols), column([values[s.name()] for s in symbols]))
    demoted = ", ".join(s.name for s in former if s.name in index_one.former_states)
    if not ca.symvar(matrix) and np.linalg.matrix_rank(ca.DM(matrix).full()) < len(index_one.constraints):
        problem = f"cannot be solved for {demoted} at the start values"
    elif any(not s.fixed and RELUCTANCE[s.attributes["state_select"]] <= 1 for s in kept):
        problem = f"does not say which variables are the states, {', '.join(s.name for s in kept)} or {demoted}"
    else:
        return
    where = index_one.constraints[-1].where
    raise TranslationError(
        f"{where}: {dae.class_name}: the index of the class is {index_one.index}: this equation must be differentiated "
        f"to find the states, is not linear, and {problem}. Use independent coordinates, such as the angle of a "
        "pendulum, or give fixed = true to states for which the equations can be solved for the others all the time."
    )


def _refuse_unsupported(dae: Dae) -> None:
    for node in dae.misread_slices():
        raise dae.refuse(
            f"the slice {dae.text(node['provenance'])} through arrays of components is not supported; write an array "
            "comprehension, as in {a[i].z[2] for i in 1:3}",
            node["provenance"],
        )
    for delay in dae.content["delays"]:
        raise dae.refuse(f"delay is not supported: {dae.text(delay['provenance'])}", delay["provenance"])
    for key, what in (
        ("previous_values", "previous is"), ("terminals", "terminals is"),
        ("initial_parameter_values", "initial values of parameters are"),
    ):  # fmt: skip
        for node in dae.content[key]:
            raise dae.refuse(f"{what} not supported", node.get("provenance"))


def _with_numbers(v: ModelVariables, equations: list[Equation]) -> list[Equation]:
    residuals = v.with_numbers([e.residual for e in equations])
    return [Equation(as_sx(r), e.where) for r, e in zip(residuals, equations, strict=True)]


def _equations(evaluate: ExpressionBuilder, system: str) -> list[Equation]:
    dae, out = evaluate.dae, list[Equation]()
    for owner in dae.content[f"{system}_equation_operations"]:
        where = dae.where(owner.get("provenance"))
        bodies = [owner["residual"]] if owner["kind"] == "residual" else owner["bodies"]
        points: Iterable[dict[tuple[int, int], int]] = [{}]
        # The loop variables that are left, all of them for RowMajorProjection, count the elements of an array.
        match owner.get("scalar_view"):
            case None | "RowMajorProjection":
                pass
            case "BinderSubstitution":
                points = dae.iterate(owner["domain"])
            case {"BinderPrefixProjection": {"binder_count": int(count)}}:
                points = dae.iterate(owner["domain"], count)
            case view:
                raise TranslationError(f"{where}: {dae.class_name}: equations of the kind {view} are not supported.")
        values = [evaluate(body, point) for point in points for body in bodies]
        out += [Equation(as_sx(r), where) for value in values for r in value.flat]
    return out


def _clocks(dae: Dae, v: ModelVariables) -> list[tuple[float, float]]:
    out: list[tuple[float, float]] = []
    settable = {p.name.rpartition(".")[2] for p in [*v.free, *v.dependent]}
    for clock in dae.content["clocks"]:
        operation = clock["operation"]
        text = dae.text(clock["provenance"])
        if operation["kind"] != "periodic" or not re.match(r"sample\s*\((?!.*\bClock\b)", text):
            raise dae.refuse(
                f"a clock (chapter 16 of the specification) is not supported: {text}; write when sample(start, period)",
                clock["provenance"],
            )
        words = "".join(c if c.isalnum() or c == "_" else " " for c in text).split()
        dependences = sorted(settable.intersection(words))
        if dependences:  # rumoca has already computed the period with the parameter's default
            raise dae.refuse(
                f"the period of {text} depends on {dependences[0]}; declare it constant or final",
                clock["provenance"],
            )
        lattice = operation["lattice"]
        phase, period = (lattice[k]["num"] / lattice[k]["den"] for k in ("phase", "period"))
        out.append((phase, period))
    return out


def _split_states(
    v: ModelVariables, pairs: list[tuple[SX, SX]], former_states: frozenset[str]
) -> tuple[list[Scalar], list[Scalar]]:
    by_name = {s.name: s for s in v.states}
    states: list[Scalar] = []
    for symbol, _ in pairs:
        if symbol.name() in by_name:
            states.append(by_name[symbol.name()])
            continue
        # A derivative that became a state, such as der(x) of a constrained position.
        states.append(
            Scalar(
                name=symbol.name(), kind="state", type="real", causality="local", symbol=symbol,
                attributes={"unit": None, "description": None}, provenance={}, protected=False,
            )
        )  # fmt: skip
    former = [s for s in v.states if s.name in former_states]
    for s in former:
        s.kind = "algebraic"
    return states, [*v.algebraics, *former]


def _solve_start(
    evaluate: ExpressionBuilder, v: ModelVariables, states: list[Scalar], algebraics: list[Scalar],
    index_one: IndexOne, loops: Loops,
) -> tuple[SX, list[bool], dict[int, SX]]:  # fmt: skip
    # The initial values of the states, whether each of them depends on parameters or initial equations, and the place
    # of each discrete variable whose value before the start depends on these with that value.
    # Initial equations may determine any variable, so they are solved together with the equations of the model.
    class_name, starts = evaluate.dae.class_name, v.with_numbers([s.binding for s in states])
    calculated = [not is_number(value) for value in starts]
    with evaluate.during("start"):
        initial, targets = _initial_equations(evaluate, v, algebraics)
    before = v.with_numbers([d.binding for d in v.discretes])
    discretes = {i: as_sx(e) for i, e in enumerate(before) if not is_number(e) and i not in targets}
    if not initial:
        return column(starts), calculated, discretes
    free = [s for s in states if not s.fixed]
    if len(free) + len(targets) != len(initial):
        places = ", ".join(dict.fromkeys(e.where for e in initial))
        unknown = ", ".join([s.name for s in free] + [f"pre({v.discretes[i].name})" for i in targets])
        spare = len(initial) - len(free) - len(targets)
        raise TranslationError(
            f"{class_name}: the initial values are not determined: the number of initial equations is "
            f"{len(initial)} ({places}), that of initial values without a fixed start {len(free) + len(targets)} "
            f"({unknown or 'none'}). A fixed start of a variable that is not a state is an initial equation. "
            f"Set fixed = {'false' if spare > 0 else 'true'} for {abs(spare)} start values, or change the initial "
            "equations."
        )
    solution, determined = solve(
        [*index_one.equations, *initial],
        [*index_one.unknowns, *(s.symbol for s in free), *(v.previous[i] for i in targets)],
        [vector(free), column([v.previous[i] for i in targets])],
        loops,
        class_name,
    )
    _require_known(class_name, v, discretes, [solution, determined, *loops.updates.values(), *loops.residuals.values()])
    place = {s.name: i for i, s in enumerate(free)}
    start = [solution[place[s.name]] if s.name in place else starts[i] for i, s in enumerate(states)]
    calculated = [is_calculated or s.name in place for is_calculated, s in zip(calculated, states, strict=True)]
    return column(start), calculated, discretes | {i: determined[k] for k, i in enumerate(targets)}


def _initial_equations(
    evaluate: ExpressionBuilder, v: ModelVariables, algebraics: list[Scalar]
) -> tuple[list[Equation], list[int]]:
    # Initial equations, fixed start values of other variables than states (MLS 3.6, section 8.6), and the places of the
    # discrete variables that they determine.
    dae, equations = evaluate.dae, _equations(evaluate, "initialization")
    equations += [
        Equation(s.symbol - s.binding, f"{dae.where(s.provenance)} ({s.name})") for s in algebraics if s.fixed
    ]
    targets: list[int] = []
    slot = {s.name: i for i, s in enumerate(v.discretes)}
    held = _held_at_start(evaluate, v)
    for node in dae.content["initial_discrete_values"]:
        scalars, values = v.of_id[node["target"]], evaluate(node["value"])
        for scalar, value in zip(scalars, np.broadcast_to(values, len(scalars)).flat, strict=True):
            i = slot.get(scalar.name)
            if i is None or (scalar.name not in held and not dae.text(node["provenance"]).startswith("pre(")):
                raise dae.refuse(
                    f"an initial equation of {scalar.name} itself is not supported, because another equation sets "
                    f"it at the start; write pre({scalar.name}) = ...",
                    node["provenance"],
                )
            targets.append(i)
            equations.append(Equation(v.previous[i] - SX(value), dae.where(node["provenance"])))
    equations = _with_numbers(v, equations)
    if twice := [v.discretes[i].name for i in targets if targets.count(i) > 1 or v.discretes[i].fixed]:
        raise TranslationError(f"{dae.class_name}: {twice[0]} has more than one initial value.")
    # At the start a discrete variable that only when clauses without initial() change has its value before the start.
    same = [i for i, s in enumerate(v.discretes) if s.name in held]
    if equations and same:
        symbols, previous = (ca.vertcat(*[x[i] for i in same]) for x in ([s.symbol for s in v.discretes], v.previous))
        residuals = ca.substitute([e.residual for e in equations], [symbols], [previous])
        equations = [Equation(r, e.where) for r, e in zip(residuals, equations, strict=True)]
    mentioned = {s.name() for e in equations for s in ca.symvar(e.residual)}
    targets += [
        i for i, s in enumerate(v.discretes) if v.previous[i].name() in mentioned and i not in targets and not s.fixed
    ]
    return equations, targets


def _held_at_start(evaluate: ExpressionBuilder, v: ModelVariables) -> set[str]:
    def active(activation: Node) -> bool:
        return activation["kind"] != "when" or includes_initial(evaluate.dae, activation["trigger"])

    changed = set[str]()
    for equation, sides in _discrete_equations(evaluate, v):
        if active(equation["activation"]):
            changed.update(*(names for names, _ in sides))
    return {s.name for s in v.discretes} - changed


def _discrete_equations(
    evaluate: ExpressionBuilder, v: ModelVariables
) -> Iterator[tuple[Node, list[tuple[list[str], int]]]]:
    # Each equation or branch that sets discrete variables, with the names of these and the expressions of their values.
    dae = evaluate.dae
    for residual in dae.content["discrete_real_equations"]:
        operation = dae.expressions[residual["residual"]]["operation"]
        yield residual, [([str(symbol) for symbol in evaluate(operation["lhs"]).flat], operation["rhs"])]
    for owner in dae.content["discrete_value_owners"]:
        names = [[s.name for s in v.of_id[target]] for target in owner["targets"]]
        for branch in owner["branches"]:
            yield branch, list(zip(names, (value["value"] for value in branch["values"]), strict=True))


def _require_known(class_name: str, v: ModelVariables, known: Mapping[int, SX], expressions: list[SX]) -> None:
    previous = {v.previous[i].name() for i, s in enumerate(v.discretes) if not s.fixed and i not in known}
    unknown = sorted({s.name() for e in expressions for s in ca.symvar(SX(e))} & previous)
    if unknown:
        raise TranslationError(
            f"{class_name}: the initial equations depend on {unknown[0]}, which none of them determines."
        )


def _event_equations(
    v: ModelVariables, conditions: EventConditions, states: list[Scalar]
) -> tuple[list[Equation], list[SX]]:
    dae, evaluate = conditions.dae, conditions.evaluate
    slot = {s.name: i for i, s in enumerate(v.discretes)}
    branches: dict[int, list[tuple[SX, SX, str]]] = {}
    for equation, sides in _discrete_equations(evaluate, v):
        active, where = conditions.active(equation["activation"]), dae.where(equation["provenance"])
        for names, expression in sides:
            for name, value in zip(names, _at_event(evaluate, expression, active).flat, strict=True):
                branches.setdefault(slot[name], []).append((active, SX(value), where))
    equations: list[Equation] = []
    for i, scalar in enumerate(v.discretes):
        value, where = v.previous[i], branches[i][0][2] if i in branches else dae.class_name
        for active, element, _ in reversed(branches.get(i, [])):  # reversed, so that the first branch has priority
            value = choose(active, element, value)
        equations.append(Equation(scalar.symbol - value, where))
    after = [s.symbol for s in states]
    place = {s.name: i for i, s in enumerate(states)}
    for action in dae.content["event_actions"]:
        operation = action["operation"]
        if operation["kind"] == "reinitialize":
            if includes_initial(dae, action["guard"]):
                raise dae.refuse(
                    "reinit in a when clause with initial() is not supported; write an initial equation as well as a "
                    "when clause without initial()",
                    action["provenance"],
                )
            scalars = v.of_id[operation["state"]]
            if len(scalars) != 1 or scalars[0].name not in place:
                raise dae.refuse(
                    f"reinit of {scalars[0].name}, which is not a scalar state, is not supported", action["provenance"]
                )
            i = place[scalars[0].name]
            active = conditions.edge(action["guard"])
            with evaluate.during("event", active):
                after[i] = choose(active, evaluate(operation["value"]).item(), after[i])
        elif operation["kind"] not in ("assert", "warning"):
            raise dae.refuse(f"{operation['kind']} is not supported", action["provenance"])
    return equations, after


def _at_event(evaluate: ExpressionBuilder, expression: int, active: SX) -> Array:
    if is_number(active):  # it holds between events, too, where its relations are watched
        with evaluate.during("watched"):
            evaluate(expression)
    with evaluate.during("event", active):
        return evaluate(expression)


def _assertions(conditions: EventConditions) -> list[Assertion]:
    dae, evaluate = conditions.dae, conditions.evaluate
    out: list[Assertion] = []
    for action in dae.content["event_actions"]:
        operation = action["operation"]
        if operation["kind"] not in ("assert", "warning"):
            continue
        # The guard is true if the assertion is violated; a warning's own condition is true if it holds.
        holds = ca.logic_not(conditions.level(action["guard"]))
        if operation["kind"] == "warning":
            holds = ca.logic_or(holds, evaluate(operation["condition"]).item())
        if ca.depends_on(holds, column(conditions.ticks[:-1])):
            raise dae.refuse("sample() in the condition of an assertion is not supported", action["provenance"])
        found = Assertion(
            holds=SX(holds),
            message=_message(evaluate, operation["message"]),
            level="error" if operation["kind"] == "assert" else "warning",
            where=dae.where(action["provenance"]),
        )
        times = [(1.0, "start")] if dae.is_initial(action["provenance"]) else [(1.0, "start"), (0.0, "running")]
        if len(times) > 1 and not ca.depends_on(holds, conditions.ticks[-1]):
            out.append(found)
            continue
        # initial() is true while the start is computed, and false from then on (8.6).
        for is_initial, when in times:
            out.append(replace(found, holds=ca.substitute(found.holds, conditions.ticks[-1], is_initial), when=when))
    return out


def _message(evaluate: ExpressionBuilder, expression: int) -> Message:
    node = evaluate.dae.expressions[expression]
    operation = node["operation"]
    if operation["kind"] == "literal" and "string" in operation["value"]:
        return (operation["value"]["string"],)
    if operation["kind"] == "binary" and operation["operator"] == "add":
        return _message(evaluate, operation["lhs"]) + _message(evaluate, operation["rhs"])
    if operation["kind"] == "string_conversion":
        with evaluate.during("never"):  # the message of an assertion that holds is never formed
            return (SX(evaluate(operation["value"]).item()),)
    text = evaluate.dae.text(node["provenance"])
    raise evaluate.dae.refuse(f"this text of a message is not supported: {text}", node["provenance"])
