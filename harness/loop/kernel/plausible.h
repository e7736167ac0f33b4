/* What a plant shows, held against what was asked and against physics; the struct is mirrored in plausible.py, field by field. */
#ifndef PLAUSIBLE_H
#define PLAUSIBLE_H

#include "layout.h"

#if defined(_WIN32)
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif

enum { PLAUSIBLE, START_SPEED, START_DISTANCE, SPEED, DISTANCE, SLIP, ADHESION };   /* the check that failed */

typedef struct {
    double period, start_speed;
    double speed, origin, travel;                /* last speed; first distance; integral of the speed since */
    double value, least, most;                   /* of the check that failed: shown, and the bounds it had */
    long long check, element;
} Plausibility;

int plausible(Plausibility *its, long long sample, const double *truth, const double *inputs);

#endif
