/* The rail of rail.h under a train; scenario/surface.py describes recovery and sand. */

#include <math.h>

#include "rail.h"
#include "vectors.h"

/* Friction at a slip speed, relative to friction at zero slip speed. */
static double friction_factor(double A, double B, double slip_speed)
{
    return (1.0 - A) * exp(-B * slip_speed) + A;
}

/* Move wheelset w to a location, with its slip energy per metre there: add its energy to the cells that it has left. */
static void move_wheelset(Recovery *recovery, int w, double location, double loss)
{
    const double mean = 0.5 * (recovery->loss[w] + loss); /* trapezoidal rule over the distance */

    recovery->loss[w] = loss;
    if (location <= recovery->location[w])
        return;
    while (recovery->cell[w] + 1 < recovery->cells) {
        const double end = recovery->origin + (double)(recovery->cell[w] + 1) * recovery->length;
        if (location < end)
            break;
        recovery->energy_own[w] += mean * (end - recovery->location[w]);
        recovery->energy[recovery->cell[w]++] += recovery->energy_own[w] / recovery->length;
        recovery->energy_own[w] = 0.0;
        recovery->location[w] = end;
        recovery->energy_ahead[w] = recovery->energy[recovery->cell[w]];
    }
    recovery->energy_own[w] += mean * (location - recovery->location[w]);
    recovery->location[w] = location;
}

/* Set the friction that slip leaves under each wheelset: f of `SlipEnergy` in scenario/surface.py. */
static void apply_recovery(Recovery *recovery, const double *outputs, double *mu0)
{
    const double speed = outputs[OUTPUT_SPEED], distance = outputs[OUTPUT_DISTANCE];

    for (int w = 0; w < WHEELSETS; w++) {
        const double slip = fmax(outputs[OUTPUT_SLIP + recovery->group[w]], 0.0);
        /* W = F s of one of the two wheels. */
        const double loss = 0.5 * fmax(outputs[OUTPUT_ADHESION + w], 0.0) * outputs[OUTPUT_WHEELSET_LOAD + w] * slip;
        const double location = distance - recovery->position[w];
        if (!recovery->has_started) {
            recovery->location[w] = location;
            recovery->cell[w] = (long long)fmax((location - recovery->origin) / recovery->length, 0.0);
            recovery->loss[w] = loss;
        }
        move_wheelset(recovery, w, location, loss);
        const double lambda = 1.0 - exp(-recovery->rate * (recovery->energy_ahead[w] + loss));
        const double slip_speed = slip * fmax(speed, 0.0),
                     factor = friction_factor(recovery->A[w], recovery->B[w], slip_speed);
        const double untreated = mu0[w] * factor,
                     clean = recovery->clean * friction_factor(recovery->clean_A, recovery->clean_B, slip_speed);
        /* Converted to friction at zero slip speed: the plant's contact reduces its input mu0 by its own law. */
        mu0[w] = fmin((untreated + lambda * (fmax(clean, untreated) - untreated)) / factor, 1.0);
    }
    recovery->has_started = 1;
}

/* Switch the sanders by the controller's demand, which reaches the rail after their delay, on and off. A pulse shorter
   than the delay moves no sand. */
static void switch_sanders(Sand *sand, double time)
{
    const double step = *sand->is_demanded > 0.5 ? time - sand->time : sand->time - time;

    sand->time = time;
    for (Sander *sander = sand->sanders; sander < sand->sanders + sand->count; sander++) {
        sander->filled = fmin(fmax(sander->filled + step, 0.0), sander->delay);
        sander->is_flowing = step > 0.0 ? sander->is_flowing || sander->filled >= sander->delay
                                        : sander->is_flowing && sander->filled > 0.0;
    }
}

/* Deposit sand in front of wheelsets, and raise friction by the sand that each of them meets, as in `SandedRail`. */
static void apply_sand(Sand *sand, double time, const double *outputs, double *mu0)
{
    static const double MIN_SPEED = 1e-3; /* m/s; at rest, the sand on a metre would be infinite */
    const double speed = fmax(outputs[OUTPUT_SPEED], MIN_SPEED);

    if (sand->is_demanded)
        switch_sanders(sand, time);
    for (int w = 0; w < WHEELSETS; w++) {
        const double reached = floor((outputs[OUTPUT_DISTANCE] - sand->position[w] - sand->origin) / sand->length);
        const long long cell = (long long)fmin(fmax(reached, 0.0), (double)(sand->cells - 1));
        double new_sand = 0.0;

        if (!sand->has_started)
            sand->cell[w] = cell;
        for (const Sander *sander = sand->sanders; sander < sand->sanders + sand->count; sander++)
            if (sander->wheelset == w && time >= sander->begin && time < sander->end &&
                (!sand->is_demanded || sander->is_flowing))
                new_sand += fmin(sander->rate / speed, sander->density);
        while (sand->cell[w] < cell) {
            double *deposited = sand->deposited + ++sand->cell[w];
            sand->density_ahead[w] = *deposited + new_sand;
            *deposited = sand->remaining_share * sand->density_ahead[w];
        }
        mu0[w] += (1.0 - exp(-sand->density_ahead[w] / sand->density)) * fmax(sand->mu0 - mu0[w], 0.0);
    }
    sand->has_started = 1;
}

/* Set the creep curve at each wheelset from a point of the grid. */
static void set_curves(Rail *rail, long long point)
{
    for (int w = 0; w < WHEELSETS; w++) {
        const double *curve = rail->curves + 4 * rail->curve_at[point * WHEELSETS + w];
        for (int i = 0; i < 4; i++)
            rail->curve[i * WHEELSETS + w] = curve[i];
        if (rail->recovery) {
            rail->recovery->A[w] = curve[2];
            rail->recovery->B[w] = curve[3];
        }
    }
}

/* Return the force of the track if the whole train were at a place; `section` is searched from its last value on. */
static double force_at(const Rail *rail, long long *section, double place)
{
    while (*section + 1 < rail->sections && rail->begins[*section + 1] <= place)
        (*section)++;
    while (*section > 0 && rail->begins[*section] > place)
        (*section)--;
    if (rail->rates[*section] == 0.0) /* a constant section may begin at minus infinity */
        return rail->forces[*section];
    return rail->forces[*section] + rail->rates[*section] * (place - rail->begins[*section]);
}

/* Set the force of the track: gradient and curve act on each wheelset at its place, by the mass that it carries. */
static void set_track_force(Rail *rail, double distance)
{
    const double leading = force_at(rail, rail->section, distance);
    double more[WHEELSETS] = {0.0}, sum = 0.0; /* differences to the leading wheelset: zero on an even track */

    for (int w = 1; w < WHEELSETS; w++)
        sum += more[w] = rail->share[w] * (force_at(rail, rail->section + w, distance - rail->behind[w]) - leading);
    rail->force = leading + sum;
    for (int c = 0; c < CARS; c++)
        rail->car_force[c] = 0.0;
    for (int w = 0; w < WHEELSETS; w++)
        rail->car_force[rail->car[w]] += more[w] - rail->share[w] * sum;
}

/* Update friction and track force for a time, given the plant's outputs; times come in order. */
EXPORT void advance_rail(Rail *rail, double time, const double *outputs)
{
    const double distance = outputs[OUTPUT_DISTANCE], last = (double)(rail->points - 1);
    const long long nearest = (long long)fmin(fmax((rail->over_time ? time : distance) / rail->grid + 0.5, 0.0), last);

    copy(rail->mu0, rail->friction + nearest * WHEELSETS, WHEELSETS);
    if (rail->curve_at)
        set_curves(rail, nearest);
    if (rail->recovery)
        apply_recovery(rail->recovery, outputs, rail->mu0);
    if (rail->sand)
        apply_sand(rail->sand, time, outputs, rail->mu0);
    set_track_force(rail, distance);
}

/* Write the rail inputs of the plant for the last position of the train. */
EXPORT void write_rail_inputs(const Rail *rail, double *inputs)
{
    copy(inputs + INPUT_MU0, rail->mu0, WHEELSETS);
    inputs[INPUT_TRACK_FORCE] = rail->force;
#ifdef INPUT_CAR_TRACK_FORCE
    copy(inputs + INPUT_CAR_TRACK_FORCE, rail->car_force, CARS);
#endif
#ifdef INPUT_CURVE_K_A
    copy(inputs + INPUT_CURVE_K_A, rail->curve, 4 * WHEELSETS);
#endif
}
