/* A stop, sample by sample: the parts that take part in it, and what they exchange. */
#ifndef CYCLE_H
#define CYCLE_H

#include "driver.h"
#include "export.h"
#include "faults.h"
#include "plausible.h"
#include "rail.h"
#include "sensors.h"

typedef int Cross(void *, int, double);
typedef int Advance(double *);
typedef void Call(double *, const double *, const double *, double *);

/* Why `cycle` returned: a part in Python is due, or the stop has ended. */
enum { BLOCK_DUE, PLANT_DUE, SENSORS_DUE, ESTIMATOR_DUE, CONTROLLER_DUE, LIMITS_DUE };
enum { STANDING = LIMITS_DUE + 1, AT_HORIZON, NOT_PLAUSIBLE, PLANT_FAILED, DIVERGED, NO_COMMAND };

enum { NEGATIVE_VARIANCE = -1 };                 /* beside the failures of the filter */
enum { BELIEVED = 1 + 3 * GROUPS, SPREAD = 2 * GROUPS, INNOVATION = 2, OBSERVATION = 2 + 6 * GROUPS };
enum { OBSERVED_PRESSURE = OBSERVATION - GROUPS };

typedef struct {
    Call *call;                                  /* null: it is not in C, or there is none */
    double *state;
    const double *parameter;
} Formula;

typedef struct {
    /* The plant; a null function is one in Python, which writes `truth`. */
    Cross *cross;
    void *set_step_get;
    double *taken;
    const double *shown;
    const long long *present;                    /* places of what is shown among all outputs */
    const double *slip_radius;                   /* null: the plant shows slip; else it follows from speeds and these radii */
    /* Instruments: a service train's, or outputs themselves, with errors if there is noise; both null are Python's, which write `reading`. */
    Service *service;
    const long long *read_of;
    const double *gain, *bias;
    double *noise;                               /* rows of READINGS for `block` samples from a multiple of it on */
    /* The filter; a null mean: there is none. A null function is one in Python, which works on the same arrays. */
    Advance *advance;
    double *memory, *held, *seen;
    const double *mean, *covariance, *squared, *used; /* of the last step: NIS, and 1 for every reading in it */
    const long long *seen_of, *believed_of;      /* places in a reading; among the states */
    const double *estimates;                     /* of an estimator in Python that gives quantities themselves; null: there is none */
    /* The law; a null function is a controller in Python, which writes `demand`. */
    Formula law, valves, free_wheel;
    Formula over;                                /* over a law in Python: takes its demands for the pressures that were read */
    const double *most;                          /* highest pressures, to which Python limits the demands of its law; null: it does not */
    long long is_pascal;                         /* whether the demands have been large enough to be in Pa; until then Python judges all */
    const double *law_state;                     /* of those states `law_of` are kept */
    const long long *law_of;
    const double *radius;
    Plausibility *plausibility;
    Rail *rail;
    Driver *driver;                              /* null: full brake */
    const double *full;                          /* pressures of that */
    Faults *faults;                              /* null: there are none */
    double period, stop_speed;
    double *rows;
    double truth[OUTPUTS], inputs[INPUTS], reading[READINGS], latest[READINGS], fresh[READINGS];
    double believed[BELIEVED], spread[SPREAD], innovation[INNOVATION];
    double observation[OBSERVATION];             /* what the controller is shown, in the order of controllers/law.py */
    double replaced[OBSERVATION];                /* by the estimates; NaN: it is as it is read */
    double reference[1 + GROUPS];                /* speed for the filter; 1 for each group that is to be released */
    double command[GROUPS], demand[GROUPS], driver_demand[GROUPS];   /* driver's: at the last decision */
    long long present_count, seen_count, estimates_count, law_count;
    long long width, capacity;                   /* numbers of a row; rows, the last for all samples beyond */
    long long block, samples;                    /* samples between two calls for noise; until the horizon */
    long long sensors_every;
    Every estimator_every, controller_every;
    long long row;                               /* from one row of the covariance to the next */
    long long true_at, sent_at, read_at, law_at; /* first columns */
    long long believed_at, spread_at, innovation_at, reference_at, estimates_at, demand_at, driver_at, traction_at; /* -1: it is not kept */
    long long any, news;                         /* whether a reading has come; one since the last step of the belief */
    long long crossed;                           /* steps of the plant that succeeded */
    long long stage, sample, written, failure;
    long long moved;                             /* whether the train has been faster than stop_speed */
} Cycle;

int cycle(Cycle *c);

#endif
