/* The onboard parts in a sample: readings, estimate, decision. They are called by the loop (cycle.c), and by the FMUs of single
   parts (exported.c). */

#include <math.h>

#include "onboard.h"
#include "vectors.h"

/* Slip from a train speed and a wheel's peripheral speed [m/s], as in vehicle/slip.py. */
static double slip_of(double speed, double rim_speed)
{
    return speed < SMALL_SPEED ? 0.0 : 1.0 - rim_speed / speed;
}

/* Compute the slip of a plant that does not output it. */
void complete_slip(Cycle *c)
{
    for (int g = 0; c->slip_radius && g < GROUPS; g++)
        c->truth[OUTPUT_SLIP + g] =
            slip_of(c->truth[OUTPUT_SPEED], c->slip_radius[g] * c->truth[OUTPUT_WHEELSET_SPEED + g]);
}

void read_sensors(Cycle *c)
{
    const long long sample = c->sample / c->sensors_every;

    if (c->service)
        read_service(c->service, sample, c->truth, c->reading);
    else
        for (int i = 0; i < READINGS; i++) {
            c->reading[i] = c->truth[c->read_of[i]];
            if (c->noise)
                c->reading[i] = c->reading[i] * c->gain[i] + c->bias[i] + c->noise[sample % c->block * READINGS + i];
        }
}

/* Store the newest reading of every sensor, and the readings that are new since the last step of the filter. */
void see(Cycle *c)
{
    const double *reading = c->reading;

    if (!c->any) {
        copy(c->latest, reading, READINGS);
        c->any = 1;
        if (c->mean)
            copy(c->held, reading + READING_CYLINDER_PRESSURE, GROUPS);
        return;
    }
    for (int i = 0; i < READINGS; i++) {
        const int new = !isnan(reading[i]);
        if (new)
            c->latest[i] = reading[i];
        /* A filter that is slower than the sensors must not lose readings between its steps. */
        if (new || !c->news)
            c->fresh[i] = reading[i];
    }
    c->news = 1;
}

/* Whether the filter takes a step; not at sample 0, whose estimate is the initial one. */
int filters(const Cycle *c)
{
    return c->mean && c->sample > 0 && due(c->estimator_every, c->sample);
}

void show_filter(Cycle *c)
{
    if (c->free_wheel.call) {
        double given[1 + 2 * GROUPS];
        given[0] = c->fresh[READING_SPEED];
        copy(given + 1, c->latest + READING_WHEELSET_SPEED, GROUPS);
        copy(given + 1 + GROUPS, c->latest + READING_CYLINDER_PRESSURE, GROUPS);
        c->free_wheel.call(c->free_wheel.state, given, c->free_wheel.parameter, c->reference);
        c->fresh[READING_SPEED] = c->reference[0];
    }
    for (long long i = 0; i < c->seen_count; i++)
        c->seen[i] = c->fresh[c->seen_of[i]];
}

void look(Cycle *c)
{
    for (int i = 0; i < BELIEVED; i++)
        c->believed[i] = c->mean[c->believed_of[i]];
    for (int i = 0; i < SPREAD; i++) {
        const long long state = c->believed_of[1 + GROUPS + i];
        c->spread[i] = c->covariance[state * c->row + state];
    }
}

/* Read the filter's estimate after a step; return 0 if any variance is negative or NaN. */
int believe(Cycle *c)
{
    c->news = 0;
    /* After the step: these pressures act during the next period. */
    copy(c->held, c->latest + READING_CYLINDER_PRESSURE, GROUPS);
    look(c);
    c->innovation[0] = *c->squared;
    c->innovation[1] = 0.0;
    for (long long i = 0; i < c->seen_count; i++)
        c->innovation[1] += c->used[i];
    for (int i = 0; i < SPREAD; i++)
        if (!(c->spread[i] >= 0.0))
            return 0;
    return 1;
}

/* Whether the filter has lost a wheelset: its standard deviation at the rim exceeds UNKNOWN_SPEED. */
static int unknown(const Cycle *c, int g)
{
    static const double UNKNOWN_SPEED = 1.0;     /* m/s: reached when the sensor is silent */
    const double most = UNKNOWN_SPEED / c->radius[g];
    const long long state = c->believed_of[1 + g];

    return c->covariance[state * c->row + state] > most * most;
}

/* Write the observation: the filter's estimates if there is a filter, else the newest readings. */
void observe(Cycle *c)
{
    const double speed = c->mean ? c->believed[0] : c->latest[READING_SPEED];
    const double *wheel = c->mean ? c->believed + 1 : c->latest + READING_WHEELSET_SPEED;
    double *shown = c->observation;

    shown[0] = speed;
    shown[1] = c->latest[READING_ACCELERATION];
    for (int g = 0; g < GROUPS; g++) {
        shown[2 + g] = slip_of(speed, c->radius[g] * wheel[g]);
        shown[2 + GROUPS + g] = c->mean ? c->believed[1 + GROUPS + g] : NOTHING;
        shown[2 + 2 * GROUPS + g] = c->mean ? c->believed[1 + 2 * GROUPS + g] : NOTHING;
        shown[2 + 3 * GROUPS + g] = c->mean && unknown(c, g) ? NOTHING : wheel[g];
        shown[2 + 4 * GROUPS + g] = c->driver ? c->driver->pressure[g] : c->full[g];
        shown[2 + 5 * GROUPS + g] = c->latest[READING_CYLINDER_PRESSURE + g];
    }
}

void observe_with_estimates(Cycle *c)
{
    observe(c);
    for (int i = 0; c->estimates && i < OBSERVATION; i++)
        if (!isnan(c->replaced[i]))
            c->observation[i] = c->replaced[i];
}

/* Convert demands to commands; return whether the commands are finite. */
int command(Cycle *c)
{
    double given[2 * GROUPS], total = 0.0;

    copy(c->command, c->demand, GROUPS);
    for (int g = 0; g < GROUPS; g++)
        total += c->demand[g];
    if (!isfinite(total))                        /* the valve logic would treat NaN as a demand to hold */
        return 0;
    for (int g = 0; g < GROUPS; g++)
        given[g] = c->free_wheel.call && c->reference[1 + g] != 0.0 ? 0.0 : c->demand[g];
    if (c->driver) {
        copy(c->driver_demand, c->driver->pressure, GROUPS);
        for (int g = 0; g < GROUPS && c->driver->binding; g++)
            given[g] = given[g] > c->driver_demand[g] ? c->driver_demand[g] : given[g];
    }
    copy(c->command, given, GROUPS);
    if (c->valves.call) {
        copy(given + GROUPS, c->latest + READING_CYLINDER_PRESSURE, GROUPS);
        c->valves.call(c->valves.state, given, c->valves.parameter, c->command);
        for (int g = 0; g < GROUPS; g++)
            total += c->command[g];
    }
    copy(c->inputs, c->command, GROUPS);
    return isfinite(total);
}
