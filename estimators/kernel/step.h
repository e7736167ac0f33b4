/* One step of the extended Kalman filter: the filter of ekf.py, for one model and with its zeros left out.

   shape.h is generated next to this file: sizes, sparsity tables, the layout of `block`, and the model itself as three
   functions (model_in_c.py): `slope` -> f; `slope_and_jacobian` -> f, df/dx; `expected` -> h, dh/dx, Jacobians by rows.

   Every product of matrices here is a sum of rows with factors, and a row has the same length everywhere: WIDTH
   numbers, those beyond N zero. So one function, `combine`, does nearly all the work, its sum kept in registers. Sums
   of rows, unlike dot products, give the same bits whatever the width of the machine's vector instructions: this file
   is compiled for one of two widths (plain.c, wide.c), that of the machine. */

#include <math.h>

/* CasADi's helper functions are not static; its own names for the prefix disagree, so both are given. */
#define CASADI_CODEGEN_PREFIX STEP
#define CODEGEN_PREFIX STEP
#include "shape.h"

enum { FINE = 0, PREDICTED_MEAN_NOT_FINITE = 1, READINGS_NOT_DEFINITE = 2, MEAN_NOT_FINITE = 3, MODEL_FAILED = 4 };

typedef double row[WIDTH];

#define WIDEST WIDTH
#include "lanes.h"

/* `combine_lanes` of whole rows, and of one part of them. */
static inline void combine(double *sum, const double *start, int count, const double *factor, const int *at,
                           const row *rows)
{
    combine_lanes(0, LANES(WIDTH), WIDTH, sum, start, count, factor, at, rows[0]);
}

static inline void combine_part(int from, int to, double *sum, const double *start, int count, const double *factor,
                                const int *at, const row *rows)
{
    combine_lanes(from, to, WIDTH, sum, start, count, factor, at, rows[0]);
}

/* Range of columns of row i in one half of a symmetric matrix, rounded to quarters of a row. */
#define QUARTER(i) ((i) * (int)sizeof(double) / LANE_BYTES * 4 / LANES(WIDTH))

static void combine_from(int i, double *sum, const double *start, int count, const double *factor, const int *at,
                         const row *rows)
{
    switch (QUARTER(i)) {
    case 0: combine_part(0, LANES(WIDTH), sum, start, count, factor, at, rows); break;
    case 1: combine_part(LANES(WIDTH) / 4, LANES(WIDTH), sum, start, count, factor, at, rows); break;
    case 2: combine_part(2 * LANES(WIDTH) / 4, LANES(WIDTH), sum, start, count, factor, at, rows); break;
    case 3: combine_part(3 * LANES(WIDTH) / 4, LANES(WIDTH), sum, start, count, factor, at, rows); break;
    }
}

static void combine_to(int i, double *sum, const double *start, int count, const double *factor, const int *at,
                       const row *rows)
{
    switch (QUARTER(i)) {
    case 0: combine_part(0, (LANES(WIDTH) + 3) / 4, sum, start, count, factor, at, rows); break;
    case 1: combine_part(0, (2 * LANES(WIDTH) + 3) / 4, sum, start, count, factor, at, rows); break;
    case 2: combine_part(0, (3 * LANES(WIDTH) + 3) / 4, sum, start, count, factor, at, rows); break;
    case 3: combine_part(0, LANES(WIDTH), sum, start, count, factor, at, rows); break;
    }
}

/* Add one to the i-th number, as part of its vector: one stored alone would have the next load of the vector wait. */
static inline void add_one(double *values, int i)
{
    enum { EACH = LANE_BYTES / sizeof(double) };
    static const double ONE[2 * EACH] = {[EACH - 1] = 1.0};
    ((lane *)values)[i / EACH] += *(const lane *)(ONE + EACH - 1 - i % EACH);
}

static int all_finite(const double *x, int count)
{
    for (int i = 0; i < count; i++)
        if (!isfinite(x[i]))
            return 0;
    return 1;
}

/* Mean one period later by RK4, or by forward Euler at ORDER 1, and A = df/dx by rows; a frozen state has derivative
   zero. */
static int advance(const double *block, const double *free, double *mean, double *jacobian)
{
    const double *x = block + MEAN;
    const double period = block[PERIOD];
    double k1[N];

    if (slope_and_jacobian(block, x, k1, jacobian))
        return MODEL_FAILED;
#if ORDER == 1
    for (int i = 0; i < N; i++)
        mean[i] = x[i] + period * k1[i] * free[i];
#else
    double k2[N], k3[N], k4[N], at[N];
    for (int i = 0; i < N; i++)
        at[i] = x[i] + 0.5 * period * (k1[i] *= free[i]);
    if (slope(block, at, k2))
        return MODEL_FAILED;
    for (int i = 0; i < N; i++)
        at[i] = x[i] + 0.5 * period * (k2[i] *= free[i]);
    if (slope(block, at, k3))
        return MODEL_FAILED;
    for (int i = 0; i < N; i++)
        at[i] = x[i] + period * (k3[i] *= free[i]);
    if (slope(block, at, k4))
        return MODEL_FAILED;
    for (int i = 0; i < N; i++)
        mean[i] = x[i] + period / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i] * free[i]);
#endif
    return FINE;
}

/* next = I + T A last / k; k is a constant. */
static inline void horner(int k, const double *jacobian, const row *last, row *next)
{
    static const row zero;
    double scaled[A_COUNT];

    for (int at = 0; at < A_ROW[N]; at++)
        scaled[at] = jacobian[at] / k;
    for (int i = 0; i < N; i++) {
        combine(next[i], zero, A_ROW[i + 1] - A_ROW[i], scaled + A_ROW[i], A_COLUMN + A_ROW[i], last);
        add_one(next[i], i);
    }
}

/* phi = sum over k <= ORDER of (T A)^k / k!, by Horner's scheme; `jacobian` becomes T A. */
static void transition(double period, const double *free, double *jacobian, row *phi)
{
    static const row zero;
    row other[N], *first = ORDER == 1 ? phi : other;

    for (int i = 0; i < N; i++) {
        combine(first[i], zero, 0, 0, 0, 0);
        for (int at = A_ROW[i]; at < A_ROW[i + 1]; at++) {
            jacobian[at] *= period * free[i];
            first[i][A_COLUMN[at]] = jacobian[at] / ORDER;
        }
        first[i][i] += 1.0;
    }
#if ORDER == 4
    horner(3, jacobian, (const row *)other, phi);
    horner(2, jacobian, (const row *)phi, other);
    horner(1, jacobian, (const row *)other, phi);
#endif
}

/* phi P phi' + Q, exactly symmetric: the upper triangle, mirrored. */
static void predict_covariance(const double *block, const double *free, const row *phi, row *predicted)
{
    static const row zero;
    const row *prior = (const row *)(block + COVARIANCE), *noise = (const row *)(block + PROCESS_NOISE);
    double factor[PHI_COUNT];
    row turned[N] = {{0}}, sum;

    for (int i = 0; i < N; i++)
        for (int at = PHI_ROW[i]; at < PHI_ROW[i + 1]; at++)
            factor[at] = phi[i][PHI_COLUMN[at]];
    for (int i = 0; i < N; i++) {
        const int first = PHI_ROW[i];
        combine(sum, zero, PHI_ROW[i + 1] - first, factor + first, PHI_COLUMN + first, prior);
        for (int j = 0; j < N; j++)
            turned[j][i] = sum[j];
    }
    for (int i = 0; i < N; i++) {
        const int first = PHI_ROW[i];
        combine_from(i, predicted[i], zero, PHI_ROW[i + 1] - first, factor + first, PHI_COLUMN + first, turned);
        for (int j = 0; j < i; j++)
            predicted[i][j] = predicted[j][i];
        for (int j = i; j < N; j++)
            predicted[i][j] += noise[i][j] * free[i] * free[j];
    }
}

/* Lower Cholesky factor of the leading r x r of S, in place; returns 0 if S is not positive definite. */
static int factorise(int r, double S[M][M])
{
    for (int j = 0; j < r; j++) {
        double left = S[j][j];
        for (int k = 0; k < j; k++)
            left -= S[j][k] * S[j][k];
        if (!(left > 0.0) || !isfinite(left))
            return 0;
        S[j][j] = sqrt(left);
        for (int i = j + 1; i < r; i++) {
            double sum = S[i][j];
            for (int k = 0; k < j; k++)
                sum -= S[i][k] * S[j][k];
            S[i][j] = sum / S[j][j];
        }
    }
    return 1;
}

/* Condition on the readings; writes mean and covariance into `block`. */
static int condition(double *block, const double *free, const double *mean, const row *P)
{
    static const row zero;
    const double *readings = block + READING, *noise = block + READING_NOISE;
    double expectation[M], H[H_COUNT], residual[M], S[M][M], R[M][M], minus[M];
    row PH[M], gain[M], excess[M], turned[N]; /* P H' and K, by columns: row a is column a of the r used readings */
    int used[M], all[M], related[M], relative[M][M], r = 0;

    if (expected(block, mean, expectation, H))
        return MODEL_FAILED;
    for (int i = 0; i < M; i++) {
        const int first = H_ROW[i], count = H_ROW[i + 1] - first;
        block[USED + i] = 0.0;
        block[EXPECTED + i] = expectation[i];
        if (isnan(readings[i]))
            continue;
        combine(PH[r], zero, count, H + first, H_COLUMN + first, P);
        residual[r] = readings[i] - expectation[i];
        const double variance = dot(count, H + first, H_COLUMN + first, PH[r]) + noise[i * M + i];
        if (residual[r] * residual[r] > block[LIMIT_SQUARED + i] * variance)
            continue;
        block[USED + i] = 1.0;
        all[r] = r;
        used[r++] = i;
    }
    for (int a = 0; a < r; a++)
        for (int b = 0; b <= a; b++) {
            const int first = H_ROW[used[b]], count = H_ROW[used[b] + 1] - first;
            S[a][b] = dot(count, H + first, H_COLUMN + first, PH[a]) + noise[used[a] * M + used[b]];
        }
    if (!factorise(r, S))
        return READINGS_NOT_DEFINITE;
    for (int a = 0; a < r; a++) { /* R without its zeros: most often only its diagonal is left */
        related[a] = 0;
        for (int b = 0; b < r; b++)
            if (noise[used[a] * M + used[b]] != 0.0) {
                R[a][related[a]] = noise[used[a] * M + used[b]];
                relative[a][related[a]++] = b;
            }
    }

    /* S K' = H P: forward, then back; the forward substitution of the residual gives its normalised square too */
    double white[M], after[WIDTH] = {0};
    block[SQUARED] = 0.0;
    for (int a = 0; a < r; a++) {
        white[a] = residual[a];
        for (int b = 0; b < a; b++) {
            minus[b] = -S[a][b];
            white[a] += minus[b] * white[b];
        }
        white[a] /= S[a][a];
        block[SQUARED] += white[a] * white[a];
        combine(gain[a], PH[a], a, minus, all, gain);
        divide(WIDTH, gain[a], gain[a], S[a][a]);
    }
    for (int a = r - 1; a >= 0; a--) {
        for (int b = a + 1; b < r; b++)
            minus[b] = -S[b][a];
        combine(gain[a], gain[a], r - a - 1, minus + a + 1, all + a + 1, gain);
        divide(WIDTH, gain[a], gain[a], S[a][a]);
        for (int i = 0; i < N; i++)
            gain[a][i] *= free[i];
    }
    for (int i = 0; i < N; i++)
        after[i] = mean[i];
    combine(after, after, r, residual, all, gain);
    if (!all_finite(after, N))
        return MEAN_NOT_FINITE;

    /* Joseph form in two products: L = (I - K H) P, then L (I - K H)' + K R K' = L - (L H' - K R) K'. Rounding of the
       first is scaled down by I - K H in the second, as in the form written out, at a third of the cost. All by
       columns, for what H and R take together are then rows: row j of `turned` is column j of L, `excess` those of -(L
       H' - K R). */
    row *covariance = (row *)(block + COVARIANCE);
    for (int j = 0; j < N; j++) {
        for (int a = 0; a < r; a++)
            minus[a] = -PH[a][j];
        combine(turned[j], P[j], r, minus, all, gain);
    }
    for (int a = 0; a < r; a++) {
        const int first = H_ROW[used[a]], count = H_ROW[used[a] + 1] - first;
        row known;
        combine(known, zero, count, H + first, H_COLUMN + first, turned);
        combine(excess[a], zero, related[a], R[a], relative[a], gain);
        for (int l = 0; l < LANES(WIDTH); l++)
            ((lane *)excess[a])[l] -= ((const lane *)known)[l];
    }
    for (int j = 0; j < N; j++) {
        for (int a = 0; a < r; a++)
            minus[a] = gain[a][j];
        combine_to(j, covariance[j], turned[j], r, minus, all, excess);
        for (int i = 0; i < j; i++)
            covariance[i][j] = covariance[j][i];
    }
    for (int i = 0; i < N; i++)
        block[MEAN + i] = after[i];
    return FINE;
}

/* Advance the belief in `block` by one period; on failure it stays as it was. */
int STEP(double *block)
{
    double free[N], mean[N], jacobian[A_COUNT];
    row phi[N], predicted[N];

    for (int i = 0; i < N; i++)
        free[i] = 1.0;
    for (int g = 0; g < GATES; g++)
        if (block[INPUT + GATE_INPUT[g]] < block[THRESHOLD])
            free[GATE_STATE[g]] = 0.0;
    if (advance(block, free, mean, jacobian))
        return MODEL_FAILED;
    if (!all_finite(mean, N))
        return PREDICTED_MEAN_NOT_FINITE;
    transition(block[PERIOD], free, jacobian, phi);
    predict_covariance(block, free, (const row *)phi, predicted);
    return condition(block, free, mean, (const row *)predicted);
}
