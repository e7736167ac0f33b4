"""CasADi functions as C, with one function that calls any of them."""

from collections.abc import Sequence

import casadi as ca

_CALL = """
typedef int Function(const double **, double **, casadi_int *, double *, int);

static int call(Function *function, const double **arguments, double **results)
{
    casadi_int integers[WHOLE];
    double work[WORK];
    return function(arguments, results, integers, work, 0);
}
"""


def in_c(functions: Sequence[ca.Function]) -> tuple[dict[str, int], str]:
    """Return the sizes of work arrays as macros, and C of the functions with `call`, which calls any of them."""
    generator = ca.CodeGenerator("model", {"with_header": False, "casadi_int": "int"})
    for function in functions:
        generator.add(function)
    sizes = {
        "ARGUMENTS": max(function.sz_arg() for function in functions),
        "RESULTS": max(function.sz_res() for function in functions),
        # One more than needed, since C knows no empty arrays.
        "WHOLE": 1 + max(function.sz_iw() for function in functions),
        "WORK": 1 + max(function.sz_w() for function in functions),
    }
    return sizes, generator.dump() + _CALL
