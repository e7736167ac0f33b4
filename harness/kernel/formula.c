/* A sampled function with memory. step.h is generated next to this file: STATES, the number of states, and `step`, a
   function (state, input, parameter) -> (state, output) by CasADi. */

#include <string.h>

#include "export.h"
#include "step.h"

EXPORT void evaluate(double *state, const double *input, const double *parameter, double *output)
{
    double next[STATES + 1]; /* one more than needed, since C has no empty arrays */
    const double *arguments[ARGUMENTS] = {state, input, parameter};
    double *results[RESULTS] = {next, output};

    call(step, arguments, results);
    memcpy(state, next, STATES * sizeof *state);
}
