/* A stop, sample by sample: its parts, and the signals that they exchange. */
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

enum { NEGATIVE_VARIANCE = -1 };                 /* in addition to the failures of the filter */
enum { STATES = ESTIMATE_ADHESION_SD };          /* estimates that are states of a filter; standard deviations follow them */

typedef struct {
    Call *call;                                  /* null: the part is not in C, or does not exist */
    double *state;
    const double *parameter;
} Formula;

typedef struct {
    /* The plant. Null functions: the plant is in Python and writes `truth`. */
    Cross *cross;
    void *set_step_get;
    double *taken;
    const double *shown;
    const long long *present;                    /* positions of `shown` among all outputs */
    const double *slip_radius;                   /* null: the plant outputs slip; else the radii to compute slip with */
    /* Instruments: those of a service train, or the outputs with optional errors; if both are null, Python writes `reading`. */
    Service *service;
    const long long *read_of;
    const double *gain, *bias;
    double *noise;                               /* rows of READINGS for `block` samples from a multiple of it on */
    /* The filter; a null mean: no filter. A null function: the filter is in Python and works on the same arrays. */
    Advance *advance;
    double *memory, *held, *seen;
    const double *mean, *covariance, *squared, *used; /* of the last step: NIS, and 1 for every reading that it used */
    const long long *seen_of, *state_of;         /* positions in a reading; of estimates among the states */
    /* The law. A null function: the controller is in Python and writes `demand`. */
    Formula law, valves, free_wheel;
    Formula over;                                /* over a law in Python: its demands replace the pressures read */
    const double *most;                          /* maximum pressures for the demands of a law in Python; null: no limit */
    long long is_pascal;                         /* whether a demand has shown the unit Pa; until then Python checks all */
    const double *law_state;                     /* of these states the elements `law_of` are recorded */
    const long long *law_of;
    const double *radius;
    Plausibility *plausibility;
    Rail *rail;
    Driver *driver;                              /* null: full brake */
    const double *full;                          /* pressures of full brake */
    Faults *faults;                              /* null: no faults */
    double period, stop_speed;
    double *rows;
    double truth[OUTPUTS], inputs[INPUTS], reading[READINGS], latest[READINGS], fresh[READINGS];
    double estimate[ESTIMATES];                  /* standard deviations as variances until the end of the stop */
    double observation[OBSERVATIONS];
    double replaced[OBSERVATIONS];               /* estimates in its place; NaN: the reading is kept */
    double reference[REFERENCES];
    double command[GROUPS], demand[GROUPS], driver_demand[GROUPS];   /* driver_demand: at the last decision */
    long long present_count, seen_count, estimates_count, law_count;
    long long width, capacity;                   /* columns of a row; rows, of which the last serves all samples beyond */
    long long block, samples;                    /* samples between two calls for noise; samples until the horizon */
    long long sensors_every;
    Every estimator_every, controller_every;
    long long row;                               /* distance between rows of the covariance */
    long long true_at, sent_at, read_at, law_at; /* first columns */
    long long reference_at, estimates_at, demand_at, driver_at, traction_at;   /* -1: absent */
    long long any, news;                         /* whether a reading has ever come; whether one has since the last filter step */
    long long crossed;                           /* steps of the plant that succeeded */
    long long stage, sample, written, failure;
    long long moved;                             /* whether the train has been faster than stop_speed */
} Cycle;

int cycle(Cycle *c);

#endif
