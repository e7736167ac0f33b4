/* A prediction FMU as functions f(x, u) and y = h(x, u) with sparse Jacobians, by functions of FMI 2.0.

   With Model Exchange f is dx/dt. With Co-Simulation the FMU itself integrates over a period T, from x to X, and f is the
   mean rate (X - x)/T: a step of forward Euler with it is the step of the FMU, and I + T df/dx is dX/dx.

   States and their derivatives are in the order of the filter here and in the FMU's order in `states` and
   `derivatives`; entries of Jacobians are by rows. */

#include <math.h>
#include <stddef.h>
#include <string.h>

#include "prediction.h"

#if defined(_WIN32)
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif

typedef int Values(Prediction *, double *);

static int failed(Prediction *p, int status, int call)
{
    p->status = status;
    return status == 0 || status == 1 ? FINE : (p->call = call); /* fmi2OK, fmi2Warning */
}

/* FMI 2.0 does not allow to set the states of a slave between two steps. Each step therefore begins in a saved state of
   the FMU: in its initialisation, where states with a start value may be set, or, for FMUs that allow it, after. */
static int restart(Prediction *p, const double *x)
{
    const Stepping *s = p->stepping;

    memcpy(p->states, x, (size_t)p->n_states * sizeof *x);
    if (failed(p, s->restore(p->fmu, s->saved), RESTORING) ||
        failed(p, p->set_real(p->fmu, s->state_references, (size_t)p->n_states, x), SETTING_STATES))
        return p->call;
    if (p->n_inputs &&
        failed(p, p->set_real(p->fmu, p->input_references, (size_t)p->n_inputs, p->inputs), SETTING_INPUTS))
        return p->call;
    return s->exit_initialisation ? failed(p, s->exit_initialisation(p->fmu), INITIALISING) : FINE;
}

static int set_states(Prediction *p, const double *x)
{
    const long long *place = p->place_of_state;
    double *states = p->states;

    if (p->stepping)
        return restart(p, x);
    for (long long i = 0; i < p->n_states; i++)
        states[place[i]] = x[i];
    return failed(p, p->set_states(p->fmu, states, (size_t)p->n_states), SETTING_STATES);
}

static int set_inputs(Prediction *p, const double *u)
{
    if (!u || !p->n_inputs)
        return FINE;
    memcpy(p->inputs, u, (size_t)p->n_inputs * sizeof *u);
    if (p->stepping)
        return FINE; /* `restart` sets them */
    return failed(p, p->set_real(p->fmu, p->input_references, (size_t)p->n_inputs, u), SETTING_INPUTS);
}

static int get_derivatives(Prediction *p, double *dx)
{
    const long long *place = p->place_of_state;
    const double *derivatives = p->derivatives;

    if (failed(p, p->get_derivatives(p->fmu, p->derivatives, (size_t)p->n_states), GETTING_DERIVATIVES))
        return p->call;
    for (long long i = 0; i < p->n_states; i++)
        dx[i] = derivatives[place[i]];
    return FINE;
}

/* Mean rates over the period from the states that were set last. */
static int get_rates(Prediction *p, double *rate)
{
    const Stepping *s = p->stepping;
    const double *states = p->states;

    if (failed(p, s->do_step(p->fmu, 0.0, s->period, 0), STEPPING) ||
        failed(p, p->get_real(p->fmu, s->state_references, (size_t)p->n_states, rate), GETTING_STATES))
        return p->call;
    for (long long i = 0; i < p->n_states; i++)
        rate[i] = (rate[i] - states[i]) / s->period;
    return FINE;
}

static int get_outputs(Prediction *p, double *y)
{
    return failed(p, p->get_real(p->fmu, p->output_references, (size_t)p->n_outputs, y), GETTING_OUTPUTS);
}

/* Entries at the FMU's present point: one call for the columns of a group, of which no two have an entry in one row. */
static int directional(Prediction *p, const Jacobian *j, double *entries)
{
    const long long *first = j->first_entry, *column = j->first_column, *place = j->place;
    const double *result = j->ahead;

    for (long long g = 0; g < j->n_groups; g++) {
        const long long count = first[g + 1] - first[g];
        const int status = p->get_directional(p->fmu, j->unknown + first[g], (size_t)count, j->known + column[g],
                                              (size_t)(column[g + 1] - column[g]), p->ones, j->ahead);
        if (failed(p, status, DIFFERENTIATING))
            return p->call;
        for (long long k = 0; k < count; k++)
            entries[place[first[g] + k]] = result[k];
    }
    return FINE;
}

/* The same by central differences around x, for an FMU without directional derivatives; it leaves the FMU at another
   point. */
static int differences(Prediction *p, const Jacobian *j, const double *x, Values *values, double *entries)
{
    const long long *first = j->first_entry, *column = j->first_column, *of = j->column, *row = j->row,
                    *state = j->state;
    const double *nominal = p->nominal, *ahead = j->ahead, *behind = j->behind;
    double *moved = p->moved;

    for (long long g = 0; g < j->n_groups; g++) {
        for (int side = 0; side < 2; side++) {
            for (long long i = 0; i < p->n_states; i++)
                moved[i] = x[i];
            for (long long c = column[g]; c < column[g + 1]; c++) {
                const double step = p->relative_step * fmax(fabs(x[state[c]]), nominal[state[c]]);
                moved[state[c]] = side ? x[state[c]] - step : x[state[c]] + step;
            }
            if (set_states(p, moved) || values(p, side ? j->behind : j->ahead))
                return p->call;
        }
        for (long long k = first[g]; k < first[g + 1]; k++) {
            const double at = x[of[k]], step = p->relative_step * fmax(fabs(at), nominal[of[k]]);
            /* Divide by the difference of the rounded points, which is not exactly twice the step. */
            entries[j->place[k]] = (ahead[row[k]] - behind[row[k]]) / ((at + step) - (at - step));
        }
    }
    return FINE;
}

/* row += factor * other */
static inline void add(long long n, double *restrict row, double factor, const double *restrict other)
{
    for (long long i = 0; i < n; i++)
        row[i] += factor * other[i];
}

/* Jacobian of the rates from A, that of the derivatives at the start of the period: (exp(T A) - 1)/T by the Taylor
   polynomial that a filter has for Model Exchange, A (1 + T A/2 (1 + T A/3 (1 + T A/4))). */
static void series(const Prediction *p, double *entries)
{
    const Stepping *s = p->stepping;
    const long long n = p->n_states, *first = s->slope->first, *column = s->slope->column, *to = s->rate->column;
    const double *slopes = s->slopes;
    double *last = s->power, *next = s->next_power;

    for (int k = 4; k > 0; k--) {
        const double factor = k > 1 ? s->period / k : 1.0;
        memset(next, 0, (size_t)(n * n) * sizeof *next);
        for (long long i = 0; i < n; i++) {
            for (long long at = first[i]; at < first[i + 1]; at++)
                if (k == 4)
                    next[i * n + column[at]] = factor * slopes[at];
                else
                    add(n, next + i * n, factor * slopes[at], last + column[at] * n);
            if (k > 1)
                next[i * n + i] += 1.0;
        }
        double *other = last;
        last = next;
        next = other;
    }
    for (long long i = 0; i < n; i++)
        for (long long at = s->rate->first[i]; at < s->rate->first[i + 1]; at++)
            entries[at] = last[i * n + to[at]];
}

static int all_finite(Prediction *p, const double *values, long long count, int call)
{
    double sum = 0.0;

    /* NaN and infinity survive a sum: one test instead of `count` in the usual case; an overflow is cleared below. */
    for (long long i = 0; i < count; i++)
        sum += values[i];
    if (isfinite(sum))
        return FINE;
    for (long long i = 0; i < count; i++)
        if (!isfinite(values[i])) {
            p->at = i;
            return p->call = call;
        }
    return FINE;
}

/* Jacobian first, then the value: OpenModelica's FMUs (to 1.27.0) evaluate only the derivatives for fmi2GetDerivatives
   but then mark everything as evaluated, so that directional derivatives after it would be those of an earlier
   point. */
static int evaluate(Prediction *p, const Jacobian *j, const double *x, const double *u, Values *values,
                    long long count, double *value, double *entries)
{
    const int expands = entries && j == p->by_state && p->stepping && p->stepping->power;
    double *at_start = expands ? p->stepping->slopes : entries;

    p->call = FINE;
    p->is_output = j == p->of_output;
    if (set_inputs(p, u) || (entries && !p->get_directional && differences(p, j, x, values, entries)) ||
        set_states(p, x) || (entries && p->get_directional && directional(p, j, at_start)) || values(p, value) ||
        all_finite(p, value, count, VALUE_NOT_FINITE))
        return p->call;
    if (entries && all_finite(p, at_start, j->n_entries, ENTRY_NOT_FINITE))
        return p->call;
    if (expands)
        series(p, entries);
    return FINE;
}

/* f at x and, unless `entries` is null, its Jacobian; if u is null, the inputs keep their values. */
EXPORT int derivative(Prediction *p, const double *x, const double *u, double *dx, double *entries)
{
    return evaluate(p, p->by_state, x, u, p->stepping ? get_rates : get_derivatives, p->n_states, dx, entries);
}

/* The outputs, with the same arguments. */
EXPORT int output(Prediction *p, const double *x, const double *u, double *y, double *entries)
{
    return evaluate(p, p->of_output, x, u, get_outputs, p->n_outputs, y, entries);
}
