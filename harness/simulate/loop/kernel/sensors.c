/* The instruments of sensors.h; sensors.py describes them. */

#include <math.h>

#include "sensors.h"

static const double NOTHING_NEW = 0.0 / 0.0;

long long turn(Every every, long long step)
{
    return step * every.turns / every.steps;
}

int due(Every every, long long step)
{
    return step * every.turns % every.steps < every.turns;
}

/* Angle of a tooth: count times pitch, plus its error, which repeats with every revolution. */
static double tooth(const Encoder *its, long long count)
{
    return (double)count * its->pitch + its->teeth[count % its->pulses];
}

EXPORT double read_encoder(Encoder *its, long long sample, double speed)
{
    const double time = (double)sample * its->period;

    if (sample == 0)
        return its->speed = speed;               /* the encoder has been running before the stop began */
    const double before = its->angle, turned = 0.5 * (its->speed + speed) * its->period;
    its->speed = speed;
    its->angle = before + turned;
    long long last = (long long)(its->angle / its->pitch);
    /* The error is a small share of the pitch, so only neighbours can be due. */
    while (last > its->count && tooth(its, last) > its->angle)
        last--;
    const long long missing = sample >= its->begin && sample < its->end ? its->missing : 0;
    while (last > its->count && last % its->pulses < missing)
        last--;
    if (last <= its->count) {
        const int silent = its->stamp >= 0.0 && time - its->stamp > its->silence;
        return silent ? 0.0 : NOTHING_NEW;
    }
    const double moment = time - its->period * (1.0 - (tooth(its, last) - before) / turned);
    const double stamp = rint(moment / its->clock) * its->clock, previous = its->stamp;
    long long passed = last - its->count;
    for (long long count = its->count + 1; missing && count < last; count++)
        passed -= count % its->pulses < missing;
    its->stamp = stamp;
    its->count = last;
    if (previous < 0.0 || stamp <= previous)
        return NOTHING_NEW;
    return (double)passed * its->pitch / (stamp - previous);
}

static double at(const Course *its, double distance)
{
    const double place = fmin(fmax((distance - its->begin) / its->step, 0.0), (double)(its->count - 1));
    const long long before = (long long)place, after = before + 1 < its->count ? before + 1 : before;

    return its->values[before] + (place - (double)before) * (its->values[after] - its->values[before]);
}

/* Deflection that the rail under a wheelset causes: the frame follows long waves, and does not follow short ones. */
static double shaken(Service *its, int wheelset, double distance)
{
    double *shift = its->shift + 2 * wheelset;
    const double height = at(&its->rail, distance - its->position[wheelset]), moved = its->forward[0] * height + shift[0];

    shift[0] = its->forward[1] * height - its->back[0] * moved + shift[1];
    shift[1] = its->forward[2] * height - its->back[1] * moved;
    return moved;
}

/* The newest reading of an encoder since the last sample; the wheel's speed is interpolated linearly in between. */
static double read_newest(Encoder *its, long long sample, long long samples, double speed)
{
    const double before = its->speed;
    double newest = NOTHING_NEW;

    if (sample == 0)
        return read_encoder(its, 0, speed);
    for (long long i = 1; i <= samples; i++) {
        const double now = i < samples ? before + (speed - before) * (double)i / (double)samples : speed;
        const double reading = read_encoder(its, (sample - 1) * samples + i, now);
        if (!isnan(reading))
            newest = reading;
    }
    return newest;
}

/* The output of a transducer with lag; the pressure is interpolated linearly between samples. */
static double lagging(Service *its, int g, long long sample, double pressure)
{
    if (sample == 0)
        its->pressure[g] = its->before[g] = pressure;
    for (long long i = 1; sample && i <= its->samples; i++) {
        const double now =
            i < its->samples ? its->before[g] + (pressure - its->before[g]) * (double)i / (double)its->samples : pressure;
        its->pressure[g] = its->pressure[g] + (now - its->pressure[g]) * its->pressure_share;
    }
    its->before[g] = pressure;
    return its->pressure[g];
}

EXPORT void read_service(Service *its, long long sample, const double *truth, double *reading)
{
    const double *noise = its->noise + sample % its->block * NOISES;
    const long long ring = its->remembered, whole = (long long)its->speed_latency;
    const double between = its->speed_latency - (double)whole;
    double acceleration = truth[OUTPUT_ACCELERATION] + its->acceleration_bias + noise[1];

    if (its->gravity.count)
        acceleration += at(&its->gravity, truth[OUTPUT_DISTANCE]);
    its->past[sample % ring] = truth[OUTPUT_SPEED];
    reading[READING_SPEED] = NOTHING_NEW;
    if (due(its->speed_every, sample) && (double)sample >= its->speed_latency) {
        const double factor = its->speed_factor[turn(its->speed_every, sample) % its->speed_factors];
        double speed = its->past[(sample - whole) % ring];
        if (between > 0.0)
            speed += between * (its->past[(sample - whole - 1) % ring] - speed);
        const double late = speed * factor + noise[0];
        /* The latency is known from the data sheet, and the sensor's own electronics extrapolates its reading. */
        reading[READING_SPEED] = late + acceleration * its->speed_latency * its->period;
    }
    for (int g = 0; g < GROUPS; g++) {
        const double pressure = lagging(its, g, sample, truth[OUTPUT_CYLINDER_PRESSURE + g]);
        reading[READING_WHEELSET_SPEED + g] =
            read_newest(its->encoder + g, sample, its->samples, truth[OUTPUT_WHEELSET_SPEED + g]);
        reading[READING_CYLINDER_PRESSURE + g] =
            rint(pressure / its->pressure_step + its->offset_steps[g]) * its->pressure_step;
    }
    for (int w = 0; w < WHEELSETS; w++) {
        reading[READING_DEFLECTION + w] = truth[OUTPUT_DEFLECTION + w] + noise[2 + w];
        if (its->rail.count)
            reading[READING_DEFLECTION + w] += shaken(its, w, truth[OUTPUT_DISTANCE]);
    }
    reading[READING_ACCELERATION] = acceleration;
}
