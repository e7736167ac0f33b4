/* Instruments of a train in service. */
#ifndef SENSORS_H
#define SENSORS_H

#include "export.h"
#include "layout.h"

enum { NOISES = 2 + WHEELSETS }; /* train speed, acceleration, one per deflection */

/* `turns` turns of a part per `steps` steps of its reference. */
typedef struct {
    long long steps, turns;
} Every;

typedef struct {
    const double *teeth; /* errors of the tooth positions [rad] */
    double pitch, clock, period, silence;
    double angle, stamp, speed;    /* stamp: time of the last pulse, negative before the first one */
    long long pulses, count;       /* count: number of the last tooth */
    long long missing, begin, end; /* teeth from the first of a revolution on; samples, `end` excluded */
} Encoder;

typedef struct {
    const double *values; /* at even places; linear between them, constant beyond the ends */
    double begin, step;   /* [m] */
    long long count;
} Course;

typedef struct {
    Encoder encoder[GROUPS];
    Course gravity, rail;        /* gravity along the track [m/s2]; height of the rail [m]; count 0: absent */
    const double *position;      /* distance of each wheelset behind the leading one [m] */
    const double *speed_factor;  /* per reading of the train speed, repeating; NaN: reading lost */
    double shift[2 * WHEELSETS]; /* filter state of each wheelset [m] */
    double forward[3], back[2];  /* digital filter from the height of the rail to the deflection */
    double *noise;               /* rows of NOISES for `block` samples from a multiple of it on */
    const double *offset_steps;  /* offset of each transducer, in steps of the converter */
    double *past;                /* `remembered` train speeds, a ring */
    double speed_latency;        /* samples */
    double period, acceleration_bias, pressure_step, pressure_share;
    double pressure[GROUPS], before[GROUPS]; /* after the transducers' lag; in the cylinders at the last reading */
    long long block, remembered, speed_factors;
    long long samples; /* samples of encoders and transducers per reading */
    Every speed_every;
} Service;

/* The last turn that began until a step; and whether a turn is due at a step: the first one at or after each multiple
   of the period. */
long long turn(Every every, long long step);
int due(Every every, long long step);

double read_encoder(Encoder *encoder, long long sample, double speed);
void read_service(Service *service, long long sample, const double *outputs, double *reading);

#endif
