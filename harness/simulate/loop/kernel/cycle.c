/* A stop, sample by sample. A part in C is called; for a part in Python `cycle` returns, and goes on when it is called again.

   Each sample: the plant moves on under the commands held since the last one; its outputs are checked; sensors read; the driver
   asks; the estimator, when due, predicts under the pressures read a sample before and conditions on the new reading; the
   controller, when due, decides. Of its demand and the driver's the lower goes to the valves. The row of a sample holds the
   truth at its end, the reading and belief then, and what was demanded and sent for it. */

#include <math.h>

#include "cycle.h"

enum { SET_STEP_GET = 7 };
enum { BEGIN, STEP, CHECK, SHOW, BELIEVE, COMMAND };     /* where a sample goes on */

static const double NOTHING = 0.0 / 0.0;

static void copy(double *to, const double *from, long long count)
{
    for (long long i = 0; i < count; i++)
        to[i] = from[i];
}

static int step_plant(Cycle *c)
{
    copy(c->taken, c->inputs, INPUTS);
    c->failure = c->cross(c->set_step_get, SET_STEP_GET, (double)(c->sample - 1) * c->period);
    if (c->failure)
        return 0;
    c->crossed++;
    for (long long i = 0; i < c->present_count; i++)
        c->truth[c->present[i]] = c->shown[i];
    return 1;
}

static void read_sensors(Cycle *c)
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

/* Keep the newest reading of every sensor, and what came since the last step of the belief. */
static void see(Cycle *c)
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
        if (new || !c->news)
            c->fresh[i] = reading[i];
    }
    c->news = 1;
}

/* Whether the filter takes a step: its first belief is that of sample 0. */
static int filters(const Cycle *c)
{
    return c->mean && c->sample > 0 && c->sample % c->estimator_every == 0;
}

static void show_filter(Cycle *c)
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

static void look(Cycle *c)
{
    for (int i = 0; i < BELIEVED; i++)
        c->believed[i] = c->mean[c->believed_of[i]];
    for (int i = 0; i < SPREAD; i++) {
        const long long state = c->believed_of[1 + GROUPS + i];
        c->spread[i] = c->covariance[state * c->row + state];
    }
}

/* Take what the filter believes after a step; return whether its variances are some. */
static int believe(Cycle *c)
{
    c->news = 0;
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

/* Whether the filter has lost a wheelset: its deviation at the rim is more than UNKNOWN_SPEED. */
static int unknown(const Cycle *c, int g)
{
    static const double UNKNOWN_SPEED = 1.0;     /* m/s: the sensor is silent */
    const double most = UNKNOWN_SPEED / c->radius[g];
    const long long state = c->believed_of[1 + g];

    return c->covariance[state * c->row + state] > most * most;
}

/* As in vehicle/slip.py, of a speed of the train and one of a wheel at the rim [m/s]. */
static double slip_of(double speed, double rim_speed)
{
    return speed < SMALL_SPEED ? 0.0 : 1.0 - rim_speed / speed;
}

/* Say what is known now, by the filter or else by the newest readings. */
static void observe(Cycle *c)
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

static void observe_with_estimates(Cycle *c)
{
    observe(c);
    for (int i = 0; c->estimates && i < OBSERVATION; i++)
        if (!isnan(c->replaced[i]))
            c->observation[i] = c->replaced[i];
}

/* Turn what was demanded into commands; return whether they are numbers. */
static int command(Cycle *c)
{
    double given[2 * GROUPS], total = 0.0;

    copy(c->command, c->demand, GROUPS);
    for (int g = 0; g < GROUPS; g++)
        total += c->demand[g];
    if (!isfinite(total))                        /* valve logic would take NaN for a wish to hold */
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

static int brakes_demanded(const Driver *driver)
{
    for (int g = 0; driver && g < GROUPS; g++)
        if (driver->pressure[g] != 0.0)
            return 1;
    return !driver;
}

/* Keep what the plant showed and was given, and what was demanded for it. */
static void keep(const Cycle *c, double *row)
{
    copy(row + c->true_at, c->truth, OUTPUTS);
    copy(row + c->sent_at, c->inputs, INPUTS);
    if (c->demand_at >= 0)
        copy(row + c->demand_at, c->demand, GROUPS);
    for (long long i = 0; i < c->law_count; i++)
        row[c->law_at + i] = c->law_state[c->law_of[i]];
    if (c->driver_at >= 0)
        copy(row + c->driver_at, c->driver_demand, GROUPS);
    if (c->traction_at >= 0)
        row[c->traction_at] = c->driver->force;
}

static void keep_belief(const Cycle *c, double *row)
{
    if (c->mean) {
        copy(row + c->believed_at, c->believed, BELIEVED);
        copy(row + c->spread_at, c->spread, SPREAD);
        copy(row + c->innovation_at, c->innovation, INNOVATION);
    }
    if (c->reference_at >= 0)
        copy(row + c->reference_at, c->reference, 1 + GROUPS);
    if (c->estimates)
        copy(row + c->estimates_at, c->estimates, c->estimates_count);
}

/* Go on until a part in Python is due, or the stop ends; return which. */
EXPORT int cycle(Cycle *c)
{
    for (;; c->sample++, c->stage = BEGIN) {
        const long long k = c->sample;
        const int decides = k % c->controller_every == 0;
        double *row = c->rows + (k < c->capacity ? k : c->capacity - 1) * c->width;

        switch (c->stage) {
        case BEGIN:
            if (k > c->samples)
                return AT_HORIZON;
            c->stage = STEP;
            if (k % c->block == 0)
                return BLOCK_DUE;
            /* fall through */
        case STEP:
            c->stage = CHECK;
            if (k > 0 && !c->cross)
                return PLANT_DUE;
            if (k > 0 && !step_plant(c))
                return PLANT_FAILED;
            /* fall through */
        case CHECK:
            for (int g = 0; c->slip_radius && g < GROUPS; g++)
                c->truth[OUTPUT_SLIP + g] =
                    slip_of(c->truth[OUTPUT_SPEED], c->slip_radius[g] * c->truth[OUTPUT_WHEELSET_SPEED + g]);
            if (!plausible(c->plausibility, k, c->truth, c->inputs))
                return NOT_PLAUSIBLE;
            keep(c, row);
            if (c->driver)
                drive(c->driver, k, c->truth);
            c->stage = SHOW;
            if (k % c->sensors_every)
                for (int i = 0; i < READINGS; i++)
                    c->reading[i] = NOTHING;
            else if (!c->service && !c->read_of)
                return SENSORS_DUE;
            else
                read_sensors(c);
            /* fall through */
        case SHOW:
            if (c->faults)
                show_faults(c->faults, k, c->reading);
            copy(row + c->read_at, c->reading, READINGS);
            see(c);
            c->stage = BELIEVE;
            if (filters(c)) {
                show_filter(c);
                if (!c->advance)
                    return ESTIMATOR_DUE;
                if ((c->failure = c->advance(c->memory)))
                    return DIVERGED;
            } else if (c->estimates && k % c->estimator_every == 0) {
                observe(c);
                return ESTIMATOR_DUE;
            }
            /* fall through */
        case BELIEVE:
            if (filters(c) && !believe(c)) {
                c->failure = NEGATIVE_VARIANCE;
                return DIVERGED;
            }
            if (c->mean && k == 0)
                look(c);
            keep_belief(c, row);
            c->written = k + 1;
            c->stage = COMMAND;
            if (decides) {
                observe_with_estimates(c);
                if (!c->law.call)
                    return CONTROLLER_DUE;
                c->law.call(c->law.state, c->observation, c->law.parameter, c->demand);
            }
            /* fall through */
        case COMMAND:
            if (decides && !command(c))
                return NO_COMMAND;
            if (c->faults)
                pass_faults(c->faults, k, c->truth, c->command, c->inputs);
            c->moved |= c->truth[OUTPUT_SPEED] > c->stop_speed;
            if (c->truth[OUTPUT_SPEED] <= c->stop_speed && (c->moved || brakes_demanded(c->driver)))
                return STANDING;
            advance_rail(c->rail, (double)k * c->period, c->truth);
            write_rail_inputs(c->rail, c->inputs);
            if (c->driver)
                c->inputs[INPUT_TRACK_FORCE] += c->driver->force;
        }
    }
}
