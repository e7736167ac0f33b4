"""Sparse elimination fixed when the FMU is built: straight-line C for (I·c − J) = LU without pivoting.

The pivots of I·c − J of a Rosenbrock method are its diagonal; the order in which they are taken is chosen
once, for least fill-in, and every operation is written out. A tiny pivot is reported, and the caller pivots
densely.
Source: Sandu et al., Atmospheric Environment 31 (1997) 3459 (the approach of KPP).
"""

from dataclasses import dataclass

MOST_OPERATIONS = 60_000
"""Multiply-adds above which straight-line code takes too long to compile; then elimination is dense."""

LONGEST = 100
"""Lines of one C function of the factorisation: compilers need more than twice the time for twice the length.

The functions are called through a table of pointers, lest a compiler put them together again.
"""

SMALLEST_PIVOT = 1e-7
"""In units of c: below it the diagonal has cancelled, and without pivoting half the digits may be lost."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Elimination:
    """C functions for one sparsity pattern.

    Attributes:
        code: `sparse_factor(jacobian, c, a)` (0 when done, 1 when a pivot is tiny) and `sparse_solve(a, b)`.
        entries: Length of `a`.
        operations: Multiply-adds of one factorisation.
    """

    code: str
    entries: int
    operations: int


def eliminate(n: int, pattern: list[tuple[int, int]]) -> Elimination:
    """Return the elimination for the nonzeros of J, given as (row, column) in the order of its values."""
    order, rows = _order(n, pattern)
    at = {(i, j): k for k, (i, j) in enumerate((i, j) for i in range(n) for j in sorted(rows[i]))}
    position = {v: k for k, v in enumerate(order)}
    work: list[str] = []
    operations = 0
    for k in order:
        work.append(f"    if (!(fabs(a[{at[k, k]}]) > {SMALLEST_PIVOT!r} * c)) return 1;")
        work.append(f"    a[{at[k, k]}] = 1 / a[{at[k, k]}];")
        below = [i for i in range(n) if k in rows[i] and position[i] > position[k]]
        right = [j for j in sorted(rows[k]) if position[j] > position[k]]
        for i in below:
            work.append(f"    a[{at[i, k]}] *= a[{at[k, k]}];")
            work += [f"    a[{at[i, j]}] -= a[{at[i, k]}] * a[{at[k, j]}];" for j in right]
            operations += 1 + len(right)
    if operations > MOST_OPERATIONS:
        return Elimination(code=_DENSE, entries=0, operations=n**3 // 3)
    values = {at[i, j]: f"-jacobian[{k}]" for k, (i, j) in enumerate(pattern)}
    for i in range(n):
        values[at[i, i]] = f"c {'- ' + values[at[i, i]][1:] if at[i, i] in values else ''}".rstrip()
    load = [f"    a[{k}] = {values.get(k, '0')};" for k in range(len(at))]
    forward = [
        f"    b[{i}] -= a[{at[i, k]}] * b[{k}];"
        for i in order
        for k in sorted(rows[i], key=position.__getitem__)
        if position[k] < position[i]
    ]
    backward: list[str] = []
    for i in reversed(order):
        later = [j for j in sorted(rows[i]) if position[j] > position[i]]
        terms = "".join(f" - a[{at[i, j]}] * b[{j}]" for j in later)
        backward.append(f"    b[{i}] = (b[{i}]{terms}) * a[{at[i, i]}];")
    arguments = "(const double *restrict jacobian, double c, double *restrict a)"
    parts: list[str] = []
    for k, part in enumerate([load, *(work[k : k + LONGEST] for k in range(0, len(work), LONGEST))]):
        parts += [f"static int factor{k}{arguments} {{", "    (void)jacobian; (void)c; (void)a;"]
        parts += [*part, "    return 0;", "}"]
    count = sum(line.startswith("static") for line in parts)
    code = "\n".join(
        [
            *parts,
            f"static int (*const factor_parts[]){arguments} = {{",
            f"    {', '.join(f'factor{k}' for k in range(count))}",
            "};",
            f"static int sparse_factor{arguments} {{",
            f"    for (int k = 0; k < {count}; k++)",
            "        if (factor_parts[k](jacobian, c, a)) return 1;",
            "    return 0;",
            "}",
            "static void sparse_solve(const double *restrict a, double *restrict b) {",
            *forward,
            *backward,
            "}",
        ]
    )
    return Elimination(code=code, entries=len(at), operations=operations)


_DENSE = """static int sparse_factor(const double *jacobian, double c, double *a) {
    (void)jacobian; (void)c; (void)a;
    return 1;
}
static void sparse_solve(const double *a, double *b) { (void)a; (void)b; }"""


def _order(n: int, pattern: list[tuple[int, int]]) -> tuple[list[int], list[set[int]]]:
    """Return the pivots by Markowitz' rule, and the columns of each row with the fill-in they make."""
    rows: list[set[int]] = [{i} for i in range(n)]
    columns: list[set[int]] = [{i} for i in range(n)]
    for i, j in pattern:
        rows[i].add(j)
        columns[j].add(i)
    left = set(range(n))
    order: list[int] = []
    while left:
        k = min(left, key=lambda v: ((len(rows[v] & left) - 1) * (len(columns[v] & left) - 1), v))
        left.remove(k)
        order.append(k)
        for i in columns[k] & left:
            rows[i] |= rows[k] & left
        for j in rows[k] & left:
            columns[j] |= columns[k] & left
    return order, rows
