/* A co-simulation FMU and compiled filters, step by step over tables: what a loop in Python would do, without it.

   Sample k is the end of step k - 1. During step k the plant's inputs are those of row k of the table; at its end the outputs are
   read, the noise of row k is added to those that are readings, and every filter predicts over the step and is conditioned
   on them. The struct is mirrored in compiled.py, field by field. */

#include <math.h>
#include <stddef.h>

#if defined(_WIN32)
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif

typedef int Cross(void *, int, double);
typedef int Advance(double *);

enum { SET_STEP_GET = 7 };
enum { COLUMN, INTEGRAL };                               /* where an input of a filter comes from */

typedef struct {
    Advance *advance;
    double *block, *mean, *covariance, *held, *seen;
    const double *squared;
    const int *kind, *from;                              /* of each held input */
    double *means, *covariances, *squares;               /* record: a row every `every` steps */
    long long states, width, inputs;
    long long failed, failed_at;                         /* outcome of `advance`, and the step it happened in */
} Filter;

typedef struct {
    Cross *cross;
    void *plan;
    double *to;                                          /* n_inputs: read by `cross` */
    const double *outputs;                               /* n_outputs: written by it */
    long long n_inputs, n_columns, n_outputs, n_readings, n_filters;
    double period;
    long long count, every;
    const double *inputs, *noise;                        /* count x n_columns, the first n_inputs for the plant; count x n_readings */
    const int *shown;                                    /* the output that each reading shows */
    double *record;                                      /* rows of outputs */
    Filter *filter;
    long long first, done;
} Run;

static void remember(const Filter *f, long long row)
{
    const double nothing = 0.0 / 0.0;
    for (long long i = 0; i < f->states; i++) {
        f->means[row * f->states + i] = f->failed ? nothing : f->mean[i];
        for (long long j = 0; j < f->states; j++)
            f->covariances[(row * f->states + i) * f->states + j] = f->failed ? nothing : f->covariance[i * f->width + j];
    }
    f->squares[row] = f->failed ? nothing : *f->squared;
}

static void believe(Filter *f, const Run *run, const double *inputs)
{
    for (long long i = 0; i < f->inputs; i++)
        switch (f->kind[i]) {
        case COLUMN: f->held[i] = inputs[f->from[i]]; break;
        /* Moved on before the step, so that what is expected at its end belongs to its end. */
        case INTEGRAL: f->held[i] += run->period * f->mean[f->from[i]]; break;
        }
}

/* Returns 0, or what `cross` ended with. */
EXPORT int run(Run *run)
{
    for (run->done = 0; run->done < run->count; run->done++) {
        const long long k = run->done;
        const double *inputs = run->inputs + k * run->n_columns;
        const double *noise = run->noise + k * run->n_readings;

        for (long long i = 0; i < run->n_inputs; i++)
            run->to[i] = inputs[i];
        const int outcome = run->cross(run->plan, SET_STEP_GET, (double)(run->first + k) * run->period);
        if (outcome)
            return outcome;
        for (long long f = 0; f < run->n_filters; f++)
            if (!run->filter[f].failed)
                believe(run->filter + f, run, inputs);
        for (long long f = 0; f < run->n_filters; f++) {
            Filter *filter = run->filter + f;
            if (filter->failed)
                continue;
            for (long long i = 0; i < run->n_readings; i++)
                filter->seen[i] = run->outputs[run->shown[i]] + noise[i];
            filter->failed = filter->advance(filter->block);
            filter->failed_at = k;
        }
        if ((k + 1) % run->every == 0) {
            const long long row = (k + 1) / run->every - 1;
            for (long long i = 0; i < run->n_outputs; i++)
                run->record[row * run->n_outputs + i] = run->outputs[i];
            for (long long f = 0; f < run->n_filters; f++)
                remember(run->filter + f, row);
        }
    }
    return 0;
}
