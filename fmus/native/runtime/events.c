/* Event iteration: relations, discrete variables, when clauses, clocks. */

static double next_time_event(const State *s) {
    double t = INFINITY;
    for (int i = 0; i < NT; i++)
        if (s->tick[i] < t) t = s->tick[i];
    for (int i = 0; i < NI; i++)
        if (s->instant[i] > s->lo && s->instant[i] >= s->v[TIME] && s->instant[i] < t) t = s->instant[i];
    return s->moving < t ? s->moving : t;
}

/* Find the next of the instants that change at events: until then it is valid. */
static void next_moving_instant(State *s) {
#if N_MOVING
    double t = AFTER(s->v[TIME]), instant[N_MOVING];
    const double *a[] = { &t, s->v + P, s->v + D, s->r };
    double *out[] = { instant };
    s->moving = s->phase < RUNNING ? s->v[TIME] : INFINITY; /* functions of time may have a step at the start */
    f_instants(a, out);
    for (int i = 0; i < N_MOVING; i++)
        if (instant[i] > t && instant[i] < s->moving) s->moving = instant[i];
#else
    s->moving = INFINITY;
#endif
}

/* The time at which an event now is evaluated. Relations have their values of the start itself during initialisation. */
static double event_time(const State *s) {
    return (NI || N_MOVING) && s->phase >= RUNNING ? AFTER(s->v[TIME]) : s->v[TIME];
}

static void event_pass(State *s, const double *tick, double *d, double *x, double *r, double *c) {
    double t = event_time(s);
    const double *a[] = { &t, s->v + X, s->v + U, s->v + P, s->previous, s->r, s->last, tick, s->g };
    double *out[] = { d, x, r, c };
    f_event(a, out);
}

/* Repeat event passes until relations and nonlinear loops are consistent; each pass writes into `d`, the discretes of the
 * state. */
static int consistent(Instance *m, const double *tick, double *d, double *x, double *r, double *c) {
    State *s = &m->s;
    for (int k = 0; k < EVENT_ITERATIONS; k++) {
        double g[NG + 1];
        int same;
        event_pass(s, tick, d, x, r, c);
        same = !NR || !memcmp(r, s->r, NR * sizeof *r);
        memcpy(s->r, r, NR * sizeof *r);
        if (NG) {
            memcpy(g, s->g, NG * sizeof *g);
            if (loops(m, event_time(s), s->v + X)) return 1;
            for (int i = 0; i < NG; i++)
                if (!(fabs(g[i] - s->g[i]) <= 10 * LOOP_TOLERANCE * (fabs(g[i]) + nominal_g[i]))) same = 0;
        }
        if (same) return 0;
    }
    return failure(m, "the relations do not settle at the event at time = %.9g s", s->v[TIME]);
}

/* Check that the operations of the event equations are defined, after an event pass with the same arguments. */
static int event_checks(Instance *m, const double *tick) {
    State *s = &m->s;
    double holds[NA_EVENT + 1], values[NM + 1], t = event_time(s);
    const double *a[] = { &t, s->v + X, s->v + U, s->v + P, s->previous, s->r, s->last, tick, s->g };
    double *out[] = { holds, values };
    if (NA_EVENT) f_event_checks(a, out);
    return violated(holds, NA_EVENT) ? report(m, EVENT_CHECKS, s->v[TIME], holds, values, WARNING) : 0;
}

/* Handle all events at the present time. `initial` suppresses edges of when clauses; `jumped` becomes whether a state was
 * reinitialised. A change of discretes that are not `repeating`, which only clocked equations read, requires no iteration. */
static int events(Instance *m, int initial, int *jumped) {
    State *s = &m->s;
    double tick[NT + 1] = { 0 }, x[NX + 1], r[NR + 1], c[NC + 1], *d = s->v + D, now = s->v[TIME];
    *jumped = 0;
    s->inputs_set = 0;
    /* Clocks do not tick during initialisation; one whose first instant is the start ticks right after it. */
    for (int i = 0; i < NT && !initial; i++)
        if (s->tick[i] <= now + 1e-12 * (1 + fabs(now))) {
            tick[i] = 1;
            s->tick[i] = clock_phase[i] + clock_period[i] * (1 + floor((now - clock_phase[i]) / clock_period[i] + 0.5));
        }
    tick[NT] = initial;
    s->lo = now >= s->hi ? s->hi : s->lo;
    if (initial) s->lo = -INFINITY;
    for (int i = 0; i < NI && !initial; i++)
        if (s->instant[i] <= now && s->instant[i] > s->lo) s->lo = s->instant[i];
    if (!ND && !NR && !NC && !NT) {
        s->hi = next_time_event(s);
        stale(s);
        return 0;
    }
    if (!initial) s->v[EVENTS]++;
    memcpy(s->previous, d, ND * sizeof *d);
    if (initial) {
        if (consistent(m, tick, d, x, r, c) || event_checks(m, tick)) return 1;
        memcpy(s->last, c, NC * sizeof *c);
    }
    for (int k = 0; k < EVENT_ITERATIONS; k++) {
        int changed;
        if (consistent(m, tick, d, x, r, c) || event_checks(m, tick)) return 1;
        changed = NX && memcmp(x, s->v + X, NX * sizeof *x);
        if (changed) {
            *jumped = 1;
            memcpy(s->v + X, x, NX * sizeof *x);
        }
        changed |= NC && memcmp(c, s->last, NC * sizeof *c);
        for (int i = 0; i < N_REPEATING; i++) changed |= !!memcmp(d + repeating[i], s->previous + repeating[i], sizeof *d);
        if (!changed) {
            for (int i = 0; i < ND; i++)
                if (!isfinite(d[i])) return failure(m, "%s is not a number at time = %.9g s", d_name[i], now);
            for (int i = 0; i < NX && *jumped; i++)
                if (!isfinite(x[i])) return failure(m, "reinit sets %s to a value that is not a number at time = %.9g s", x_name[i], now);
            next_moving_instant(s);
            s->hi = next_time_event(s);
            stale(s);
            return 0;
        }
        memcpy(s->previous, d, ND * sizeof *d);
        memcpy(s->last, c, NC * sizeof *c);
        memset(tick, 0, sizeof tick);
    }
    return failure(m, "the event iteration does not end at time = %.9g s", now);
}

/* Whether an indicator contradicts the stored value of its relation. One that is not a number belongs to a relation in a
 * branch that is not chosen. */
static int contradicts(const State *s, int i, double z) {
    return !isnan(z) && (s->r[indicator_relation[i]] > 0.5) != (indicator_inclusive[i] ? z >= 0 : z > 0);
}

static int crossed(const State *s, const double *z) {
    for (int i = 0; i < NZ; i++)
        if (contradicts(s, i, z[i])) return 1;
    return 0;
}
