"""Relations and conditions of a class, whose values the event iteration keeps, and the instants of its time events."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field

import casadi as ca

from railgrip.fmus.native.arrays import SX
from railgrip.fmus.native.dae import Binding, Dae, Node
from railgrip.fmus.native.expressions import ExpressionBuilder, Site, site

# Factor of lhs − rhs with which it is positive where the relation holds.
SIGN = {"less": -1, "less_equal": -1, "greater": 1, "greater_equal": 1}

STEPS = frozenset(("floor", "ceil", "integer", "mod", "rem", "div"))
"""Functions with steps, which cause events (Modelica Language Specification 3.6, section 3.7.2)."""

_DEPTH = 30
"""Depth to which CasADi compares two expressions; if they are equal only below it, both are kept."""


@dataclass(slots=True)
class Relations:
    """Relations whose truth values are constant between events.

    Attributes:
        memory: Symbol of each distinct relation, with the value since the last event.
        live: Expression of its present value.
        indicator: Expression that crosses zero where the relation changes, and is positive where it holds.
        inclusive: Whether it holds where the indicator is zero.
        steps: Place of a relation that represents a function with steps, such as `floor` → the expression that is a
            whole number at these steps.
        slot: Relation id of the DAE → place in `memory`; relations that only assertions use are never kept.
    """

    memory: list[SX] = field(default_factory=list)
    live: list[SX] = field(default_factory=list)
    indicator: list[SX] = field(default_factory=list)
    inclusive: list[bool] = field(default_factory=list)
    steps: dict[int, SX] = field(default_factory=dict)
    slot: dict[int, int] = field(default_factory=dict)


def find_relations(dae: Dae, evaluate: ExpressionBuilder, with_numbers: Callable[[list[SX]], list[SX]]) -> Relations:
    """Collect the relations of a class and make `evaluate` use their memory.

    Args:
        dae: The class.
        evaluate: Builder of expressions, which uses the symbols in `memory` afterwards.
        with_numbers: Function that replaces constants by their numbers.
    """
    relations = dae.content["relations"]
    assertion_only = _assertion_only_relations(dae)
    out = Relations()
    sites: list[tuple[int | None, int, Binding]] = [
        (r["id"], r["expression"], {}) for r in relations if r["id"] not in assertion_only
    ]
    for root in dae.content["structured_roots"]:
        sites += [(None, root["expression"], point) for point in dae.iterate(root["domain"])]
    listed = {r["expression"] for r in relations}
    sites += [(None, i, {}) for i in _relations_of_time(dae) if i not in listed]
    place: dict[Site, SX] = {}
    of_symbols: dict[tuple[str, ...], list[int]] = {}  # equal relations have equal symbols
    for relation, expression, binding in sites:
        (live,) = with_numbers([evaluate.live(expression, binding).item()])
        similar = of_symbols.setdefault(tuple(sorted(s.name() for s in ca.symvar(live))), [])
        number = next((k for k in similar if ca.is_equal(out.live[k], live, _DEPTH)), None)
        if number is None:
            number = len(out.live)
            similar.append(number)
            operation = dae.expressions[expression]["operation"]
            sign = SIGN.get(operation.get("operator", ""))
            indicator = live - 0.5  # of a relation that is not an inequality
            if sign:
                sides = [evaluate(operation[k], binding).item() for k in ("lhs", "rhs")]
                (indicator,) = with_numbers([sign * (sides[0] - sides[1])])
            steps = _steps(dae, expression)
            if steps is not None:
                (out.steps[number],) = with_numbers([evaluate(steps, binding).item()])
            out.inclusive.append(operation.get("operator", "").endswith("_equal"))
            out.live.append(live)
            out.indicator.append(indicator)
            out.memory.append(SX.sym(f"relation{number}"))
        place[site(expression, binding)] = out.memory[number]
        if relation is not None:
            out.slot[relation] = number
    evaluate.remember(place)
    return out


def _steps(dae: Dae, expression: int) -> int | None:
    # rumoca represents the steps of floor, mod, ... by the relation sin(π e) >= 0, where e is a whole number at a step,
    # with the provenance of the function.
    node = dae.expressions[expression]
    left = dae.expressions[node["operation"]["lhs"]] if node["operation"].get("operator") == "greater_equal" else node
    if left["operation"].get("builtin") != "sin":
        return None
    product = dae.expressions[left["operation"]["operands"][0]]
    span = node["provenance"]["span"]
    here = dae.by_span[span["source"], span["start"], span["end"]]
    is_step = left in here and product in here and any(n["operation"].get("builtin") in STEPS for n in here)
    return product["operation"]["rhs"] if is_step else None


def _relations_of_time(dae: Dae) -> list[int]:
    # Relations that rumoca lists as time events, by the provenance alone; those with a moving deadline are listed as
    # relations, too.
    number = {id(node): i for i, node in enumerate(dae.expressions)}
    out: list[int] = []
    for event in dae.content["time_events"]:
        span = event["provenance"]["span"]
        nodes = [
            n
            for n in dae.by_span.get((span["source"], span["start"], span["end"]), [])
            if n["operation"]["kind"] == "binary" and n["operation"]["operator"] in SIGN
        ]
        if not nodes or any(n["domains"] for n in nodes):
            raise dae.refuse(
                f"a time event of this form is not supported: {dae.text(event['provenance'])}", event["provenance"]
            )
        out += [number[id(n)] for n in nodes]
    return list(dict.fromkeys(out))


def _assertion_only_relations(dae: Dae) -> set[int]:
    def relations(conditions: Iterable[int]) -> set[int]:
        return {o["relation"] for k in conditions for o in operations(dae, k) if o["kind"] == "relation"}

    asserted, elsewhere = list[int](), list[int]()
    for action in dae.content["event_actions"]:
        (asserted if action["operation"]["kind"] in ("assert", "warning") else elsewhere).append(action["guard"])
    branches = [branch for owner in dae.content["discrete_value_owners"] for branch in owner["branches"]]
    activations = [node["activation"] for node in (*branches, *dae.content["discrete_real_equations"])]
    elsewhere += [activation["trigger"] for activation in activations if activation["kind"] == "when"]
    return relations(asserted) - relations(elsewhere)


def operations(dae: Dae, condition: int) -> Iterator[Node]:
    """Yield the operation of a condition, and those of all conditions in it."""
    operation = dae.content["conditions"][condition]["operation"]
    yield operation
    for key in ("condition", "lhs", "rhs"):
        if isinstance(operation.get(key), int):
            yield from operations(dae, operation[key])


def includes_initial(dae: Dae, condition: int) -> bool:
    """Return whether a condition contains `initial()`."""
    return any(operation["kind"] == "initial" for operation in operations(dae, condition))


@dataclass(slots=True)
class EventConditions:
    """Conditions of `when` clauses and assertions as expressions.

    Attributes:
        ticks: One symbol for each periodic clock, and a last one that is 1 during initialisation.
        edge_conditions: Ids of conditions whose last value is kept in order to detect an edge.
        last: Symbols of their last values.
    """

    dae: Dae
    evaluate: ExpressionBuilder
    relations: Relations
    ticks: list[SX]
    edge_conditions: list[int] = field(default_factory=list)
    last: list[SX] = field(default_factory=list)

    def level(self, i: int) -> SX:
        """Return whether condition `i` holds."""
        node = self.dae.content["conditions"][i]
        operation = node["operation"]
        kind = operation["kind"]
        if kind == "relation":
            relation = self.dae.content["relations"][operation["relation"]]
            live = self.evaluate.live(relation["expression"], {}).item()  # also for its requirements
            slot = self.relations.slot.get(relation["id"])
            return live if slot is None else self.relations.memory[slot]
        if kind == "always":
            return SX(1)
        if kind == "clock":
            return self.ticks[operation["clock"]]
        if kind == "initial":
            return self.ticks[-1]
        if kind == "not":
            return ca.logic_not(self.level(operation["condition"]))
        if kind in ("and", "or"):
            join = ca.logic_and if kind == "and" else ca.logic_or
            left = self.level(operation["lhs"])
            with self.evaluate.under(left if kind == "and" else ca.logic_not(left)):
                return join(left, self.level(operation["rhs"]))
        if kind == "discrete":
            return self.evaluate(operation["expression"]).item()
        raise self.dae.refuse(f"a condition of kind {kind} is not supported", node["provenance"])

    def edge(self, i: int) -> SX:
        """Return whether condition `i` has just become true."""
        operation = self.dae.content["conditions"][i]["operation"]
        if operation["kind"] == "any_rise":
            return ca.logic_or(self.edge(operation["lhs"]), self.edge(operation["rhs"]))
        if operation["kind"] in ("clock", "initial"):
            return self.level(i)
        if includes_initial(self.dae, i):
            raise self.dae.refuse(
                "initial() in a condition of a when clause is supported alone or as an element of a vector only (8.6); "
                "write `when {initial(), ...}`",
                self.dae.content["conditions"][i]["provenance"],
            )
        if i not in self.edge_conditions:
            self.edge_conditions.append(i)
            self.last.append(SX.sym(f"last_condition{i}"))
        return ca.logic_and(self.level(i), ca.logic_not(self.last[self.edge_conditions.index(i)]))

    def active(self, activation: Node) -> SX:
        """Return whether an equation with this activation is active now."""
        return SX(1) if activation["kind"] == "always" else self.edge(activation["trigger"])


_CONSTANT, _STEPS, _LINEAR, _OTHER = range(4)
"""Dependence on time: none, piecewise constant, piecewise linear, any other."""

_COMPARISONS = (ca.OP_LT, ca.OP_LE, ca.OP_EQ, ca.OP_NE)


@dataclass(frozen=True, slots=True)
class TimeEvents:
    """Instants of the time events of a class.

    Attributes:
        time: Symbol of time.
        parameters: Symbols of the parameters.
        held: Symbols that are constant between events: parameters, discrete variables, memories of relations.
        instants: Instants as expressions of the parameters.
        moving: Next instants as expressions of `time` and `held`; they are valid until the next event, and infinite,
            not a number or in the past without one.
    """

    time: SX
    parameters: frozenset[str]
    held: frozenset[str]
    instants: list[SX] = field(default_factory=list[SX])
    moving: list[SX] = field(default_factory=list[SX])

    def add_zeros(self, expression: SX) -> bool:
        """Add the zeros of an expression; False if they cannot be computed."""
        if not ca.depends_on(expression, self.time):
            return False
        return self._add(expression, _next_zero(expression, self.time))

    def add_whole_numbers(self, expression: SX) -> bool:
        """Add the instants at which an expression is a whole number; False if they cannot be computed."""
        if not ca.depends_on(expression, self.time):
            return False
        return self._add(expression, _next_whole_number(expression, self.time), is_zero=False)

    def _add(self, expression: SX, following: SX, *, is_zero: bool = True) -> bool:
        names = {s.name() for s in ca.symvar(expression)} - {self.time.name()}
        if not names <= self.held:
            return False
        breakpoints, is_piecewise_linear = _breakpoints(expression, self.time)
        if not is_piecewise_linear:  # the search for zeros begins anew at each breakpoint
            for instant in breakpoints:
                _add_once(self.moving, ca.densify(instant))
            return False
        if is_zero and not breakpoints and names <= self.parameters:
            slope = ca.jacobian(expression, self.time)
            rest = ca.substitute(expression, self.time, SX(0))
            _add_once(self.instants, ca.densify(-rest / slope))
        else:
            for instant in (*breakpoints, following):
                _add_once(self.moving, ca.densify(instant))
        return True


def _add_once(instants: list[SX], instant: SX) -> None:
    if not any(ca.is_equal(instant, other, _DEPTH) for other in instants):
        instants.append(instant)


def _next_zero(expression: SX, time: SX) -> SX:
    return time - expression / ca.jacobian(expression, time)


def _next_whole_number(expression: SX, time: SX) -> SX:
    slope = ca.jacobian(expression, time)
    return time + (ca.if_else(slope > 0, ca.floor(expression) + 1, ca.ceil(expression) - 1) - expression) / slope


def _breakpoints(expression: SX, time: SX) -> tuple[list[SX], bool]:
    """Return the next breakpoints of the piecewise linear parts of an expression, and whether it is one as a whole."""
    others = [s for s in ca.symvar(expression) if s.name() != time.name()]
    inputs = [time, ca.vertcat(*others)]
    program = ca.Function("program", inputs, [expression])
    values: dict[int, tuple[SX, int]] = {}
    out: list[SX] = []
    kinds: list[int] = []
    for k in range(program.n_instructions()):
        operation = program.instruction_id(k)
        if operation == ca.OP_OUTPUT:
            continue
        (place,) = program.instruction_output(k)
        if operation == ca.OP_CONST:
            values[place] = SX(program.instruction_constant(k)), _CONSTANT
            continue
        arguments = program.instruction_input(k)
        if operation == ca.OP_INPUT:
            values[place] = inputs[arguments[0]].nz[arguments[1]], _CONSTANT if arguments[0] else _LINEAR
            continue
        operands = [values[i][0] for i in arguments]
        value = SX.unary(operation, *operands) if len(operands) == 1 else SX.binary(operation, *operands)
        kind, more = _kind(operation, operands, [values[i][1] for i in arguments], time)
        values[place] = value, kind
        out += more
        kinds.append(kind)
    return out, _OTHER not in kinds


def _kind(operation: int, operands: Sequence[SX], kinds: Sequence[int], time: SX) -> tuple[int, list[SX]]:
    # The dependence on time of an operation's result, and its own next breakpoints.
    if _OTHER in kinds:
        return _OTHER, []
    if max(kinds) < _LINEAR:
        return max(kinds), []
    if operation in (ca.OP_ADD, ca.OP_SUB, ca.OP_NEG, ca.OP_TWICE):
        return _LINEAR, []
    if operation in (ca.OP_MUL, ca.OP_IF_ELSE_ZERO):
        return (_LINEAR if min(kinds) < _LINEAR else _OTHER), []
    if operation == ca.OP_DIV:
        return (_LINEAR if kinds[1] < _LINEAR else _OTHER), []
    if operation in (ca.OP_FLOOR, ca.OP_CEIL):
        return _STEPS, [_next_whole_number(operands[0], time)]
    if operation in (ca.OP_SIGN, ca.OP_FABS):
        return _STEPS if operation == ca.OP_SIGN else _LINEAR, [_next_zero(operands[0], time)]
    if operation in (ca.OP_FMIN, ca.OP_FMAX, *_COMPARISONS):
        kind = _STEPS if operation in _COMPARISONS else _LINEAR
        return kind, [_next_zero(operands[0] - operands[1], time)]
    return _OTHER, []
