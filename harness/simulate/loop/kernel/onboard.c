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
        double given[REFERENCE_INPUTS];
        given[REFERENCE_INPUT_SPEED] = c->fresh[READING_SPEED];
        copy(given + REFERENCE_INPUT_WHEELSET_SPEED, c->latest + READING_WHEELSET_SPEED, GROUPS);
        copy(given + REFERENCE_INPUT_PRESSURE, c->latest + READING_CYLINDER_PRESSURE, GROUPS);
        c->free_wheel.call(c->free_wheel.state, given, c->free_wheel.parameter, c->reference);
        c->fresh[READING_SPEED] = c->reference[REFERENCE_SPEED];
    }
    for (long long i = 0; i < c->seen_count; i++)
        c->seen[i] = c->fresh[c->seen_of[i]];
}

static double variance(const Cycle *c, int estimate)
{
    const long long state = c->state_of[estimate];

    return c->covariance[state * c->row + state];
}

void look(Cycle *c)
{
    for (int i = 0; i < STATES; i++)
        c->estimate[i] = c->mean[c->state_of[i]];
    for (int g = 0; g < GROUPS; g++) {
        c->estimate[ESTIMATE_ADHESION_SD + g] = variance(c, ESTIMATE_ADHESION + g);
        c->estimate[ESTIMATE_PAD_FRICTION_SD + g] = variance(c, ESTIMATE_PAD_FRICTION + g);
    }
}

/* Read the filter's estimate after a step; return 0 if any variance is negative or NaN. */
int believe(Cycle *c)
{
    c->news = 0;
    /* After the step: these pressures act during the next period. */
    copy(c->held, c->latest + READING_CYLINDER_PRESSURE, GROUPS);
    look(c);
    c->estimate[ESTIMATE_NIS] = *c->squared;
    c->estimate[ESTIMATE_READINGS] = 0.0;
    for (long long i = 0; i < c->seen_count; i++)
        c->estimate[ESTIMATE_READINGS] += c->used[i];
    for (int g = 0; g < GROUPS; g++)
        if (!(c->estimate[ESTIMATE_ADHESION_SD + g] >= 0.0 && c->estimate[ESTIMATE_PAD_FRICTION_SD + g] >= 0.0))
            return 0;
    return 1;
}

/* Whether the filter has lost a wheelset: its standard deviation at the rim exceeds UNKNOWN_SPEED. */
static int unknown(const Cycle *c, int g)
{
    static const double UNKNOWN_SPEED = 1.0;     /* m/s: reached when the sensor is silent */
    const double limit = UNKNOWN_SPEED / c->radius[g];

    return variance(c, ESTIMATE_WHEELSET_SPEED + g) > limit * limit;
}

/* Write the observation: the filter's estimates if there is a filter, else the newest readings. */
void observe(Cycle *c)
{
    const double speed = c->mean ? c->estimate[ESTIMATE_SPEED] : c->latest[READING_SPEED];
    const double *wheel = c->mean ? c->estimate + ESTIMATE_WHEELSET_SPEED : c->latest + READING_WHEELSET_SPEED;
    double *observation = c->observation;

    observation[OBSERVATION_SPEED] = speed;
    observation[OBSERVATION_ACCELERATION] = c->latest[READING_ACCELERATION];
    for (int g = 0; g < GROUPS; g++) {
        observation[OBSERVATION_SLIP + g] = slip_of(speed, c->radius[g] * wheel[g]);
        observation[OBSERVATION_ADHESION + g] = c->mean ? c->estimate[ESTIMATE_ADHESION + g] : NOTHING;
        observation[OBSERVATION_PAD_FRICTION + g] = c->mean ? c->estimate[ESTIMATE_PAD_FRICTION + g] : NOTHING;
        observation[OBSERVATION_WHEELSET_SPEED + g] = c->mean && unknown(c, g) ? NOTHING : wheel[g];
        observation[OBSERVATION_DRIVER_DEMAND + g] = c->driver ? c->driver->pressure[g] : c->full[g];
        observation[OBSERVATION_PRESSURE + g] = c->latest[READING_CYLINDER_PRESSURE + g];
    }
}

void observe_with_estimates(Cycle *c)
{
    observe(c);
    for (int i = 0; !c->mean && c->estimates_count && i < OBSERVATIONS; i++)
        if (!isnan(c->replaced[i]))
            c->observation[i] = c->replaced[i];
}

/* Whether the values of all groups are finite: the sum of finite pressures or commands does not overflow. */
static int all_finite(const double *values)
{
    double sum = 0.0;

    for (int g = 0; g < GROUPS; g++)
        sum += values[g];
    return isfinite(sum);
}

/* Convert demands to commands; return whether the commands are finite. */
int command(Cycle *c)
{
    double given[VALVE_INPUTS], *limited = given + VALVE_INPUT_DEMAND;

    copy(c->command, c->demand, GROUPS);
    if (!all_finite(c->demand))                      /* the valve logic would treat NaN as a demand to hold */
        return 0;
    if (c->driver)
        copy(c->driver_demand, c->driver->pressure, GROUPS);
    for (int g = 0; g < GROUPS; g++) {
        limited[g] = c->free_wheel.call && c->reference[REFERENCE_TEST_RELEASE + g] != 0.0 ? 0.0 : c->demand[g];
        if (c->driver && c->driver->binding && limited[g] > c->driver_demand[g])
            limited[g] = c->driver_demand[g];
    }
    if (c->valves.call) {
        copy(given + VALVE_INPUT_PRESSURE, c->latest + READING_CYLINDER_PRESSURE, GROUPS);
        c->valves.call(c->valves.state, given, c->valves.parameter, c->command);
    } else
        copy(c->command, limited, GROUPS);
    copy(c->inputs + INPUT_COMMAND, c->command, GROUPS);
    return all_finite(c->command);
}
