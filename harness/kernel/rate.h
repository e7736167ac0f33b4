/* Turns of a part whose period is a number of steps, not necessarily whole. */
#ifndef RATE_H
#define RATE_H

#include "sensors.h"

/* Number of the turn that is in progress at a step. */
static inline long long turn_at(Rate rate, long long step)
{
    return step * rate.turns / rate.steps;
}

/* Whether a turn begins at a step: the first step at or after each multiple of the period. */
static inline int is_due(Rate rate, long long step)
{
    return step * rate.turns % rate.steps < rate.turns;
}

#endif
