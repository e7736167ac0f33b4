/* Many steps in one call: a recording at the speed of C, for tuning and for long files. */
#include "sizes.h"

#if defined(_WIN32)
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif

int dispatch(double *block);

/* Advance `block` by `count` periods with row k of `held` and `seen`; rows k of the results say what is believed then.
   Returns the number of steps that succeeded; what stopped it, if anything did, is in `outcome`. */
EXPORT int run(double *block, int count, const double *held, const double *seen, double *mean, double *variance,
               double *expected, double *squared, double *used, int *outcome)
{
    *outcome = 0;
    for (int k = 0; k < count; k++) {
        for (int i = 0; i < INPUTS; i++)
            block[HELD + i] = held[k * INPUTS + i];
        for (int i = 0; i < M; i++)
            block[SEEN + i] = seen[k * M + i];
        *outcome = dispatch(block);
        if (*outcome)
            return k;
        for (int i = 0; i < N; i++) {
            mean[k * N + i] = block[MEAN + i];
            variance[k * N + i] = block[COVARIANCE + i * WIDTH + i];
        }
        squared[k] = block[SQUARED];
        used[k] = 0.0;
        for (int i = 0; i < M; i++) {
            used[k] += block[USED + i];
            expected[k * M + i] = block[EXPECTED + i];
        }
    }
    return count;
}
