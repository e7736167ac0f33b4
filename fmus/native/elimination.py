"""Sparse elimination fixed when the FMU is built: (I·c − J) = LU without pivoting.

The pivots of I·c − J of a Rosenbrock method are its diagonal; the order in which they are taken is chosen once, for
least fill-in. `runtime/elimination.c` factors along tables of it; solving, done several times as often, is written out.
A tiny pivot is reported, and the caller pivots densely.
Source: Sandu et al., Atmospheric Environment 31 (1997) 3459 (the approach of KPP).
"""

from collections.abc import Sequence
from dataclasses import dataclass

from railgrip.fmus.native.ctext import in_parts, table

MOST_ENTRIES = 10_000
"""Entries of LU above which solving takes too long to compile; then elimination is dense."""

LONGEST = 100
"""Lines of one part of the solution; a line of the backward substitution may hold many entries."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Elimination:
    """The elimination of one sparsity pattern.

    Attributes:
        code: C tables for `runtime/elimination.c`, and `sparse_solve(a, b)`.
        entries: Length of `a`; 0 when elimination is dense.
    """

    code: str
    entries: int


def eliminate(n: int, pattern: list[tuple[int, int]]) -> Elimination:
    """Return the elimination for the nonzeros of J, given as (row, column) in the order of its values.

    Pivot by pivot, `a` holds the pivot's inverse, what is right of it in U and what is below it in L.
    """
    order, rows = _order(n, pattern)
    position = {v: k for k, v in enumerate(order)}
    right = {k: [j for j in sorted(rows[k]) if position[j] > position[k]] for k in order}
    below = {k: [i for i in range(n) if k in rows[i] and position[i] > position[k]] for k in order}
    at: dict[tuple[int, int], int] = {}
    for k in order:
        for place in ((k, k), *((k, j) for j in right[k]), *((i, k) for i in below[k])):
            at[place] = len(at)
    tables = {
        "lu_jacobian": [at[place] for place in pattern],
        "lu_diagonal": [at[i, i] for i in range(n)],
        "lu_right": [len(right[k]) for k in order],
        "lu_below": [len(below[k]) for k in order],
        "lu_target": [at[i, j] for k in order for i in below[k] for j in right[k]],
    }
    solution = [f"b[{i}] -= a[{at[i, k]}] * b[{k}];" for k in order for i in below[k]]
    for i in reversed(order):
        terms = "".join(f" - a[{at[i, j]}] * b[{j}]" for j in right[i])
        solution.append(f"b[{i}] = (b[{i}]{terms}) * a[{at[i, i]}];")
    if len(at) > MOST_ENTRIES:
        at, tables, solution = {}, {name: [] for name in tables}, []
    lines = [*(table("int", name, values) for name, values in tables.items()), *_solve(solution)]
    return Elimination(code="\n".join(lines), entries=len(at))


def _solve(lines: Sequence[str]) -> list[str]:
    parts = [lines[k : k + LONGEST] for k in range(0, len(lines), LONGEST)]
    return [
        *in_parts("solve", "const double *restrict a, double *restrict b", parts),
        "static void sparse_solve(const double *a, double *b) {",
        f"    for (int k = 0; k < {len(parts)}; k++) solve_parts[k](a, b);",
        "}",
    ]


def _order(n: int, pattern: list[tuple[int, int]]) -> tuple[list[int], list[set[int]]]:
    """Return the pivots by Markowitz' rule, and the columns of each row with the fill-in they make."""
    rows: list[set[int]] = [{i} for i in range(n)]
    columns: list[set[int]] = [{i} for i in range(n)]
    for i, j in pattern:
        rows[i].add(j)
        columns[j].add(i)
    rest = set(range(n))
    order: list[int] = []
    while rest:
        k = min(rest, key=lambda v: ((len(rows[v] & rest) - 1) * (len(columns[v] & rest) - 1), v))
        rest.remove(k)
        order.append(k)
        for i in columns[k] & rest:
            rows[i] |= rows[k] & rest
        for j in rows[k] & rest:
            columns[j] |= columns[k] & rest
    return order, rows
