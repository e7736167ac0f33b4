/* A system with its own memory, without FMI: nothing is allocated, and states do not share anything.
 *
 * The generated file comes first: the header of the library, START, STEP and State, the table start_p of the parameters,
 * `lay` and `sample`. */
#include <string.h>

void START(State *state) {
    memset(state, 0, sizeof *state);
    memcpy(&state->parameters, start_p, sizeof state->parameters);
    lay(state->memory);
}

int STEP(State *state, const Inputs *inputs, Outputs *outputs) {
    return sample(state->memory, state->sample++, (const double *)inputs, (const double *)&state->parameters,
                  (double *)outputs);
}
