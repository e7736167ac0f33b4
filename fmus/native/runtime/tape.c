/* Functions that no step calls are not compiled but kept as tapes, lists of operations that this interpreter plays:
 * a C compiler needs ten times as long for an operation as for a line of a table.
 *
 * Names and meaning of the operations are CasADi's; x and y are the operands. */

#include <math.h>
#include <stddef.h>

#define OPERATIONS(_)                                                                                              \
    _(OP_ASSIGN, x) _(OP_LIFT, x) _(OP_ADD, x + y) _(OP_SUB, x - y) _(OP_MUL, x * y) _(OP_DIV, x / y)              \
    _(OP_NEG, -x) _(OP_INV, 1 / x) _(OP_SQ, x * x) _(OP_TWICE, 2 * x) _(OP_SQRT, sqrt(x)) _(OP_POW, pow(x, y))     \
    _(OP_CONSTPOW, pow(x, y)) _(OP_EXP, exp(x)) _(OP_EXPM1, expm1(x)) _(OP_LOG, log(x)) _(OP_LOG1P, log1p(x))      \
    _(OP_SIN, sin(x)) _(OP_COS, cos(x)) _(OP_TAN, tan(x)) _(OP_ASIN, asin(x)) _(OP_ACOS, acos(x))                  \
    _(OP_ATAN, atan(x)) _(OP_ATAN2, atan2(x, y)) _(OP_SINH, sinh(x)) _(OP_COSH, cosh(x)) _(OP_TANH, tanh(x))       \
    _(OP_ASINH, asinh(x)) _(OP_ACOSH, acosh(x)) _(OP_ATANH, atanh(x)) _(OP_ERF, erf(x)) _(OP_HYPOT, hypot(x, y))   \
    _(OP_FABS, fabs(x)) _(OP_SIGN, x > 0 ? 1 : x < 0 ? -1 : x) _(OP_COPYSIGN, copysign(x, y))                      \
    _(OP_FLOOR, floor(x)) _(OP_CEIL, ceil(x)) _(OP_FMOD, fmod(x, y)) _(OP_REMAINDER, remainder(x, y))              \
    _(OP_FMIN, fmin(x, y)) _(OP_FMAX, fmax(x, y)) _(OP_LT, x < y) _(OP_LE, x <= y) _(OP_EQ, x == y)                \
    _(OP_NE, x != y) _(OP_NOT, !x) _(OP_AND, x && y) _(OP_OR, x || y) _(OP_IF_ELSE_ZERO, x ? y : 0)

#define ENUMERATOR(name, value) name,
enum { OP_CONST, OP_INPUT, OP_OUTPUT, OPERATIONS(ENUMERATOR) };

/* w[to] = a op b; or constants[a], arguments[a][b], and results[to][b] = w[a]. */
typedef struct {
    unsigned short operation, to, a, b;
} Operation;

#define CASE(name, value) \
    case name:            \
        w[o->to] = value; \
        break;
static void play(const Operation *o, size_t count, const double *constants, const double **arguments, double **results,
                 double *w) {
    for (const Operation *end = o + count; o < end; o++) {
        double x, y;
        switch (o->operation) {
        case OP_CONST:
            w[o->to] = constants[o->a];
            continue;
        case OP_INPUT:
            w[o->to] = arguments[o->a][o->b];
            continue;
        case OP_OUTPUT:
            results[o->to][o->b] = w[o->a];
            continue;
        default:
            break;
        }
        x = w[o->a];
        y = w[o->b];
        switch (o->operation) { OPERATIONS(CASE) }
    }
}
