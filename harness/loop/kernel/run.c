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

typedef int Exchange(void *, const unsigned *, size_t, double *);
typedef int DoStep(void *, double, double, int);
typedef int Advance(double *);

enum { COLUMN, READING, INTEGRAL };                       /* where an input of a filter comes from */
enum { FINE, SETTING, STEPPING, READING_OUTPUTS, NOT_FINITE };

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
    Exchange *set, *get;
    DoStep *step;
    void *fmu;
    const unsigned *to, *of;
    long long n_inputs, n_columns, n_outputs, n_readings, n_filters;
    double start, period;
    long long count, every, looks_back;
    const double *inputs, *noise;                        /* count x n_columns, the first n_inputs for the plant; count x n_readings */
    const int *shown;                                    /* the output that each reading shows */
    double *outputs;                                     /* n_outputs: the last ones */
    double *reading;                                     /* n_readings: the last ones */
    double *record;                                      /* rows of outputs */
    Filter *filter;
    long long first, done, status, where;
} Run;

/* Whether a status is neither fmi2OK nor fmi2Warning: a number that is no status at all is an error, too. */
static int failed(long long status)
{
    return status != 0 && status != 1;
}

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
        case READING: f->held[i] = run->reading[f->from[i]]; break;
        /* Moved on before the step, so that what is expected at its end belongs to its end. */
        case INTEGRAL: f->held[i] += run->period * f->mean[f->from[i]]; break;
        }
}

EXPORT int run(Run *run)
{
    for (run->done = 0; run->done < run->count; run->done++) {
        const long long k = run->done;
        const double *inputs = run->inputs + k * run->n_columns;
        const double *noise = run->noise + k * run->n_readings;

        run->where = SETTING;
        if (run->n_inputs && failed(run->status = run->set(run->fmu, run->to, run->n_inputs, (double *)inputs)))
            return 1;
        run->where = STEPPING;
        if (failed(run->status = run->step(run->fmu, run->start + (run->first + k) * run->period, run->period, (int)run->looks_back)))
            return 1;
        run->where = READING_OUTPUTS;
        if (failed(run->status = run->get(run->fmu, run->of, run->n_outputs, run->outputs)))
            return 1;
        run->where = NOT_FINITE;
        for (long long i = 0; i < run->n_outputs; i++)
            if (!isfinite(run->outputs[i])) {
                run->status = i;
                return 1;
            }
        for (long long f = 0; f < run->n_filters; f++)   /* on the readings at the start of the step */
            if (!run->filter[f].failed)
                believe(run->filter + f, run, inputs);
        for (long long i = 0; i < run->n_readings; i++)
            run->reading[i] = run->outputs[run->shown[i]] + noise[i];
        for (long long f = 0; f < run->n_filters; f++) {
            Filter *filter = run->filter + f;
            if (filter->failed)
                continue;
            for (long long i = 0; i < run->n_readings; i++)
                filter->seen[i] = run->reading[i];
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
    run->status = 0;
    return 0;
}
