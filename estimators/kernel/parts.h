/* One step of the decentralised Kalman filter of decentralised.py: cost linear in the parts of a train.

   shape.h is generated next to this file: sizes, tables, the layout of `block`, and by CasADi the equations of each kind
   of part and of the body. Rows of `covariance` (D of a part) have WIDTH numbers, rows of `shared` (U) have LENGTH; unused
   ones are zero. All sums run in the order written, so that both widths of vectors give the same bits. Sums of whole
   rows, which take nearly all of the time, are kept in registers by `combine`. */

#include <math.h>
#include <string.h>

#define CASADI_CODEGEN_PREFIX STEP
#define CODEGEN_PREFIX STEP
#include "shape.h"

enum { FINE = 0, PREDICTED_MEAN_NOT_FINITE = 1, NOT_DEFINITE = 2, MEAN_NOT_FINITE = 3 };

/* Columns of U: RANK that are kept, and three that a step adds. */
enum { PULLED = RANK, PUSHED = RANK + 1, WEIGHED = RANK + 2, COLUMNS = RANK + 3 };

typedef double row[WIDTH];
typedef double mode[LENGTH];

#define WIDEST (WIDTH > LENGTH ? WIDTH : LENGTH)
#include "lanes.h"

typedef struct {
    row covariance[PARTS][WIDTH]; /* D: covariance of each part alone */
    mode shared[N];           /* U: effect of the common unknowns on each state */
    mode common[LENGTH];      /* C: covariance of the common unknowns, may be indefinite */
    double mean[N], push[N], pull[N], jacobian[PARTS][WIDTH * WIDTH];
} Belief;

/* sum = start + factor[0] rows[0] + factor[1] rows[1] + ..., `count` of them. */
static inline void combine(int length, double *sum, const double *start, int count, const double *factor,
                           const double *rows)
{
    combine_lanes(0, LANES(length), length, sum, start, count, factor, 0, rows);
}

static const double ZERO[WIDEST];

/* Inputs of a part: its pressures, and zero acceleration, in which the equations are linear. */
static void inputs_of(int part, const double *block, double *inputs)
{
    const int count = PART_INPUT[part + 1] - PART_INPUT[part];
    for (int i = 0; i < count; i++)
        inputs[i] = block[INPUT + INPUT_PLACE[PART_INPUT[part] + i]];
    inputs[count] = 0.0;
}

/* Acceleration of the train, and its derivatives by speed and by force. */
static void body_at(const double *block, double v, double force, double *acceleration, double *by_speed,
                    double *by_force)
{
    const double inputs[2] = {force, block[INPUT + TRACK_FORCE]};
    const double *arguments[ARGUMENTS] = {&v, inputs, block + PARAMETERS};
    double *results[RESULTS] = {acceleration, by_speed, by_force};
    call(body, arguments, results);
}

/* Time derivative of all states at x; with `at`, also the linear equations of each part: x' = A x + push a. */
static void slope_at(const double *block, const double *x, double *slope, Belief *at)
{
    double force = 0.0, acceleration, by_speed, by_force;
    for (int p = 1; p < PARTS; p++) {
        double inputs[WIDTH + 1], own;
        inputs_of(p, block, inputs);
        const double *arguments[ARGUMENTS] = {x + PART_STATE[p], inputs, block + PARAMETERS + PART_PARAMETER[p]};
        double *results[RESULTS] = {slope + PART_STATE[p], &own};
        if (at) {
            results[2] = at->push + PART_STATE[p];
            results[3] = at->pull + PART_STATE[p];
            results[4] = at->jacobian[p];
        }
        call(at ? LINEAR[KIND[p]] : SLOPE[KIND[p]], arguments, results);
        force += own;
    }
    body_at(block, x[0], force, &acceleration, &by_speed, &by_force);
    slope[0] = acceleration;
    if (at) {
        for (int i = 1; i < N; i++)
            at->pull[i] *= by_force;
        at->pull[0] = by_speed;
        at->push[0] = 1.0;
    }
    const double *push = block + PUSH;
    for (int i = 1; i < N; i++)
        slope[i] += (at ? at->push[i] : push[i]) * acceleration;
}

/* Mean one period later by RK4, all parts together; leaves the linear equations at the prior mean in `b`. */
static void advance(double *block, Belief *b)
{
    const double *x = block + MEAN, period = block[PERIOD];
    double k1[N], k2[N], k3[N], k4[N], at[N];
    slope_at(block, x, k1, b);
    memcpy(block + PUSH, b->push, sizeof b->push);
    for (int i = 0; i < N; i++)
        at[i] = x[i] + 0.5 * period * k1[i];
    slope_at(block, at, k2, 0);
    for (int i = 0; i < N; i++)
        at[i] = x[i] + 0.5 * period * k2[i];
    slope_at(block, at, k3, 0);
    for (int i = 0; i < N; i++)
        at[i] = x[i] + period * k3[i];
    slope_at(block, at, k4, 0);
    for (int i = 0; i < N; i++)
        b->mean[i] = x[i] + period / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]);
}

/* Number of terms of a sum: n, or 0 if all of them are zero. */
static inline int needed(int n, const double *factor)
{
    for (int j = 0; j < n; j++)
        if (factor[j] != 0.0)
            return n;
    return 0;
}

/* phi = sum over k <= 4 of (T A)^k / k!, by Horner's scheme. */
static void transition(double period, int n, const double *jacobian, row *phi)
{
    row other[WIDTH] = {{0}}, factor;
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < n; j++)
            other[i][j] = period / 4 * jacobian[i * n + j];
        other[i][i] += 1.0;
    }
    for (int k = 3; k >= 1; k--) {
        const row *last = (const row *)(k % 2 ? other : phi);
        row *next = k % 2 ? phi : other;
        for (int i = 0; i < n; i++) {
            for (int j = 0; j < n; j++)
                factor[j] = period / k * jacobian[i * n + j];
            combine(WIDTH, next[i], ZERO, needed(n, factor), factor, last[0]);
            next[i][i] += 1.0;
        }
    }
}

/* phi D phi' of one part, and its rows of phi U. */
static void propagate(int n, const row *phi, row *covariance, mode *shared)
{
    row turned[WIDTH] = {{0}}, half;
    mode moved[WIDTH];
    for (int i = 0; i < n; i++) {
        combine(WIDTH, half, ZERO, n, phi[i], covariance[0]);
        combine(LENGTH, moved[i], ZERO, n, phi[i], shared[0]);
        for (int j = 0; j < n; j++)
            turned[j][i] = half[j];
    }
    for (int i = 0; i < n; i++) {
        combine(WIDTH, covariance[i], ZERO, n, phi[i], turned[0]);
        for (int j = 0; j < i; j++)
            covariance[i][j] = covariance[j][i];
    }
    memcpy(shared, moved, n * sizeof *moved);
}

/* C z; returns z' C z. */
static double through(const mode *common, const double *z, double *product)
{
    combine(LENGTH, product, ZERO, COLUMNS, z, common[0]);
    return dot(COLUMNS, z, 0, product);
}

/* C - k k' / by */
static void learn(mode *common, const double *k, double by)
{
    mode factor;
    divide(LENGTH, factor, k, -by);
    for (int i = 0; i < COLUMNS; i++)
        combine(LENGTH, common[i], common[i], 1, factor + i, k);
}

/* D c by parts, and U' c, the effect of the common unknowns on a reading c' x; returns c' D c. */
static double seen_by(const Belief *b, const double *c, double *product, double *z)
{
    double total = 0.0;
    for (int p = 0; p < PARTS; p++) {
        const int first = PART_STATE[p], n = PART_STATE[p + 1] - first;
        for (int i = 0; i < n; i++) {
            product[first + i] = dot(n, b->covariance[p][i], 0, c + first);
            total += c[first + i] * product[first + i];
        }
    }
    combine(LENGTH, z, ZERO, N, c, b->shared[0]);
    return total;
}

/* Covariance one period later. */
static void predict(double *block, Belief *b, const double *free)
{
    const double period = block[PERIOD];
    double own[N];
    mode z, carried;

    for (int p = 0; p < PARTS; p++)
        for (int i = 0; i < WIDTH; i++)
            for (int l = 0; l < WIDTH; l++)
                b->covariance[p][i][l] = block[PART_COVARIANCE + (p * WIDTH + i) * WIDTH + l];
    memset(b->common, 0, sizeof b->common);
    for (int k = 0; k < RANK; k++)
        b->common[k][k] = block[COMMON + k];
    for (int i = 0; i < N; i++) {
        for (int l = 0; l < LENGTH; l++)
            b->shared[i][l] = l < RANK ? block[SHARED + i * RANK + l] : 0.0;
    }
    const double alone = seen_by(b, b->pull, own, z);
    const double total = alone + through((const mode *)b->common, z, carried);
    carried[PULLED] = 1.0;
    for (int k = 0; k <= PULLED; k++) {
        b->common[k][PUSHED] = carried[k];
        b->common[PUSHED][k] = carried[k];
    }
    b->common[PUSHED][PUSHED] = total;

    for (int i = 0; i < N; i++)
        b->shared[i][PULLED] = own[i];
    for (int p = 1; p < PARTS; p++) {
        row phi[WIDTH];
        const int first = PART_STATE[p], n = PART_STATE[p + 1] - first;
        transition(period, n, b->jacobian[p], phi);
        propagate(n, (const row *)phi, b->covariance[p], b->shared + first);
    }
    for (int p = 0; p < PARTS; p++)
        for (int i = PART_STATE[p]; i < PART_STATE[p + 1]; i++) {
            b->shared[i][PUSHED] = period * b->push[i];
            b->covariance[p][i - PART_STATE[p]][i - PART_STATE[p]] += block[NOISE + i] * free[i];
        }
}

/* Condition on the readings; `shift` is the correction of the mean. */
static int condition(double *block, Belief *b, double *shift)
{
    double eta[LENGTH] = {0}, pull[N], own[N];
    mode z, product;

    memset(shift, 0, N * sizeof *shift);
    block[SQUARED] = 0.0;
    for (int i = 0; i < M; i++) {
        const int p = READING_PART[i], state = READING_STATE[i];
        block[USED + i] = 0.0;
        if (p < 0 || isnan(block[READING + i]))
            continue;
        const int first = PART_STATE[p], n = PART_STATE[p + 1] - first;
        row k, gain;
        memcpy(k, b->covariance[p][state - first], sizeof k);
        memcpy(z, b->shared[state], sizeof z);
        const double alone = k[state - first] + block[READING_NOISE + i];
        const double all = alone + through((const mode *)b->common, z, product);
        if (!(alone > 0.0 && all > 0.0))
            return NOT_DEFINITE;
        const double residual = block[READING + i] - b->mean[state] - shift[state];
        const double innovation = residual - dot(COLUMNS, z, 0, eta);
        divide(WIDTH, gain, k, -alone);
        for (int r = 0; r < n; r++) {
            shift[first + r] -= gain[r] * residual;
            combine(WIDTH, b->covariance[p][r], b->covariance[p][r], 1, gain + r, k);
            combine(LENGTH, b->shared[first + r], b->shared[first + r], 1, gain + r, z);
        }
        learn(b->common, product, all);
        for (int l = 0; l < COLUMNS; l++)
            eta[l] += product[l] * innovation / all;
        block[SQUARED] += innovation * innovation / all;
        block[USED + i] = 1.0;
    }
    for (int i = 0; i < M; i++) {
        if (READING_PART[i] >= 0 || isnan(block[READING + i]))
            continue;
        double force = 0.0, acceleration, by_speed, by_force;
        for (int p = 1; p < PARTS; p++) {
            double inputs[WIDTH + 1], part;
            inputs_of(p, block, inputs);
            const double *arguments[ARGUMENTS] = {b->mean + PART_STATE[p], inputs,
                                                  block + PARAMETERS + PART_PARAMETER[p]};
            double *results[RESULTS] = {&part, pull + PART_STATE[p]};
            call(FORCE[KIND[p]], arguments, results);
            force += part;
        }
        body_at(block, b->mean[0], force, &acceleration, &by_speed, &by_force);
        pull[0] = by_speed;
        for (int j = 1; j < N; j++)
            pull[j] *= by_force;
        const double alone = seen_by(b, pull, own, z) + block[READING_NOISE + i];
        const double all = alone + through((const mode *)b->common, z, product);
        if (!(all > 0.0))
            return NOT_DEFINITE;
        const double innovation = block[READING + i] - acceleration - dot(N, pull, 0, shift) - dot(COLUMNS, z, 0, eta);
        for (int j = 0; j < N; j++)
            b->shared[j][WEIGHED] = own[j];
        product[WEIGHED] = 1.0;
        learn(b->common, product, all);
        for (int l = 0; l < COLUMNS; l++)
            eta[l] += product[l] * innovation / all;
        block[SQUARED] += innovation * innovation / all;
        block[USED + i] = 1.0;
    }
    for (int i = 0; i < N; i++)
        shift[i] += dot(COLUMNS, b->shared[i], 0, eta);
    return FINE;
}

/* Covariance of every frozen state with the frozen ones of its part. */
static void frozen(const Belief *b, const double *free, row *known)
{
    for (int g = 0; g < GATES; g++) {
        const int p = GATE_PART[g], first = PART_STATE[p], state = GATE_STATE[g];
        mode product;
        if (free[state] != 0.0)
            continue;
        through((const mode *)b->common, b->shared[state], product);
        for (int i = first; i < PART_STATE[p + 1]; i++)
            if (free[i] == 0.0)
                known[g][i - first] = b->covariance[p][state - first][i - first] + dot(COLUMNS, product, 0, b->shared[i]);
    }
}

/* Undo the changes of frozen states by the readings: they are consider states of Schmidt's filter, except for the
   covariance between frozen states of different parts. */
static void restore(Belief *b, const double *free, const row *before, double *shift)
{
    row after[GATES + 1];
    frozen(b, free, after);
    for (int g = 0; g < GATES; g++) {
        const int p = GATE_PART[g], first = PART_STATE[p], state = GATE_STATE[g];
        if (free[state] != 0.0)
            continue;
        shift[state] = 0.0;
        for (int i = first; i < PART_STATE[p + 1]; i++)
            if (free[i] == 0.0)
                b->covariance[p][state - first][i - first] += before[g][i - first] - after[g][i - first];
    }
}

/* Eigenvalues of a symmetric matrix on its diagonal and eigenvectors in the rows of `vector`, by Jacobi's rotations. */
static void eigen(mode *matrix, mode *vector)
{
    memset(vector, 0, LENGTH * sizeof *vector);
    for (int i = 0; i < COLUMNS; i++)
        vector[i][i] = 1.0;
    for (int sweep = 0; sweep < 30; sweep++) {
        int turned = 0;
        for (int p = 0; p < COLUMNS - 1; p++)
            for (int q = p + 1; q < COLUMNS; q++) {
                const double off = matrix[p][q];
                if (fabs(off) <= 1e-13 * (1.0 + fabs(matrix[p][p]) + fabs(matrix[q][q])))
                    continue;
                turned = 1;
                const double theta = (matrix[q][q] - matrix[p][p]) / (2.0 * off);
                const double t = (theta < 0.0 ? -1.0 : 1.0) / (fabs(theta) + sqrt(theta * theta + 1.0));
                const double c = 1.0 / sqrt(t * t + 1.0), s = t * c;
                const double at_p = matrix[p][p] - t * off, at_q = matrix[q][q] + t * off;
                for (int l = 0; l < LENGTH; l++) {
                    const double x = vector[p][l], y = vector[q][l];
                    vector[p][l] = c * x - s * y;
                    vector[q][l] = s * x + c * y;
                }
                /* number by number: vectors would wait for the numbers that the last rotation stored in them */
                for (int l = 0; l < COLUMNS; l++) {
                    const double a = matrix[p][l], b = matrix[q][l];
                    matrix[p][l] = matrix[l][p] = c * a - s * b;
                    matrix[q][l] = matrix[l][q] = s * a + c * b;
                }
                matrix[p][p] = at_p;
                matrix[q][q] = at_q;
                matrix[p][q] = matrix[q][p] = 0.0;
            }
        if (!turned)
            return;
    }
}

/* Write D + U C U' back with RANK common unknowns: those with the largest effect in units of D.

   Removed directions with positive eigenvalues are added to D; those with negative ones, shared knowledge, are dropped.
   Neither reduces the covariance. */
static int compress(double *block, Belief *b)
{
    mode gram[LENGTH] = {{0}}, root[LENGTH] = {{0}}, inner[LENGTH] = {{0}}, vector[LENGTH], weight[LENGTH] = {{0}};
    int order[COLUMNS];

    for (int p = 0; p < PARTS; p++) {
        const int first = PART_STATE[p], n = PART_STATE[p + 1] - first;
        row across[WIDTH] = {{0}}, factor[WIDTH], sum, before;
        mode white[WIDTH];
        for (int i = 0; i < n; i++)
            for (int j = 0; j < i; j++)
                across[j][i] = b->covariance[p][i][j];
        /* D = L L', L by columns in the rows of `factor`; then L white = U */
        for (int j = 0; j < n; j++) {
            for (int k = 0; k < j; k++)
                before[k] = factor[k][j];
            combine(WIDTH, sum, ZERO, j, before, factor[0]);
            const double left = b->covariance[p][j][j] - sum[j];
            if (!(left > 0.0))
                return NOT_DEFINITE;
            for (int i = 0; i < WIDTH; i++)
                across[j][i] -= sum[i];
            divide(WIDTH, factor[j], across[j], sqrt(left));
            factor[j][j] = sqrt(left);
            for (int k = 0; k < j; k++)
                before[k] = -before[k];
            combine(LENGTH, white[j], b->shared[first + j], j, before, white[0]);
            divide(LENGTH, white[j], white[j], factor[j][j]);
        }
        for (int k = 0; k < COLUMNS; k++) {
            row column;
            for (int i = 0; i < n; i++)
                column[i] = white[i][k];
            combine(LENGTH, gram[k], gram[k], n, column, white[0]);
        }
    }
    /* gram = root' root; a column that others make up has no row in it */
    for (int k = 0; k < COLUMNS; k++) {
        const double whole = gram[k][k];
        double left = whole;
        for (int j = 0; j < k; j++)
            left -= root[j][k] * root[j][k];
        if (!(left > 1e-13 * whole))
            continue;
        for (int l = 0; l < LENGTH; l++)
            root[k][l] = l < k ? 0.0 : gram[k][l];
        for (int j = 0; j < k; j++)
            for (int l = k; l < LENGTH; l++)
                root[k][l] -= root[j][k] * root[j][l];
        const double pivot = sqrt(left);
        for (int l = k; l < LENGTH; l++)
            root[k][l] /= pivot;
    }
    for (int k = 0; k < COLUMNS; k++) {
        mode product;
        through((const mode *)b->common, root[k], product);
        for (int j = 0; j <= k; j++)
            inner[k][j] = inner[j][k] = dot(COLUMNS, root[j], 0, product);
    }
    eigen(inner, vector);
    for (int k = 0; k < COLUMNS; k++) {
        int at = k;
        if (!(inner[k][k] > -1.0))
            return NOT_DEFINITE;
        for (; at > 0 && fabs(log1p(inner[order[at - 1]][order[at - 1]])) < fabs(log1p(inner[k][k])); at--)
            order[at] = order[at - 1];
        order[at] = k;
    }
    /* root weight = eigenvectors, the ones that matter most first */
    for (int k = COLUMNS - 1; k >= 0; k--) {
        if (root[k][k] == 0.0)
            continue;
        for (int l = 0; l < COLUMNS; l++)
            weight[k][l] = vector[order[l]][k];
        for (int j = k + 1; j < COLUMNS; j++)
            for (int l = 0; l < LENGTH; l++)
                weight[k][l] -= root[k][j] * weight[j][l];
        for (int l = 0; l < LENGTH; l++)
            weight[k][l] /= root[k][k];
    }
    for (int p = 0; p < PARTS; p++) {
        const int first = PART_STATE[p], n = PART_STATE[p + 1] - first;
        mode turned[WIDTH];
        for (int i = 0; i < n; i++) {
            combine(LENGTH, turned[i], ZERO, COLUMNS, b->shared[first + i], weight[0]);
        }
        for (int l = RANK; l < COLUMNS; l++) {
            const double excess = inner[order[l]][order[l]];
            if (excess > 0.0)
                for (int i = 0; i < n; i++)
                    for (int j = 0; j < n; j++)
                        b->covariance[p][i][j] += excess * turned[i][l] * turned[j][l];
        }
        for (int i = 0; i < n; i++) {
            double variance = b->covariance[p][i][i];
            for (int k = 0; k < RANK; k++) {
                variance += inner[order[k]][order[k]] * turned[i][k] * turned[i][k];
                block[SHARED + (first + i) * RANK + k] = turned[i][k];
            }
            for (int j = 0; j < WIDTH; j++)
                block[PART_COVARIANCE + (p * WIDTH + i) * WIDTH + j] = b->covariance[p][i][j];
            block[COVARIANCE + (first + i) * (N + 1)] = variance;
        }
    }
    for (int k = 0; k < RANK; k++)
        block[COMMON + k] = inner[order[k]][order[k]];
    return FINE;
}

/* Advance the belief in `block` by one period; on failure it stays as it was. */
int STEP(double *block)
{
    Belief b;
    double free[N], shift[N];
    row before[GATES + 1];

    for (int i = 0; i < N; i++)
        free[i] = 1.0;
    for (int g = 0; g < GATES; g++)
        if (block[INPUT + GATE_INPUT[g]] < block[THRESHOLD])
            free[GATE_STATE[g]] = 0.0;
    advance(block, &b);
    for (int i = 0; i < N; i++)
        if (!isfinite(b.mean[i]))
            return PREDICTED_MEAN_NOT_FINITE;
    predict(block, &b, free);
    frozen(&b, free, before);
    int outcome = condition(block, &b, shift);
    if (outcome)
        return outcome;
    restore(&b, free, (const row *)before, shift);
    for (int i = 0; i < N; i++)
        if (!isfinite(b.mean[i] + shift[i]))
            return MEAN_NOT_FINITE;
    outcome = compress(block, &b);
    if (outcome)
        return outcome;
    for (int i = 0; i < N; i++)
        block[MEAN + i] = b.mean[i] + shift[i];
    return FINE;
}
