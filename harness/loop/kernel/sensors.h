/* Instruments as a train in service may have them; the structs are mirrored in sensors.py, field by field. */
#ifndef SENSORS_H
#define SENSORS_H

#include "layout.h"

#if defined(_WIN32)
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif

enum { NOISES = 2 + WHEELSETS };                 /* train speed, acceleration, one per deflection */

typedef struct {
    const double *teeth;                         /* errors of the tooth positions [rad] */
    double pitch, clock, period, silence;
    double angle, stamp, speed;                  /* stamp: of the last pulse, negative before the first */
    long long pulses, count;                     /* count: of the last tooth seen */
    long long missing, begin, end;               /* teeth from the first of a revolution on; samples, `end` is not one of them */
} Encoder;

typedef struct {
    Encoder encoder[GROUPS];
    const double *noise;                         /* rows of NOISES for `block` samples from a multiple of it on */
    const double *offset_steps;                  /* of each transducer, in steps of the converter */
    double *past;                                /* speed_latency + 1 train speeds, a ring */
    double period, speed_scale, acceleration_bias, pressure_step, pressure_share;
    double pressure[GROUPS];                     /* behind the transducers' lag */
    long long block, speed_every, speed_latency;
} Service;

double read_encoder(Encoder *its, long long sample, double speed);
void read_service(Service *its, long long sample, const double *truth, double *reading);

#endif
