/* A prediction FMU 2.0 with the buffers and addresses for its evaluation. */
#ifndef PREDICTION_H
#define PREDICTION_H

#include <stddef.h>

/* The call that ended an evaluation; exchange.py and stepped.py have their names in FMI. */
enum {
    FINE,
    RESTORING,
    SETTING_STATES,
    SETTING_INPUTS,
    INITIALISING,
    STEPPING,
    GETTING_DERIVATIVES,
    GETTING_STATES,
    GETTING_OUTPUTS,
    DIFFERENTIATING,
    VALUE_NOT_FINITE,
    ENTRY_NOT_FINITE
};

typedef int SetStates(void *, const double *, size_t);
typedef int GetDerivatives(void *, double *, size_t);
typedef int SetReal(void *, const unsigned *, size_t, const double *);
typedef int GetReal(void *, const unsigned *, size_t, double *);
typedef int GetDirectional(void *, const unsigned *, size_t, const unsigned *, size_t, const double *, double *);
typedef int Restore(void *, void *);
typedef int ExitInitialisation(void *);
typedef int DoStep(void *, double, double, int);

/* One sparse Jacobian with respect to the states; columns are grouped, and the entries of a group are adjacent. */
typedef struct {
    const long long *first_column;         /* of each group, and one beyond the last */
    const unsigned *known;                 /* value reference of each column's state, by groups */
    const long long *state;                /* index of each column's state, by groups */
    const long long *first_entry;          /* of each group, and one beyond the last */
    const unsigned *unknown;               /* value reference of each entry's row, by groups */
    const long long *column, *row, *place; /* of each entry, by groups; `place` is its position by rows */
    double *ahead, *behind;                /* buffers */
    long long n_groups, n_entries;
} Jacobian;

/* The pattern of a matrix by rows: first entry of each row, and one beyond the last; column of each entry. */
typedef struct {
    const long long *first, *column;
} Rows;

/* Of Co-Simulation only. */
typedef struct {
    DoStep *do_step;
    Restore *restore;
    ExitInitialisation *exit_initialisation; /* null: the saved state is after initialisation */
    void *saved;                             /* state of the whole FMU from which every step begins */
    const unsigned *state_references;
    const Rows *slope, *rate;   /* of df/dx and of the Jacobian of the rates */
    double *slopes;             /* entries of df/dx */
    double *power, *next_power; /* n x n; null: the rates are differentiated by differences */
    double period;
} Stepping;

typedef struct {
    void *fmu;
    SetStates *set_states;
    SetReal *set_real;
    GetDerivatives *get_derivatives;
    GetReal *get_real;
    GetDirectional *get_directional; /* null: not provided */
    const unsigned *input_references, *output_references;
    const long long *place_of_state; /* position of each of the filter's states among the FMU's */
    double *states, *derivatives;    /* in the FMU's order; in Co-Simulation in that of the filter */
    double *moved, *inputs;
    const double *ones, *nominal;
    const Jacobian *by_state, *of_output;
    const Stepping *stepping; /* null: Model Exchange */
    long long n_states, n_inputs, n_outputs;
    long long status, call, is_output, at; /* of the call that ended an evaluation */
    double relative_step;
} Prediction;

int derivative(Prediction *p, const double *x, const double *u, double *dx, double *entries);
int output(Prediction *p, const double *x, const double *u, double *y, double *entries);

#endif
