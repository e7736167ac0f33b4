/* Vectors of doubles. */
#ifndef VECTORS_H
#define VECTORS_H

/* Value for a sensor without a new reading, or an unknown quantity. */
static const double NOTHING = 0.0 / 0.0;

static inline void copy(double *to, const double *from, long long count)
{
    for (long long i = 0; i < count; i++)
        to[i] = from[i];
}

static inline void fill(double *values, double value, long long count)
{
    for (long long i = 0; i < count; i++)
        values[i] = value;
}

#endif
