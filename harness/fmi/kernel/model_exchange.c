/* A Model Exchange FMU as the functions dx/dt = f(x, u) and y = h(x, u) with sparse Jacobians, by functions of FMI 2.0.

   States and their derivatives are in the order of the filter here and in the FMU's order in `states` and
   `derivatives`; entries of Jacobians are by rows. */

#include <math.h>
#include <stddef.h>

#include "model_exchange.h"

#if defined(_WIN32)
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif

typedef int Values(ModelExchange *, double *);

static int failed(ModelExchange *m, int status, int call)
{
    m->status = status;
    return status == 0 || status == 1 ? FINE : (m->call = call); /* fmi2OK, fmi2Warning */
}

static int set_states(ModelExchange *m, const double *x)
{
    const long long *place = m->place_of_state;
    double *states = m->states;

    for (long long i = 0; i < m->n_states; i++)
        states[place[i]] = x[i];
    return failed(m, m->set_states(m->fmu, states, (size_t)m->n_states), SETTING_STATES);
}

static int set_inputs(ModelExchange *m, const double *u)
{
    if (!u || !m->n_inputs)
        return FINE;
    return failed(m, m->set_real(m->fmu, m->input_references, (size_t)m->n_inputs, u), SETTING_INPUTS);
}

static int get_derivatives(ModelExchange *m, double *dx)
{
    const long long *place = m->place_of_state;
    const double *derivatives = m->derivatives;

    if (failed(m, m->get_derivatives(m->fmu, m->derivatives, (size_t)m->n_states), GETTING_DERIVATIVES))
        return m->call;
    for (long long i = 0; i < m->n_states; i++)
        dx[i] = derivatives[place[i]];
    return FINE;
}

static int get_outputs(ModelExchange *m, double *y)
{
    return failed(m, m->get_real(m->fmu, m->output_references, (size_t)m->n_outputs, y), GETTING_OUTPUTS);
}

/* Entries at the FMU's present point: one call for the columns of a group, of which no two have an entry in one row. */
static int directional(ModelExchange *m, const Jacobian *j, double *entries)
{
    const long long *first = j->first_entry, *column = j->first_column, *place = j->place;
    const double *result = j->ahead;

    for (long long g = 0; g < j->n_groups; g++) {
        const long long count = first[g + 1] - first[g];
        const int status = m->get_directional(m->fmu, j->unknown + first[g], (size_t)count, j->known + column[g],
                                              (size_t)(column[g + 1] - column[g]), m->ones, j->ahead);
        if (failed(m, status, DIFFERENTIATING))
            return m->call;
        for (long long k = 0; k < count; k++)
            entries[place[first[g] + k]] = result[k];
    }
    return FINE;
}

/* The same by central differences around x, for an FMU without directional derivatives; it leaves the FMU at another
   point. */
static int differences(ModelExchange *m, const Jacobian *j, const double *x, Values *values, double *entries)
{
    const long long *first = j->first_entry, *column = j->first_column, *of = j->column, *row = j->row,
                    *state = j->state;
    const double *nominal = m->nominal, *ahead = j->ahead, *behind = j->behind;
    double *moved = m->moved;

    for (long long g = 0; g < j->n_groups; g++) {
        for (int side = 0; side < 2; side++) {
            for (long long i = 0; i < m->n_states; i++)
                moved[i] = x[i];
            for (long long c = column[g]; c < column[g + 1]; c++) {
                const double step = m->relative_step * fmax(fabs(x[state[c]]), nominal[state[c]]);
                moved[state[c]] = side ? x[state[c]] - step : x[state[c]] + step;
            }
            if (set_states(m, moved) || values(m, side ? j->behind : j->ahead))
                return m->call;
        }
        for (long long k = first[g]; k < first[g + 1]; k++) {
            const double at = x[of[k]], step = m->relative_step * fmax(fabs(at), nominal[of[k]]);
            /* Divide by the difference of the rounded points, which is not exactly twice the step. */
            entries[j->place[k]] = (ahead[row[k]] - behind[row[k]]) / ((at + step) - (at - step));
        }
    }
    return FINE;
}

static int all_finite(ModelExchange *m, const double *values, long long count, int call)
{
    double sum = 0.0;

    /* NaN and infinity survive a sum: one test instead of `count` in the usual case; an overflow is cleared below. */
    for (long long i = 0; i < count; i++)
        sum += values[i];
    if (isfinite(sum))
        return FINE;
    for (long long i = 0; i < count; i++)
        if (!isfinite(values[i])) {
            m->at = i;
            return m->call = call;
        }
    return FINE;
}

/* Jacobian first, then the value: OpenModelica's FMUs (to 1.27.0) evaluate only the derivatives for fmi2GetDerivatives
   but then mark everything as evaluated, so that directional derivatives after it would be those of an earlier
   point. */
static int evaluate(ModelExchange *m, const Jacobian *j, const double *x, const double *u, Values *values,
                    long long count, double *value, double *entries)
{
    m->call = FINE;
    m->is_output = j == m->of_output;
    if (set_inputs(m, u) || (entries && !m->get_directional && differences(m, j, x, values, entries)) ||
        set_states(m, x) || (entries && m->get_directional && directional(m, j, entries)) || values(m, value) ||
        all_finite(m, value, count, VALUE_NOT_FINITE))
        return m->call;
    return entries ? all_finite(m, entries, j->n_entries, ENTRY_NOT_FINITE) : FINE;
}

/* dx/dt at x and, unless `entries` is null, its Jacobian; if u is null, the inputs keep their values. */
EXPORT int derivative(ModelExchange *m, const double *x, const double *u, double *dx, double *entries)
{
    return evaluate(m, m->by_state, x, u, get_derivatives, m->n_states, dx, entries);
}

/* The outputs, with the same arguments. */
EXPORT int output(ModelExchange *m, const double *x, const double *u, double *y, double *entries)
{
    return evaluate(m, m->of_output, x, u, get_outputs, m->n_outputs, y, entries);
}
