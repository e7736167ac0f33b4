/* Checks of the outputs of every plant, built-in or foreign, at every sample.

   Each check is an interval around a value that physics determines. The comments state the error in the braking distance that
   its width permits. A signal that a plant lacks is NaN and passes. */

#include <math.h>

#include "plausible.h"

/* Share of the required speed; the error of the distance is twice that, 0.2 %. The floor is for starts at rest. */
static const double SPEED_SHARE = 1e-3, SPEED_FLOOR = 1e-3;         /* 1, m/s */
/* The highest acceleration on a rail: friction of 1 on a gradient of 20 %, the steepest that [track] accepts. */
static const double MOST_ACCELERATION = 1.2 * GRAVITY;              /* m/s2 */
/* Tolerance for a fall (or rise) of speed beyond its bound, in any interval of time: SPEED_SHARE of the highest speed so far.
   If all of it is used at the start, the distance is 0.2 % shorter. BOUND_SHARE of the bound, 0.1 % of the distance, allows for
   another constant of gravity. */
static const double BOUND_SHARE = 1e-3;
/* Below this speed, the usual stop speed, a plant may snap to rest: less than a centimetre at 0.5 m/s2. */
static const double SNAP = 0.1;                  /* m/s */
/* The integral of the acceleration may differ from the change of speed by SPEED_SHARE of the highest speed, which causes an
   error of 0.1 % in an estimate based on it; by one sample, for a plant that holds its acceleration over a step or outputs it
   late; and by the sum of noise of 0.1 m/s2 over some 1e4 samples of a millisecond. */
static const double GAIN_STEP = 0.01;            /* m/s */
/* Solvers keep distance and speed consistent to 1e-5, odometers of trains to about 1e-3: 0.1 %. One sample of travel is added,
   because a plant may hold its speed over a step, or output one of the two a sample late; and one step of the odometer. */
static const double DISTANCE_SHARE = 1e-3, DISTANCE_STEP = 0.01;    /* 1, m */
/* A brake stops a wheel but cannot reverse it. A wheel is not driven, so it leads only by creep, below 1 %, and by the error of
   the radius that slip is computed with, up to 8 % between new and worn. */
static const double LEAST_SLIP = -0.1, MOST_SLIP = 1.05;
/* Below this speed slip is a ratio of two small numbers. */
static const double SLOW = 1.0;                  /* m/s */
/* mu0 is the maximum friction at any slip; the share is for a plant that computes its loads differently. It adds no error to
   the distance, which the fall of the speed bounds. */
static const double ADHESION_SHARE = 0.01, ADHESION_STEP = 1e-3;

static int within(Plausibility *its, int check, int element, double value, double least, double most)
{
    if (value < least || value > most) {             /* false for NaN, so that a missing signal passes */
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

/* Return the maximum deceleration [m/s2] under held inputs: mean friction over the wheelset loads, track force, and running
   resistance and track brakes. If a plant does not output its loads, the maximum friction replaces the mean. */
static double most_deceleration(const Plausibility *its, double speed, const double *truth, const double *inputs)
{
    const double force = inputs[INPUT_TRACK_FORCE];
    double load = 0.0, held = 0.0, highest = 0.0;

    for (int i = 0; i < WHEELSETS; i++) {
        const double friction = inputs[INPUT_MU0 + i], each = truth[OUTPUT_WHEELSET_LOAD + i];
        load += each < 0.0 ? 0.0 / 0.0 : each;
        held += friction * each;
        highest = fmax(highest, friction);
    }
    return (1.0 + BOUND_SHARE) * GRAVITY * (load > 0.0 ? held / load : highest) + its->constant +
           its->quadratic * speed * speed - force / (force > 0.0 ? its->heaviest : its->lightest);
}

/* Return a speed reduced by SNAP towards rest. */
static double beyond_snap(double speed)
{
    return speed > SNAP ? speed - SNAP : fmin(speed + SNAP, 0.0);
}

/* Return 1 if the speed changes by no more than its bounds, and in agreement with the acceleration. */
static int moves(Plausibility *its, long long sample, const double *truth, const double *inputs)
{
    const double speed = truth[OUTPUT_SPEED], acceleration = truth[OUTPUT_ACCELERATION], time = sample * its->period;
    const double bound = most_deceleration(its, fmax(its->speed, speed), truth, inputs);
    const double change = beyond_snap(speed) - beyond_snap(its->speed);

    its->top = fmax(its->top, speed);
    const double tolerance = SPEED_SHARE * its->top + SPEED_FLOOR;
    /* The higher of two bounds: a plant may use an input a sample late. Time spent below the bound earns no credit for later.
       */
    its->fall = fmax(its->fall - change - fmax(bound, its->deceleration) * its->period, 0.0);
    its->rise = fmax(its->rise + change - MOST_ACCELERATION * its->period, 0.0);
    its->deceleration = bound;
    if (fmin(its->speed, speed) > SNAP)
        its->gained += 0.5 * its->period * (its->acceleration + acceleration) - (speed - its->speed);
    its->acceleration = acceleration;
    its->hardest = fmax(its->hardest, fabs(acceleration));
    const double mean = (speed - its->start_speed) / time;
    return around(its, SPEED, speed, speed + its->fall, tolerance) && around(its, SPEED, speed, speed - its->rise, tolerance) &&
           around(its, ACCELERATION, mean + its->gained / time, mean, (tolerance + its->period * its->hardest + GAIN_STEP) / time);
}

/* Return 1 if the outputs of a sample are possible; `inputs` are those held during the step to it. Samples come in order. */
EXPORT int plausible(Plausibility *its, long long sample, const double *truth, const double *inputs)
{
    const double speed = truth[OUTPUT_SPEED], distance = truth[OUTPUT_DISTANCE];
    const double one_sample = its->period * its->start_speed;

    if (sample == 0) {
        its->origin = distance;
        its->travel = its->gained = its->hardest = its->rise = its->fall = 0.0;
        its->top = speed;
        its->acceleration = truth[OUTPUT_ACCELERATION];
        its->deceleration = most_deceleration(its, speed, truth, inputs);
        if (!around(its, START_SPEED, speed, its->start_speed, SPEED_SHARE * its->start_speed + SPEED_FLOOR) ||
            !around(its, START_DISTANCE, distance, 0.0, one_sample + DISTANCE_STEP))
            return 0;
    } else {
        its->travel += 0.5 * its->period * (its->speed + speed);
        if (!moves(its, sample, truth, inputs) ||
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
