"""Structural index reduction: Pantelides' algorithm, then static selection of dummy derivatives.

Sources: Pantelides, SIAM J. Sci. Stat. Comput. 9 (1988) 213; Mattsson and Söderlind, SIAM J. Sci. Comput. 14
(1993) 677. The states to keep follow from a full matching of minimum cost, in which the cost of demoting a state
depends on its attributes `stateSelect` and `fixed`.
"""

from collections.abc import Sequence, Set
from dataclasses import dataclass, field

import casadi as ca
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import min_weight_full_bipartite_matching

from railgrip.base.errors import TranslationError
from railgrip.fmus.native.arrays import SX
from railgrip.fmus.native.structure import Equation

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
    """

    equations: list[Equation]
    unknowns: list[SX]
    states: list[tuple[SX, SX]]
    former_states: frozenset[str]


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
