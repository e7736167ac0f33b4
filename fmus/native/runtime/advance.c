/* Co-simulation: integration between communication points with adaptive internal steps. */

/* Whether the sides of a relation that is used are not numbers. */
static int undefined(Instance *m, double t, const double *x, const double *z) {
    for (int i = 0; i < NZ; i++)
        if (isnan(z[i])) return !crossed(&m->s, z) && assertions_at(m, inside(&m->s, t), x, DOMAIN_ERROR);
    return 0;
}

/* Take work.x1 at time t as the state. */
static void accept(Instance *m, double t) {
    State *s = &m->s;
    memcpy(s->v + X, m->w.x1, NX * sizeof(double));
    s->v[TIME] = t;
    stale(s);
}

/* Shorten an accepted step of size h, at whose end work.z1 indicates a crossing, to the first crossing in it.
 *
 * The probes are just beyond and just before a secant estimate, which closes the bracket in a few steps if the indicator
 * is smooth; bisection limits the number of probes otherwise. Every probe is a Rosenbrock step from the same start. */
static int locate(Instance *m, double t, double *h) {
    State *s = &m->s;
    Work *w = &m->w;
    double lo = 0, hi = *h, width = hi, at_hi[NX + 1];
    double tolerance = EVENT_TIME + 4 * DBL_EPSILON * fabs(t);
    memcpy(at_hi, w->x1, NX * sizeof(double));
    for (int k = 0; hi - lo > tolerance; k++) {
        double probe = hi, z[NZ + 1];
        for (int i = 0; i < NZ; i++)
            if (contradicts(s, i, w->z1[i])) {
                double root = lo + (hi - lo) * w->z0[i] / (w->z0[i] - w->z1[i]);
                if (!(root >= probe)) probe = root;
            }
        probe += k % 2 ? -0.4 * tolerance : 0.4 * tolerance;
        if (k % 3 == 2) {
            if (hi - lo > 0.5 * width) probe = 0.5 * (lo + hi);
            width = hi - lo;
        }
        if (!(probe > lo && probe < hi)) probe = 0.5 * (lo + hi);
        if (!(probe > lo && probe < hi)) break; /* no number is between lo and hi */
        if (try_step(m, t, probe)) return 1;
        indicators(s, t + probe, w->x1, z);
        if (crossed(s, z)) {
            hi = probe;
            memcpy(w->z1, z, sizeof z);
            memcpy(at_hi, w->x1, NX * sizeof(double));
        } else {
            lo = probe;
            memcpy(w->z0, z, sizeof z);
        }
    }
    memcpy(w->x1, at_hi, NX * sizeof(double));
    *h = hi;
    return 0;
}

/* Longest step in which zeros of functions of time or periodic functions are searched for: their number is not limited by
 * the error of integration. */
static double search_length(const Instance *m) {
    double part = m->communication_step / SEARCHED_PARTS;
    return !SEARCHED ? INFINITY : part > SEARCHED_TIME ? part : SEARCHED_TIME;
}

/* Find the first event of a model without states up to `target`, which becomes its time; 1 if there is one, -1 if a loop
 * has no solution. */
static int search(Instance *m, double *target) {
    State *s = &m->s;
    double z[NZ + 1], lo = s->v[TIME], end = *target, part = search_length(m);
    double parts = part < end - lo ? ceil((end - lo) / part) : 1, start = lo;
    for (double k = 1; k <= parts; k++) {
        double hi = k == parts ? end : start + (end - start) * (k / parts);
        if (NG && loops(m, inside(s, hi), s->v + X)) return -1;
        indicators(s, hi, s->v + X, z);
        if (undefined(m, hi, s->v + X, z)) return -1;
        if (!crossed(s, z)) {
            lo = hi;
            continue;
        }
        while (hi - lo > EVENT_TIME + 4 * DBL_EPSILON * fabs(hi)) {
            double middle = 0.5 * (lo + hi);
            if (NG && loops(m, inside(s, middle), s->v + X)) return -1;
            indicators(s, middle, s->v + X, z);
            *(crossed(s, z) ? &hi : &lo) = middle;
        }
        *target = hi;
        return 1;
    }
    return 0;
}

/* Whether an operation is not defined at the start of an internal step, or soon after: that ended the step. */
static int undefined_nearby(Instance *m, double t, double h) {
    Work *w = &m->w;
    double x[NX + 1], ahead = 0;
    for (int k = 0; k < 6; k++) {
        EACH x[i] = w->x0[i] + ahead * w->f0[i];
        if (assertions_at(m, inside(&m->s, t + ahead), x, DOMAIN_ERROR)) return 1;
        ahead = ahead > 0 ? 10 * ahead : h;
    }
    return 0;
}

#if NG
/* Largest change of an unknown of the nonlinear loops, relative to its nominal value. */
static double loop_change(const double *from, const double *to) {
    double largest = 0;
    for (int i = 0; i < NG; i++) {
        double change = fabs(to[i] - from[i]) / (nominal_g[i] + fabs(from[i]) + fabs(to[i]));
        if (!(change <= largest)) largest = change;
    }
    return largest;
}

/* Find out whether the solution of the loops, which was `g` at the beginning of a step of size h to work.x1, ceases to exist
 * within it, so that another one was found at its end. Then h becomes the time before which that happens and 1 is returned,
 * or 2 if that is now, and the step over the jump has been taken. Bisection follows the solution along the line between the
 * states: the change of a continuous solution is halved as well. */
static int loop_jumps(Instance *m, double t, double *h, const double *g) {
    State *s = &m->s;
    Work *w = &m->w;
    double x[NX + 1], end[NG], low[NG], high[NG], lo = 0, hi = 1, whole = loop_change(g, s->g);
    const double resolution = EVENT_TIME + 4 * DBL_EPSILON * fabs(t);
    if (whole < LOOP_JUMP) return 0;
    memcpy(end, s->g, sizeof end);
    memcpy(low, g, sizeof low);
    memcpy(high, end, sizeof high);
    while ((hi - lo) * *h > resolution) {
        double part = 0.5 * (lo + hi);
        for (int i = 0; i < NX; i++) x[i] = w->x0[i] + part * (w->x1[i] - w->x0[i]);
        memcpy(s->g, low, sizeof low);
        if (loops(m, t + part * *h, x)) {
            hi = part;
        } else if (loop_change(low, s->g) >= loop_change(s->g, high)) {
            hi = part;
            memcpy(high, s->g, sizeof high);
        } else {
            lo = part;
            memcpy(low, s->g, sizeof low);
        }
        if (loop_change(low, high) < 0.1 * whole) {
            memcpy(s->g, end, sizeof end);
            return 0;
        }
    }
    if (lo * *h > 4 * resolution) {
        /* If the line to its end keeps the branch, a stage of the step has left it. */
        *h *= hi < 1 ? lo : 0.5;
        memcpy(s->g, g, sizeof low);
        return 1;
    }
    *h *= hi;
    for (int i = 0; i < NX; i++) w->x1[i] = w->x0[i] + *h * w->f0[i];
    memcpy(s->g, high, sizeof high);
    return loops(m, t + *h, w->x1) ? -1 : 2;
}
/* Take a step over the end of the branch of the solution: just after it Newton's method does not find the other branch, but
 * it does further ahead, from where that branch is followed back. */
static int leave_branch(Instance *m, double t, double *h, const double *g) {
    State *s = &m->s;
    Work *w = &m->w;
    const double resolution = EVENT_TIME + 4 * DBL_EPSILON * fabs(t);
    for (double ahead = 2 * resolution; ahead < 1; ahead *= 2) {
        for (int i = 0; i < NX; i++) w->x1[i] = w->x0[i] + ahead * w->f0[i];
        memcpy(s->g, g, NG * sizeof *g);
        if (loops(m, t + ahead, w->x1) || loop_change(g, s->g) < LOOP_JUMP) continue;
        *h = resolution;
        for (int i = 0; i < NX; i++) w->x1[i] = w->x0[i] + *h * w->f0[i];
        if (!loops(m, t + *h, w->x1) && loop_change(g, s->g) >= LOOP_JUMP) return 2;
    }
    return 0;
}
#endif

/* Whether a relation changes at the beginning of a step of size h, at whose end it has its value again, as that of the height
 * of a ball which bounces and falls within the step. */
static int changes_twice(Instance *m, double t, double h) {
    State *s = &m->s;
    Work *w = &m->w;
    double x[NX + 1], z[NZ + 1];
    for (int i = 0; i < NX; i++) x[i] = w->x0[i] + h * w->f0[i];
#if NG
    double g[NG];
    memcpy(g, s->g, sizeof g);
    int unsolved = loops(m, t + h, x);
    if (!unsolved) indicators(s, t + h, x, z);
    memcpy(s->g, g, sizeof g);
    if (unsolved) return 0;
#else
    indicators(s, t + h, x, z);
#endif
    return crossed(s, z);
}

/* Take one internal step towards `target`; `linear` is whether the model is already linearised at its start, `left` whether
 * it starts at an event, `event` becomes whether the step ended at a state event. */
static int internal_step(Instance *m, double target, int linear, int left, int *event) {
    State *s = &m->s;
    Work *w = &m->w;
    const double t = s->v[TIME], longest = search_length(m), order = s->v[SOLVER] == 3 ? 1.0 / 3 : 0.25;
    int rejected = 0, worst = 0;
    memcpy(w->x0, s->v + X, NX * sizeof(double));
    if (!linear && linearise(m, t)) return 1;
#if NG
    double g[NG];
    memcpy(g, s->g, sizeof g);
#endif
    for (;;) {
        double rest = target - t, h = s->h < longest ? s->h : longest;
        /* Two equal steps are more accurate than a full one and a very short rest. */
        if (h >= 0.999 * rest)
            h = rest;
        else if (h > 0.5 * rest)
            h = 0.5 * rest;
        int failed = try_step(m, t, h), whole, shown;
        double e = failed ? NAN : error_norm(m, &worst), scale;
#if NG
        int jump = isfinite(e) ? loop_jumps(m, t, &h, g) : failed && h < 10 * EVENT_TIME ? leave_branch(m, t, &h, g) : 0;
        if (jump < 0) return 1;
        if (jump == 1) {
            s->h = h;
            rejected = 1;
            s->v[REJECTED]++;
            continue;
        }
        if (jump == 2) {
            *event = 1;
            s->v[STEPS]++;
            accept(m, t + h);
            return 0;
        }
#endif
        whole = h == rest;
        /* The importer usually requests the outputs next. With nonlinear loops these must be solved first. */
        shown = whole && !NG;
        if (e <= 1) {
            if (shown)
                outputs_and_indicators(s, target, w->x1, s->v + O, w->z1);
            else
                indicators(s, t + h, w->x1, w->z1);
            if (undefined(m, t + h, w->x1, w->z1)) e = NAN;
        }
        if (e <= 1) {
            double grown;
            scale = e > 1e-8 ? 0.9 * pow(e, -order) : 6;
            scale = scale > 6 ? 6 : scale < 0.2 ? 0.2 : scale;
            if (rejected && scale > 1) scale = 1;
            grown = h * scale;
            /* A step that was shortened to the communication point does not reduce the step size. */
            s->h = h < 0.999 * s->h && grown < s->h ? s->h : grown;
            *event = crossed(s, w->z1);
            if (left && !*event && changes_twice(m, t, LEFT_PART * h)) {
#if NG
                memcpy(s->g, g, sizeof g);
#endif
                s->h = LEFT_PART * h;
                rejected = 1;
                left = 0;
                continue;
            }
            if (*event && locate(m, t, &h)) return 1;
            s->v[STEPS]++;
            accept(m, !*event && whole ? target : t + h);
            s->stale_outputs = *event || !shown;
            return 0;
        }
#if NG
        memcpy(s->g, g, sizeof g); /* the solutions of a rejected step may be on another branch */
#endif
        rejected = 1;
        s->v[REJECTED]++;
        scale = isnan(e) || isinf(e) ? 0.1 : 0.9 * pow(e, -order);
        s->h = h * (scale < 0.1 ? 0.1 : scale > 0.9 ? 0.9 : scale);
        if (s->h < 16 * DBL_EPSILON * (1e-3 + fabs(t))) {
            if (undefined_nearby(m, t, h)) return 1;
            if (failed) return 1; /* its message is already set */
            for (int i = 0; i < NX; i++)
                if (!isfinite(w->f0[i])) return failure(m, "der(%s) is not a number at time = %.9g s", x_name[i], t);
            return failure(m, "the step size becomes too small at time = %.9g s because of %s = %.9g", t, x_name[worst], w->x0[worst]);
        }
    }
}

/* Whether the inputs set since the last call cause an event at once; `linear` becomes whether the model was linearised for
 * that. */
static int input_event(Instance *m, int *linear) {
    State *s = &m->s;
    Work *w = &m->w;
    if (!s->inputs_set) return 0;
    s->inputs_set = 0;
    if (DISCRETE_INPUTS) return 1;
    if (!NZ) return 0;
    if (NX && !NG) {
        memcpy(w->x0, s->v + X, NX * sizeof(double));
        if (linearise(m, s->v[TIME])) return -1;
        *linear = !crossed(s, w->z0);
        return !*linear;
    }
    if (NG && loops(m, s->v[TIME], s->v + X)) return -1;
    indicators(s, s->v[TIME], s->v + X, w->z0);
    return crossed(s, w->z0);
}

/* Whether the budget of internal steps is used up: the model chatters, or is far too stiff. */
static int endless(Instance *m) {
    if (m->attempts > 0) return 0;
    return failure(m, "too many internal steps, more than %g in a second, at time = %.9g s: check the parameters",
                   (double)ATTEMPTS_PER_SECOND, m->s.v[TIME]);
}

/* Advance to time `end`. */
static int advance(Instance *m, double end) {
    State *s = &m->s;
    int jumped, crowd = 0, now = 0, linear = 0, left;
    double last = -INFINITY;
    double more = ATTEMPTS_PER_SECOND * (end - s->v[TIME]);
    more = more > ATTEMPTS_AT_LEAST ? more : ATTEMPTS_AT_LEAST;
    m->communication_step = end - s->v[TIME];
    m->attempts = (m->attempts < ATTEMPTS_SAVED ? m->attempts : ATTEMPTS_SAVED) + more;
    if (s->stale_parameters) {
        dependent_parameters(s);
        now = NI || N_MOVING; /* relations of time and parameters may have changed */
    }
    if (!now) now = input_event(m, &linear);
    if (now != 0 && (now < 0 || events(m, 0, &jumped))) return 1;
    left = now;
    while (s->v[TIME] < end || s->hi <= end) {
        double target = s->hi < end ? s->hi : end;
        int event = 0;
        if (NX) {
            for (; !event && target - s->v[TIME] > 4 * DBL_EPSILON * fabs(target); linear = left = 0)
                if (endless(m) || internal_step(m, target, linear, left, &event)) return 1;
        } else {
            m->attempts--;
            if (endless(m) || (NZ && (event = search(m, &target)) < 0)) return 1;
            s->v[TIME] = target;
            stale(s);
        }
        if (!event) s->v[TIME] = target;
        if (event || s->v[TIME] >= s->hi) {
            if (events(m, 0, &jumped)) return 1;
            left = 1;
            crowd = s->v[TIME] - last < 1e-9 ? crowd + 1 : 0;
            last = s->v[TIME];
            if (crowd > 1000) return failure(m, "more than 1000 events within 1 ns at time = %.9g s: the model chatters", last);
        }
    }
    return 0;
}
