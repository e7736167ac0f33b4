/* Faults of readings and commands, between the plant and the other parts. */
#ifndef FAULTS_H
#define FAULTS_H

#include "export.h"
#include "layout.h"
#include "sensors.h"

enum { DEAD, STUCK, SCALED, BIASED, NOISY }; /* kinds for a reading */
enum { FIXED, KEPT, LATE, LIMITED };         /* kinds for a command */

typedef struct {
    double value;                   /* factor; offset; command; volume of a reservoir [m3] */
    double pressure, free_pressure; /* of the full reservoir, gauge; at which free air is counted, absolute [Pa] */
    double last;                    /* last reading or command before the fault; free air used before it [m3] */
    double refill, refilled;        /* free air that the compressor delivers per sample; in total [m3] */
    double *ring;                   /* LATE: `count` commands, a ring; NOISY: `count` samples of noise */
    long long kind, place, begin, end, count; /* place: in the reading, or the group; samples, `end` excluded */
} Fault;

typedef struct {
    Fault *readings, *commands;
    long long reading_count, command_count;
    long long valves;  /* valve positions if set, else pressures */
    Rate noise_rate; /* a draw of noise per number of samples */
} Faults;

void change_reading(Faults *faults, long long sample, double *reading);
void change_command(Faults *faults, long long sample, const double *outputs, double *command);

#endif
