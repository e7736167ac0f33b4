/* The loop of a stop, sample by sample. Parts in C are called; for a part in Python `cycle` returns, and resumes when
   it is called again.

   Each sample: the plant advances under the commands held since the last sample; its outputs are checked; the sensors
   read; the driver demands; the estimator, when due, predicts under the pressures read at its last step and updates
   with the new reading; the controller, when due, decides. The lower of its demand and the driver's goes to the valves.
   The row of a sample holds the true state at its end, the reading and estimate then, and the demand and command for
   it. */

#include <math.h>

#include "cycle.h"
#include "onboard.h"
#include "rate.h"
#include "vectors.h"

enum {
    BEGIN,
    STEP_PLANT,
    CHECK_PLANT,
    USE_READING,
    USE_ESTIMATE,
    LIMIT_DEMAND,
    SEND_COMMAND
}; /* stage at which a sample resumes */

static int step_plant(Plant *plant, double time)
{
    const int failure = plant->step(plant->interface, time);

    plant->steps += !failure;
    return failure;
}

static int is_braking(const double *demand)
{
    for (int g = 0; g < GROUPS; g++)
        if (demand[g] != 0.0)
            return 1;
    return 0;
}

/* A train that starts at rest has not stopped until it has moved or is braked. */
static int is_standing(Cycle *c)
{
    const double speed = c->plant->outputs[OUTPUT_SPEED];

    c->has_moved |= speed > c->stop_speed;
    return speed <= c->stop_speed && (c->has_moved || is_braking(driver_demand(c)));
}

/* Record the plant's outputs and inputs, and the demands that led to these inputs. */
static void record_plant(const Cycle *c, double *row)
{
    const Record *record = c->record;

    copy(row + record->output, c->plant->outputs, OUTPUTS);
    copy(row + record->input, c->plant->inputs, INPUTS);
    if (record->demand >= 0)
        copy(row + record->demand, c->onboard->demand, GROUPS);
    for (long long i = 0; i < record->law_count; i++)
        row[record->law + i] = record->law_state[record->law_state_at[i]];
    if (record->driver_demand >= 0)
        copy(row + record->driver_demand, c->onboard->driver_demand, GROUPS);
    if (record->traction >= 0)
        row[record->traction] = c->driver->force;
}

static void record_estimate(const Cycle *c, double *row)
{
    copy(row + c->record->estimate, c->onboard->estimate, c->record->estimate_count);
    if (c->record->reference >= 0)
        copy(row + c->record->reference, c->filter->reference, REFERENCES);
}

static int is_within_limits(const Onboard *onboard)
{
    for (int g = 0; g < GROUPS; g++)
        /* Negated, so that NaN is outside. */
        if (!(onboard->demand[g] >= 0.0 && onboard->demand[g] <= onboard->maximum[g]))
            return 0;
    return onboard->is_pascal;
}

static void decide_for_train(Onboard *onboard)
{
    double input[TRAIN_INPUTS];

    copy(input, onboard->observation, OBSERVATIONS);
    copy(input + TRAIN_INPUT_DEMAND, onboard->demand, GROUPS);
    evaluate(&onboard->train_level, input, onboard->demand);
}

/* Run until a part in Python is due, or the stop ends; return which. */
EXPORT int cycle(Cycle *c)
{
    Plant *plant = c->plant;
    Instruments *instruments = c->instruments;
    Onboard *onboard = c->onboard;

    for (;; c->sample++, c->stage = BEGIN) {
        const long long k = c->sample, last = c->record->capacity - 1;
        const int decides = is_due(onboard->controller_rate, k);
        double *row = c->record->rows + (k < last ? k : last) * c->record->width;

        /* Each case stores the next stage before it returns to a part in Python, so that the next call resumes after
           that part. */
        switch (c->stage) {
        case BEGIN:
            if (k > c->samples)
                return AT_HORIZON;
            c->stage = STEP_PLANT;
            if (k % c->block == 0)
                return BLOCK_DUE;
            /* fall through */
        case STEP_PLANT:
            c->stage = CHECK_PLANT;
            if (k > 0 && !plant->step)
                return PLANT_DUE;
            if (k > 0 && (c->failure = step_plant(plant, (double)(k - 1) * c->period)))
                return PLANT_FAILED;
            /* fall through */
        case CHECK_PLANT:
            complete_slip(plant);
            if (!plausible(c->plausibility, k, plant->outputs, plant->inputs))
                return NOT_PLAUSIBLE;
            record_plant(c, row);
            if (c->driver)
                drive(c->driver, k, plant->outputs);
            c->stage = USE_READING;
            if (k % instruments->every)
                fill(instruments->reading, NOTHING, READINGS);
            else if (!instruments->service && !instruments->output_at)
                return SENSORS_DUE;
            else
                read_sensors(instruments, k / instruments->every, plant->outputs);
            /* fall through */
        case USE_READING:
            if (c->faults)
                change_reading(c->faults, k, instruments->reading);
            copy(row + c->record->reading, instruments->reading, READINGS);
            store_readings(c);
            c->stage = USE_ESTIMATE;
            if (filter_is_due(c)) {
                prepare_filter(c);
                if (!c->filter->advance)
                    return ESTIMATOR_DUE;
                if ((c->failure = c->filter->advance(c->filter->memory)))
                    return DIVERGED;
            } else if (onboard->has_estimator && is_due(onboard->estimator_rate, k)) {
                observe(c);
                return ESTIMATOR_DUE;
            }
            /* fall through */
        case USE_ESTIMATE:
            if (filter_is_due(c) && !read_estimate(c)) {
                c->failure = NEGATIVE_VARIANCE;
                return DIVERGED;
            }
            if (c->filter && k == 0)
                read_states(c);
            record_estimate(c, row);
            c->record->written = k + 1; /* now, so that the row is kept if the controller fails */
            c->stage = LIMIT_DEMAND;
            if (decides) {
                observe(c);
                if (onboard->has_estimator)
                    replace_by_estimates(onboard);
                if (!onboard->law.call)
                    return CONTROLLER_DUE;
                evaluate(&onboard->law, onboard->observation, onboard->demand);
            }
            /* fall through */
        case LIMIT_DEMAND:
            c->stage = SEND_COMMAND;
            if (decides && onboard->maximum && !is_within_limits(onboard))
                return LIMITS_DUE;
            /* fall through */
        case SEND_COMMAND:
            if (decides && onboard->train_level.call)
                decide_for_train(onboard);
            if (decides && !compute_command(c))
                return NO_COMMAND;
            copy(plant->inputs + INPUT_COMMAND, onboard->command, GROUPS);
            if (c->faults)
                change_command(c->faults, k, plant->outputs, plant->inputs + INPUT_COMMAND);
            if (is_standing(c))
                return STANDING;
            update_rail_inputs(c);
        }
    }
}
