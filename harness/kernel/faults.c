/* The faults of faults.h; simulate/faults/site.py defines them. */

#include <math.h>

#include "faults.h"
#include "rate.h"
#include "vectors.h"

static const double MIN_FILL = 0.5; /* valve command that counts as fill: commands are -1 vent, 0 hold, 1 fill */

/* Apply the faults of sensors to a reading, in their order. */
EXPORT void change_reading(Faults *faults, long long sample, double *reading)
{
    for (long long i = 0; i < faults->reading_count; i++) {
        Fault *fault = faults->readings + i;
        double *entry = reading + fault->place;
        const int active = sample >= fault->begin && sample < fault->end;
        if (isnan(*entry))
            continue;
        /* A sensor that is faulty from the start delivers its first reading, even if it is dead: the parts start with
           a reading of every sensor. */
        if (!active || isnan(fault->last)) {
            fault->last = *entry;
            if (!active || fault->kind == DEAD)
                continue;
        }
        switch (fault->kind) {
        case DEAD: *entry = NOTHING; break;
        case STUCK: *entry = fault->last; break;
        case SCALED: *entry *= fault->value; break;
        case BIASED: *entry += fault->value; break;
        case NOISY:
            *entry += fault->value * fault->ring[turn_at(faults->noise_rate, sample - fault->begin) % fault->count];
            break;
        }
    }
}

/* Return the pressure of a reservoir, isothermal, after one more sample of its compressor. */
static double reservoir_pressure(Fault *fault, const double *outputs)
{
    const double drawn = outputs[OUTPUT_AIR_USED] - fault->last;

    fault->refilled = fmin(fault->refilled + fault->refill, drawn);
    return fault->pressure - (drawn - fault->refilled) * fault->free_pressure / fault->value;
}

/* Apply the faults of brakes to the commands on their way to the plant. */
EXPORT void change_command(Faults *faults, long long sample, const double *outputs, double *command)
{
    for (long long i = 0; i < faults->command_count; i++) {
        Fault *fault = faults->commands + i;
        const int active = sample >= fault->begin && sample < fault->end;
        double *entry = command + fault->place;
        const double sent = *entry;
        switch (fault->kind) {
        case FIXED:
            if (active)
                *entry = fault->value;
            break;
        case KEPT:
            if (active && !isnan(fault->last))
                *entry = fault->last;
            else
                fault->last = sent;
            break;
        case LATE:
            fault->ring[sample % fault->count] = sent;
            if (active)
                *entry = fault->ring[(sample + 1) % fault->count];
            break;
        case LIMITED:
            if (!active) {
                fault->last = outputs[OUTPUT_AIR_USED];
                fault->refilled = 0.0;
                break;
            }
            if (isnan(fault->last))
                fault->last = outputs[OUTPUT_AIR_USED];
            /* A check valve prevents flow from the cylinder back to the reservoir. */
            const double inside = outputs[OUTPUT_CYLINDER_PRESSURE + fault->place],
                         limit = fmax(reservoir_pressure(fault, outputs), inside);
            if (!faults->valves)
                *entry = fmin(sent, limit);
            else if (sent >= MIN_FILL && limit <= inside)
                *entry = 0.0;
            break;
        }
    }
}
