"""Sparse elimination fixed when the FMU is built: (I·c − J) = LU without pivoting.

The pivots of I·c − J in a Rosenbrock method are its diagonal elements. Their order is chosen once, for minimum fill-in,
and factorisation and solution are generated as straight-line code. A tiny pivot is reported, and the caller then uses
dense elimination with pivoting. Source: Sandu et al., Atmospheric Environment 31 (1997) 3459 (the approach of KPP).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

from railgrip.fmus.native.c_source import in_parts

MAX_ENTRIES, MAX_PRODUCTS = 10_000, 10_000
"""Entries of LU, and products of the factorisation, above which compiling takes too long; elimination is dense then."""

LONGEST = 100
"""Lines of one part; a line may have many entries."""

SMALLEST_PIVOT = 1e-7
"""Smallest pivot in units of c: below it the diagonal has cancelled, and half of the digits may be lost."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Elimination:
    """The elimination of one sparsity pattern.

    Attributes:
        code: C code of `int sparse_factor(jacobian, c, a)`, which returns 1 for a tiny pivot, and `sparse_solve(a, b)`.
        entries: Length of `a`; 0 if elimination is dense.
    """

    code: str
    entries: int


def eliminate(n: int, pattern: list[tuple[int, int]]) -> Elimination:
    """Return the elimination for the nonzeros of J, given as (row, column) in the order of its values.

    For each pivot, `a` has the inverse of the pivot, the row of U to its right and the column of L below it.
    """
    order, rows = _order(n, pattern)
    position = {v: k for k, v in enumerate(order)}
    right = {k: [j for j in sorted(rows[k]) if position[j] > position[k]] for k in order}
    below = {k: [i for i in range(n) if k in rows[i] and position[i] > position[k]] for k in order}
    at: dict[tuple[int, int], int] = {}
    for k in order:
        for place in ((k, k), *((k, j) for j in right[k]), *((i, k) for i in below[k])):
            at[place] = len(at)
    if len(at) > MAX_ENTRIES or sum(len(below[k]) * len(right[k]) for k in order) > MAX_PRODUCTS:
        order, at, pattern = [], {}, []
    sums = {(i, j): "c" if i == j else "0" for i, j in at}
    for m, place in enumerate(pattern):
        sums[place] += f" - jacobian[{m}]"
    for k in order:
        for i, j in product(below[k], right[k]):
            sums[i, j] += f" - a[{at[i, k]}] * a[{at[k, j]}]"
    factors: list[str] = []
    for (i, j), value in sums.items():
        to = f"a[{at[i, j]}]"
        if i == j:
            factors.append(f"{to} = {value}; *tiny |= !(fabs({to}) > {SMALLEST_PIVOT} * c); {to} = 1 / {to};")
        else:
            factors.append(f"{to} = ({value}) * a[{at[j, j]}];" if position[i] > position[j] else f"{to} = {value};")
    solution = [f"b[{i}] -= a[{at[i, k]}] * b[{k}];" for k in order for i in below[k]]
    for i in reversed(order):
        terms = "".join(f" - a[{at[i, j]}] * b[{j}]" for j in right[i])
        solution.append(f"b[{i}] = (b[{i}]{terms}) * a[{at[i, i]}];")
    lines = [
        *in_parts(
            "factor",
            "const double *restrict jacobian, double c, double *restrict a, int *restrict tiny",
            _parts(factors),
        ),
        "static int sparse_factor(const double *jacobian, double c, double *a) {",
        f"    int tiny = {int(not at)};",
        f"    for (int k = 0; k < {len(_parts(factors))}; k++) factor_parts[k](jacobian, c, a, &tiny);",
        "    return tiny;",
        "}",
        *in_parts("solve", "const double *restrict a, double *restrict b", _parts(solution)),
        "static void sparse_solve(const double *a, double *b) {",
        f"    for (int k = 0; k < {len(_parts(solution))}; k++) solve_parts[k](a, b);",
        "}",
    ]
    return Elimination(code="\n".join(lines), entries=len(at))


def _parts(lines: Sequence[str]) -> list[Sequence[str]]:
    return [lines[k : k + LONGEST] for k in range(0, len(lines), LONGEST)]


def _order(n: int, pattern: list[tuple[int, int]]) -> tuple[list[int], list[set[int]]]:
    rows: list[set[int]] = [{i} for i in range(n)]
    columns: list[set[int]] = [{i} for i in range(n)]
    for i, j in pattern:
        rows[i].add(j)
        columns[j].add(i)
    rest = set(range(n))
    order: list[int] = []
    while rest:
        # Markowitz: the product bounds the number of new nonzeros; the number breaks ties, for reproducible code.
        k = min(rest, key=lambda v: ((len(rows[v] & rest) - 1) * (len(columns[v] & rest) - 1), v))
        rest.remove(k)
        order.append(k)
        for i in columns[k] & rest:
            rows[i] |= rows[k] & rest
        for j in rows[k] & rest:
            columns[j] |= columns[k] & rest
    return order, rows
