/* One communication step of a co-simulation FMU in one call: values in, the step, values out. */

#include <math.h>
#include <stddef.h>

#include "set_step_get.h"

#if defined(_WIN32)
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif

/* Whether a status is an error: not fmi2OK or fmi2Warning, including numbers that FMI does not define. */
static int failed(SetStepGet *c, long long status)
{
    c->status = status;
    c->warnings += status == 1;
    return status != 0 && status != 1;
}

static int send(const SetStepGet *c, const Channel *to)
{
    for (long long i = 0; i < to->count; i++) {
        double value = c->inputs[to->positions[i]];
        if (to->gain)
            value = value * to->gain[i] + to->shift[i];
        if (to->whole)
            ((int *)to->buffer)[i] = (int)rint(value); /* nearest: 0.9999999 is a rounded one */
        else
            ((double *)to->buffer)[i] = value;
    }
    return to->transfer(c->fmu, to->references, (size_t)to->count, to->buffer);
}

static int receive(const SetStepGet *c, const Channel *from)
{
    const int status = from->transfer(c->fmu, from->references, (size_t)from->count, from->buffer);

    for (long long i = 0; i < from->count; i++) {
        double value = from->whole ? (double)((int *)from->buffer)[i] : ((double *)from->buffer)[i];
        if (from->gain)
            value = value * from->gain[i] + from->shift[i];
        c->outputs[from->positions[i]] = value;
    }
    return status;
}

/* `time` is the time since the start of the stop. */
EXPORT int exchange(SetStepGet *c, int actions, double time)
{
    if (actions & SET)
        for (long long k = 0; k < c->n_senders; k++)
            if (failed(c, send(c, c->senders + (c->at = k))))
                return SETTING;
    if (actions & STEP)
        if (failed(c, c->step(c->fmu, c->begin + time, c->period, 1))) /* true: no earlier state is restored */
            return STEPPING;
    if (actions & GET) {
        for (long long k = 0; k < c->n_receivers; k++)
            if (failed(c, receive(c, c->receivers + (c->at = k))))
                return GETTING;
        for (long long k = 0; k < c->n_receivers; k++)
            for (long long i = 0; i < c->receivers[k].count; i++)
                if (!isfinite(c->outputs[c->at = c->receivers[k].positions[i]]))
                    return NOT_FINITE;
    }
    return FINE;
}

EXPORT int set_step_get(SetStepGet *c, double time)
{
    return exchange(c, SET | STEP | GET, time);
}

/* Step through `count` rows of inputs from sample `first` on, with a row of outputs at the end of each step. */
EXPORT int follow(SetStepGet *c, long long count, long long first, const double *inputs, long long width,
                  double *outputs)
{
    for (c->done = 0; c->done < count; c->done++) {
        const double *row = inputs + c->done * width;
        for (long long i = 0; i < width; i++)
            c->inputs[i] = row[i];
        const int outcome = set_step_get(c, (double)(first + c->done) * c->period);
        if (outcome)
            return outcome;
        for (long long i = 0; i < c->n_outputs; i++)
            outputs[c->done * c->n_outputs + i] = c->outputs[i];
    }
    return FINE;
}
