/* Definitions in the generated code, and the layout of the values of one instance.
 *
 * The generated file comes first: sizes (NX states, NU inputs, NP parameters of which NF may be set, NO algebraic
 * outputs, NL other algebraic variables, ND discretes, NR relations kept between events, NZ indicators, NC conditions, NT
 * clocks, NI instants, N_MOVING instants that change at events, SEARCHED 1 if indicators may become zero several times in a
 * step, NG and NQ unknowns of running and initial nonlinear loops, NA assertions (NA_RUNNING, NA_PARAMETERS, NA_START and
 * NA_EVENT of them, in this order), NM values in their messages, NJ entries of the solver's Jacobian, N_REPEATING discretes
 * whose change requires another event pass, ND_CALCULATED discretes whose value before the start is calculated; for Model
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
enum { RUNNING_CHECKS, PARAMETER_CHECKS, START_CHECKS, EVENT_CHECKS }; /* when an assertion is checked */
enum { WARNING, ASSERTION, DOMAIN_ERROR };                              /* its level */
enum { INSTANTIATED, INITIALIZING, RUNNING, FAILED, TERMINATED };

#define EVENT_TIME 1e-10 /* accuracy of the location of state events [s] */
/* Time events are evaluated just after their instant, so that `time > T` holds and floor(time/T) has its next value. */
#define AFTER(t) ((t) + 1e-14 * (1 + fabs(t)))
#define LEFT_PART 1e-3   /* part of a step after an event at whose end relations are checked for changes */
#define EVENT_EPS 1e-9   /* hysteresis of Model Exchange indicators */
/* Parts in which a communication step is searched for zeros of functions that may have several in one internal step: their
 * largest number, and their smallest size [s]. */
#define SEARCHED_PARTS 64
#define SEARCHED_TIME 1e-3
#define LOOP_TOLERANCE 1e-10
#define LOOP_JUMP 1e-2 /* relative change of an unknown of a loop in a step from which it is checked for a jump */
#define LOOP_ITERATIONS 50
#define EVENT_ITERATIONS 200
/* Limits of the number of internal steps in a communication step, including rejected ones and those that locate events: a
 * number for each second, a minimum, and a maximum of unused ones from earlier steps. Stops take three to thirty steps in
 * a millisecond. */
#define ATTEMPTS_PER_SECOND 300000
#define ATTEMPTS_AT_LEAST 300
#define ATTEMPTS_SAVED 20000

/* The whole model state, so that get, set and serialise FMU state are a single copy. */
typedef struct {
    double v[NV];
    double x0[NX + 1], d0[ND + 1];   /* before initialisation */
    double previous[ND + 1];         /* discretes before the event */
    double r[NR + 1], last[NC + 1];  /* relations and conditions at the last event */
    double g[NG + 1], q[NQ + 1];     /* unknowns of nonlinear loops */
    double settled_g[NG + 1];        /* Model Exchange: at the last event or completed step */
    double tick[NT + 1];             /* next instant of each clock */
    double instant[NI + 1];
    double moving;                   /* next of the instants that change at events */
    double lo, hi;                   /* no time event occurs between these times */
    double settled;                  /* Model Exchange: time of the last event or completed step */
    double h;                        /* internal step to try next */
    int phase;
    int inputs_set;                  /* since the last event iteration */
    double by_state[BY_STATE * (NX + NO) * NX + 1]; /* derivatives and outputs, by rows, differentiated by the states */
    int stale_parameters, stale_start, stale_derivatives, stale_outputs, stale_locals;
    int stale_state_jacobian, stale_output_jacobian;
    int unchecked_parameters;
    char x_set[NX + 1];
    char warned[NA + 1];             /* whether a warning has been given since its condition held */
    int warnings[NA + 1];
} State;

/* Work memory of one internal step; its content is not kept between calls. */
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
    double communication_step;
    double attempts;   /* remaining number of internal steps */
    char failure[512]; /* message of the last failure within a step */
    char name[1];      /* the other characters follow */
} Instance;

#define ARGUMENTS(s, t, x) { t, x, (s)->v + U, (s)->v + P, (s)->v + D, (s)->r, (s)->g }
