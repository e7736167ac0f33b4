/* A stop, sample by sample, in C: what cycle.py and watch.py do, to the same bits, when every party can be called from C.

   The structs are mirrored in compiled_cycle.py, field by field. */

#include <math.h>

#include "driver.h"
#include "faults.h"
#include "plausible.h"
#include "rail.h"
#include "sensors.h"

typedef int Cross(void *, int, double);
typedef int Advance(double *);
typedef void Call(double *, const double *, const double *, double *);

enum { SET_STEP_GET = 7 };
enum { GOING, STANDING, PLANT_FAILED, DIVERGED, NO_COMMAND, IMPLAUSIBLE };
enum { NOISE_BLOCK = 1024 };                     /* `BLOCK` in sensors.py */
enum { NEGATIVE_VARIANCE = -1 };                 /* beside the failures of the filter */
enum { BELIEVED = 1 + 3 * GROUPS, SPREAD = 2 * GROUPS, INNOVATION = 2 };

typedef struct {
    Call *call;                                  /* null: there is none */
    double *state;
    const double *parameter;
} Formula;

typedef struct {
    /* the plant */
    Cross *cross;
    void *set_step_get;
    double *taken;
    const double *shown;
    const long long *present;                    /* places of what is shown among all outputs */
    const double *slip_radius;                   /* null: slip is among them; else it follows from speeds and these radii */
    /* instruments; null: the outputs themselves, with errors if there is noise */
    Service *service;
    const long long *read_of;
    const double *gain, *bias, *noise;           /* rows of READINGS for NOISE_BLOCK samples from a multiple of it on */
    /* the filter; null: there is none */
    Advance *advance;
    double *block, *held, *seen;
    const double *mean, *covariance, *squared, *used; /* of the last step: NIS, and 1 for every reading in it */
    const long long *seen_of, *believed_of;      /* places in a reading; among the states */
    const long long *law_of;                     /* places among the law's states of those that are kept */
    const double *radius;
    Formula law, valves, free_wheel;
    Plausibility *plausibility;
    Rail *rail;
    Driver *driver;                              /* null: full brake */
    const double *full;                          /* pressures of that */
    Faults *faults;                              /* null: there are none */
    double period, stop_speed;
    double *rows;
    double truth[OUTPUTS], inputs[INPUTS], latest[READINGS], fresh[READINGS], believed[BELIEVED], spread[SPREAD], innovation[INNOVATION];
    double reference[1 + GROUPS];                /* speed for the filter; 1 for each group that is to be released */
    double command[GROUPS], demand[GROUPS], driver_demand[GROUPS];   /* driver's: at the last decision */
    long long present_count, width, capacity, seen_count; /* numbers of a row; rows, the last for all samples beyond */
    long long sensors_every, estimator_every, controller_every, row, true_at, sent_at, read_at, believed_at, spread_at, innovation_at;
    long long demand_at, driver_at, traction_at, reference_at, law_at, law_count; /* -1: it is not kept */
    long long any, news;                         /* whether a reading has come; one since the last step of the belief */
    long long crossed, sample, written, failure; /* steps of the plant that succeeded */
    long long moved;                             /* whether the train has been faster than stop_speed */
} Cycle;

static void copy(double *to, const double *from, long long count)
{
    for (long long i = 0; i < count; i++)
        to[i] = from[i];
}

static void read_all(const Cycle *c, double *reading)
{
    static const double NOTHING_NEW = 0.0 / 0.0;
    const long long sample = c->sample / c->sensors_every;

    if (c->sample % c->sensors_every)
        for (int i = 0; i < READINGS; i++)
            reading[i] = NOTHING_NEW;
    else if (c->service)
        read_service(c->service, sample, c->truth, reading);
    else
        for (int i = 0; i < READINGS; i++) {
            reading[i] = c->truth[c->read_of[i]];
            if (c->noise)
                reading[i] = reading[i] * c->gain[i] + c->bias[i] + c->noise[sample % NOISE_BLOCK * READINGS + i];
        }
}

/* Keep the newest reading of every sensor, and what came since the last step of the belief. */
static void see(Cycle *c, const double *reading)
{
    if (!c->any) {
        copy(c->latest, reading, READINGS);
        c->any = 1;
        if (c->advance)
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

static void look(Cycle *c)
{
    for (int i = 0; i < BELIEVED; i++)
        c->believed[i] = c->mean[c->believed_of[i]];
    for (int i = 0; i < SPREAD; i++) {
        const long long state = c->believed_of[1 + GROUPS + i];
        c->spread[i] = c->covariance[state * c->row + state];
    }
}

static long long believe(Cycle *c)
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
    const int failure = c->advance(c->block);
    if (failure)
        return failure;
    c->news = 0;
    copy(c->held, c->latest + READING_CYLINDER_PRESSURE, GROUPS);
    look(c);
    c->innovation[0] = *c->squared;
    c->innovation[1] = 0.0;
    for (long long i = 0; i < c->seen_count; i++)
        c->innovation[1] += c->used[i];
    for (int i = 0; i < SPREAD; i++)
        if (!(c->spread[i] >= 0.0))
            return NEGATIVE_VARIANCE;
    return 0;
}

/* Whether the filter has lost a wheelset: its deviation at the rim is more than UNKNOWN_SPEED. */
static int unknown(const Cycle *c, int g)
{
    static const double UNKNOWN_SPEED = 1.0;
    const double most = UNKNOWN_SPEED / c->radius[g];
    const long long state = c->believed_of[1 + g];

    return c->covariance[state * c->row + state] > most * most;
}

/* What the law sees is in the order of controllers/law.py; below SMALL_SPEED slip would be a ratio of two noises. */
static int decide(Cycle *c)
{
    static const double SMALL_SPEED = 0.05, UNKNOWN = 0.0 / 0.0;
    double given[2 + 6 * GROUPS], demand[2 * GROUPS], total = 0.0;
    const double speed = c->advance ? c->believed[0] : c->latest[READING_SPEED];
    const double *wheel = c->advance ? c->believed + 1 : c->latest + READING_WHEELSET_SPEED;

    given[0] = speed;
    given[1] = c->latest[READING_ACCELERATION];
    for (int g = 0; g < GROUPS; g++) {
        given[2 + g] = speed < SMALL_SPEED ? 0.0 : 1.0 - c->radius[g] * wheel[g] / speed;
        given[2 + GROUPS + g] = c->advance ? c->believed[1 + GROUPS + g] : UNKNOWN;
        given[2 + 2 * GROUPS + g] = c->advance ? c->believed[1 + 2 * GROUPS + g] : UNKNOWN;
        given[2 + 3 * GROUPS + g] = c->advance && unknown(c, g) ? UNKNOWN : wheel[g];
        given[2 + 4 * GROUPS + g] = c->driver ? c->driver->pressure[g] : c->full[g];
        given[2 + 5 * GROUPS + g] = c->latest[READING_CYLINDER_PRESSURE + g];
    }
    c->law.call(c->law.state, given, c->law.parameter, demand);
    copy(c->demand, demand, GROUPS);
    for (int g = 0; g < GROUPS; g++) {
        total += demand[g];
        if (c->free_wheel.call && c->reference[1 + g] != 0.0)
            demand[g] = 0.0;
    }
    if (c->driver) {                              /* in this form, a demand that is no number stays none */
        copy(c->driver_demand, c->driver->pressure, GROUPS);
        for (int g = 0; g < GROUPS && c->driver->binding; g++)
            demand[g] = demand[g] > c->driver_demand[g] ? c->driver_demand[g] : demand[g];
    }
    copy(c->command, demand, GROUPS);
    if (isfinite(total) && c->valves.call) {      /* valve logic would take NaN for a wish to hold */
        copy(demand + GROUPS, c->latest + READING_CYLINDER_PRESSURE, GROUPS);
        c->valves.call(c->valves.state, demand, c->valves.parameter, c->command);
        for (int g = 0; g < GROUPS; g++)
            total += c->command[g];
    }
    return isfinite(total);
}

static int brakes_demanded(const Driver *driver)
{
    for (int g = 0; driver && g < GROUPS; g++)
        if (driver->pressure[g] != 0.0)
            return 1;
    return !driver;
}

/* Go on until the sample `until` is due, or something ends the stop. */
EXPORT int cycle(Cycle *c, long long until)
{
    for (; c->sample < until; c->sample++) {
        const long long k = c->sample;
        double *row = c->rows + (k < c->capacity ? k : c->capacity - 1) * c->width;

        if (k > 0) {
            copy(c->taken, c->inputs, INPUTS);
            c->failure = c->cross(c->set_step_get, SET_STEP_GET, (double)(k - 1) * c->period);
            if (c->failure)
                return PLANT_FAILED;
            c->crossed++;
            for (long long i = 0; i < c->present_count; i++)
                c->truth[c->present[i]] = c->shown[i];
            for (int g = 0; c->slip_radius && g < GROUPS; g++)
                c->truth[OUTPUT_SLIP + g] = 1.0 - c->slip_radius[g] * c->truth[OUTPUT_WHEELSET_SPEED + g] /
                                                      fmax(c->truth[OUTPUT_SPEED], 1e-3);
        }
        if (!plausible(c->plausibility, k, c->truth, c->inputs))
            return IMPLAUSIBLE;
        copy(row + c->true_at, c->truth, OUTPUTS);
        copy(row + c->sent_at, c->inputs, INPUTS);
        if (c->demand_at >= 0)
            copy(row + c->demand_at, c->demand, GROUPS);
        for (long long i = 0; i < c->law_count; i++)
            row[c->law_at + i] = c->law.state[c->law_of[i]];
        if (c->driver) {
            copy(row + c->driver_at, c->driver_demand, GROUPS);
            if (c->traction_at >= 0)
                row[c->traction_at] = c->driver->force;
            drive(c->driver, k, c->truth);
        }
        read_all(c, row + c->read_at);
        if (c->faults)
            show_faults(c->faults, k, row + c->read_at);
        see(c, row + c->read_at);
        if (c->advance) {
            if (k == 0)
                look(c);
            else if (k % c->estimator_every == 0 && (c->failure = believe(c)))
                return DIVERGED;
            copy(row + c->believed_at, c->believed, BELIEVED);
            copy(row + c->spread_at, c->spread, SPREAD);
            copy(row + c->innovation_at, c->innovation, INNOVATION);
            if (c->reference_at >= 0)
                copy(row + c->reference_at, c->reference, 1 + GROUPS);
        }
        c->written = k + 1;
        if (k % c->controller_every == 0) {
            if (!decide(c))
                return NO_COMMAND;
            copy(c->inputs, c->command, GROUPS);
        }
        if (c->faults)
            pass_faults(c->faults, k, c->truth, c->command, c->inputs);
        c->moved |= c->truth[OUTPUT_SPEED] > c->stop_speed;
        if (c->truth[OUTPUT_SPEED] <= c->stop_speed && (c->moved || brakes_demanded(c->driver)))
            return STANDING;
        roll(c->rail, (double)k * c->period, c->truth);
        copy(c->inputs + INPUT_MU0, c->rail->mu0, WHEELSETS);
        c->inputs[INPUT_TRACK_FORCE] = c->rail->force;
#ifdef INPUT_CURVE_K_A
        copy(c->inputs + INPUT_CURVE_K_A, c->rail->curve, 4 * WHEELSETS);
#endif
        if (c->driver)
            c->inputs[INPUT_TRACK_FORCE] += c->driver->force;
    }
    return GOING;
}
