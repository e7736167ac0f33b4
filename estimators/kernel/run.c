/* Many steps in one call: a recording at the speed of C, for tuning and for long files. */
#include "sizes.h"

#if defined(_WIN32)
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif

int dispatch(double *block);

/* Advance `block` by `count` periods with row k of `inputs` and `readings`. If `integral_of` has the index of a state for an
   input, not -1, the input is the integral of that state, advanced before the step so that the expected readings are those
   at its end. Every `every`-th step writes a row of the results; `covariance` may be null. Returns the number of steps
   that succeeded; `outcome` has the failure of the next one, or 0. */
EXPORT int run(double *block, int count, int every, const int *integral_of, const double *inputs,
               const double *readings, double *mean, double *variance, double *covariance, double *expected,
               double *squared, double *used, int *outcome)
{
    *outcome = 0;
    for (int k = 0; k < count; k++) {
        for (int i = 0; i < INPUTS; i++)
            if (integral_of[i] < 0)
                block[INPUT + i] = inputs[k * INPUTS + i];
            else
                block[INPUT + i] += block[PERIOD] * block[MEAN + integral_of[i]];
        for (int i = 0; i < M; i++)
            block[READING + i] = readings[k * M + i];
        *outcome = dispatch(block);
        if (*outcome)
            return k;
        if ((k + 1) % every)
            continue;
        const int row = (k + 1) / every - 1;
        for (int i = 0; i < N; i++) {
            mean[row * N + i] = block[MEAN + i];
            variance[row * N + i] = block[COVARIANCE + i * WIDTH + i];
            for (int j = 0; covariance && j < N; j++)
                covariance[(row * N + i) * N + j] = block[COVARIANCE + i * WIDTH + j];
        }
        squared[row] = block[SQUARED];
        for (int i = 0; i < M; i++) {
            used[row * M + i] = block[USED + i];
            expected[row * M + i] = block[EXPECTED + i];
        }
    }
    return count;
}
