"""Assignments from equations: block triangular ordering, elimination within blocks, Newton's method for loops."""

from collections.abc import Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass, field
from graphlib import TopologicalSorter

import casadi as ca
import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import connected_components, maximum_bipartite_matching

from railgrip.base.errors import TranslationError
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

    started: AbstractSet[str] = frozenset()
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
    dependencies = _dependencies(row, column, match, target_columns)
    names: list[SX] = []
    values: list[SX] = []
    newton: list[tuple[SX, SX]] = []
    divisors: list[tuple[str, SX, str]] = []
    for rows in _blocks(row, column, match):
        if rows[0] not in dependencies:
            continue
        block = [(equations[i], unknowns[int(match[i])]) for i in rows]
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
    solution = dict(
        zip(
            (s.name() for v in names for s in ca.vertsplit(v)),
            (e for v in expressions for e in ca.vertsplit(v)),
            strict=True,
        )
    )
    for (unknown, _), residual in zip(newton, ca.vertsplit(out[-1]) if newton else [], strict=True):
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


def _dependencies(row: np.ndarray, column: np.ndarray, match: np.ndarray, target_columns: Sequence[int]) -> set[int]:
    # A block is solved as a whole, so a value that depends on one of its rows depends on all of them.
    equation_of = {j: i for i, j in enumerate(match.tolist())}
    uses: dict[int, list[int]] = {}
    for i, j in zip(row.tolist(), column.tolist(), strict=True):
        uses.setdefault(i, []).append(equation_of[j])
    rows: set[int] = set()
    stack = [equation_of[j] for j in target_columns]
    while stack:
        i = stack.pop()
        if i not in rows:
            rows.add(i)
            stack += uses[i]
    return rows


def _blocks(row: np.ndarray, column: np.ndarray, match: np.ndarray) -> list[list[int]]:
    n = len(match)
    equation_of = np.empty(n, dtype=int)
    equation_of[match] = np.arange(n)
    graph = csr_matrix((np.ones(len(row)), (row, equation_of[column])), shape=(n, n))
    _, label = connected_components(graph, directed=True, connection="strong")
    before: dict[int, set[int]] = {int(k): set() for k in label}
    for i, j in zip(label[row].tolist(), label[equation_of[column]].tolist(), strict=True):
        if i != j:
            before[i].add(j)
    members: dict[int, list[int]] = {}
    for i, k in enumerate(label.tolist()):
        members.setdefault(k, []).append(i)
    return [members[k] for k in TopologicalSorter(before).static_order()]


def _eliminate(
    block: list[tuple[Equation, SX]], last: AbstractSet[str] = frozenset()
) -> tuple[list[tuple[SX, SX]], list[tuple[Equation, SX]]]:
    """Solve equations of a block that are linear in an unknown with a constant number as its coefficient.

    Only numbers are pivots: a pivot that is an expression may become zero at run time. Unknowns with names in `last`
    are eliminated after the others.

    Returns:
        (unknown, expression) in the order of elimination, each in terms of later ones; and the remaining equations.
    """
    equations, unknowns = [e for e, _ in block], [u for _, u in block]
    if len(block) == 1:
        value = _side_equal_to(equations[0].residual, unknowns[0])
        if value is not None:
            return [(unknowns[0], value)], []
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


def _side_equal_to(residual: SX, unknown: SX) -> SX | None:
    # Most equations are `unknown = expression`. The result is that of the general case, in a tenth of the time.
    if residual.is_op(ca.OP_SUB):
        sides = residual.dep(0), residual.dep(1)
        for side, other in (sides, sides[::-1]):
            if side.element_hash() == unknown.element_hash() and not ca.depends_on(other, unknown):
                return other
    return None


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
