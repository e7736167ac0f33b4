/* One communication step of a co-simulation FMU.

   The vectors of the harness hold doubles in its units and order; a channel has the positions of its values in the
   vector, their factors, and the fmi2Set or fmi2Get function for them. */
#ifndef SET_STEP_GET_H
#define SET_STEP_GET_H

#include <stddef.h>

enum { SET = 1, STEP = 2, GET = 4 };                   /* actions of `exchange`, to be combined */
enum { FINE, SETTING, STEPPING, GETTING, NOT_FINITE }; /* action that failed */

typedef int Transfer(void *, const unsigned *, size_t, void *);
typedef int DoStep(void *, double, double, int);

typedef struct {
    Transfer *transfer; /* fmi2Set or fmi2Get for the type of the values */
    const unsigned *references;
    const long long *positions; /* in the harness's vector */
    const double *gain, *shift; /* null when units agree */
    void *buffer;               /* count doubles, or count ints when `whole` */
    long long count, whole;
} Channel;

typedef struct {
    void *fmu;
    DoStep *step;
    Channel *senders, *receivers;
    long long n_senders, n_receivers, n_outputs;
    double *inputs;
    double *outputs;      /* NaN for outputs that the FMU lacks */
    double period, begin; /* begin: time of the FMU at the start */
    long long done;       /* steps of `follow` that succeeded */
    long long warnings;   /* calls that returned one */
    long long status, at; /* of the call that failed; index of its channel or output */
} SetStepGet;

int exchange(SetStepGet *c, int actions, double time);
int set_step_get(SetStepGet *c, double time);
int follow(SetStepGet *c, long long count, long long first, const double *inputs, long long width, double *outputs);

#endif
