/* Single parts of a stop, as FMUs: a sample of a part computes its outputs from its inputs, and returns 1 on failure.

   The generated file comes first: INPUT_PLACES, the positions of the part's inputs among the plant's outputs;
   OUTPUT_PLACES, those of its outputs among inputs of the plant, observations or estimates; DEVIATIONS, the standard
   deviations of the sensors' noise; BINDING as in driver.h; LAW_PARAMETERS, the number of parameters that belong to the
   law. */

#include <math.h>

#include "onboard.h"
#include "rate.h"
#include "vectors.h"

/* Write the part's outputs from a vector; return the position after them. */
static double *write_outputs(double *output, const double *vector)
{
    static const int place[] = {OUTPUT_PLACES};

    for (unsigned i = 0; i < sizeof place / sizeof *place; i++)
        *output++ = vector[place[i]];
    return output;
}

#ifndef ONBOARD_ALONE
static void write_plant_outputs(Plant *plant, const double *input)
{
    static const int place[] = {INPUT_PLACES};

    fill(plant->outputs, NOTHING, OUTPUTS);
    for (unsigned i = 0; i < sizeof place / sizeof *place; i++)
        plant->outputs[place[i]] = input[i];
    complete_slip(plant);
}

/* Track and driver: from the plant's outputs to all of the plant's inputs except the command, and the driver's
   demand. */
static int sample_track(Cycle *c, const double *input, const double *parameter, double *output)
{
    (void)parameter;
    write_plant_outputs(c->plant, input);
    if (c->driver)
        drive(c->driver, c->sample, c->plant->outputs);
    update_rail_inputs(c);
    copy(write_outputs(output, c->plant->inputs), driver_demand(c), GROUPS);
    return 0;
}

/* Return the random number between 0 and 1 at a place in the sequence of SplitMix64 (Steele, Lea and Flood, OOPSLA
   2014), without computing those before it. */
static double uniform(unsigned long long seed, unsigned long long place)
{
    unsigned long long z = seed + (place + 1) * 0x9e3779b97f4a7c15ull;

    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
    return ((double)((z ^ (z >> 31)) >> 11) + 0.5) * 0x1p-53;
}

/* Draw the noise of one sample, normally distributed, with the Box-Muller transform. */
static void draw(double *noise, long long sample, double seed)
{
    static const double deviation[] = {DEVIATIONS};
    const unsigned long long count = sizeof deviation / sizeof *deviation;

    for (unsigned long long i = 0; i < count; i++) {
        const unsigned long long place = 2 * ((unsigned long long)sample * count + i);
        const double radius = sqrt(-2.0 * log(uniform((unsigned long long)seed, place)));
        noise[i] = deviation[i] * radius * cos(6.283185307179586 * uniform((unsigned long long)seed, place + 1));
    }
}

/* Sensors: from the plant's outputs to readings, NaN for sensors without a new reading. */
static int sample_sensors(Cycle *c, const double *input, const double *parameter, double *output)
{
    Instruments *instruments = c->instruments;
    double *noise = instruments->service ? instruments->service->noise : instruments->noise;
    const long long sample = c->sample / instruments->every;

    write_plant_outputs(c->plant, input);
    fill(instruments->reading, NOTHING, READINGS);
    if (c->sample % instruments->every == 0) {
        if (noise)
            draw(noise, sample, parameter[0]);
        read_sensors(instruments, sample, c->plant->outputs);
    }
    copy(output, instruments->reading, READINGS);
    return 0;
}
#endif

/* Update the filter with readings; return whether it has diverged. */
static int update_filter(Cycle *c, const double *input)
{
    copy(c->instruments->reading, input, READINGS);
    store_readings(c);
    if (filter_is_due(c)) {
        prepare_filter(c);
        if (c->filter->advance(c->filter->memory) || !read_estimate(c))
            return 1;
    }
    if (c->filter && c->sample == 0)
        read_states(c);
    return 0;
}

/* Estimator: from readings to the inputs of a law, except for the driver's demand. */
static int sample_estimator(Cycle *c, const double *input, const double *parameter, double *output)
{
    (void)parameter;
    if (update_filter(c, input))
        return 1;
    observe(c);
    write_outputs(output, c->onboard->observation);
    return 0;
}

/* All onboard parts: from readings and the driver's demand to commands and the estimate. */
static int sample_onboard(Cycle *c, const double *input, const double *parameter, double *output)
{
    Driver driver = {.binding = BINDING}; /* holds the demand for `observe` and `compute_command` */
    Onboard *onboard = c->onboard;

    if (update_filter(c, input))
        return 1;
    if (is_due(onboard->controller_rate, c->sample)) {
        copy(driver.pressure, input + READINGS, GROUPS);
        c->driver = &driver;
        observe(c);
        onboard->law.parameter = parameter;
        onboard->valves.parameter = parameter + LAW_PARAMETERS;
        evaluate(&onboard->law, onboard->observation, onboard->demand);
        if (!compute_command(c))
            return 1;
        c->driver = 0;
    }
    copy(output, onboard->command, GROUPS);
    if (c->filter)
        write_outputs(output + GROUPS, onboard->estimate);
    return 0;
}
