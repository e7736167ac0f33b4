"""Assignments from equations: index reduction, block triangular ordering, elimination in blocks, Newton's method.

Index reduction is Pantelides' algorithm, then static selection of dummy derivatives: a full matching of minimum cost
decides the states to keep; the cost of demoting a state depends on its attributes `stateSelect` and `fixed`. Sources:
Pantelides, SIAM J. Sci. Stat. Comput. 9 (1988) 213; Mattsson and Söderlind, SIAM J. Sci. Comput. 14 (1993) 677.
"""

from collections.abc import Iterator, Sequence, Set
from dataclasses import dataclass, field
from graphlib import TopologicalSorter

import casadi as ca
import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import connected_components, maximum_bipartite_matching, min_weight_full_bipartite_matching

from railgrip.base.errors import TranslationError
from railgrip.base.groups import gather
from railgrip.fmus.native.arrays import SX, is_number

LARGEST_LOOP = 24
"""Maximum number of unknowns of a nonlinear loop after elimination: the code of Newton's step grows cubically."""


@dataclass(frozen=True, slots=True)
class Equation:
    """A scalar equation `residual = 0` and its place in the source."""

    residual: SX
    where: str


@dataclass(slots=True)
class Loops:
    """Unknowns of nonlinear loops, solved at run time by Newton's method from their last values.

    In other expressions such an unknown is replaced by one symbolic Newton step from `guesses`. At a converged guess
    this is the solution, and because the residual is zero there, its derivative is that of the implicit function, so
    that Jacobians need no special treatment.

    Attributes:
        started: Names of unknowns with a start value; loops are solved for these and begin there.
        guesses: Name of an unknown → symbol of its last value.
        updates: Name → next Newton iterate.
        residuals: Name → residual at `guesses` of the equation matched with it.
        blocks: Names of the unknowns of each loop.
        divisors: Name of an unknown → its coefficient, where that is no number, and the place of its equation.
    """

    started: Set[str] = frozenset()
    guesses: dict[str, SX] = field(default_factory=dict)
    updates: dict[str, SX] = field(default_factory=dict)
    residuals: dict[str, SX] = field(default_factory=dict)
    blocks: list[tuple[str, ...]] = field(default_factory=list)
    divisors: dict[str, tuple[SX, str]] = field(default_factory=dict)

    def guess(self, unknown: SX) -> SX:
        """Return the symbol of the last value of `unknown`."""
        return self.guesses.setdefault(unknown.name(), SX.sym(f"guess({unknown.name()})"))


def solve(
    equations: Sequence[Equation], unknowns: Sequence[SX], targets: Sequence[SX], loops: Loops, owner: str
) -> list[SX]:
    """Return `targets` with the unknowns eliminated; only equations that they depend on are solved.

    Args:
        equations: Equations, as many as `unknowns`.
        unknowns: Unknowns to eliminate.
        targets: Expressions of the unknowns.
        loops: Receives the remaining nonlinear loops.
        owner: Class name for error messages.

    Raises:
        TranslationError: The system is not square, structurally singular, or has too large a nonlinear loop.
    """
    n = len(unknowns)
    if len(equations) != n:
        raise TranslationError(f"{owner}: {len(equations)} equations for {n} unknowns.")
    if not n:
        return list(targets)
    residuals, columns = ca.vertcat(*[e.residual for e in equations]), ca.vertcat(*unknowns)
    row, column = (np.array(k, dtype=int) for k in ca.jacobian_sparsity(residuals, columns).get_triplet())
    # Block lower triangular form: a matching, then strongly connected components in the order of their dependence.
    match = _matching(row, column, equations, unknowns, owner)
    target_columns = ca.jacobian_sparsity(SX(ca.vertcat(*targets)), columns).get_triplet()[1] if targets else []
    sides = _sides_equal_to_unknowns(equations, unknowns, match)
    names: list[SX] = []
    values: list[SX] = []
    newton: list[tuple[SX, SX]] = []
    divisors: list[tuple[str, SX, str]] = []
    for rows in _blocks(row, column, match, target_columns):
        block = [(equations[i], unknowns[int(match[i])]) for i in rows]
        side = sides.get(rows[0]) if len(block) == 1 else None
        if side is not None:
            names.append(block[0][1])
            values.append(side)
            continue
        assignments, core = _eliminate(block)
        if core and not _is_linear(core) and any(u.name() in loops.started for _, u in block):
            assignments, core = _eliminate(block, loops.started)
        if len(block) == 1 and assignments:
            slope = ca.jacobian(block[0][0].residual, block[0][1])
            if not is_number(slope):
                divisors.append((block[0][1].name(), slope, block[0][0].where))
        if core:
            core_values, pending = _solve_core(core, loops, owner)
            names.append(ca.vertcat(*[unknown for _, unknown in core]))
            values.append(core_values)
            newton += pending
        for unknown, expression in reversed(assignments):
            names.append(unknown)
            values.append(expression)
    residuals_of_loops = ca.vertcat(*[SX(residual) for _, residual in newton]) if newton else SX(0, 1)
    coefficients = [slope for _, slope, _ in divisors]
    expressions, out = ca.substitute_inplace(names, values, [*targets, *coefficients, residuals_of_loops])
    if newton:
        solution = dict(
            zip(
                (s.name() for v in names for s in ca.vertsplit(v)),
                (e for v in expressions for e in ca.vertsplit(v)),
                strict=True,
            )
        )
        for (unknown, _), residual in zip(newton, ca.vertsplit(out[-1]), strict=True):
            # The event system has the same loops with the same guesses; the update of the first system is kept.
            loops.updates.setdefault(unknown.name(), solution[unknown.name()])
            loops.residuals.setdefault(unknown.name(), residual)
    for (name, _, where), coefficient in zip(divisors, out[len(targets) :], strict=False):
        loops.divisors.setdefault(name, (SX(coefficient), where))
    return list(out[: len(targets)])


def _matching(
    row: np.ndarray, column: np.ndarray, equations: Sequence[Equation], unknowns: Sequence[SX], owner: str
) -> np.ndarray:
    n = len(unknowns)
    pattern = csr_matrix((np.ones(len(row)), (row, column)), shape=(n, n))
    match = np.asarray(maximum_bipartite_matching(pattern, perm_type="column"))
    if (match < 0).any():
        spare = sorted(set(range(n)) - set(match.tolist()))
        raise TranslationError(
            f"{owner}: structurally singular: no unknown left for the equation at "
            + ", ".join(equations[int(i)].where for i in np.flatnonzero(match < 0))
            + "; no equation left for "
            + ", ".join(unknowns[j].name() for j in spare)
            + "."
        )
    return match


def _blocks(
    row: np.ndarray, column: np.ndarray, match: np.ndarray, target_columns: Sequence[int]
) -> Iterator[list[int]]:
    # The rows of each block that targets depend on, in the order of dependence.
    n = len(match)
    equation_of = np.empty(n, dtype=int)
    equation_of[match] = np.arange(n)
    graph = csr_matrix((np.ones(len(row)), (row, equation_of[column])), shape=(n, n))
    _, label = connected_components(graph, directed=True, connection="strong")
    before: dict[int, set[int]] = {int(k): set() for k in label}
    for i, j in zip(label[row].tolist(), label[equation_of[column]].tolist(), strict=True):
        if i != j:
            before[i].add(j)
    members = gather((k, i) for i, k in enumerate(label.tolist()))
    order = list(TopologicalSorter(before).static_order())
    # A block is solved as a whole, so a value that depends on one of its rows depends on all of them.
    needed = set(label[equation_of[list(target_columns)]].tolist())
    for k in reversed(order):
        if k in needed:
            needed |= before[k]
    return (members[k] for k in order if k in needed)


def _eliminate(
    block: list[tuple[Equation, SX]], last: Set[str] = frozenset()
) -> tuple[list[tuple[SX, SX]], list[tuple[Equation, SX]]]:
    """Solve equations of a block that are linear in an unknown with a constant number as its coefficient.

    Only numbers are pivots: a pivot that is an expression may become zero at run time. Unknowns with names in `last`
    are eliminated after the others.

    Returns:
        (unknown, expression) in the order of elimination, each in terms of later ones; and the remaining equations.
    """
    equations, unknowns = [e for e, _ in block], [u for _, u in block]
    if len(block) == 1:
        slope = ca.jacobian(equations[0].residual, unknowns[0])
        if ca.depends_on(slope, unknowns[0]):
            return [], block
        rest = ca.substitute(equations[0].residual, unknowns[0], SX(0))
        return [(unknowns[0], -rest / slope)], []
    assignments: list[tuple[SX, SX]] = []
    while len(equations) > 1:
        columns = ca.vertcat(*unknowns)
        jacobian = ca.jacobian(ca.vertcat(*[e.residual for e in equations]), columns)
        rows, cols = jacobian.sparsity().get_triplet()
        in_row, in_col = (np.bincount(places, minlength=len(unknowns)) for places in (rows, cols))
        pivots = [
            (unknowns[j].name() in last, int((in_row[i] - 1) * (in_col[j] - 1)), i, j)
            for k, (i, j) in enumerate(zip(rows, cols, strict=True))
            if is_number(jacobian.nz[k]) and float(jacobian.nz[k]) != 0.0
        ]
        if not pivots:
            break
        *_, i, j = min(pivots)  # minimum fill-in (Markowitz)
        unknown, equation = unknowns.pop(j), equations.pop(i)
        expression = -ca.substitute(equation.residual, unknown, SX(0)) / jacobian[i, j]
        assignments.append((unknown, expression))
        residuals = ca.substitute([e.residual for e in equations], [unknown], [expression])
        equations = [Equation(r, e.where) for r, e in zip(residuals, equations, strict=True)]
    if len(equations) == 1:
        rest, core = _eliminate([(equations[0], unknowns[0])])
        return assignments + rest, core
    return assignments, list(zip(equations, unknowns, strict=True))


def _sides_equal_to_unknowns(equations: Sequence[Equation], unknowns: Sequence[SX], match: np.ndarray) -> dict[int, SX]:
    # Most equations are `unknown = expression`. The result is that of the general case, in a tenth of the time. The
    # dependences of all are computed together, because each call has a fixed cost.
    places, others = list[int](), list[SX]()
    for i, equation in enumerate(equations):
        if equation.residual.is_op(ca.OP_SUB):
            sides = equation.residual.dep(0), equation.residual.dep(1)
            unknown = unknowns[int(match[i])].element_hash()
            for side, other in (sides, sides[::-1]):
                if side.element_hash() == unknown:
                    places.append(i)
                    others.append(other)
                    break
    if not others:
        return {}
    rows, columns = ca.jacobian_sparsity(ca.vertcat(*others), ca.vertcat(*unknowns)).get_triplet()
    implicit = {k for k, j in zip(rows, columns, strict=True) if j == match[places[k]]}
    return {i: other for k, (i, other) in enumerate(zip(places, others, strict=True)) if k not in implicit}


def _is_linear(core: list[tuple[Equation, SX]]) -> bool:
    unknowns = ca.vertcat(*[u for _, u in core])
    return not ca.depends_on(ca.jacobian(ca.vertcat(*[e.residual for e, _ in core]), unknowns), unknowns)


def _solve_core(core: list[tuple[Equation, SX]], loops: Loops, owner: str) -> tuple[SX, list[tuple[SX, SX]]]:
    unknowns = ca.vertcat(*[u for _, u in core])
    residuals = ca.vertcat(*[e.residual for e, _ in core])
    matrix = ca.jacobian(residuals, unknowns)
    if _is_linear(core):
        return ca.densify(ca.solve(matrix, -ca.substitute(residuals, unknowns, SX.zeros(len(core))))), []
    if len(core) > LARGEST_LOOP:
        raise TranslationError(
            f"{owner}: a nonlinear loop of {len(core)} unknowns, at most {LARGEST_LOOP} are supported: "
            + ", ".join(f"{u.name()} ({e.where})" for e, u in core)
        )
    loops.blocks.append(tuple(u.name() for _, u in core))
    guess = ca.vertcat(*[loops.guess(u) for _, u in core])
    at, value = ca.substitute([matrix, residuals], [unknowns], [guess])
    # One Newton step, solved symbolically; the runtime iterates it.
    step = value / at if len(core) == 1 else ca.solve(at, value)
    return ca.densify(guess - step), [(u, value[i]) for i, (_, u) in enumerate(core)]


RELUCTANCE = {"Never": 0.01, "Avoid": 0.1, "Default": 1.0, "Prefer": 10.0, "Always": 1000.0}
"""Cost of demoting a state, by its stateSelect."""

DEEPEST = 8
"""Number of differentiations of one equation after which a model counts as singular; mechanics requires three."""


@dataclass(frozen=True, slots=True, kw_only=True)
class IndexOne:
    """An index-1 system.

    Attributes:
        unknowns: Unknowns to solve for, as many as `equations`.
        states: Pairs of a state and its derivative; a state may be the derivative of a former one.
        former_states: Names of states that became algebraic unknowns.
        constraints: Equations of the model that were differentiated.
        index: Differential index of the model: the largest number of differentiations of an equation, and one.
    """

    equations: list[Equation]
    unknowns: list[SX]
    states: list[tuple[SX, SX]]
    former_states: frozenset[str]
    constraints: tuple[Equation, ...] = ()
    index: int = 1


def reduce_index(
    equations: Sequence[Equation],
    time: SX,
    inputs: SX,
    states: Sequence[SX],
    derivatives: Sequence[SX],
    algebraics: Sequence[SX],
    cost: Sequence[float],
    owner: str,
) -> IndexOne:
    """Differentiate equations until the highest derivatives and the algebraic unknowns can be solved for.

    Args:
        equations: Equations of the model.
        time: Symbol of time.
        inputs: Symbols of the inputs.
        states: States.
        derivatives: Derivatives of `states`.
        algebraics: Algebraic unknowns.
        cost: Cost of demoting each state.
        owner: Class name for error messages.

    Raises:
        TranslationError: The system is singular, or an equation with an input would have to be differentiated.
    """
    n = len(states)
    if not equations and not n and not algebraics:  # discrete variables alone
        return IndexOne(equations=[], unknowns=[], states=[], former_states=frozenset())
    system = _Pantelides(
        equations=list(equations),
        symbols=[*states, *derivatives, *algebraics],
        derivative_of={i: n + i for i in range(n)},
        time=time,
        inputs=inputs,
        owner=owner,
    )
    for first in range(len(equations)):
        system.assign(first)
    symbols, derivative_of = system.symbols, system.derivative_of
    # A symbol without a derivative must be solved for, so it costs less than any with one. Among the latter, those that
    # are not states of the model are demoted first, so they cost less than any RELUCTANCE.
    demotion_cost = [*cost, *[0.001] * (len(symbols) - n)]
    weight = [1.0 + demotion_cost[i] if i in derivative_of else 0.5 for i in range(len(symbols))]
    unknown_places = _select_unknowns(system.contains, symbols, weight, derivative_of.keys(), owner)
    state_places = [v for v in range(len(symbols)) if v not in unknown_places]
    return IndexOne(
        equations=system.equations,
        unknowns=[symbols[v] for v in sorted(unknown_places)],
        states=[(symbols[v], symbols[derivative_of[v]]) for v in state_places],
        former_states=frozenset(symbols[i].name() for i in range(n) if i in unknown_places),
        constraints=tuple(e for q, e in enumerate(equations) if q in system.derivative_of_equation),
        index=1 + max(map(system.differentiations, range(len(equations))), default=0),
    )


@dataclass(slots=True, kw_only=True)
class _Pantelides:
    """A system during index reduction: equations and symbols, referred to by their places, and their matching.

    Attributes:
        equations: Equations of the model, then derivatives of some.
        symbols: Symbols of the model, then derivatives of some.
        derivative_of: Place of a symbol → place of its derivative.
        contains: Places of the symbols in each equation.
        place: Hash of a symbol → its place.
        derivative_of_equation: Place of an equation → place of its derivative.
        match: Place of a symbol → place of the equation that determines it.
    """

    equations: list[Equation]
    symbols: list[SX]
    derivative_of: dict[int, int]
    time: SX
    inputs: SX
    owner: str
    contains: list[set[int]] = field(init=False)
    place: dict[int, int] = field(init=False)
    derivative_of_equation: dict[int, int] = field(default_factory=dict[int, int])
    match: dict[int, int] = field(default_factory=dict[int, int])

    def __post_init__(self) -> None:
        self.place = {symbol.element_hash(): place for place, symbol in enumerate(self.symbols)}
        self.contains = self._incidence([e.residual for e in self.equations])

    def assign(self, first: int) -> None:
        """Match an equation, differentiated as often as necessary, with a symbol that it determines."""
        e = first
        for _ in range(DEEPEST):
            seen_equations, seen_variables = set[int](), set[int]()
            if self._augment(e, seen_equations, seen_variables):
                return
            where = self.equations[e].where
            if not seen_variables and not any(v in self.derivative_of for v in self.contains[e]):
                raise TranslationError(f"{where}: {self.owner}: this equation has no unknown left to determine.")
            # Pantelides: the equations of a failed search are a minimal structurally singular subset; differentiate
            # them.
            for v in sorted(seen_variables):
                self.derivative_of[v] = len(self.symbols)
                self.symbols.append(SX.sym(f"der({self.symbols[v].name()})"))
                self.place[self.symbols[-1].element_hash()] = self.derivative_of[v]
            for q in sorted(seen_equations):
                self._differentiate(q)
            for v in sorted(seen_variables):
                self.match[self.derivative_of[v]] = self.derivative_of_equation[self.match[v]]
            e = self.derivative_of_equation[e]
        where = self.equations[first].where
        raise TranslationError(f"{where}: {self.owner}: singular: differentiating this equation does not help.")

    def differentiations(self, equation: int) -> int:
        """Return how often an equation was differentiated."""
        following = self.derivative_of_equation.get(equation)
        return 0 if following is None else 1 + self.differentiations(following)

    def _highest(self, equation: int) -> list[int]:
        return sorted(v for v in self.contains[equation] if v not in self.derivative_of)

    def _augment(self, root: int, seen_equations: set[int], seen_variables: set[int]) -> bool:
        # Depth first with an explicit stack: recursion would exceed Python's limit on large models.
        stack = [(root, iter(self._highest(root)))]
        path: list[tuple[int, int]] = []
        seen_equations.add(root)
        while stack:
            e, candidates = stack[-1]
            free = next((v for v in self._highest(e) if v not in self.match), None)
            if free is not None:
                self.match[free] = e
                for equation, variable in path:
                    self.match[variable] = equation
                return True
            for v in candidates:
                if v not in seen_variables:
                    seen_variables.add(v)
                    path.append((e, v))
                    following = self.match[v]
                    seen_equations.add(following)
                    stack.append((following, iter(self._highest(following))))
                    break
            else:
                stack.pop()
                if path:
                    path.pop()
        return False

    def _differentiate(self, q: int) -> None:
        e = self.equations[q]
        if self.inputs.numel() and ca.depends_on(e.residual, self.inputs):
            raise TranslationError(
                f"{e.where}: {self.owner}: this equation must be differentiated to find the states, "
                "but it contains an input."
            )
        terms = sorted(self.contains[q])
        along = ca.jtimes(
            e.residual,
            ca.vertcat(*[self.symbols[v] for v in terms]),
            ca.vertcat(*[self.symbols[self.derivative_of[v]] for v in terms]),
        )
        self.derivative_of_equation[q] = len(self.equations)
        self.equations.append(Equation(along + ca.jacobian(e.residual, self.time), e.where))
        self.contains.extend(self._incidence([self.equations[-1].residual]))

    def _incidence(self, residuals: Sequence[SX]) -> list[set[int]]:
        found = [set[int]() for _ in residuals]
        column = ca.vertcat(*residuals)
        used = [s for s in ca.symvar(column) if s.element_hash() in self.place]
        if used:  # a derivative has few of all symbols
            for i, j in zip(*ca.jacobian_sparsity(column, ca.vertcat(*used)).get_triplet(), strict=True):
                found[i].add(self.place[used[j].element_hash()])
        return found


def _select_unknowns(
    contains: Sequence[set[int]], symbols: Sequence[SX], weight: Sequence[float], differentiated: Set[int], owner: str
) -> set[int]:
    # The unknowns of a matching are solved for; the cheapest matching therefore demotes the cheapest states. Every
    # symbol without a derivative must be among them.
    rows, columns = zip(*[(e, v) for e, symbols_of in enumerate(contains) for v in symbols_of], strict=True)
    weights = csr_matrix(([weight[v] for v in columns], (rows, columns)), shape=(len(contains), len(symbols)))
    try:
        _, matching = min_weight_full_bipartite_matching(weights)
    except ValueError as error:
        raise TranslationError(f"{owner}: structurally singular after index reduction.") from error
    places = set(matching.tolist())
    missing = [symbols[v].name() for v in range(len(symbols)) if v not in differentiated and v not in places]
    if missing:
        raise TranslationError(f"{owner}: structurally singular: no equation left for {', '.join(missing)}.")
    return places
