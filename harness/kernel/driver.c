/* The driver of driver.h; scenario/demand.py describes it. */

#include <math.h>

#include "driver.h"

/* Times are compared to the nearest sample: k * period may miss "4 s" by a rounding error. */
static int has_ended(const Driver *driver, const Phase *phase, double time, double speed, double distance)
{
    switch (phase->until) {
    case AT_TIME: return time > phase->end - 0.5 * driver->period;
    case AT_DURATION: return time - driver->phase_start > phase->end - 0.5 * driver->period;
    case AT_DISTANCE: return distance >= phase->end;
    case AT_SPEED_BELOW: return speed <= phase->end;
    case AT_SPEED_ABOVE: return speed >= phase->end;
    }
    return 0;
}

/* Gain on the deviation from the braking curve, in addition to the deviation itself: a train that brakes by a share b
   of the expected deceleration then runs on a curve of 2 b / (3 b - 1) times the deceleration, 1.27 for b = 0.7, and
   still ends at the target. A much higher gain would oscillate over the last metre because of the lag of the
   cylinders. */
static const double CORRECTION = 2.0;

/* Return the share of full brake that stops at the target from here; 0 until the braking curve has been reached. */
static double share_to_target(Driver *driver, const Phase *phase, double speed, double distance)
{
    const double remaining = phase->target - distance;

    if (remaining <= 0.0)
        return 1.0;
    const double deceleration = 0.5 * speed * speed / remaining;
    if (deceleration >= phase->deceleration)
        driver->is_on_curve = 1;
    const double corrected = deceleration + CORRECTION * (deceleration - phase->deceleration);
    return driver->is_on_curve ? fmin(corrected / phase->full_deceleration, 1.0) : 0.0;
}

/* Update the driver's brake demand and traction for a sample. */
EXPORT void drive(Driver *driver, long long sample, const double *outputs)
{
    const double time = (double)sample * driver->period, speed = outputs[OUTPUT_SPEED],
                 distance = outputs[OUTPUT_DISTANCE];

    while (driver->phase + 1 < driver->count &&
           has_ended(driver, driver->phases + driver->phase, time, speed, distance)) {
        driver->phase++;
        driver->phase_start = time;
        driver->is_on_curve = 0;
    }
    const Phase *phase = driver->phases + driver->phase;
    if (isnan(phase->target)) {
        const double elapsed = fmax(time - phase->begin, 0.0);
        for (int g = 0; g < GROUPS; g++)
            driver->pressure[g] = phase->pressure[g] + phase->slope[g] * elapsed;
    } else {
        const double share = share_to_target(driver, phase, speed, distance);
        for (int g = 0; g < GROUPS; g++)
            driver->pressure[g] =
                share > 0.0 ? driver->release_pressure[g] + share * (driver->full[g] - driver->release_pressure[g]) : 0.0;
    }
    const double traction = speed > 0.0 ? fmin(phase->force, phase->power / speed) : phase->force;
    const double max_change = phase->rate * driver->period;
    driver->force = fmin(fmax(traction, driver->force - max_change), driver->force + max_change);
}
