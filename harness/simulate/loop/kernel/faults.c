/* The faults of faults.h; faults.py defines them. */

#include <math.h>

#include "faults.h"

static const double NOTHING_SHOWN = 0.0 / 0.0;
static const double NEARLY_OPEN = 0.5;           /* command at which a fill valve opens */

/* Apply the faults of sensors to a reading, in their order. */
EXPORT void change_reading(Faults *its, long long sample, double *reading)
{
    for (long long i = 0; i < its->reading_count; i++) {
        Fault *fault = its->readings + i;
        double *entry = reading + fault->place;
        if (isnan(*entry))
            continue;
        /* Without a reading before the fault, the first one under it serves as the last one. */
        if (sample < fault->begin || sample >= fault->end || isnan(fault->held)) {
            fault->held = *entry;
            if (sample < fault->begin || sample >= fault->end || fault->kind == DEAD)
                continue;
        }
        switch (fault->kind) {
        case DEAD: *entry = NOTHING_SHOWN; break;
        case STUCK: *entry = fault->held; break;
        case SCALED: *entry *= fault->value; break;
        case BIASED: *entry += fault->value; break;
        case NOISY: *entry += fault->value * fault->past[turn(its->noise_every, sample - fault->begin) % fault->count]; break;
        }
    }
}

/* Return the pressure of a reservoir after one more sample of its compressor. */
static double left(Fault *fault, const double *truth)
{
    const double used = truth[OUTPUT_AIR_USED] - fault->held;

    fault->refilled = fmin(fault->refilled + fault->refill, used);
    return fault->pressure - (used - fault->refilled) * fault->free / fault->value;
}

/* Apply the faults of brakes to the commands, so that they become those that reach the plant. */
EXPORT void change_command(Faults *its, long long sample, const double *truth, double *command)
{
    for (long long i = 0; i < its->command_count; i++) {
        Fault *fault = its->commands + i;
        const int active = sample >= fault->begin && sample < fault->end;
        double *entry = command + fault->place;
        const double came = *entry;
        switch (fault->kind) {
        case FIXED:
            if (active)
                *entry = fault->value;
            break;
        case KEPT:
            if (active && !isnan(fault->held))
                *entry = fault->held;
            else
                fault->held = came;
            break;
        case LATE:
            fault->past[sample % fault->count] = came;
            if (active)
                *entry = fault->past[(sample + 1) % fault->count];
            break;
        case LIMITED:
            if (!active) {
                fault->held = truth[OUTPUT_AIR_USED];
                fault->refilled = 0.0;
                break;
            }
            if (isnan(fault->held))
                fault->held = truth[OUTPUT_AIR_USED];
            /* A check valve prevents flow from the cylinder back to the reservoir. */
            const double inside = truth[OUTPUT_CYLINDER_PRESSURE + fault->place], most = fmax(left(fault, truth), inside);
            if (!its->valves)
                *entry = fmin(came, most);
            else if (came >= NEARLY_OPEN && most <= inside)
                *entry = 0.0;
            break;
        }
    }
}
