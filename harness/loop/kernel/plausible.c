/* One table of checks for every plant, own or foreign, at every sample, called by both engines.

   Each is an interval around what must be true. The intervals are as wide as an honest plant may need, and no wider: what is
   off by more gives a wrong distance. A signal that a plant lacks is NaN and passes. */

#include <math.h>

#include "plausible.h"

/* A plant may show its speed in steps of 0.1 km/h, or find it by solving; a wrong unit is off by 3.6. */
static const double START_SHARE = 0.01, START_STEP = 0.02;          /* 1, m/s */
/* Nothing on a rail accelerates by more: friction of 1 on a gradient of 20 %, the steepest that [track] takes. */
static const double ACCELERATION = 1.2 * 9.81;   /* m/s2 */
/* A plant may snap to rest at a low speed, and may show its speed in steps; 0.1 m/s is the usual stop speed. */
static const double SPEED_STEP = 0.1;            /* m/s */
/* Solvers keep distance and speed together to 1e-5, odometers of trains to some 1e-3. On top comes one sample of travel: a
   plant may hold its speed over a step, or show one of the two a sample late; and a step of the odometer. */
static const double DISTANCE_SHARE = 1e-3, DISTANCE_STEP = 0.01;    /* 1, m */
/* A brake stops a wheel but cannot turn it back; nothing drives it, so that it leads by creep, below 1 %, and by what its
   radius is off from the one that slip is computed with, up to 8 % between new and worn. */
static const double LEAST_SLIP = -0.1, MOST_SLIP = 1.05;
/* Below this speed slip is a ratio of two small numbers. */
static const double SLOW = 1.0;                  /* m/s */
/* mu0 is the most that the rail gives at any slip; the share is for a plant that computes its loads otherwise. */
static const double ADHESION_SHARE = 0.01, ADHESION_STEP = 1e-3;

static int within(Plausibility *its, int check, int element, double value, double least, double most)
{
    if (value < least || value > most) {
        its->check = check;
        its->element = element;
        its->value = value;
        its->least = least;
        its->most = most;
        return 0;
    }
    return 1;
}

static int around(Plausibility *its, int check, double value, double expected, double tolerance)
{
    return within(its, check, 0, value, expected - tolerance, expected + tolerance);
}

/* Return 1 when the truth of a sample can be; `inputs` are those that were held until then. Samples come in order. */
EXPORT int plausible(Plausibility *its, long long sample, const double *truth, const double *inputs)
{
    const double speed = truth[OUTPUT_SPEED], distance = truth[OUTPUT_DISTANCE];
    const double last = its->speed, one_sample = its->period * its->start_speed;

    if (sample == 0) {
        its->origin = distance;
        its->travel = 0.0;
        if (!around(its, START_SPEED, speed, its->start_speed, START_SHARE * its->start_speed + START_STEP) ||
            !around(its, START_DISTANCE, distance, 0.0, one_sample + DISTANCE_STEP))
            return 0;
    } else {
        its->travel += 0.5 * its->period * (last + speed);
        if (!around(its, SPEED, speed, last, ACCELERATION * its->period + SPEED_STEP) ||
            !around(its, DISTANCE, distance, its->origin + its->travel,
                    DISTANCE_SHARE * its->travel + one_sample + DISTANCE_STEP))
            return 0;
    }
    its->speed = speed;
    if (speed > SLOW)
        for (int g = 0; g < GROUPS; g++)
            if (!within(its, SLIP, g, truth[OUTPUT_SLIP + g], LEAST_SLIP, MOST_SLIP))
                return 0;
    for (int i = 0; i < WHEELSETS; i++) {
        const double most = (1.0 + ADHESION_SHARE) * inputs[INPUT_MU0 + i] + ADHESION_STEP;
        if (!within(its, ADHESION, i, truth[OUTPUT_ADHESION + i], -most, most))
            return 0;
    }
    return 1;
}
