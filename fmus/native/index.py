"""Structural index reduction: Pantelides' algorithm, then static selection of dummy derivatives.

Sources: Pantelides, SIAM J. Sci. Stat. Comput. 9 (1988) 213; Mattsson and Söderlind, SIAM J. Sci. Comput. 14
(1993) 677. The states to keep are found as a full matching of least cost, where demoting a state costs what
its `stateSelect` and `fixed` attributes say.
"""

from collections.abc import Sequence, Set
from dataclasses import dataclass

import casadi as ca
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import min_weight_full_bipartite_matching

from railgrip.base.errors import TranslationError
from railgrip.fmus.native.arrays import SX
from railgrip.fmus.native.structure import Equation

RELUCTANCE = {"Never": 0.01, "Avoid": 0.1, "Default": 1.0, "Prefer": 10.0, "Always": 1000.0}
"""Cost of demoting a state, by its stateSelect."""

DEEPEST = 8
"""Differentiations of one equation after which a model counts as singular; mechanics needs three."""


@dataclass(frozen=True, slots=True, kw_only=True)
class IndexOne:
    """An index-1 system.

    Attributes:
        unknowns: To be solved for, as many as `equations`.
        states: (state, its derivative), states that were kept or made.
        former_states: Names of former states.
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
        states: With `derivatives`, one for one, and `cost`, what demoting each costs.

    Raises:
        TranslationError: The system is singular, or an equation with an input would have to be differentiated.
    """
    symbols = [*states, *derivatives, *algebraics]
    n = len(states)
    derivative_of = {i: n + i for i in range(n)}
    work = list(equations)
    derivative_of_equation: dict[int, int] = {}
    match: dict[int, int] = {}

    def incidence(residuals: Sequence[SX]) -> list[set[int]]:
        """Return the symbols in each residual."""
        found = [set[int]() for _ in residuals]
        pattern = ca.jacobian_sparsity(ca.vertcat(*residuals), ca.vertcat(*symbols))
        for i, j in zip(*pattern.get_triplet(), strict=True):
            found[i].add(j)
        return found

    contains = incidence([e.residual for e in work])

    def augment(root: int, seen_equations: set[int], seen_variables: set[int]) -> bool:
        """Find an augmenting path, depth first, without the recursion that large models would exhaust."""
        stack = [(root, iter(sorted(v for v in contains[root] if v not in derivative_of)))]
        path: list[tuple[int, int]] = []
        seen_equations.add(root)
        while stack:
            e, candidates = stack[-1]
            free = next((v for v in sorted(contains[e]) if v not in derivative_of and v not in match), None)
            if free is not None:
                match[free] = e
                for equation, variable in path:
                    match[variable] = equation
                return True
            for v in candidates:
                if v not in seen_variables:
                    seen_variables.add(v)
                    path.append((e, v))
                    following = match[v]
                    seen_equations.add(following)
                    stack.append((following, iter(sorted(w for w in contains[following] if w not in derivative_of))))
                    break
            else:
                stack.pop()
                if path:
                    path.pop()
        return False

    def differentiate(q: int) -> None:
        e = work[q]
        if inputs.numel() and ca.depends_on(e.residual, inputs):
            raise TranslationError(
                f"{e.where}: {owner}: this equation must be differentiated to find the states, "
                "but it contains an input."
            )
        terms = sorted(contains[q])
        along = ca.jtimes(
            e.residual,
            ca.vertcat(*[symbols[v] for v in terms]),
            ca.vertcat(*[symbols[derivative_of[v]] for v in terms]),
        )
        derivative_of_equation[q] = len(work)
        work.append(Equation(along + ca.jacobian(e.residual, time), e.where))
        contains.extend(incidence([work[-1].residual]))

    for first in range(len(equations)):
        e = first
        for _ in range(DEEPEST):
            seen_equations, seen_variables = set[int](), set[int]()
            if augment(e, seen_equations, seen_variables):
                break
            if not seen_variables and not any(v in derivative_of for v in contains[e]):
                raise TranslationError(f"{work[e].where}: {owner}: this equation has no unknown left to determine.")
            for v in sorted(seen_variables):
                derivative_of[v] = len(symbols)
                symbols.append(SX.sym(f"der({symbols[v].name()})"))
            for q in sorted(seen_equations):
                differentiate(q)
            for v in sorted(seen_variables):
                match[derivative_of[v]] = derivative_of_equation[match[v]]
            e = derivative_of_equation[e]
        else:
            raise TranslationError(
                f"{work[first].where}: {owner}: singular: differentiating this equation leads nowhere."
            )

    own_cost = [*cost, *[0.001] * (len(symbols) - n)]
    price = [1.0 + own_cost[i] if i in derivative_of else 0.5 for i in range(len(symbols))]
    unknown_places = _solved_for(contains, symbols, price, derivative_of.keys(), owner)
    state_places = [v for v in range(len(symbols)) if v not in unknown_places]
    return IndexOne(
        equations=work,
        unknowns=[symbols[v] for v in sorted(unknown_places)],
        states=[(symbols[v], symbols[derivative_of[v]]) for v in state_places],
        former_states=frozenset(symbols[i].name() for i in range(n) if i in unknown_places),
    )


def _solved_for(
    contains: Sequence[set[int]], symbols: Sequence[SX], price: Sequence[float], differentiated: Set[int], owner: str
) -> set[int]:
    """Return the places of the symbols to solve for: all without a derivative, of the others the cheapest.

    Args:
        contains: Places of the symbols in each equation.
        price: Of solving for each symbol.
        differentiated: Places of the symbols whose derivative is a symbol, too.

    Raises:
        TranslationError: No such choice solves every equation.
    """
    rows, columns = zip(*[(e, v) for e, own in enumerate(contains) for v in own], strict=True)
    weight = csr_matrix(([price[v] for v in columns], (rows, columns)), shape=(len(contains), len(symbols)))
    try:
        _, matching = min_weight_full_bipartite_matching(weight)
    except ValueError as error:
        raise TranslationError(f"{owner}: structurally singular after index reduction.") from error
    places = set(matching.tolist())
    missing = [symbols[v].name() for v in range(len(symbols)) if v not in differentiated and v not in places]
    if missing:
        raise TranslationError(f"{owner}: structurally singular: no equation left for {', '.join(missing)}.")
    return places
