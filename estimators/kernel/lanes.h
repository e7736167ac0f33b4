/* Rows of numbers in vectors of LANE_BYTES. The length of a row is a constant, WIDEST or less.

   Sums run in the order written, so that all widths of vectors give the same bits, and stay in registers, for which the
   loops over the vectors of a row must be unrolled: clang does not by itself for WebAssembly. */
#ifndef LANES_H
#define LANES_H

typedef double lane __attribute__((vector_size(LANE_BYTES), aligned(sizeof(double)), may_alias));

#define LANES(length) ((length) * (int)sizeof(double) / LANE_BYTES)

/* sum = start + factor[0] rows[at[0]] + factor[1] rows[at[1]] + ..., `count` of them; without `at` the rows in their
   order. Only the vectors `from` to `to` of a row are summed, which are constants; `sum` may be `start`. */
static inline void combine_lanes(int from, int to, int length, double *sum, const double *start, int count,
                                 const double *factor, const int *at, const double *rows)
{
    lane total[LANES(WIDEST)];
#pragma GCC unroll 32
    for (int l = from; l < to; l++)
        total[l] = ((const lane *)start)[l];
    for (int k = 0; k < count; k++) {
        const lane *term = (const lane *)(rows + (at ? at[k] : k) * length);
        const double times = factor[k];
#pragma GCC unroll 32
        for (int l = from; l < to; l++)
            total[l] += times * term[l];
    }
#pragma GCC unroll 32
    for (int l = from; l < to; l++)
        ((lane *)sum)[l] = total[l];
}

static inline void divide(int length, double *quotient, const double *values, double by)
{
    for (int l = 0; l < LANES(length); l++)
        ((lane *)quotient)[l] = ((const lane *)values)[l] / by;
}

/* Sum of factor[k] values[at[k]]; without `at` of factor[k] values[k]. */
static inline double dot(int count, const double *factor, const int *at, const double *values)
{
    double total = 0.0;
    for (int k = 0; k < count; k++)
        total += factor[k] * values[at ? at[k] : k];
    return total;
}

#endif
