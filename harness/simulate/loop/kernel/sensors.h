/* Instruments as a train in service may have them. */
#ifndef SENSORS_H
#define SENSORS_H

#include "export.h"
#include "layout.h"

enum { NOISES = 2 + WHEELSETS };                 /* train speed, acceleration, one per deflection */

/* `turns` turns of a part in `steps` steps of what it follows. */
typedef struct {
    long long steps, turns;
} Every;

typedef struct {
    const double *teeth;                         /* errors of the tooth positions [rad] */
    double pitch, clock, period, silence;
    double angle, stamp, speed;                  /* stamp: of the last pulse, negative before the first */
    long long pulses, count;                     /* count: of the last tooth seen */
    long long missing, begin, end;               /* teeth from the first of a revolution on; samples, `end` is not one of them */
} Encoder;

typedef struct {
    const double *values;                        /* at even places; straight between them, beyond the ends as there */
    double begin, step;                          /* [m] */
    long long count;
} Course;

typedef struct {
    Encoder encoder[GROUPS];
    Course gravity, rail;                        /* along the track [m/s2]; height of the rail [m]; count 0: there is none */
    const double *position;                      /* of each wheelset behind the leading one [m] */
    const double *speed_factor;                  /* of one reading of the train speed after the other, and again; NaN: lost */
    double shift[2 * WHEELSETS];                 /* of each wheelset, what the frame over it remembers of the rail [m] */
    double forward[3], back[2];                  /* from the height of the rail to the deflection: a digital filter */
    double *noise;                               /* rows of NOISES for `block` samples from a multiple of it on */
    const double *offset_steps;                  /* of each transducer, in steps of the converter */
    double *past;                                /* `remembered` train speeds, a ring */
    double speed_latency;                        /* samples */
    double period, acceleration_bias, pressure_step, pressure_share;
    double pressure[GROUPS], before[GROUPS];     /* behind the transducers' lag; in the cylinders at the last reading */
    long long block, remembered, speed_factors;
    long long samples;                           /* of encoders and transducers from one reading to the next */
    Every speed_every;
} Service;

/* The last turn that began until a step, and whether it is due at that step: the first at or after each multiple of the period. */
long long turn(Every every, long long step);
int due(Every every, long long step);

double read_encoder(Encoder *its, long long sample, double speed);
void read_service(Service *its, long long sample, const double *truth, double *reading);

#endif
