/* Demands of a driver, phase by phase. */
#ifndef DRIVER_H
#define DRIVER_H

#include "export.h"
#include "layout.h"

enum { AT_END, AT_TIME, AT_DURATION, AT_DISTANCE, AT_SPEED_BELOW, AT_SPEED_ABOVE }; /* event that ends a phase */

typedef struct {
    double end;                                     /* at which the phase ends: s, m or m/s; unused for AT_END */
    double begin;                                   /* time from which pressures change by their slopes */
    double target, deceleration, full_deceleration; /* to stop at a target; NaN: by pressures */
    double force, power, rate;                      /* traction: N, W and N/s; power and rate may be infinite */
    double pressure[GROUPS], slope[GROUPS];         /* demand at `begin` [Pa]; its change [Pa/s] */
    long long until;
} Phase;

typedef struct {
    const Phase *phases;
    const double *release_pressure, *full;       /* pressure of each group at which pads touch, and at full brake */
    double period, phase_start, force;   /* force: present traction */
    double pressure[GROUPS];             /* present demand */
    long long count, phase, is_on_curve; /* is_on_curve: whether the curve to the target has been reached */
    long long binding;                   /* whether commands are limited to `pressure` */
} Driver;

void drive(Driver *driver, long long sample, const double *outputs);

#endif
