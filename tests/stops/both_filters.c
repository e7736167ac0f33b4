/* A step of two filters from the same prior, inputs and readings; keeps the largest difference of their results.

   `filter` holds pairs of addresses of the parts of the blocks: mean, covariance, inputs, readings. The first filter's
   results count for the stop. Differences are relative to the size of a state, value and deviation together, and to the
   deviations of the two states of a covariance.                                                                      */
#include <math.h>
#include <string.h>

typedef int Step(double *);

typedef struct {
    Step *step[2];
    double *block[2], *mean[2], *covariance[2], *inputs[2], *readings[2];
    long long states, width, n_inputs, n_readings;
    double largest;
    long long steps;
} Both;

static void compare(Both *b, double difference)
{
    if (!(difference <= b->largest)) /* a NaN counts, too */
        b->largest = difference;
}

int step_both(Both *b)
{
    memcpy(b->mean[1], b->mean[0], b->states * sizeof(double));
    memcpy(b->covariance[1], b->covariance[0], b->states * b->width * sizeof(double));
    memcpy(b->inputs[1], b->inputs[0], b->n_inputs * sizeof(double));
    memcpy(b->readings[1], b->readings[0], b->n_readings * sizeof(double));
    const int first = b->step[0](b->block[0]), second = b->step[1](b->block[1]);

    if (first || second) {
        compare(b, first == second ? 0.0 : INFINITY);
        return first;
    }
    for (long long i = 0; i < b->states; i++) {
        const double *P = b->covariance[0], *Q = b->covariance[1], x = b->mean[0][i];
        const double deviation = sqrt(P[i * b->width + i]);
        compare(b, fabs(x - b->mean[1][i]) / (fabs(x) + deviation));
        for (long long j = 0; j < b->states; j++)
            compare(b, fabs(P[i * b->width + j] - Q[i * b->width + j]) / (deviation * sqrt(P[j * b->width + j])));
    }
    b->steps++;
    return first;
}
