/* The rail of rail.h under a train; rail.py describes recovery and sand. */

#include <math.h>

#include "rail.h"

/* Friction at a slip speed, relative to friction at zero slip speed. */
static double falling(double A, double B, double slip_speed)
{
    return (1.0 - A) * exp(-B * slip_speed) + A;
}

/* Move wheelset w to a place, with its slip energy per metre there: add its energy to the cells that it has left. */
static void pass(Recovery *its, int w, double place, double loss)
{
    const double mean = 0.5 * (its->loss[w] + loss);

    its->loss[w] = loss;
    if (place <= its->place[w])
        return;
    while (its->cell[w] + 1 < its->cells) {
        const double end = its->origin + (double)(its->cell[w] + 1) * its->length;
        if (place < end)
            break;
        its->left[w] += mean * (end - its->place[w]);
        its->energy[its->cell[w]++] += its->left[w] / its->length;
        its->left[w] = 0.0;
        its->place[w] = end;
        its->met[w] = its->energy[its->cell[w]];
    }
    its->left[w] += mean * (place - its->place[w]);
    its->place[w] = place;
}

static void recover(Recovery *its, const double *truth, double *mu0)
{
    const double speed = truth[OUTPUT_SPEED], distance = truth[OUTPUT_DISTANCE];

    for (int w = 0; w < WHEELSETS; w++) {
        const double slip = fmax(truth[OUTPUT_SLIP + its->group[w]], 0.0);
        const double loss = 0.5 * fmax(truth[OUTPUT_ADHESION + w], 0.0) * truth[OUTPUT_WHEELSET_LOAD + w] * slip;
        const double place = distance - its->position[w];
        if (!its->begun) {
            its->place[w] = place;
            its->cell[w] = (long long)fmax((place - its->origin) / its->length, 0.0);
            its->loss[w] = loss;
        }
        pass(its, w, place, loss);
        const double share = 1.0 - exp(-its->rate * (its->met[w] + loss));
        const double slip_speed = slip * fmax(speed, 0.0), falls = falling(its->A[w], its->B[w], slip_speed);
        const double laid = mu0[w] * falls, clean = its->clean * falling(its->clean_A, its->clean_B, slip_speed);
        /* Converted to friction at zero slip speed: the plant's contact reduces its input mu0 by its own law. */
        mu0[w] = fmin((laid + share * (fmax(clean, laid) - laid)) / falls, 1.0);
    }
    its->begun = 1;
}

/* Strew sand in front of wheelsets, and raise friction by the sand that each of them meets. */
static void strew(Sand *its, double time, const double *truth, double *mu0)
{
    static const double SLOWEST = 1e-3;          /* m/s, below which the sand of a metre would have no bound */
    const double speed = fmax(truth[OUTPUT_SPEED], SLOWEST);

    for (int w = 0; w < WHEELSETS; w++) {
        const double reached = floor((truth[OUTPUT_DISTANCE] - its->position[w] - its->origin) / its->length);
        const long long cell = (long long)fmin(fmax(reached, 0.0), (double)(its->cells - 1));
        double laid = 0.0;

        if (!its->begun)
            its->cell[w] = cell;
        for (const Sander *sander = its->sanders; sander < its->sanders + its->count; sander++)
            if (sander->wheelset == w && time >= sander->begin && time < sander->end)
                laid += fmin(sander->rate / speed, sander->density);
        while (its->cell[w] < cell) {
            double *lying = its->lying + ++its->cell[w];
            its->met[w] = *lying + laid;
            *lying = its->left * its->met[w];
        }
        mu0[w] += (1.0 - exp(-its->met[w] / its->density)) * fmax(its->mu0 - mu0[w], 0.0);
    }
    its->begun = 1;
}

/* Set the creep curve at each wheelset from a point of the grid. */
static void lay_curves(Rail *its, long long point)
{
    for (int w = 0; w < WHEELSETS; w++) {
        const double *curve = its->curves + 4 * its->curve_at[point * WHEELSETS + w];
        for (int i = 0; i < 4; i++)
            its->curve[i * WHEELSETS + w] = curve[i];
        if (its->recovery) {
            its->recovery->A[w] = curve[2];
            its->recovery->B[w] = curve[3];
        }
    }
}

/* Update friction and track force for a time, given the plant's outputs; times come in order. */
EXPORT void advance_rail(Rail *its, double time, const double *truth)
{
    const double distance = truth[OUTPUT_DISTANCE], last = (double)(its->points - 1);
    const double place = fmin(fmax((its->over_time ? time : distance) / its->grid + 0.5, 0.0), last);
    const double *nearest = its->friction + (long long)place * WHEELSETS;
    long long section = its->section;

    for (int w = 0; w < WHEELSETS; w++)
        its->mu0[w] = nearest[w];
    if (its->curve_at)
        lay_curves(its, (long long)place);
    if (its->recovery)
        recover(its->recovery, truth, its->mu0);
    if (its->sand)
        strew(its->sand, time, truth, its->mu0);
    while (section + 1 < its->sections && its->begins[section + 1] <= distance)
        section++;
    while (section > 0 && its->begins[section] > distance)
        section--;
    its->section = section;
    its->force = its->forces[section];
    if (its->rates[section] != 0.0)
        its->force += its->rates[section] * (distance - its->begins[section]);
}

/* Write the rail inputs of the plant for the last position of the train. */
EXPORT void write_rail_inputs(const Rail *its, double *inputs)
{
    for (int w = 0; w < WHEELSETS; w++)
        inputs[INPUT_MU0 + w] = its->mu0[w];
    inputs[INPUT_TRACK_FORCE] = its->force;
#ifdef INPUT_CURVE_K_A
    for (int i = 0; i < 4 * WHEELSETS; i++)
        inputs[INPUT_CURVE_K_A + i] = its->curve[i];
#endif
}
