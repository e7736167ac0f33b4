/* A stop, sample by sample: its parts, and the signals that they exchange. */
#ifndef CYCLE_H
#define CYCLE_H

#include "driver.h"
#include "export.h"
#include "faults.h"
#include "plausible.h"
#include "rail.h"
#include "sensors.h"

typedef int Step(void *interface, double time);
typedef int Advance(double *memory);
typedef void Call(double *state, const double *input, const double *parameter, double *output);

/* Why `cycle` returned: a part in Python is due, or the stop has ended. */
enum { BLOCK_DUE, PLANT_DUE, SENSORS_DUE, ESTIMATOR_DUE, CONTROLLER_DUE, LIMITS_DUE };
enum { STANDING = LIMITS_DUE + 1, AT_HORIZON, NOT_PLAUSIBLE, PLANT_FAILED, DIVERGED, NO_COMMAND };

enum { NEGATIVE_VARIANCE = -1 }; /* in addition to the failures of the filter */

typedef struct {
    Call *call; /* null: the part is not in C, or does not exist */
    double *state;
    const double *parameter;
} Formula;

/* Without a function the plant is in Python and writes `outputs`. */
typedef struct {
    Step *step; /* see set_step_get.h */
    void *interface;
    double *inputs;            /* held during the next step */
    double *outputs;           /* NaN for outputs that it lacks */
    const double *slip_radius; /* null: the plant outputs slip; else the radii to compute slip with */
    long long steps;           /* number of steps that succeeded */
} Plant;

/* Instruments of a service train, or outputs with optional errors; if both are null, Python writes `reading`. */
typedef struct {
    Service *service;
    const long long *output_at; /* output that each entry of a reading is taken from */
    const double *gain, *bias;
    double *noise; /* rows of READINGS for `block` samples from a multiple of it on */
    double reading[READINGS];
    long long every, block; /* samples between two readings; readings between two draws of noise */
} Instruments;

/* Without a function the filter is in Python and works on the same arrays. */
typedef struct {
    Advance *advance;
    double *memory;
    double *inputs, *readings; /* of the next step */
    const double *mean, *covariance;
    const double *squared_innovation, *selection; /* of the last step; selection: 1 for every reading that it used */
    const long long *reading_at, *state_at;       /* positions of `readings` in a reading; of estimates in `mean` */
    Formula reference_speed;                      /* from wheels, for a silent radar */
    double reference[REFERENCES];
    Formula body_force;              /* braking force on the body: brakes on the rail, resistance; null: none */
    long long track_force;           /* position of the force of the track in `inputs`; -1: there is none */
    double new_reading[READINGS];    /* newest readings since the last step */
    long long has_new_reading;       /* whether there are any since the last step */
    long long reading_count, stride; /* stride: distance between rows of the covariance */
} Filter;

typedef struct {
    Formula law;         /* null: the controller is in Python and writes `demand` */
    Formula train_level; /* decisions for the whole train, over a law in Python */
    Formula valves;
    const double *maximum;      /* maximum pressures for the demands of a law in Python; null: no limit */
    const double *radius;       /* wheel radius of each group that the estimator assumes, else the nominal one */
    const double *magnets;      /* the law's demand for magnetic track brakes; null: those of the driver */
    const double *full;         /* pressures of full brake; see `driver_demand` in onboard.c */
    double reading[READINGS];   /* newest reading of every sensor */
    double estimate[ESTIMATES]; /* standard deviations as variances until the end of the stop */
    double observation[OBSERVATIONS];
    double replacement[OBSERVATIONS]; /* estimates that replace parts of the observation; NaN: no replacement */
    double demand[GROUPS], command[GROUPS];
    double driver_demand[GROUPS]; /* at the last decision */
    long long has_reading, has_estimator;
    long long is_pascal; /* whether a demand was large enough to be in Pa; until then Python checks every demand */
    Rate estimator_rate, controller_rate;
} Onboard;

typedef struct {
    double *rows;
    const double *law_state; /* the elements `law_state_at` are recorded */
    const long long *law_state_at;
    long long width, capacity; /* columns; rows, of which the last is overwritten by all later samples */
    /* First columns, -1 if absent. */
    long long output, input, reading, estimate, demand, driver_demand, traction, reference, law;
    long long estimate_count, law_count;
    long long written; /* number of samples recorded */
} Record;

typedef struct {
    Plant *plant;
    Plausibility *plausibility;
    Rail *rail;
    Driver *driver; /* null: full brake, see `driver_demand` */
    Instruments *instruments;
    Faults *faults; /* null: no faults */
    Filter *filter; /* null: no filter, or an estimator without states */
    Onboard *onboard;
    Record *record;
    double period, stop_speed;
    long long block, samples; /* samples between two calls for noise; samples until the horizon */
    long long stage, sample;  /* where `cycle` resumes; see cycle.c */
    long long failure;        /* code of the plant or filter that failed */
    long long has_moved;      /* whether the train has been faster than stop_speed */
} Cycle;

int cycle(Cycle *c);

#endif
