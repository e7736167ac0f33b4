"""Relations, conditions and time events of a class, whose values the event iteration keeps."""

from collections.abc import Callable
from dataclasses import dataclass, field

import casadi as ca

from railgrip.fmus.native.arrays import SX
from railgrip.fmus.native.dae import Binding, Dae, Node
from railgrip.fmus.native.expressions import ExpressionBuilder, Site, site

# Factor of lhs − rhs with which it is positive where the relation holds.
SIGN = {"less": -1, "less_equal": -1, "greater": 1, "greater_equal": 1}

_DEPTH = 30
"""Depth to which CasADi compares two expressions; if they are equal only below it, both are kept."""


@dataclass(slots=True)
class Relations:
    """Relations whose truth values are constant between events.

    Attributes:
        memory: Symbol of each distinct relation, with the value since the last event.
        live: Expression of its present value.
        indicator: Expression that crosses zero where the relation changes, and is positive where it holds.
        crossings: Places of the relations whose zeros must be searched for; the others change at known `instants`.
        slot: Relation id of the DAE → place in `memory`.
        alone: Relation id → expression id of relations that only assertions use, which are never kept.
        instants: Times at which relations between time and parameters change, as expressions of the parameters.
    """

    memory: list[SX] = field(default_factory=list)
    live: list[SX] = field(default_factory=list)
    indicator: list[SX] = field(default_factory=list)
    crossings: list[int] = field(default_factory=list)
    slot: dict[int, int] = field(default_factory=dict)
    alone: dict[int, int] = field(default_factory=dict)
    instants: list[SX] = field(default_factory=list)


def find_relations(
    dae: Dae, evaluate: ExpressionBuilder, with_numbers: Callable[[list[SX]], list[SX]], parameters: SX
) -> Relations:
    """Collect the relations of a class and make `evaluate` use their memory.

    Args:
        dae: The class.
        evaluate: Builder of expressions, which uses the symbols in `memory` afterwards.
        with_numbers: Function that replaces constants by their numbers.
        parameters: Symbols on which an instant may depend.
    """
    conditions = dae.systems["conditions"]
    assertion_only = _assertion_only_relations(dae)
    out = Relations(alone={r["id"]: r["expression"] for r in conditions["relations"] if r["id"] in assertion_only})
    sites: list[tuple[Node, int, Binding]] = [
        (r, r["expression"], {}) for r in conditions["relations"] if r["id"] not in assertion_only
    ]
    for root in conditions["structured_roots"]:
        sites += [(root, root["expression"], point) for point in dae.iterate(root["domain"])]
    place: dict[Site, SX] = {}
    for root, expression, binding in sites:
        (live,) = with_numbers([evaluate.live(expression, binding).item()])
        number = next((k for k, other in enumerate(out.live) if ca.is_equal(other, live, _DEPTH)), None)
        if number is None:
            number = len(out.live)
            operation = dae.expressions[expression]["operation"]
            sign = SIGN.get(operation.get("operator", ""))
            indicator = live - 0.5  # of a relation that is not an inequality
            if sign:
                sides = [evaluate(operation[k], binding).item() for k in ("lhs", "rhs")]
                (indicator,) = with_numbers([sign * (sides[0] - sides[1])])
            out.live.append(live)
            out.indicator.append(indicator)
            out.memory.append(SX.sym(f"relation{number}"))
        place[site(expression, binding)] = out.memory[number]
        if not binding and "id" in root:
            out.slot[root["id"]] = number
    out.instants = _declared_instants(dae, evaluate, with_numbers, parameters)
    for k, indicator in enumerate(out.indicator):
        instant = _instant(indicator, evaluate.time, parameters)
        if instant is None:
            out.crossings.append(k)
        else:
            _add_once(out.instants, instant)
    evaluate.remember(place)
    return out


def _instant(difference: SX, time: SX, parameters: SX) -> SX | None:
    # The time at which the difference is zero, if it is linear in time and otherwise depends on parameters alone.
    if not ca.depends_on(difference, time):
        return None
    slope = ca.jacobian(difference, time)
    rest = ca.substitute(difference, time, SX(0))
    names = {s.name() for s in ca.vertsplit(parameters)} if parameters.numel() else set[str]()
    if any(s.name() not in names for s in [*ca.symvar(slope), *ca.symvar(rest)]):
        return None
    return ca.densify(-rest / slope)


def _add_once(instants: list[SX], instant: SX) -> None:
    if not any(ca.is_equal(instant, other, _DEPTH) for other in instants):
        instants.append(instant)


def _declared_instants(
    dae: Dae, evaluate: ExpressionBuilder, with_numbers: Callable[[list[SX]], list[SX]], parameters: SX
) -> list[SX]:
    out: list[SX] = []
    for event in dae.systems["events"]["time_events"]:
        span = event["provenance"]["span"]
        nodes = dae.by_span.get((span["source"], span["start"], span["end"]), [])
        linear = False
        for node in nodes:
            operation = node["operation"]
            if operation["kind"] != "binary" or operation["operator"] not in SIGN or node["binder_domain"] is not None:
                continue
            lhs, rhs = (evaluate(operation[k]).item() for k in ("lhs", "rhs"))
            instant = _instant(with_numbers([lhs - rhs])[0], evaluate.time, parameters)
            if instant is not None:
                linear = True
                _add_once(out, instant)
        if not linear:
            raise dae.refuse(
                f"a time event that is not linear in time is not supported: {dae.text(event['provenance'])}",
                event["provenance"],
            )
    return out


def _assertion_only_relations(dae: Dae) -> set[int]:
    conditions = dae.systems["conditions"]["conditions"]
    elsewhere: set[int] = set()
    in_assertions: set[int] = set()

    def walk(i: int, into: set[int]) -> None:
        operation = conditions[i]["operation"]
        if operation["kind"] == "relation":
            into.add(operation["relation"])
        for key in ("condition", "lhs", "rhs"):
            if isinstance(operation.get(key), int):
                walk(operation[key], into)

    for action in dae.systems["events"]["actions"]:
        walk(action["guard"], in_assertions if action["operation"]["kind"] in ("assert", "warning") else elsewhere)
    for owner in dae.systems["discrete_values"]["owners"]:
        for branch in owner["branches"]:
            if branch["activation"]["kind"] == "when":
                walk(branch["activation"]["trigger"], elsewhere)
    for residual in dae.systems["discrete_real"]["residuals"]:
        if residual["activation"]["kind"] == "when":
            walk(residual["activation"]["trigger"], elsewhere)
    return in_assertions - elsewhere


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
        node = self.dae.systems["conditions"]["conditions"][i]
        operation = node["operation"]
        kind = operation["kind"]
        if kind == "relation":
            relation = operation["relation"]
            if relation in self.relations.slot:
                return self.relations.memory[self.relations.slot[relation]]
            return self.evaluate.live(self.relations.alone[relation], {}).item()
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
            return join(self.level(operation["lhs"]), self.level(operation["rhs"]))
        if kind == "discrete":
            return self.evaluate(operation["expression"]).item()
        raise self.dae.refuse(f"a condition of kind {kind} is not supported", node["provenance"])

    def edge(self, i: int) -> SX:
        """Return whether condition `i` has just become true."""
        operation = self.dae.systems["conditions"]["conditions"][i]["operation"]
        if operation["kind"] == "any_rise":
            return ca.logic_or(self.edge(operation["lhs"]), self.edge(operation["rhs"]))
        if operation["kind"] in ("clock", "initial"):
            return self.level(i)
        if i not in self.edge_conditions:
            self.edge_conditions.append(i)
            self.last.append(SX.sym(f"last_condition{i}"))
        return ca.logic_and(self.level(i), ca.logic_not(self.last[self.edge_conditions.index(i)]))

    def active(self, activation: Node) -> SX:
        """Return whether an equation with this activation is active now."""
        return SX(1) if activation["kind"] == "always" else self.edge(activation["trigger"])
