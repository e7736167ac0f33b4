/* Instruments of a train in service. */
#ifndef SENSORS_H
#define SENSORS_H

#include "export.h"
#include "layout.h"

enum { NOISE_SPEED, NOISE_ACCELERATION, NOISE_DEFLECTION, NOISES = NOISE_DEFLECTION + WHEELSETS }; /* in a row */

/* Rate of a part: `turns` turns in `steps` steps of the clock that it follows, so that a period need not be whole. */
typedef struct {
    long long steps, turns;
} Rate;

typedef struct {
    const double *teeth;           /* errors of the tooth positions [rad] */
    double pitch, clock, period;   /* [rad]; tick of the clock that times pulses, and sampling period [s] */
    double timeout;                /* time without a pulse after which the reading is zero [s] */
    double angle, stamp, speed;    /* stamp: time of the last pulse, negative before the first one */
    long long pulses, count;       /* count: number of the last tooth */
    long long missing, begin, end; /* teeth from the first of a revolution on; samples, `end` excluded */
} Encoder;

typedef struct {
    const double *values; /* at equidistant places; linear between them, constant beyond the ends */
    double begin, step;   /* [m] */
    long long count;
} TrackQuantity;

typedef struct {
    Encoder encoder[GROUPS];
    TrackQuantity gravity, rail;        /* gravity along the track [m/s2]; height of the rail [m]; count 0: absent */
    const double *position;             /* distance of each wheelset behind the leading one [m] */
    const double *speed_factor;         /* per reading of the train speed, repeating; NaN: reading lost */
    double filter_state[2 * WHEELSETS]; /* two states for each wheelset [m] */
    double forward[3], back[2]; /* b0, b1, b2 and a1, a2 of the filter from the height of the rail to the deflection */
    double *noise;              /* rows of NOISES for `block` samples from a multiple of it on */
    const double *offset_steps; /* offset of each transducer, in steps of the converter */
    double *past_speed;         /* `past_count` train speeds, a ring */
    double speed_latency;       /* samples */
    double period, acceleration_bias, pressure_step, pressure_share;
    double lagged_pressure[GROUPS]; /* after the transducers' lag */
    double last_pressure[GROUPS];   /* in the cylinders at the last reading */
    long long block, past_count, speed_factors;
    long long samples; /* samples of encoders and transducers per reading */
    Rate speed_rate;
} Service;

double read_encoder(Encoder *encoder, long long sample, double speed);
void read_service(Service *service, long long sample, const double *outputs, double *reading);

#endif
