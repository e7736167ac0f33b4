/* Rosenbrock methods RODAS3 and RODAS4: linearly implicit, L-stable, stiffly accurate, embedded error estimate.
 *
 * Each stage solves (I/(hγ) − J) k = f(t + αh, y) + Σ (c/h) k + hγ' ∂f/∂t.
 * Sources: RODAS4 (order 4(3), 6 stages) Hairer and Wanner, Solving ODEs II (1996), §IV.7; RODAS3 (order 3(2),
 * 4 stages) Sandu et al., Atmospheric Environment 31 (1997) 3459. */

/* Derivatives, their Jacobian, their partial derivative in time and indicators at (t, work.x0), evaluated together because
 * they share most of their subexpressions. */
static int linearise(Instance *m, double t) {
    State *s = &m->s;
    Work *w = &m->w;
    t = inside(s, t);
    if (NG && loops(m, t, w->x0)) return 1;
    const double *a[] = ARGUMENTS(s, &t, w->x0);
    double *r[] = { w->f0, w->jacobian, w->ft, w->z0 };
    f_jacobian(a, r);
    s->v[EVALUATIONS]++;
    s->v[JACOBIANS]++;
    return 0;
}

static int dense_factor(double *a, int *pivot) {
    for (int k = 0; k < NX; k++) {
        int p = k;
        for (int i = k + 1; i < NX; i++)
            if (fabs(a[i + k * NX]) > fabs(a[p + k * NX])) p = i;
        pivot[k] = p;
        if (!(fabs(a[p + k * NX]) > 0)) return 1;
        if (p != k)
            for (int j = 0; j < NX; j++) {
                double swap = a[k + j * NX];
                a[k + j * NX] = a[p + j * NX];
                a[p + j * NX] = swap;
            }
        for (int i = k + 1; i < NX; i++) a[i + k * NX] /= a[k + k * NX];
        for (int j = k + 1; j < NX; j++) {
            double factor = a[k + j * NX];
            if (factor != 0)
                for (int i = k + 1; i < NX; i++) a[i + j * NX] -= a[i + k * NX] * factor;
        }
    }
    return 0;
}

static void dense_solve(const double *a, const int *pivot, double *b) {
    for (int k = 0; k < NX; k++) {
        double swap = b[pivot[k]];
        b[pivot[k]] = b[k];
        b[k] = swap;
    }
    for (int k = 0; k < NX; k++)
        for (int i = k + 1; i < NX; i++) b[i] -= a[i + k * NX] * b[k];
    for (int k = NX - 1; k >= 0; k--) {
        b[k] /= a[k + k * NX];
        for (int i = 0; i < k; i++) b[i] -= a[i + k * NX] * b[k];
    }
}

/* Factor I·c − J in the elimination order fixed at compile time, or densely if that gives a tiny pivot. */
static int factor(Work *w, double c) {
    w->is_dense = sparse_factor(w->jacobian, c, w->lu);
    if (!w->is_dense) return 0;
    double *a = w->dense;
    memset(a, 0, NX * NX * sizeof *a);
    for (int i = 0; i < NJ; i++) a[jacobian_row[i] + jacobian_column[i] * NX] = -w->jacobian[i];
    for (int i = 0; i < NX; i++) a[i + i * NX] += c;
    return dense_factor(a, w->pivot);
}

static inline void backsolve(const Work *w, double *b) {
    if (w->is_dense)
        dense_solve(w->dense, w->pivot, b);
    else
        sparse_solve(w->lu, b);
}

#define EACH for (int i = 0; i < NX; i++)

static int rodas3(Instance *m, double t, double h) {
    Work *w = &m->w;
    double *x0 = w->x0, *x1 = w->x1, *y = w->y, *f = w->f, *k1 = w->k[0], *k2 = w->k[1], *k3 = w->k[2], *k4 = w->k[3];
    const double c = 1 / h;
    if (factor(w, 2 * c)) return failure(m, "the iteration matrix is singular at time = %.9g s", t);
    EACH k1[i] = w->f0[i] + 0.5 * h * w->ft[i];
    backsolve(w, k1);
    EACH k2[i] = w->f0[i] + 4 * c * k1[i] + 1.5 * h * w->ft[i];
    backsolve(w, k2);
    EACH y[i] = x0[i] + 2 * k1[i];
    if (derivatives(m, t + h, y, f)) return 1;
    EACH k3[i] = f[i] + c * (k1[i] - k2[i]);
    backsolve(w, k3);
    EACH y[i] += k3[i];
    if (derivatives(m, t + h, y, f)) return 1;
    EACH k4[i] = f[i] + c * (k1[i] - k2[i] - 8.0 / 3 * k3[i]);
    backsolve(w, k4);
    EACH {
        w->error[i] = k4[i];
        x1[i] = y[i] + k4[i];
    }
    return 0;
}

static int rodas4(Instance *m, double t, double h) {
    Work *w = &m->w;
    double *x0 = w->x0, *x1 = w->x1, *y = w->y, *f = w->f;
    double *k1 = w->k[0], *k2 = w->k[1], *k3 = w->k[2], *k4 = w->k[3], *k5 = w->k[4], *k6 = w->k[5];
    const double c = 1 / h;
    if (factor(w, 4 * c)) return failure(m, "the iteration matrix is singular at time = %.9g s", t);
    EACH k1[i] = w->f0[i] + 0.25 * h * w->ft[i];
    backsolve(w, k1);
    EACH y[i] = x0[i] + 1.544 * k1[i];
    if (derivatives(m, t + 0.386 * h, y, f)) return 1;
    EACH k2[i] = f[i] - 5.6688 * c * k1[i] - 0.1043 * h * w->ft[i];
    backsolve(w, k2);
    EACH y[i] = x0[i] + 0.9466785280815826 * k1[i] + 0.2557011698983284 * k2[i];
    if (derivatives(m, t + 0.21 * h, y, f)) return 1;
    EACH k3[i] = f[i] - c * (2.430093356833875 * k1[i] + 0.2063599157091915 * k2[i]) + 0.1035 * h * w->ft[i];
    backsolve(w, k3);
    EACH y[i] = x0[i] + 3.314825187068521 * k1[i] + 2.896124015972201 * k2[i] + 0.9986419139977817 * k3[i];
    if (derivatives(m, t + 0.63 * h, y, f)) return 1;
    EACH k4[i] = f[i] - c * (0.1073529058151375 * k1[i] + 9.594562251023355 * k2[i] + 20.47028614809616 * k3[i])
        - 0.03620000000000023 * h * w->ft[i];
    backsolve(w, k4);
    EACH y[i] = x0[i] + 1.221224509226641 * k1[i] + 6.019134481288629 * k2[i] + 12.53708332932087 * k3[i]
        - 0.6878860361058950 * k4[i];
    if (derivatives(m, t + h, y, f)) return 1;
    EACH k5[i] = f[i] + c * (7.496443313967647 * k1[i] - 10.24680431464352 * k2[i] - 33.99990352819905 * k3[i]
        + 11.70890893206160 * k4[i]);
    backsolve(w, k5);
    EACH y[i] += k5[i];
    if (derivatives(m, t + h, y, f)) return 1;
    EACH k6[i] = f[i] + c * (8.083246795921522 * k1[i] - 7.981132988064893 * k2[i] - 31.52159432874371 * k3[i]
        + 16.31930543123136 * k4[i] - 6.058818238834054 * k5[i]);
    backsolve(w, k6);
    EACH {
        w->error[i] = k6[i];
        x1[i] = y[i] + k6[i];
    }
    return 0;
}

/* One step of size h from work.x0, with the derivatives and Jacobian of `linearise`; the result is in work.x1. */
static int try_step(Instance *m, double t, double h) {
    m->attempts--;
    return m->s.v[SOLVER] == 3 ? rodas3(m, t, h) : rodas4(m, t, h);
}

/* Root mean square of the error relative to the tolerance; `worst` is the state with the largest error. */
static double error_norm(const Instance *m, int *worst) {
    const Work *w = &m->w;
    const double tolerance = m->s.v[TOLERANCE];
    double sum = 0, most = -1;
    EACH {
        double a = fabs(w->x0[i]), b = fabs(w->x1[i]);
        double e = w->error[i] / (tolerance * (nominal_x[i] + (a > b ? a : b)));
        e *= e;
        if (!(e <= most)) {
            most = e;
            *worst = i;
            if (isnan(e)) return NAN;
        }
        sum += e;
    }
    return sqrt(sum / NX);
}
