/* Single parts of a stop, as FMUs: a sample of a part computes its outputs from its inputs, and returns 1 on failure.

   The generated file comes first: GIVEN, the positions of the part's inputs among the plant's outputs; SHOWN,
   those of its outputs among inputs, observations or estimates; DEVIATIONS, the standard
   deviations of the sensors' noise; BINDING as in driver.h; LAW_PARAMETERS, the number of parameters that belong to the law. */

#include <math.h>

#include "onboard.h"
#include "vectors.h"

static void take_truth(Cycle *c, const double *given)
{
    static const int place[] = {GIVEN};

    for (int i = 0; i < OUTPUTS; i++)
        c->truth[i] = NOTHING;
    for (unsigned i = 0; i < sizeof place / sizeof *place; i++)
        c->truth[place[i]] = given[i];
    complete_slip(c);
}

/* Write the part's outputs from a vector; return the position behind them. */
static double *write_outputs(double *outputs, const double *vector)
{
    static const int place[] = {SHOWN};

    for (unsigned i = 0; i < sizeof place / sizeof *place; i++)
        *outputs++ = vector[place[i]];
    return outputs;
}

/* Track and driver: from the plant's outputs to the driver's demand and to all of the plant's inputs except the command. */
static int sample_track(Cycle *c, long long sample, const double *given, const double *parameter, double *shown)
{
    (void)parameter;
    take_truth(c, given);
    if (c->driver)
        drive(c->driver, sample, c->truth);
    advance_rail(c->rail, (double)sample * c->period, c->truth);
    write_rail_inputs(c->rail, c->inputs);
    if (c->driver)
        c->inputs[INPUT_TRACK_FORCE] += c->driver->force;
    copy(write_outputs(shown, c->inputs), c->driver ? c->driver->pressure : c->full, GROUPS);
    return 0;
}

/* A number between 0 and 1, a function of seed and place: SplitMix64 (Steele, Lea and Flood, OOPSLA 2014), its state by place.
   */
static double uniform(unsigned long long seed, unsigned long long place)
{
    unsigned long long z = seed + (place + 1) * 0x9e3779b97f4a7c15ull;

    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
    return ((double)((z ^ (z >> 31)) >> 11) + 0.5) * 0x1p-53;
}

/* Draw the noise of one sample with the Box-Muller transform. */
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
static int sample_sensors(Cycle *c, long long sample, const double *given, const double *parameter, double *shown)
{
    double *noise = c->service ? c->service->noise : c->noise;

    take_truth(c, given);
    c->sample = sample;
    if (sample % c->sensors_every == 0) {
        if (noise)
            draw(noise, sample / c->sensors_every, parameter[0]);
        read_sensors(c);
        copy(shown, c->reading, READINGS);
    } else
        for (int i = 0; i < READINGS; i++)
            shown[i] = NOTHING;
    return 0;
}

/* Update the filter with readings; return whether it has diverged. */
static int believe_readings(Cycle *c, long long sample, const double *given)
{
    c->sample = sample;
    copy(c->reading, given, READINGS);
    see(c);
    if (filters(c)) {
        show_filter(c);
        if (c->advance(c->memory) || !believe(c))
            return 1;
    }
    if (c->mean && c->sample == 0)
        look(c);
    return 0;
}

/* Estimator: from readings to the inputs of a law, except for the driver's demand. */
static int sample_estimator(Cycle *c, long long sample, const double *given, const double *parameter, double *shown)
{
    (void)parameter;
    if (believe_readings(c, sample, given))
        return 1;
    observe(c);
    write_outputs(shown, c->observation);
    return 0;
}

/* All onboard parts: from readings and the driver's demand to commands and the estimate behind them. */
static int sample_onboard(Cycle *c, long long sample, const double *given, const double *parameter, double *shown)
{
    Driver driver = {.binding = BINDING};

    if (believe_readings(c, sample, given))
        return 1;
    if (due(c->controller_every, sample)) {
        copy(driver.pressure, given + READINGS, GROUPS);
        c->driver = &driver;
        observe(c);
        c->law.parameter = parameter;
        c->valves.parameter = parameter + LAW_PARAMETERS;
        c->law.call(c->law.state, c->observation, c->law.parameter, c->demand);
        if (!command(c))
            return 1;
        c->driver = 0;
    }
    copy(shown, c->command, GROUPS);
    if (c->mean)
        write_outputs(shown + GROUPS, c->estimate);
    return 0;
}
