/* The parts of a sample: readings, estimate, decision, rail. They are called by the loop (cycle.c), and by the FMUs of
   single parts (exported.c). With ONBOARD_ALONE those of the plant's side are left out. */

#include <math.h>

#include "onboard.h"
#include "rate.h"
#include "vectors.h"

void evaluate(const Formula *formula, const double *input, double *output)
{
    formula->call(formula->state, input, formula->parameter, output);
}

/* Slip from a train speed and a wheel's peripheral speed [m/s], as in vehicle/brake.py. */
static double slip_of(double speed, double rim_speed)
{
    return speed < SMALL_SPEED ? 0.0 : 1.0 - rim_speed / speed;
}

/* Store the newest reading of every sensor, and those that are new since the last step of the filter. The first reading
   only starts the filter's inputs: its initial estimate belongs to the same instant. */
void store_readings(Cycle *c)
{
    const double *reading = c->instruments->reading;
    Onboard *onboard = c->onboard;
    Filter *filter = c->filter;

    if (!onboard->has_reading) {
        copy(onboard->reading, reading, READINGS);
        onboard->has_reading = 1;
        if (filter)
            copy(filter->inputs, reading + READING_CYLINDER_PRESSURE, GROUPS);
        return;
    }
    for (int i = 0; i < READINGS; i++) {
        const int is_new = !isnan(reading[i]);
        if (is_new)
            onboard->reading[i] = reading[i];
        /* A filter that is slower than the sensors must not lose readings between its steps. */
        if (filter && (is_new || !filter->has_new_reading))
            filter->new_reading[i] = reading[i];
    }
    if (filter)
        filter->has_new_reading = 1;
}

/* Whether the filter takes a step; not at sample 0, whose estimate is the initial one. */
int filter_is_due(const Cycle *c)
{
    return c->filter && c->sample > 0 && is_due(c->onboard->estimator_rate, c->sample);
}

/* Write the readings for the next step of the filter. */
void prepare_filter(Cycle *c)
{
    Filter *filter = c->filter;

    if (filter->reference_speed.call) {
        double input[REFERENCE_INPUTS];
        input[REFERENCE_INPUT_SPEED] = filter->new_reading[READING_SPEED];
        copy(input + REFERENCE_INPUT_WHEELSET_SPEED, c->onboard->reading + READING_WHEELSET_SPEED, GROUPS);
        copy(input + REFERENCE_INPUT_PRESSURE, c->onboard->reading + READING_CYLINDER_PRESSURE, GROUPS);
        evaluate(&filter->reference_speed, input, filter->reference);
        filter->new_reading[READING_SPEED] = filter->reference[REFERENCE_SPEED];
    }
    for (long long i = 0; i < filter->reading_count; i++)
        filter->readings[i] = filter->new_reading[filter->reading_at[i]];
}

static double variance(const Filter *filter, int estimate)
{
    const long long state = filter->state_at[estimate];

    return filter->covariance[state * filter->stride + state];
}

/* Read the estimates that are states of the filter, and variances in place of the standard deviations. */
void read_states(Cycle *c)
{
    double *estimate = c->onboard->estimate;

    for (int i = 0; i < ESTIMATE_ADHESION_SD; i++) /* standard deviations follow the states */
        estimate[i] = c->filter->mean[c->filter->state_at[i]];
    for (int g = 0; g < GROUPS; g++) {
        estimate[ESTIMATE_ADHESION_SD + g] = variance(c->filter, ESTIMATE_ADHESION + g);
        estimate[ESTIMATE_PAD_FRICTION_SD + g] = variance(c->filter, ESTIMATE_PAD_FRICTION + g);
    }
}

/* The pressures [Pa] that the driver demands; without a driver those of full brake. */
const double *driver_demand(const Cycle *c)
{
    return c->driver ? c->driver->pressure : c->onboard->full;
}

/* The demand for magnetic track brakes: that of the law, else 1 in an emergency brake, in which all groups are to brake
   fully, and 0 otherwise. It is always 1 for a plant without an input for it. */
static double magnets_demanded(const Onboard *onboard, const double *pressure)
{
#ifdef INPUT_MAGNETS
    if (onboard->magnets)
        return *onboard->magnets;
    for (int g = 0; g < GROUPS; g++)
        if (pressure[g] < onboard->full[g])
            return 0.0;
#endif
    (void)onboard, (void)pressure;
    return 1.0;
}

#ifdef INPUT_BRAKE_DEMAND
/* The brake demand of the driver over full pressure, in the group where it is largest. */
static double largest_share(const Onboard *onboard, const double *pressure)
{
    double share = 0.0;

    for (int g = 0; g < GROUPS; g++)
        share = fmax(share, pressure[g] / onboard->full[g]);
    return share;
}
#endif

/* Write the highest pressure that each group may demand: that of the driver. Where the command of the train brings the
   largest demand to all distributors, the valves of the groups that have it are open, and those of other groups hold
   theirs. */
static void largest_demands(const Cycle *c, double *largest)
{
    const Onboard *onboard = c->onboard;

    copy(largest, driver_demand(c), GROUPS);
#ifdef INPUT_BRAKE_DEMAND
    const double share = largest_share(onboard, largest) * (1.0 - 1e-9);
    for (int g = 0; g < GROUPS; g++)
        if (largest[g] >= share * onboard->full[g])
            largest[g] = onboard->full[g];
#endif
}

/* The assumed braking force on the body, by the last commands. */
static double body_force(Cycle *c)
{
    const Onboard *onboard = c->onboard;
    double input[BODY_FORCE_INPUTS], force, largest = 0.0;

    for (int g = 0; g < GROUPS; g++)
        largest = fmax(largest, onboard->command[g]);
    input[BODY_FORCE_INPUT_SPEED] = onboard->estimate[ESTIMATE_SPEED];
    input[BODY_FORCE_INPUT_APPLIED] = largest > 0.0;
    input[BODY_FORCE_INPUT_EMERGENCY] = 1.0;
#ifdef INPUT_BRAKE_DEMAND
    input[BODY_FORCE_INPUT_EMERGENCY] = largest_share(onboard, onboard->driver_demand) >= 1.0;
#endif
    input[BODY_FORCE_INPUT_MAGNETS] = magnets_demanded(onboard, onboard->driver_demand);
    evaluate(&c->filter->body_force, input, &force);
    return force;
}

/* Write the forces on the body that are known on board to the filter's force of the track. */
static void predict_track_force(Cycle *c)
{
    const double traction = c->driver ? c->driver->force : 0.0;
    const double braking = c->filter->body_force.call ? body_force(c) : 0.0;

    if (c->filter->track_force >= 0)
        c->filter->inputs[c->filter->track_force] = traction - braking;
}

/* Read the filter's estimate after a step; return 0 if any variance is negative or NaN. */
int read_estimate(Cycle *c)
{
    double *estimate = c->onboard->estimate, count = 0.0;
    Filter *filter = c->filter;

    filter->has_new_reading = 0;
    /* Only now, because these pressures act during the next period. */
    copy(filter->inputs, c->onboard->reading + READING_CYLINDER_PRESSURE, GROUPS);
    read_states(c);
    predict_track_force(c);
    for (long long i = 0; i < filter->reading_count; i++)
        count += filter->selection[i];
    estimate[ESTIMATE_NIS] = *filter->squared_innovation;
    estimate[ESTIMATE_READINGS] = count;
    for (int g = 0; g < GROUPS; g++)
        if (!(estimate[ESTIMATE_ADHESION_SD + g] >= 0.0 && estimate[ESTIMATE_PAD_FRICTION_SD + g] >= 0.0))
            return 0;
    return 1;
}

/* Whether the filter has lost a wheelset, for example after its sensor has failed: the standard deviation of its rim
   speed exceeds the maximum, which docs/faults.md states. */
static int is_lost(const Cycle *c, int group)
{
    static const double MAX_DEVIATION = 1.0; /* m/s */
    const double deviation = MAX_DEVIATION / c->onboard->radius[group];

    return variance(c->filter, ESTIMATE_WHEELSET_SPEED + group) > deviation * deviation;
}

/* Write the observation from the estimates of a filter, else from the newest readings. */
void observe(Cycle *c)
{
    const Onboard *onboard = c->onboard;
    const double *reading = onboard->reading, *estimate = onboard->estimate;
    const double speed = c->filter ? estimate[ESTIMATE_SPEED] : reading[READING_SPEED];
    const double *wheelset_speed = c->filter ? estimate + ESTIMATE_WHEELSET_SPEED : reading + READING_WHEELSET_SPEED;
    double largest[GROUPS], *observation = c->onboard->observation;

    largest_demands(c, largest);
    observation[OBSERVATION_SPEED] = speed;
    observation[OBSERVATION_ACCELERATION] = reading[READING_ACCELERATION];
    for (int g = 0; g < GROUPS; g++) {
        observation[OBSERVATION_SLIP + g] = slip_of(speed, onboard->radius[g] * wheelset_speed[g]);
        observation[OBSERVATION_ADHESION + g] = c->filter ? estimate[ESTIMATE_ADHESION + g] : NOTHING;
        observation[OBSERVATION_PAD_FRICTION + g] = c->filter ? estimate[ESTIMATE_PAD_FRICTION + g] : NOTHING;
        observation[OBSERVATION_WHEELSET_SPEED + g] = c->filter && is_lost(c, g) ? NOTHING : wheelset_speed[g];
        observation[OBSERVATION_DRIVER_DEMAND + g] = largest[g];
        observation[OBSERVATION_PRESSURE + g] = reading[READING_CYLINDER_PRESSURE + g];
    }
}

/* Replace parts of the observation by the estimates of an estimator in Python. */
void replace_by_estimates(Onboard *onboard)
{
    for (int i = 0; i < OBSERVATIONS; i++)
        if (!isnan(onboard->replacement[i]))
            onboard->observation[i] = onboard->replacement[i];
}

/* Whether the values of all groups are finite; the sum of finite pressures or commands does not overflow. */
static int all_finite(const double *values)
{
    double sum = 0.0;

    for (int g = 0; g < GROUPS; g++)
        sum += values[g];
    return isfinite(sum);
}

/* Limit the demands to the driver's, and convert them to commands; return whether the commands are finite. */
int compute_command(Cycle *c)
{
    Onboard *onboard = c->onboard;
    double largest[GROUPS], input[VALVE_INPUTS], *limited = onboard->valves.call ? input + VALVE_INPUT_DEMAND : onboard->command;

    if (!all_finite(onboard->demand)) { /* the valve logic would treat NaN as a demand to hold */
        copy(onboard->command, onboard->demand, GROUPS);
        return 0;
    }
    copy(onboard->driver_demand, driver_demand(c), GROUPS);
    largest_demands(c, largest);
    for (int g = 0; g < GROUPS; g++) {
        const double limit = c->driver && c->driver->binding ? largest[g] : INFINITY;
        const int is_released = c->filter && c->filter->reference[REFERENCE_TEST_RELEASE + g] != 0.0;
        const double demand = is_released ? 0.0 : onboard->demand[g];
        limited[g] = demand > limit ? limit : demand;
    }
    if (onboard->valves.call) {
        copy(input + VALVE_INPUT_PRESSURE, onboard->reading + READING_CYLINDER_PRESSURE, GROUPS);
        evaluate(&onboard->valves, input, onboard->command);
    }
    return all_finite(onboard->command);
}

#ifndef ONBOARD_ALONE
/* Compute the slip of a plant that does not output it. */
void complete_slip(Plant *plant)
{
    double *outputs = plant->outputs;

    if (!plant->slip_radius)
        return;
    for (int g = 0; g < GROUPS; g++)
        outputs[OUTPUT_SLIP + g] =
            slip_of(outputs[OUTPUT_SPEED], plant->slip_radius[g] * outputs[OUTPUT_WHEELSET_SPEED + g]);
}

void read_sensors(Instruments *instruments, long long sample, const double *outputs)
{
    double *reading = instruments->reading;

    if (instruments->service) {
        read_service(instruments->service, sample, outputs, reading);
        return;
    }
    for (int i = 0; i < READINGS; i++) {
        reading[i] = outputs[instruments->output_at[i]];
        if (instruments->noise)
            reading[i] = reading[i] * instruments->gain[i] + instruments->bias[i] +
                         instruments->noise[sample % instruments->block * READINGS + i];
    }
}

/* Write friction, creep curves, force of track and traction, and the demands for brakes to the inputs of the plant. */
void update_rail_inputs(Cycle *c)
{
    advance_rail(c->rail, (double)c->sample * c->period, c->plant->outputs);
    write_rail_inputs(c->rail, c->plant->inputs);
    if (c->driver)
        c->plant->inputs[INPUT_TRACK_FORCE] += c->driver->force;
#ifdef INPUT_MAGNETS
    c->plant->inputs[INPUT_MAGNETS] = magnets_demanded(c->onboard, driver_demand(c));
#endif
#ifdef INPUT_BRAKE_DEMAND
    c->plant->inputs[INPUT_BRAKE_DEMAND] = largest_share(c->onboard, driver_demand(c));
#endif
}
#endif
