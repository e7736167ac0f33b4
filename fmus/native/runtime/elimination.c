/* Sparse LU factors of I·c − J, along tables of an order of pivots that was chosen when the FMU was built.
 *
 * The generated code defines, beside `sparse_solve`: where the entries of J and the diagonal lie in `a`; pivot by pivot
 * how many entries are right of it and below it, which in `a` follow it in that order; and, one after the other, the
 * entries that elimination changes. */

#define SMALLEST_PIVOT 1e-7 /* in units of c: below it the diagonal has cancelled, and half the digits may be lost */

/* Returns 1 when a pivot is tiny. */
static int sparse_factor(const double *restrict jacobian, double c, double *restrict a) {
    const int *target = lu_target;
    double *u = a;
    if (!NLU) return 1;
    memset(a, 0, NLU * sizeof *a);
    for (int i = 0; i < NX; i++) a[lu_diagonal[i]] = c;
    for (int i = 0; i < NJ; i++) a[lu_jacobian[i]] -= jacobian[i];
    for (int k = 0; k < NX; k++) {
        const int right = lu_right[k], below = lu_below[k];
        const double pivot = 1 / *u;
        if (!(fabs(*u) > SMALLEST_PIVOT * c)) return 1;
        *u++ = pivot;
        double *l = u + right;
        for (int i = 0; i < below; i++) {
            const double factor = *l++ *= pivot;
            for (int j = 0; j < right; j++) a[*target++] -= factor * u[j];
        }
        u = l;
    }
    return 0;
}
