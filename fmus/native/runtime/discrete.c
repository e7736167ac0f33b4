/* FMI 2.0 for Co-Simulation of a function (state, input, parameter) -> (state, output) called once a period.
 *
 * The generated file comes first: sizes (NX states, NU inputs, NP parameters, NY outputs), PERIOD, tables of start
 * values, MODEL_GUID and f_step. WAITS is the number of leading inputs of which one must be nonzero for the first period
 * to begin; until then f_step is not called. With MEMORY, the words that hand-written C code works on, it has no states but `lay`, which initialises the words, and
 * `sample`, which advances them. A value reference is an index into State.v. */
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmi2Functions.h"

enum { TIME = 0, X = 1, U = X + NX, P = U + NU, Y = P + NP, NV = Y + NY };
enum { INSTANTIATED, INITIALIZING, RUNNING, FAILED, TERMINATED };

typedef struct {
    double v[NV];
    double start; /* time at which the first period begins */
    double calls; /* so far, so that time is never summed */
    double into;  /* elapsed share of the period since the last call; 0: the next call is due */
    int phase;
#ifdef MEMORY
    unsigned long long memory[MEMORY];
#endif
} State;

typedef struct {
    State s;
    fmi2CallbackFunctions callbacks;
    fmi2Boolean logging;
    char failure[512];
    double next_x[NX + 1], next_y[NY + 1];
    char name[1]; /* rest follows */
} Instance;

#include "instance.c"

static void reset(State *s) {
    memset(s, 0, sizeof *s);
    memcpy(s->v + X, start_x, NX * sizeof(double));
    memcpy(s->v + U, start_u, NU * sizeof(double));
    memcpy(s->v + P, start_p, NP * sizeof(double));
    memcpy(s->v + Y, start_y, NY * sizeof(double));
#ifdef MEMORY
    lay(s->memory);
#endif
}

static int begin(Instance *m, fmi2Type type) {
    if (type != fmi2CoSimulation) {
        refuse(m, "this FMU is for co-simulation only");
        return 0;
    }
    reset(&m->s);
    return 1;
}

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean has_tolerance, fmi2Real tolerance, fmi2Real start,
                               fmi2Boolean has_stop, fmi2Real stop) {
    (void)has_tolerance;
    (void)tolerance;
    (void)has_stop;
    (void)stop;
    if (M->s.phase != INSTANTIATED) return refuse(M, "fmi2SetupExperiment: only before initialisation");
    M->s.v[TIME] = M->s.start = start;
    return fmi2OK;
}
fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
    if (M->s.phase != INSTANTIATED) return refuse(M, "fmi2EnterInitializationMode: only once, after instantiation or reset");
    M->s.phase = INITIALIZING;
    return fmi2OK;
}
fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
    if (M->s.phase != INITIALIZING) return refuse(M, "fmi2ExitInitializationMode: not in initialisation mode");
    M->s.phase = RUNNING;
    return fmi2OK;
}

/* Whether no function has been called yet and all awaited inputs are zero: an importer may step an instance before it
 * has set any input. */
static int waits(const State *s) {
    int count = s->calls == 0 ? WAITS : 0, i = 0;
    while (i < count && s->v[U + i] == 0) i++;
    return count && i == count;
}

/* Call the function once with the present inputs. */
static int call(Instance *m) {
    State *s = &m->s;
#ifdef MEMORY
    if (sample(s->memory, (long long)s->calls, s->v + U, s->v + P, s->v + Y)) return 1;
#else
    const double *a[] = { s->v + X, s->v + U, s->v + P };
    double *r[] = { m->next_x, m->next_y };
    f_step(a, r);
    for (int i = 0; i < NX; i++)
        if (!isfinite(m->next_x[i])) return 1;
    memcpy(s->v + X, m->next_x, NX * sizeof(double));
    memcpy(s->v + Y, m->next_y, NY * sizeof(double));
#endif
    s->calls++;
    return 0;
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real t, fmi2Real h, fmi2Boolean no_set_state) {
    State *s = &M->s;
    double periods = h / PERIOD, whole = floor(periods + 0.5), fraction = floor(PERIOD / h + 0.5);
    (void)no_set_state;
    if (s->phase != RUNNING) return refuse(M, "fmi2DoStep: not initialised, or terminated");
    /* The importer's time may be a rounded sum: a deviation of a hundredth of a period is tolerated, a lost sample is not. */
    if (!(fabs(t - s->v[TIME]) <= 0.01 * PERIOD))
        return refuse(M, "fmi2DoStep: a step was requested from %.17g s, but this FMU is at %.17g s", t, s->v[TIME]);
    int is_whole = whole >= 1 && fabs(periods - whole) <= 0.01 && s->into == 0;
    if (!is_whole && !(h > 0 && fraction >= 1 && fabs(periods * fraction - 1) <= 0.01))
        return refuse(M, "fmi2DoStep: a step is a whole number of periods of %.9g s, or a whole part of one, got %.9g s",
                      (double)PERIOD, h);
    if (waits(s)) {
        s->v[TIME] = s->start = t + h;
        return fmi2OK;
    }
    for (double k = 0; s->into == 0 && k < (is_whole ? whole : 1); k++)
        if (call(M)) {
            s->phase = FAILED;
            return refuse(M, "fmi2DoStep: a state is not a number at time = %.9g s", s->v[TIME]);
        }
    if (!is_whole) s->into = floor(s->into * fraction + 1.5) / fraction;
    if (s->into >= 1) s->into = 0;
    s->v[TIME] = s->start + (s->into > 0 ? s->calls - 1 + s->into : s->calls) * PERIOD;
    return fmi2OK;
}
/* ---- values ---- */
fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real value[]) {
    for (size_t i = 0; i < n; i++) {
        if (vr[i] >= NV) return refuse(M, "there is no variable with value reference %u", vr[i]);
        value[i] = M->s.v[vr[i]];
    }
    return fmi2OK;
}
fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Real value[]) {
    for (size_t i = 0; i < n; i++) {
        fmi2ValueReference k = vr[i];
        int input = k >= U && k < P, before = k >= X && k < NV && M->s.phase < RUNNING;
        if (!input && !before)
            return refuse(M, "the variable with value reference %u cannot be set%s", k, k < NV ? " any more" : "");
        M->s.v[k] = value[i];
    }
    return fmi2OK;
}
#define NONE(NAME, TYPE, KIND)                                                                        \
    fmi2Status NAME(fmi2Component c, const fmi2ValueReference vr[], size_t n, TYPE value[]) { \
        (void)vr;                                                                                     \
        (void)value;                                                                                  \
        return n ? refuse(M, #NAME ": there are no " KIND " variables") : fmi2OK;                     \
    }
NONE(fmi2GetInteger, fmi2Integer, "Integer")
NONE(fmi2GetBoolean, fmi2Boolean, "Boolean")
NONE(fmi2SetInteger, const fmi2Integer, "Integer")
NONE(fmi2SetBoolean, const fmi2Boolean, "Boolean")

/* ---- not supported ---- */
fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference unknown[], size_t n_unknown,
                                        const fmi2ValueReference known[], size_t n_known, const fmi2Real along[],
                                        fmi2Real result[]) {
    (void)unknown;
    (void)n_unknown;
    (void)known;
    (void)n_known;
    (void)along;
    (void)result;
    return refuse(M, "fmi2GetDirectionalDerivative: not offered");
}
#include "status.c"
