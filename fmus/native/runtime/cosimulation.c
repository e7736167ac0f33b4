/* FMI 2.0 for Co-Simulation: the FMU integrates. */

/* Whether a state is not a number. */
static int not_finite(Instance *m) {
    State *s = &m->s;
    for (int i = 0; i < NX; i++)
        if (!isfinite(s->v[X + i])) return failure(m, "%s is not a number at time = %.9g s", x_name[i], s->v[TIME]);
    return 0;
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real t, fmi2Real h, fmi2Boolean no_set_state) {
    State *s = &M->s;
    (void)no_set_state;
    if (s->phase != RUNNING) return refuse(M, "fmi2DoStep: not initialised, or terminated");
    if (!(h > 0)) return refuse(M, "fmi2DoStep: the step must be positive");
    /* Seconds since 1970 have a resolution of 2e-7 s: a sum and a product of steps differ by that. */
    if (!(fabs(t - s->v[TIME]) <= 1e-6 * h + 4 * DBL_EPSILON * fabs(t))) {
        failure(M, "fmi2DoStep: a step was requested from %.17g s, but this FMU is at %.17g s", t, s->v[TIME]);
        return failed(M, fmi2Error);
    }
    if (advance(M, t + h) || not_finite(M) || (NA && ((NG && loops(M, inside(s, s->v[TIME]), s->v + X)) || assertions(M)))) {
        s->phase = FAILED; /* an importer that repeats the step would never end */
        return failed(M, fmi2Error);
    }
    return fmi2OK;
}
