/* Checks of the outputs of every plant, built-in or foreign, at every sample.

   Each check is an interval around a value that physics determines. The comments state the error in the braking
   distance that its width permits. A signal that a plant lacks is NaN and passes. */

#include <math.h>

#include "plausible.h"
#include "vectors.h"

/* Share of the required speed; the error of the distance is twice that, 0.2 %. The floor is for starts at rest. */
static const double SPEED_SHARE = 1e-3, SPEED_FLOOR = 1e-3; /* 1, m/s */
/* The highest acceleration on a rail: friction of 1 on a gradient of 20 %, the steepest that [track] accepts. */
static const double MAX_ACCELERATION = 1.2 * GRAVITY; /* m/s2 */
/* Tolerance for a fall (or rise) of speed beyond its bound, in any interval of time: SPEED_SHARE of the highest speed
   so far. If all of it is used at the start, the distance is 0.2 % shorter. BOUND_SHARE of the bound, 0.1 % of the
   distance, allows for another constant of gravity. */
static const double BOUND_SHARE = 1e-3;
/* Below this speed, the usual stop speed, a plant may snap to rest: less than a centimetre at 0.5 m/s2. */
static const double SNAP = 0.1; /* m/s */
/* The integral of the acceleration may differ from the change of speed by SPEED_SHARE of the highest speed, which
   causes an error of 0.1 % in an estimate based on it; by one sample, for a plant that holds its acceleration over a
   step or outputs it late; and by the sum of noise of 0.1 m/s2 over some 1e4 samples of a millisecond. */
static const double GAIN_STEP = 0.01; /* m/s */
/* Solvers keep distance and speed consistent to 1e-5, odometers of trains to about 1e-3: 0.1 %. One sample of travel is
   added, because a plant may hold its speed over a step, or output one of the two a sample late; and one step of the
   odometer. */
static const double DISTANCE_SHARE = 1e-3, DISTANCE_STEP = 0.01; /* 1, m */
/* A brake stops a wheel but cannot reverse it. A wheel is not driven, so it leads only by creep, below 1 %, and by the
   error of the radius that slip is computed with, up to 8 % between new and worn. */
static const double MIN_SLIP = -0.1, MAX_SLIP = 1.05;
/* Below this speed slip is a ratio of two small numbers. */
static const double SLOW = 1.0; /* m/s */
/* mu0 is the maximum friction at any slip; the share is for a plant that computes its loads differently. It adds no
   error to the distance, which the fall of the speed bounds. */
static const double ADHESION_SHARE = 0.01, ADHESION_STEP = 1e-3;

static int is_within(Plausibility *checks, int check, int element, double value, double lower, double upper)
{
    if (value < lower || value > upper) { /* false for NaN, so that a missing signal passes */
        checks->check = check;
        checks->element = element;
        checks->value = value;
        checks->lower = lower;
        checks->upper = upper;
        return 0;
    }
    return 1;
}

static int is_around(Plausibility *checks, int check, double value, double expected, double tolerance)
{
    return is_within(checks, check, 0, value, expected - tolerance, expected + tolerance);
}

/* Return the maximum deceleration [m/s2] under held inputs: by mean friction weighted with the wheelset loads, by track
   force, and by running resistance and track brakes. Without positive loads, the highest friction replaces the mean. */
static double max_deceleration(const Plausibility *checks, double speed, const double *outputs, const double *inputs)
{
    const double force = inputs[INPUT_TRACK_FORCE];
    double load = 0.0, weighted = 0.0, highest = 0.0;

    for (int i = 0; i < WHEELSETS; i++) {
        const double friction = inputs[INPUT_MU0 + i], wheelset_load = outputs[OUTPUT_WHEELSET_LOAD + i];
        load += wheelset_load < 0.0 ? NOTHING : wheelset_load; /* a negative load cannot be a weight */
        weighted += friction * wheelset_load;
        highest = fmax(highest, friction);
    }
    return (1.0 + BOUND_SHARE) * GRAVITY * (load > 0.0 ? weighted / load : highest) + checks->constant +
           checks->quadratic * speed * speed - force / (force > 0.0 ? checks->heaviest : checks->lightest);
}

/* Return a speed reduced by SNAP towards rest. */
static double beyond_snap(double speed)
{
    return speed > SNAP ? speed - SNAP : fmin(speed + SNAP, 0.0);
}

/* Return 1 if the speed changes by no more than its bounds, and in agreement with the acceleration. */
static int is_motion_plausible(Plausibility *checks, long long sample, const double *outputs, const double *inputs)
{
    const double speed = outputs[OUTPUT_SPEED], acceleration = outputs[OUTPUT_ACCELERATION],
                 time = sample * checks->period;
    const double bound = max_deceleration(checks, fmax(checks->speed, speed), outputs, inputs);
    const double change = beyond_snap(speed) - beyond_snap(checks->speed);

    checks->max_speed = fmax(checks->max_speed, speed);
    const double tolerance = SPEED_SHARE * checks->max_speed + SPEED_FLOOR;
    /* Cumulative sums that never fall below 0: a change within the bound does not permit a larger one later. The bound
       is the higher of two, because a plant may use an input a sample late. */
    checks->fall = fmax(checks->fall - change - fmax(bound, checks->deceleration) * checks->period, 0.0);
    checks->rise = fmax(checks->rise + change - MAX_ACCELERATION * checks->period, 0.0);
    checks->deceleration = bound;
    if (fmin(checks->speed, speed) > SNAP)
        checks->speed_error += 0.5 * checks->period * (checks->acceleration + acceleration) - (speed - checks->speed);
    checks->acceleration = acceleration;
    checks->max_acceleration = fmax(checks->max_acceleration, fabs(acceleration));
    /* Integral of the acceleration and change of speed, both over the time since the start: a message in m/s2. */
    const double mean = (speed - checks->start_speed) / time;
    /* speed + fall and speed - rise are the lowest and highest speed within the bounds. */
    return is_around(checks, SPEED, speed, speed + checks->fall, tolerance) &&
           is_around(checks, SPEED, speed, speed - checks->rise, tolerance) &&
           is_around(checks, ACCELERATION, mean + checks->speed_error / time, mean,
                     (tolerance + checks->period * checks->max_acceleration + GAIN_STEP) / time);
}

/* Return 1 if the outputs of a sample are possible; `inputs` are those held during the step to it. Samples come in
   order. */
EXPORT int plausible(Plausibility *checks, long long sample, const double *outputs, const double *inputs)
{
    const double speed = outputs[OUTPUT_SPEED], distance = outputs[OUTPUT_DISTANCE];
    const double sample_travel = checks->period * checks->start_speed;

    if (sample == 0) {
        checks->origin = distance;
        checks->travel = checks->speed_error = checks->max_acceleration = checks->rise = checks->fall = 0.0;
        checks->max_speed = speed;
        checks->acceleration = outputs[OUTPUT_ACCELERATION];
        checks->deceleration = max_deceleration(checks, speed, outputs, inputs);
        if (!is_around(checks, START_SPEED, speed, checks->start_speed,
                       SPEED_SHARE * checks->start_speed + SPEED_FLOOR) ||
            !is_around(checks, START_DISTANCE, distance, 0.0, sample_travel + DISTANCE_STEP))
            return 0;
    } else {
        checks->travel += 0.5 * checks->period * (checks->speed + speed);
        if (!is_motion_plausible(checks, sample, outputs, inputs) ||
            !is_around(checks, DISTANCE, distance, checks->origin + checks->travel,
                       DISTANCE_SHARE * checks->travel + sample_travel + DISTANCE_STEP))
            return 0;
    }
    checks->speed = speed;
    if (speed > SLOW)
        for (int g = 0; g < GROUPS; g++)
            if (!is_within(checks, SLIP, g, outputs[OUTPUT_SLIP + g], MIN_SLIP, MAX_SLIP))
                return 0;
    for (int i = 0; i < WHEELSETS; i++) {
        const double upper = (1.0 + ADHESION_SHARE) * inputs[INPUT_MU0 + i] + ADHESION_STEP;
        if (!is_within(checks, ADHESION, i, outputs[OUTPUT_ADHESION + i], -upper, upper))
            return 0;
    }
    return 1;
}
