/* The loop of a stop, sample by sample. Parts in C are called; for a part in Python `cycle` returns, and resumes when it is
   called again.

   Each sample: the plant advances under the commands held since the last sample; its outputs are checked; the sensors read; the
   driver demands; the estimator, when due, predicts under the pressures read one sample before and updates with the new
   reading; the controller, when due, decides. The lower of its demand and the driver's goes to the valves. The row of a sample
   holds the true state at its end, the reading and estimate then, and the demand and command for it. */

#include <math.h>

#include "cycle.h"
#include "onboard.h"
#include "vectors.h"

enum { SET_STEP_GET = 7 };
enum { BEGIN, STEP, CHECK, SHOW, BELIEVE, LIMIT, COMMAND };     /* stage at which a sample resumes */

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

static int brakes_demanded(const Driver *driver)
{
    for (int g = 0; driver && g < GROUPS; g++)
        if (driver->pressure[g] != 0.0)
            return 1;
    return !driver;
}

/* Record the plant's outputs and inputs, and the demands behind the inputs. */
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

static int within_limits(const Cycle *c)
{
    for (int g = 0; g < GROUPS; g++)
        if (!(c->demand[g] >= 0.0 && c->demand[g] <= c->most[g]))   /* negated, so that NaN is outside */
            return 0;
    return c->is_pascal;
}

static void decide_over_the_train(Cycle *c)
{
    copy(c->observation + OBSERVATION_PRESSURE, c->demand, GROUPS);
    c->over.call(c->over.state, c->observation, c->over.parameter, c->demand);
}

static void keep_belief(const Cycle *c, double *row)
{
    copy(row + c->estimates_at, c->estimate, c->estimates_count);
    if (c->reference_at >= 0)
        copy(row + c->reference_at, c->reference, REFERENCES);
}

/* Run until a part in Python is due, or the stop ends; return which. */
EXPORT int cycle(Cycle *c)
{
    for (;; c->sample++, c->stage = BEGIN) {
        const long long k = c->sample;
        const int decides = due(c->controller_every, k);
        double *row = c->rows + (k < c->capacity ? k : c->capacity - 1) * c->width;

        /* Each case stores the next stage before it may return, so that the call after a part in Python resumes behind it. */
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
            complete_slip(c);
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
            } else if (!c->mean && c->estimates_count && due(c->estimator_every, k)) {
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
            c->written = k + 1;              /* already here: a controller that fails now must not cost the row */
            c->stage = LIMIT;
            if (decides) {
                observe_with_estimates(c);
                if (!c->law.call)
                    return CONTROLLER_DUE;
                c->law.call(c->law.state, c->observation, c->law.parameter, c->demand);
            }
            /* fall through */
        case LIMIT:
            c->stage = COMMAND;
            if (decides && c->most && !within_limits(c))
                return LIMITS_DUE;
            /* fall through */
        case COMMAND:
            if (decides && c->over.call)
                decide_over_the_train(c);
            if (decides && !command(c))
                return NO_COMMAND;
            if (c->faults)
                pass_faults(c->faults, k, c->truth, c->command, c->inputs);
            /* A train that starts at rest has not stopped until it has moved or is braked. */
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
