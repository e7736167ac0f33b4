/* What a driver asks for, phase by phase. */
#ifndef DRIVER_H
#define DRIVER_H

#include "export.h"
#include "layout.h"

enum { AT_END, AT_TIME, AT_DURATION, AT_DISTANCE, AT_SPEED_BELOW, AT_SPEED_ABOVE };   /* what ends a phase */

typedef struct {
    double limit;                                /* what ends it: s, m or m/s; unused for AT_END */
    double begin;                                /* time from which pressures change by their slopes */
    double target, deceleration, full_deceleration;   /* to stop at a target; NaN: by pressures */
    double force, power, rate;                   /* of the traction: N, W and N/s; may be infinite but for the force */
    long long until;
} Phase;

typedef struct {
    const Phase *phases;
    const double *pressures, *slopes;            /* of each phase and group [Pa], [Pa/s] */
    const double *touching, *full;               /* pressures of each group at which pads touch, and at full brake */
    double period, began, force;                 /* began: when the phase did; force: of the traction, now */
    double pressure[GROUPS];                     /* demanded now */
    long long count, phase, braking;             /* braking: whether the curve to the target has been reached */
    long long binding;                           /* whether no group gets more pressure than demanded */
} Driver;

void drive(Driver *its, long long sample, const double *truth);

#endif
