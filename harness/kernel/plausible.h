/* Checks of a plant's outputs against its inputs and against physics. */
#ifndef PLAUSIBLE_H
#define PLAUSIBLE_H

#include "export.h"
#include "layout.h"

/* The check that failed. */
enum { PLAUSIBLE, START_SPEED, START_DISTANCE, SPEED, ACCELERATION, DISTANCE, SLIP, ADHESION };

typedef struct {
    double period, start_speed;
    double lightest, heaviest;    /* bounds of the train's mass [kg] */
    double constant, quadratic;   /* running resistance and track brakes decelerate by up to constant + quadratic v^2 */
    double speed, origin, travel; /* last speed; first distance; integral of the speed since then */
    double acceleration, max_acceleration; /* last one; maximum magnitude */
    double speed_error;                    /* integral of the acceleration minus the change of speed */
    double max_speed, deceleration;        /* maximum so far; last bound */
    double rise, fall;                     /* present excess of the speed's change over its bounds [m/s] */
    double value, lower, upper;            /* of the check that failed: value, and its bounds */
    long long check, element;              /* that check; index of the signal's element */
} Plausibility;

int plausible(Plausibility *checks, long long sample, const double *outputs, const double *inputs);

#endif
