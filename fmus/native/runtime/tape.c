/* Functions that no step calls are not compiled but kept as tapes, lists of operations that this interpreter plays:
 * a C compiler needs ten times as long for an operation as for a line of a table.
 *
 * OPERATIONS(_), in the generated file, lists them as _(name, value), names and meaning are CasADi's; x and y are the
 * operands. */

#include <math.h>
#include <stddef.h>

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
