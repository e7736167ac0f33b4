/* The instruments of sensors.h; simulate/sensors/service.py describes them. */

#include <math.h>

#include "rate.h"
#include "sensors.h"
#include "vectors.h"

/* Angle of a tooth: count times pitch, plus its error, which repeats with every revolution. */
static double tooth(const Encoder *encoder, long long count)
{
    return (double)count * encoder->pitch + encoder->teeth[count % encoder->pulses];
}

/* Return the reading of an encoder whose wheel turns at a speed [rad/s]; NaN without a new one. `ServiceSensors`
   in simulate/sensors/service.py describes it. */
EXPORT double read_encoder(Encoder *encoder, long long sample, double speed)
{
    const double time = (double)sample * encoder->period;

    if (sample == 0)
        return encoder->speed = speed; /* the encoder has been running before the stop began */
    const double start = encoder->angle, turned = 0.5 * (encoder->speed + speed) * encoder->period;
    encoder->speed = speed;
    encoder->angle = start + turned;
    long long last = (long long)(encoder->angle / encoder->pitch);
    /* The error is a small share of the pitch, so only neighbours can be due. */
    while (last > encoder->count && tooth(encoder, last) > encoder->angle)
        last--;
    const long long missing = sample >= encoder->begin && sample < encoder->end ? encoder->missing : 0;
    while (last > encoder->count && last % encoder->pulses < missing)
        last--;
    if (last <= encoder->count) {
        const int silent = encoder->stamp >= 0.0 && time - encoder->stamp > encoder->timeout;
        return silent ? 0.0 : NOTHING;
    }
    /* The speed counts as constant within a sample. */
    const double crossing = time - encoder->period * (1.0 - (tooth(encoder, last) - start) / turned);
    const double stamp = rint(crossing / encoder->clock) * encoder->clock, previous = encoder->stamp;
    long long pitches = last - encoder->count;
    for (long long count = encoder->count + 1; missing && count < last; count++)
        pitches -= count % encoder->pulses < missing;
    encoder->stamp = stamp;
    encoder->count = last;
    if (previous < 0.0 || stamp <= previous)
        return NOTHING;
    return (double)pitches * encoder->pitch / (stamp - previous);
}

static double interpolate(double from, double to, long long part, long long parts)
{
    return part < parts ? from + (to - from) * (double)part / (double)parts : to;
}

static double value_at(const TrackQuantity *quantity, double distance)
{
    const double place = fmin(fmax((distance - quantity->begin) / quantity->step, 0.0), (double)(quantity->count - 1));
    const long long before = (long long)place, after = before + 1 < quantity->count ? before + 1 : before;

    return quantity->values[before] + (place - (double)before) * (quantity->values[after] - quantity->values[before]);
}

/* Deflection that the rail under a wheelset causes: the frame follows long waves, and does not follow short ones. The
   digital filter is in transposed direct form II, as in scipy.signal.lfilter. */
static double deflection_by_rail(Service *service, int wheelset, double distance)
{
    double *state = service->filter_state + 2 * wheelset;
    const double height = value_at(&service->rail, distance - service->position[wheelset]),
                 deflection = service->forward[0] * height + state[0];

    state[0] = service->forward[1] * height - service->back[0] * deflection + state[1];
    state[1] = service->forward[2] * height - service->back[1] * deflection;
    return deflection;
}

/* The newest reading of an encoder since the last sample; the wheel's speed is interpolated linearly in between. */
static double read_newest(Encoder *encoder, long long sample, long long samples, double speed)
{
    const double before = encoder->speed;
    double newest = NOTHING;

    if (sample == 0)
        return read_encoder(encoder, 0, speed);
    for (long long i = 1; i <= samples; i++) {
        const double now = interpolate(before, speed, i, samples);
        const double reading = read_encoder(encoder, (sample - 1) * samples + i, now);
        if (!isnan(reading))
            newest = reading;
    }
    return newest;
}

/* The output of a transducer with lag; the pressure is interpolated linearly between samples. */
static double lag_pressure(Service *service, int g, long long sample, double pressure)
{
    double *lagged = service->lagged_pressure + g;

    if (sample == 0)
        *lagged = service->last_pressure[g] = pressure;
    for (long long i = 1; sample && i <= service->samples; i++) {
        const double now = interpolate(service->last_pressure[g], pressure, i, service->samples);
        *lagged += (now - *lagged) * service->pressure_share;
    }
    service->last_pressure[g] = pressure;
    return *lagged;
}

/* Write the reading of a sample; entries without a new reading are NaN. */
EXPORT void read_service(Service *service, long long sample, const double *outputs, double *reading)
{
    const double *noise = service->noise + sample % service->block * NOISES;
    const long long count = service->past_count, whole = (long long)service->speed_latency;
    const double fraction = service->speed_latency - (double)whole;
    double acceleration = outputs[OUTPUT_ACCELERATION] + service->acceleration_bias + noise[NOISE_ACCELERATION];

    if (service->gravity.count)
        acceleration += value_at(&service->gravity, outputs[OUTPUT_DISTANCE]);
    service->past_speed[sample % count] = outputs[OUTPUT_SPEED];
    reading[READING_SPEED] = NOTHING;
    if (is_due(service->speed_rate, sample) && (double)sample >= service->speed_latency) {
        const double factor = service->speed_factor[turn_at(service->speed_rate, sample) % service->speed_factors];
        double speed = service->past_speed[(sample - whole) % count];
        if (fraction > 0.0)
            speed += fraction * (service->past_speed[(sample - whole - 1) % count] - speed);
        const double delayed = speed * factor + noise[NOISE_SPEED];
        /* The latency is known from the data sheet, and the sensor's own electronics extrapolates its reading. */
        reading[READING_SPEED] = delayed + acceleration * service->speed_latency * service->period;
    }
    for (int g = 0; g < GROUPS; g++) {
        const double pressure = lag_pressure(service, g, sample, outputs[OUTPUT_CYLINDER_PRESSURE + g]);
        reading[READING_WHEELSET_SPEED + g] =
            read_newest(service->encoder + g, sample, service->samples, outputs[OUTPUT_WHEELSET_SPEED + g]);
        reading[READING_CYLINDER_PRESSURE + g] =
            rint(pressure / service->pressure_step + service->offset_steps[g]) * service->pressure_step;
    }
    for (int w = 0; w < WHEELSETS; w++) {
        reading[READING_DEFLECTION + w] = outputs[OUTPUT_DEFLECTION + w] + noise[NOISE_DEFLECTION + w];
        if (service->rail.count)
            reading[READING_DEFLECTION + w] += deflection_by_rail(service, w, outputs[OUTPUT_DISTANCE]);
    }
    reading[READING_ACCELERATION] = acceleration;
}
