/* Evaluation of the model: parameters, derivatives, nonlinear loops, outputs. */

/* Equations are evaluated strictly between two time events, so that `noEvent(time < T)` and floor(time/T) have the same
 * value in the whole interval. */
static double inside(const State *s, double t) {
#if N_MOVING
    double lo = AFTER(s->lo), hi = s->hi - (AFTER(s->hi) - s->hi);
    return s->phase < RUNNING ? t : t > hi && hi > lo ? hi : t < lo ? lo : t;
#else
    return t >= s->hi ? nextafter(s->hi, -INFINITY) : t <= s->lo ? nextafter(s->lo, INFINITY) : t;
#endif
}

/* Solve the nonlinear loops at (t, x) by damped Newton iteration from their last solution. */
static int newton(Instance *m, double t, const double *x) {
    State *s = &m->s;
    double next[NG + 1], further[NG + 1], residual[NG + 1], before[NG + 1], norm = 0, last = INFINITY;
    const double *a[] = ARGUMENTS(s, &t, x);
    double *r[] = { next, residual };
    if (!NG) return 0;
    for (int k = 0; k < 4 * LOOP_ITERATIONS; k++) {
        int converged = 1;
        f_loop(a, r);
        norm = 0;
        for (int i = 0; i < NG; i++) {
            double e = fabs(residual[i]);
            if (!(e <= norm)) norm = e;
            if (!(fabs(next[i] - s->g[i]) <= LOOP_TOLERANCE * (fabs(next[i]) + nominal_g[i]))) converged = 0;
        }
        if (converged) {
            memcpy(s->g, next, NG * sizeof *next);
            /* Where the slope changes, a short step may end at a residual that is not zero; then the next one is long. */
            r[0] = further;
            f_loop(a, r);
            r[0] = next;
            for (int i = 0; i < NG; i++)
                if (!(fabs(further[i] - s->g[i]) <= 10 * LOOP_TOLERANCE * (fabs(further[i]) + nominal_g[i]))) converged = 0;
            if (converged) return 0;
            continue;
        }
        /* Halve the step after a larger residual or NaN; if the iteration does not end, after each that is not smaller. */
        if (k && !(k < LOOP_ITERATIONS ? norm <= 2 * last : norm < last)) {
            for (int i = 0; i < NG; i++) s->g[i] = 0.5 * (s->g[i] + before[i]);
            continue;
        }
        last = norm;
        memcpy(before, s->g, NG * sizeof *before);
        for (int i = 0; i < NG; i++) {
            if (!isfinite(next[i])) goto failed;
            s->g[i] = next[i];
        }
    }
failed:
    return failure(m, "the nonlinear loop of %s does not converge at time = %.9g s (residual %.3g)", loop_names[0], t, norm);
}

/* Solve the nonlinear loops from the last solution; in Model Exchange from that of the last event or completed step, if it
 * leads to one, because trial steps of the importer must not select the branch. */
static int loops(Instance *m, double t, const double *x) {
    State *s = &m->s;
    double g[NG + 1];
    if (!NG || m->co_simulation || s->phase < RUNNING) return newton(m, t, x);
    memcpy(g, s->g, sizeof g);
    memcpy(s->g, s->settled_g, sizeof g);
    if (!newton(m, t, x)) return 0;
    memcpy(s->g, g, sizeof g);
    return newton(m, t, x);
}

static int derivatives(Instance *m, double t, const double *x, double *dx) {
    State *s = &m->s;
    t = inside(s, t);
    if (NG && loops(m, t, x)) return 1;
    const double *a[] = ARGUMENTS(s, &t, x);
    double *r[] = { dx };
    if (NX) f_ode(a, r);
    s->v[EVALUATIONS]++;
    return 0;
}

/* Outputs and indicators, which share most of their operations. */
static void outputs_and_indicators(State *s, double t, const double *x, double *outputs, double *z) {
    t = inside(s, t);
    const double *a[] = ARGUMENTS(s, &t, x);
    double *r[] = { outputs, z };
    if (NO || NZ) f_outputs(a, r);
}

static void indicators(State *s, double t, const double *x, double *z) {
    double outputs[NO + 1];
    if (NZ) outputs_and_indicators(s, t, x, outputs, z);
}

static void dependent_parameters(State *s) {
    const double *a[] = { s->v + P };
    double *r[] = { s->v + P + NF, s->instant };
    if (!s->stale_parameters) return;
    if (NP > NF || NI) f_parameters(a, r);
    s->stale_parameters = 0;
}

static void stale(State *s) {
    s->stale_derivatives = s->stale_outputs = s->stale_locals = s->stale_state_jacobian = s->stale_output_jacobian = 1;
}

static void start_values(State *s, const double **a, double **r) {
    if (NX || ND_CALCULATED) f_start(a, r);
    for (int i = 0; i < ND_CALCULATED; i++) s->d0[d_calculated[i]] = r[1][i];
    for (int i = 0; i < NX; i++)
        if (x_calculated[i] && !s->x_set[i]) s->x0[i] = r[0][i];
}

/* Initial states from parameters and inputs, initial equations included. */
static int start_states(Instance *m) {
    State *s = &m->s;
    double x[NX + 1], d[ND_CALCULATED + 1], next[NQ + 1], residual[NQ + 1], before[NQ + 1], norm = 0, last = INFINITY;
    const double *a[] = { s->v, s->x0, s->v + U, s->v + P, s->v + D, s->r, s->q, s->d0 };
    double *r[] = { x, d }, *l[] = { next, residual };
    start_values(s, a, r); /* the solution depends on fixed ones */
    for (int k = 0; NQ; k++) {
        int converged = 1;
        if (k == 4 * LOOP_ITERATIONS)
            return failure(m, "the initial equations of %s do not converge (residual %.3g)", loop_names[1], norm);
        f_start_loop(a, l);
        norm = 0;
        for (int i = 0; i < NQ; i++) {
            if (!(fabs(residual[i]) <= norm)) norm = fabs(residual[i]);
            if (!(fabs(next[i] - s->q[i]) <= LOOP_TOLERANCE * (fabs(next[i]) + nominal_q[i]))) converged = 0;
        }
        if (converged) break;
        if (k && !(k < LOOP_ITERATIONS ? norm <= 2 * last : norm < last)) {
            for (int i = 0; i < NQ; i++) s->q[i] = 0.5 * (s->q[i] + before[i]);
            continue;
        }
        last = norm;
        memcpy(before, s->q, NQ * sizeof *before);
        memcpy(s->q, next, NQ * sizeof *next);
    }
    start_values(s, a, r);
    return 0;
}

static int events(Instance *m, int initial, int *jumped);
static int parameter_checks(Instance *m);

/* Bring parameters and, before the run, initial states and discretes up to date. */
static int prepare(Instance *m) {
    State *s = &m->s;
    dependent_parameters(s);
    if (s->unchecked_parameters && parameter_checks(m)) return 1;
    if (s->phase >= RUNNING || !s->stale_start) return 0;
    s->stale_start = 0;
    memcpy(s->v + D, s->d0, ND * sizeof(double));
    memset(s->r, 0, sizeof s->r);
    /* Initial states may depend on relations and discretes, and these on the states. */
    for (int k = 0;; k++) {
        double r[NR + 1], d[ND + 1];
        int jumped;
        if (k == 20) return failure(m, "the initial values of states and discrete variables do not settle");
        memcpy(d, s->v + D, ND * sizeof *d);
        if (start_states(m)) return 1;
        memcpy(r, s->r, sizeof r);
        memcpy(s->v + X, s->x0, NX * sizeof(double));
        memcpy(s->v + D, s->d0, ND * sizeof(double));
        if (events(m, 1, &jumped)) return 1;
        if (!memcmp(r, s->r, NR * sizeof *r) && !memcmp(d, s->v + D, ND * sizeof *d)) break;
    }
    stale(s);
    return 0;
}

static int fresh_derivatives(Instance *m) {
    State *s = &m->s;
    if (prepare(m)) return 1;
    if (!s->stale_derivatives) return 0;
    if (derivatives(m, s->v[TIME], s->v + X, s->v + DX)) return 1;
    s->stale_derivatives = 0;
    return 0;
}

static int fresh_algebraics(Instance *m, int locals) {
    State *s = &m->s;
    if (prepare(m)) return 1;
    if (!(locals ? s->stale_locals : s->stale_outputs)) return 0;
    double t = inside(s, s->v[TIME]), z[NZ + 1];
    if (NG && loops(m, t, s->v + X)) return 1;
    if (!locals) {
        outputs_and_indicators(s, t, s->v + X, s->v + O, z);
        s->stale_outputs = 0;
        return 0;
    }
    const double *a[] = ARGUMENTS(s, &t, s->v + X);
    double *r[] = { s->v + L };
    if (NL) f_locals(a, r);
    s->stale_locals = 0;
    return 0;
}

#if BY_STATE
/* Update the rows of State.by_state. The values themselves are computed with them and are then up to date, too: the importer
 * of a filter requests both at the same point. */
static int fresh_state_jacobian(Instance *m) {
    State *s = &m->s;
    double entries[NSJ + 1];
    if (!s->stale_state_jacobian) return 0;
    double t = inside(s, s->v[TIME]);
    if (NG && loops(m, t, s->v + X)) return 1;
    const double *a[] = ARGUMENTS(s, &t, s->v + X);
    double *r[] = { s->v + DX, entries };
    if (NX) f_state_jacobian(a, r);
    for (int i = 0; i < NSJ; i++) s->by_state[state_row[i] * NX + state_column[i]] = entries[i];
    s->v[EVALUATIONS]++;
    s->stale_state_jacobian = s->stale_derivatives = 0;
    return 0;
}

static int fresh_output_jacobian(Instance *m) {
    State *s = &m->s;
    double entries[NOJ + 1], z[NZ + 1];
    if (!s->stale_output_jacobian) return 0;
    double t = inside(s, s->v[TIME]);
    if (NG && loops(m, t, s->v + X)) return 1;
    const double *a[] = ARGUMENTS(s, &t, s->v + X);
    double *r[] = { s->v + O, z, entries };
    if (NO || NZ) f_output_jacobian(a, r);
    for (int i = 0; i < NOJ; i++) s->by_state[(NX + output_row[i]) * NX + output_column[i]] = entries[i];
    s->stale_output_jacobian = s->stale_outputs = 0;
    return 0;
}
#endif

/* Number of values in the message of an assertion. */
static int message_values(int i) {
    int n = 0;
    for (int k = message_begin[i]; k < message_begin[i + 1]; k++) n += !message_piece[k];
    return n;
}

/* Write the message of an assertion: its pieces, and the next of `values` where a piece is null. */
static void assertion_text(int i, const double *values, char *text, size_t size) {
    text[0] = 0;
    for (int k = message_begin[i]; k < message_begin[i + 1]; k++) {
        int n = message_piece[k] ? snprintf(text, size, "%s", message_piece[k]) : snprintf(text, size, "%g", *values++);
        if (n < 0 || (size_t)n >= size) return;
        text += n;
        size -= (size_t)n;
    }
}

/* Report the assertions of a group that are violated; 1 if one of them is fatal. Of several the first whose message has no
 * NaN is reported, because a NaN is the consequence of another violation. */
static int report(Instance *m, int group, double t, const double *holds, const double *values, int level) {
    int fatal = -1, is_cause = 0;
    const double *of_fatal = values;
    holds -= first_assertion[group];
    for (int i = first_assertion[group]; i < first_assertion[group + 1]; values += message_values(i++)) {
        char text[512];
        int has_nan = 0;
        if (holds[i] != 0) {
            if (level == WARNING) m->s.warned[i] = 0;
            continue;
        }
        if (assertion_level[i] < level) continue;
        for (int k = 0; k < message_values(i); k++) has_nan |= isnan(values[k]);
        if (assertion_level[i] != WARNING && (fatal < 0 || (!is_cause && !has_nan))) {
            fatal = i;
            is_cause = !has_nan;
            of_fatal = values;
        }
        if (assertion_level[i] != WARNING || m->s.warned[i]) continue;
        char again[32] = "";
        if (++m->s.warnings[i] > 1) snprintf(again, sizeof again, ", occurrence %d", m->s.warnings[i]);
        m->s.warned[i] = 1; /* one warning until the condition holds again */
        assertion_text(i, values, text, sizeof text);
        message(m, fmi2Warning, "logStatusWarning", "warning (%s) at time = %.9g s%s: %s", assertion_place[i], t, again, text);
    }
    if (fatal >= 0) {
        char text[512];
        assertion_text(fatal, of_fatal, text, sizeof text);
        return failure(m, "%s (%s) at time = %.9g s: %s", assertion_level[fatal] == ASSERTION ? "assertion" : "domain error",
                       assertion_place[fatal], t, text);
    }
    return 0;
}

static int violated(const double *holds, int n) {
    for (int i = 0; i < n; i++)
        if (!(holds[i] != 0)) return 1;
    return 0;
}

/* Check that all operations on parameters are defined. */
static int parameter_checks(Instance *m) {
    State *s = &m->s;
    double holds[NA_PARAMETERS + 1], values[NM + 1];
    const double *a[] = { s->v + P };
    double *r[] = { holds, values };
    if (!s->unchecked_parameters) return 0;
    if (NA_PARAMETERS) f_parameter_checks(a, r);
    if (violated(holds, NA_PARAMETERS)) return report(m, PARAMETER_CHECKS, s->v[TIME], holds, values, WARNING);
    s->unchecked_parameters = 0;
    return 0;
}

/* Check the assertions of at least a level at (t, x). */
static int assertions_at(Instance *m, double t, const double *x, int level) {
    State *s = &m->s;
    double holds[NA_RUNNING + 1], values[NM + 1];
    const double *a[] = ARGUMENTS(s, &t, x);
    double *r[] = { holds }, *texts[] = { values };
    if (!NA_RUNNING) return 0;
    f_assertions(a, r);
    if (!violated(holds, NA_RUNNING)) {
        if (level == WARNING) memset(s->warned, 0, sizeof s->warned);
        return 0;
    }
    f_assertion_values(a, texts);
    return report(m, RUNNING_CHECKS, t, holds, values, level);
}

/* Check the model's assertions; 1 if one of level error is violated. */
static int assertions(Instance *m) {
    State *s = &m->s;
    return parameter_checks(m) || assertions_at(m, inside(s, s->v[TIME]), s->v + X, WARNING);
}

/* Check the initial equations after they have been solved. */
static int start_checks(Instance *m) {
    State *s = &m->s;
    double holds[NA_START + 1], values[NM + 1], t = s->v[TIME];
    const double *a[] = { &t, s->v + X, s->v + U, s->v + P, s->v + D, s->r, s->g, s->d0 };
    double *r[] = { holds, values };
    if (NA_START) f_start_checks(a, r);
    return violated(holds, NA_START) ? report(m, START_CHECKS, t, holds, values, WARNING) : 0;
}
