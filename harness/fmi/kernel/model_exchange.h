/* A Model Exchange FMU with the buffers and addresses for its evaluation. */
#ifndef MODEL_EXCHANGE_H
#define MODEL_EXCHANGE_H

#include <stddef.h>

/* The call that ended an evaluation; exchange.py has their names in FMI. */
enum {
    FINE,
    SETTING_STATES,
    SETTING_INPUTS,
    GETTING_DERIVATIVES,
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

typedef struct {
    void *fmu;
    SetStates *set_states;
    SetReal *set_real;
    GetDerivatives *get_derivatives;
    GetReal *get_real;
    GetDirectional *get_directional; /* null: not provided */
    const unsigned *input_references, *output_references;
    const long long *place_of_state; /* position of each of the filter's states among the FMU's */
    double *states, *derivatives;    /* in the FMU's order */
    double *moved;
    const double *ones, *nominal;
    const Jacobian *by_state, *of_output;
    long long n_states, n_inputs, n_outputs;
    long long status, call, is_output, at; /* of the call that ended an evaluation */
    double relative_step;
} ModelExchange;

int derivative(ModelExchange *m, const double *x, const double *u, double *dx, double *entries);
int output(ModelExchange *m, const double *x, const double *u, double *y, double *entries);

#endif
