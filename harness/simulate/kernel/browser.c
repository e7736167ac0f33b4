/* A stop in a browser: the loop of a scenario with the C code of its plant, for WebAssembly.

   browser_parts.h is generated next to this file: the plant's variables, and the formulas of each law. The memory of
   the stop comes from the page, as the words that `Loop` fills in Python: pointers in it are zero, and `links` has their
   places and targets. */

#include <stdlib.h>
#include <string.h>

#include "fmi2Functions.h"
#include "browser_parts.h"
#include "set_step_get.h"

#include "contact.h" /* after the others, whose enumerators have the names of its macros */

#define SHOWN(name) __attribute__((export_name(#name)))

enum { NO_INSTANCE = 100, NOT_STARTED }; /* failures before the first sample, after those of cycle.h */

static char message[1024]; /* the plant's last message */
static SetStepGet plan;
static double *friction;
static long long points;

static void note(fmi2ComponentEnvironment environment, fmi2String instance, fmi2Status status, fmi2String category,
                 fmi2String text, ...)
{
    (void)environment, (void)instance, (void)category;
    if (status > fmi2Warning)
        strncpy(message, text, sizeof message - 1);
}

SHOWN(allocate) void *allocate(size_t bytes)
{
    return malloc(bytes);
}

SHOWN(release) void release(void *memory)
{
    free(memory);
}

SHOWN(plant_message) const char *plant_message(void)
{
    return message;
}

/* The bits of the shape of a rail, (rows x columns), from their second differences along a column. */
SHOWN(add_up) void add_up(unsigned long long *bits, int rows, int columns)
{
    for (int pass = 0; pass < 2; pass++)
        for (int i = columns; i < rows * columns; i++)
            bits[i] += bits[i - columns];
}

/* The friction of a rail, (rows x wheelsets), from that of its shape, (rows x columns): a factor, and conditioning as in
   scenario/adhesion.py, with the recovery of each wheelset. */
SHOWN(lay_rail)
void lay_rail(double *rail, const double *shape, int rows, int columns, double factor, double recovered,
              const double *recovery)
{
    friction = rail;
    points = rows;
    for (int i = 0; i < rows; i++)
        for (int w = 0; w < WHEELSETS; w++) {
            const double mu0 = factor * shape[i * columns + (columns > 1 ? w : 0)], rise = recovered - mu0;
            friction[i * WHEELSETS + w] = mu0 + (rise > 0.0 ? rise : 0.0) * recovery[w];
        }
}

/* The rail and the plant at the start, in the order of `TabulatedRail` and of `LoadedPlant.start`. */
static int start_plant(Cycle *c, const double *parameters)
{
    static const fmi2CallbackFunctions callbacks = { note, calloc, free, 0, 0 };
    Plant *plant = c->plant;
    Rail *rail = c->rail;
    Recovery *recovery = rail->recovery;
    Sand *sand = rail->sand;

    rail->friction = friction;
    rail->points = points;
    rail->recovery = 0;
    rail->sand = 0;
    advance_rail(rail, 0.0, plant->outputs);
    rail->recovery = recovery;
    rail->sand = sand;
    write_rail_inputs(rail, plant->inputs);

    fmi2FreeInstance(plan.fmu);
    memset(&plan, 0, sizeof plan);
    plan.fmu = fmi2Instantiate("plant", fmi2CoSimulation, PLANT_GUID, "", &callbacks, 0, 0);
    if (!plan.fmu) {
        note(0, 0, fmi2Error, 0, "the browser has no memory left for it");
        return NO_INSTANCE;
    }
    plan.step = (DoStep *)fmi2DoStep;
    plan.senders = senders;
    plan.receivers = receivers;
    plan.n_senders = SENDERS;
    plan.n_receivers = RECEIVERS;
    plan.n_outputs = OUTPUTS;
    plan.period = c->period;
    plan.begin = PLANT_BEGIN;
    plan.inputs = plant->inputs;
    plan.outputs = plant->outputs;
    plant->step = (Step *)set_step_get;
    plant->interface = &plan;
    for (int i = 0; i < OUTPUTS; i++)
        plant->outputs[i] = NAN;
    if (fmi2SetReal(plan.fmu, parameter_references, PARAMETERS, parameters) > fmi2Warning
        || fmi2SetupExperiment(plan.fmu, 0, 0.0, PLANT_BEGIN, 0, 0.0) > fmi2Warning
        || fmi2EnterInitializationMode(plan.fmu) > fmi2Warning || exchange(&plan, SET, 0.0)
        || fmi2ExitInitializationMode(plan.fmu) > fmi2Warning || exchange(&plan, GET, 0.0))
        return NOT_STARTED;
    return 0;
}

/* Run a stop; return its end as `cycle` does, or a failure before it.

   `rows` receives the row of each `stride`th sample and of the last one, `written` their number. */
SHOWN(run)
int run(int law, double *words, const int *links, int count, const double *parameters, int stride, double *rows,
        int *written)
{
    Cycle *c = (Cycle *)words;
    int end, failure;

    for (int i = 0; i < count; i++) {
        const char *target = (const char *)words + links[2 * i + 1];
        memcpy(words + links[2 * i], &target, sizeof target);
    }
    connect[law](c);
    message[0] = 0;
    *written = 0;
    if ((failure = start_plant(c, parameters)))
        return failure;
    c->block = 1;
    do {
        end = cycle(c);
        const long long last = c->sample - (end == BLOCK_DUE);
        if (last >= 0 && (last % stride == 0 || end != BLOCK_DUE)) {
            memcpy(rows, c->record->rows, sizeof *rows * c->record->width);
            rows += c->record->width;
            ++*written;
        }
    } while (end == BLOCK_DUE);
    return end;
}

SHOWN(sample) int sample(const double *words)
{
    return (int)((const Cycle *)words)->sample;
}

static double adhesion_at(double log_slip, double speed, double load, double mu0)
{
    double point[4], adhesion;
    const double *arguments[ARGUMENTS] = { point, contact_curve, contact_fixed };
    double *results[RESULTS] = { &adhesion };

    point[SLIP] = exp(log_slip);
    point[SPEED] = speed;
    point[LOAD] = load;
    point[MU0] = mu0;
    call(contact, arguments, results);
    return adhesion;
}

/* The slip at the peak of the creep curve, to 0.5 %: the best of a grid, then golden section, as in trace/bound.py. */
SHOWN(peak) double peak(double speed, double load, double mu0)
{
    const double lowest = -9.2, step = 0.3, golden = 0.6180339887498949;
    double best = lowest, highest = -1.0;

    for (double at = lowest; at <= 0.0; at += step) {
        const double here = adhesion_at(at, speed, load, mu0);
        if (here > highest) {
            highest = here;
            best = at;
        }
    }
    double low = best - step, high = best + step;
    while (high - low > 5e-3) {
        const double left = high - golden * (high - low), right = low + golden * (high - low);
        if (adhesion_at(left, speed, load, mu0) < adhesion_at(right, speed, load, mu0))
            low = left;
        else
            high = right;
    }
    return exp(0.5 * (low + high) < 0.0 ? 0.5 * (low + high) : 0.0);
}
