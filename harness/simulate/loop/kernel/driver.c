/* Demands of the driver; the purpose is described in driver.py. */

#include <math.h>

#include "driver.h"

/* Times are compared to the nearest sample: k * period may miss "4 s" by a rounding error. */
static int over(const Driver *its, const Phase *phase, double time, double speed, double distance)
{
    switch (phase->until) {
    case AT_TIME: return time > phase->limit - 0.5 * its->period;
    case AT_DURATION: return time - its->began > phase->limit - 0.5 * its->period;
    case AT_DISTANCE: return distance >= phase->limit;
    case AT_SPEED_BELOW: return speed <= phase->limit;
    case AT_SPEED_ABOVE: return speed >= phase->limit;
    }
    return 0;
}

/* Gain on the deviation from the braking curve, in addition to the deviation itself: a train that brakes by a share b of the
   expected deceleration then runs on a curve of 2 b / (3 b - 1) times the deceleration, 1.27 for b = 0.7, and still ends at the
   target. A much higher gain would oscillate over the last metre because of the lag of the cylinders. */
static const double CORRECTION = 2.0;

/* Return the share of full brake that stops at the target from here; 0 until the braking curve has been reached. */
static double to_target(Driver *its, const Phase *phase, double speed, double distance)
{
    const double left = phase->target - distance;

    if (left <= 0.0)
        return 1.0;
    const double needed = 0.5 * speed * speed / left;
    if (needed >= phase->deceleration)
        its->braking = 1;
    const double wanted = needed + CORRECTION * (needed - phase->deceleration);
    return its->braking ? fmin(wanted / phase->full_deceleration, 1.0) : 0.0;
}

EXPORT void drive(Driver *its, long long sample, const double *truth)
{
    const double time = (double)sample * its->period, speed = truth[OUTPUT_SPEED], distance = truth[OUTPUT_DISTANCE];

    while (its->phase + 1 < its->count && over(its, its->phases + its->phase, time, speed, distance)) {
        its->phase++;
        its->began = time;
        its->braking = 0;
    }
    const Phase *phase = its->phases + its->phase;
    if (isnan(phase->target)) {
        const double *pressure = its->pressures + its->phase * GROUPS, *slope = its->slopes + its->phase * GROUPS;
        const double since = fmax(time - phase->begin, 0.0);
        for (int g = 0; g < GROUPS; g++)
            its->pressure[g] = pressure[g] + slope[g] * since;
    } else {
        const double share = to_target(its, phase, speed, distance);
        for (int g = 0; g < GROUPS; g++)
            its->pressure[g] = share > 0.0 ? its->touching[g] + share * (its->full[g] - its->touching[g]) : 0.0;
    }
    const double wanted = speed > 0.0 ? fmin(phase->force, phase->power / speed) : phase->force;
    const double step = phase->rate * its->period;
    its->force = fmin(fmax(wanted, its->force - step), its->force + step);
}
