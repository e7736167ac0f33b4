/* A sampled function with memory. step.h is generated next to this file: sizes, and `step`, a function (state, input,
   parameter) -> (state, output) by CasADi. */

#include <string.h>

#include "step.h"

#if defined(_WIN32)
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif

EXPORT void call(double *state, const double *input, const double *parameter, double *output)
{
    double following[NX + 1], work[WORK + 1];
    int index[INDEX + 1];
    const double *argument[ARGUMENTS + 1] = {state, input, parameter};
    double *result[RESULTS + 1] = {following, output};

    step(argument, result, index, work, 0);
    memcpy(state, following, NX * sizeof *state);
}
