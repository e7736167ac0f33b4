/* What the generated code defines, and how the values of one instance lie in memory.
 *
 * The generated file comes first: sizes (NX states, NU inputs, NP parameters of which NF may be set, NO algebraic
 * outputs, NL other algebraic variables, ND discretes, NR remembered relations, NZ indicators, NC conditions, NT
 * clocks, NI instants, NG and NQ unknowns of running and initial nonlinear loops, NA assertions, NM values in their
 * messages, NJ entries of the solver's Jacobian, N_LOUD discretes whose change asks for another event pass; for Model
 * Exchange BY_STATE is 1 and NSJ and NOJ count the entries of the Jacobians of derivatives and outputs by the states),
 * tables, and the functions f_*. */
#include <float.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmi2Functions.h"

/* A value reference is an index into State.v. */
enum {
    TIME = 0,
    X = 1,
    DX = X + NX,
    U = DX + NX,
    P = U + NU,
    O = P + NP,
    L = O + NO,
    D = L + NL,
    TOLERANCE = D + ND,
    SOLVER,
    STEPS,
    REJECTED,
    JACOBIANS,
    EVALUATIONS,
    EVENTS,
    NV
};
enum { INSTANTIATED, INITIALIZING, RUNNING, FAILED, TERMINATED };

#define EVENT_TIME 1e-10 /* s: state events are located this closely */
#define EVENT_EPS 1e-9   /* hysteresis of Model Exchange indicators */
#define LOOP_TOLERANCE 1e-10
#define LOOP_ITERATIONS 50
#define EVENT_ITERATIONS 200
/* Internal steps, rejected ones and those that locate events too, that a communication step may take: a number for each
 * second, a minimum, and those saved in earlier steps. Stops take three to thirty in a millisecond. */
#define ATTEMPTS_PER_SECOND 300000
#define ATTEMPTS_AT_LEAST 300
#define ATTEMPTS_SAVED 20000

/* Everything that is model state, so that get, set and serialise FMU state are one copy. */
typedef struct {
    double v[NV];
    double x0[NX + 1], d0[ND + 1];   /* before initialisation */
    double previous[ND + 1];         /* discretes before the event */
    double r[NR + 1], last[NC + 1];  /* remembered relations and conditions */
    double g[NG + 1], q[NQ + 1];     /* unknowns of nonlinear loops */
    double tick[NT + 1];             /* next instant of each clock */
    double instant[NI + 1];
    double lo, hi;                   /* nothing timed happens between these */
    double h;                        /* internal step to try next */
    int phase;
    int inputs_set;                  /* since the last event iteration */
    double by_state[BY_STATE * (NX + NO) * NX + 1]; /* derivatives and outputs, by rows, differentiated by the states */
    int stale_parameters, stale_start, stale_derivatives, stale_outputs, stale_locals;
    int stale_state_jacobian, stale_output_jacobian;
    char x_set[NX + 1];
    char warned[NA + 1];
} State;

/* Room for one internal step; nothing here outlives a call. */
typedef struct {
    double x0[NX + 1], x1[NX + 1], y[NX + 1], f[NX + 1], f0[NX + 1], ft[NX + 1], error[NX + 1];
    double k[6][NX + 1];
    double jacobian[NJ + 1], lu[NLU + 1];
    double dense[NX * NX + 1];
    int pivot[NX + 1], is_dense;
    double z0[NZ + 1], z1[NZ + 1];
} Work;

typedef struct {
    State s;
    Work w;
    fmi2CallbackFunctions callbacks;
    fmi2Boolean logging;
    int co_simulation;
    double attempts;   /* internal steps that may still be tried */
    char failure[512]; /* sentence of the last failure inside a step */
    char name[1];      /* rest follows */
} Instance;

#define ARGUMENTS(s, t, x) { t, x, (s)->v + U, (s)->v + P, (s)->v + D, (s)->r, (s)->g }
