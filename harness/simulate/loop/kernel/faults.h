/* What is broken on the way from the plant to who reads it, and back. */
#ifndef FAULTS_H
#define FAULTS_H

#include "export.h"
#include "layout.h"
#include "sensors.h"

enum { DEAD, STUCK, SCALED, BIASED, NOISY };     /* of a reading */
enum { FIXED, KEPT, LATE, LIMITED };             /* of a command */

typedef struct {
    double value;                                /* factor; what is added; command; volume of a reservoir [m3] */
    double pressure, free;                       /* of the full reservoir [Pa]; at which free air is counted [Pa] */
    double held;                                 /* last reading or command before; free air used before [m3] */
    double refill, refilled;                     /* free air that comes back each sample; that has come [m3] */
    double *past;                                /* LATE: `count` commands, a ring; NOISY: `count` samples of noise */
    long long kind, place, begin, end, count;    /* place: in the reading, or the group; samples, `end` is not one of them */
} Fault;

typedef struct {
    Fault *readings, *commands;
    long long reading_count, command_count;
    long long valves;                            /* whether commands are positions of valves, else pressures */
    Every noise_every;                           /* a draw of noise in so many samples */
} Faults;

void show_faults(Faults *its, long long sample, double *reading);
void pass_faults(Faults *its, long long sample, const double *truth, const double *sent, double *command);

#endif
