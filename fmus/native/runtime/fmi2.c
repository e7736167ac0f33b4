/* FMI 2.0: functions common to Model Exchange and Co-Simulation of a Modelica class. */

static void reset(State *s) {
    memset(s, 0, sizeof *s);
    memcpy(s->x0, start_x, NX * sizeof(double));
    memcpy(s->v + X, start_x, NX * sizeof(double));
    memcpy(s->v + U, start_u, NU * sizeof(double));
    memcpy(s->v + P, start_p, NP * sizeof(double));
    memcpy(s->d0, start_d, ND * sizeof(double));
    memcpy(s->g, start_g, NG * sizeof(double));
    memcpy(s->q, start_q, NQ * sizeof(double));
    s->v[TOLERANCE] = DEFAULT_TOLERANCE;
    s->v[SOLVER] = DEFAULT_SOLVER;
    s->stale_parameters = s->stale_start = s->unchecked_parameters = 1;
    s->lo = s->settled = -INFINITY;
    s->hi = s->h = s->moving = INFINITY;
    stale(s);
}

static int begin(Instance *m, fmi2Type type) {
    m->co_simulation = type == fmi2CoSimulation;
    reset(&m->s);
    return 1;
}

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean has_tolerance, fmi2Real tolerance, fmi2Real start,
                               fmi2Boolean has_stop, fmi2Real stop) {
    (void)has_stop;
    (void)stop;
    if (M->s.phase != INSTANTIATED) return refuse(M, "fmi2SetupExperiment: only before initialisation");
    M->s.v[TIME] = start;
    if (has_tolerance && tolerance > 0) M->s.v[TOLERANCE] = tolerance;
    return fmi2OK;
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
    State *s = &M->s;
    if (s->phase != INSTANTIATED) return refuse(M, "fmi2EnterInitializationMode: only once, after instantiation or reset");
    s->phase = INITIALIZING;
    s->stale_start = 1;
    for (int i = 0; i < NT; i++) {
        double n = ceil((s->v[TIME] - clock_phase[i]) / clock_period[i] - 1e-9);
        s->tick[i] = clock_phase[i] + clock_period[i] * (n > 0 ? n : 0);
    }
    return fmi2OK;
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
    State *s = &M->s;
    int jumped;
    if (s->phase != INITIALIZING) return refuse(M, "fmi2ExitInitializationMode: not in initialisation mode");
    if (prepare(M) || start_checks(M) || assertions(M)) {
        s->phase = FAILED;
        return failed(M, fmi2Error);
    }
    for (int i = 0; i < NX; i++)
        if (!isfinite(s->v[X + i])) {
            failure(M, "%s is not a number after initialisation", x_name[i]);
            return failed(M, fmi2Error);
        }
    s->phase = RUNNING;
    memcpy(s->settled_g, s->g, sizeof s->g);
    if (M->co_simulation && s->hi <= s->v[TIME] && events(M, 0, &jumped)) return failed(M, fmi2Error);
    s->v[EVENTS] = s->v[EVALUATIONS] = 0;
    s->inputs_set = 0;
    return fmi2OK;
}

/* ---- values ---- */
static int fresh(Instance *m, fmi2ValueReference k) {
    if (k >= NV) return failure(m, "there is no variable with value reference %u", k);
    if (k >= O && k < D) {
        if ((k < L ? m->s.stale_outputs : m->s.stale_locals) && fresh_algebraics(m, k >= L)) return 1;
        if (isfinite(m->s.v[k])) return 0;
        return assertions(m) || failure(m, "the variable with value reference %u is %g at time = %.9g s: a number is too large, "
                                        "or an equation has no solution", k, m->s.v[k], m->s.v[TIME]);
    }
    if (k >= DX && k < U) return m->s.stale_derivatives && fresh_derivatives(m);
    return prepare(m);
}

#define GETTER(NAME, TYPE, VALUE)                                                              \
    fmi2Status NAME(fmi2Component c, const fmi2ValueReference vr[], size_t n, TYPE value[]) { \
        for (size_t i = 0; i < n; i++) {                                                       \
            if (fresh(M, vr[i])) return failed(M, fmi2Error);                                  \
            value[i] = VALUE(M->s.v[vr[i]]);                                                   \
        }                                                                                      \
        return fmi2OK;                                                                         \
    }
GETTER(fmi2GetReal, fmi2Real, )
GETTER(fmi2GetBoolean, fmi2Boolean, 0.0 != )
fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Integer value[]) {
    for (size_t i = 0; i < n; i++) {
        if (fresh(M, vr[i])) return failed(M, fmi2Error);
        double real = M->s.v[vr[i]];
        if (!(fabs(real) <= 2147483647))
            return refuse(M, "the Integer with value reference %u is %.9g at time = %.9g s, beyond 32 bits", vr[i], real, M->s.v[TIME]);
        value[i] = (fmi2Integer)lround(real);
    }
    return fmi2OK;
}

static fmi2Status set(Instance *m, fmi2ValueReference k, double value) {
    State *s = &m->s;
    if (k >= U && k < P) {
        if (s->v[k] == value) return fmi2OK;
        s->inputs_set = 1;
    } else if (k >= P && k < P + NF) {
        s->stale_parameters = s->unchecked_parameters = 1;
    } else if (k >= X && k < DX) {
        if (s->phase < RUNNING) {
            s->x0[k - X] = value;
            s->x_set[k - X] = 1;
        } else if (m->co_simulation)
            return refuse(m, "set: states can be set before initialisation only");
    } else if (k >= D && k < TOLERANCE && s->phase < RUNNING) {
        s->d0[k - D] = value;
    } else if (k == TOLERANCE) {
        if (!(value > 0 && value < 1)) return refuse(m, "set: _tolerance must lie between 0 and 1");
    } else if (k == SOLVER) {
        if (value != 3 && value != 4) return refuse(m, "set: _solver is 3 (RODAS3) or 4 (RODAS4)");
    } else {
        return refuse(m, "the variable with value reference %u cannot be set", k);
    }
    s->v[k] = value;
    stale(s);
    s->stale_start = 1;
    return fmi2OK;
}
#define SETTER(NAME, TYPE)                                                                          \
    fmi2Status NAME(fmi2Component c, const fmi2ValueReference vr[], size_t n, const TYPE value[]) { \
        for (size_t i = 0; i < n; i++)                                                              \
            if (set(M, vr[i], value[i]) != fmi2OK) return fmi2Error;                                \
        return fmi2OK;                                                                              \
    }
SETTER(fmi2SetReal, fmi2Real)
SETTER(fmi2SetInteger, fmi2Integer)
SETTER(fmi2SetBoolean, fmi2Boolean)

/* ---- directional derivatives: of derivatives and outputs, along states, inputs and parameters ---- */
#if BY_STATE
/* Along states alone: an estimator requests the columns of the same Jacobian one after the other at every sample. */
static fmi2Status along_states(Instance *m, const fmi2ValueReference unknown[], size_t n_unknown,
                               const fmi2ValueReference known[], size_t n_known, const fmi2Real along[], fmi2Real result[]) {
    State *s = &m->s;
    for (size_t i = 0; i < n_unknown; i++) {
        fmi2ValueReference k = unknown[i];
        const double *row;
        if (k >= DX && k < U) {
            if (fresh_state_jacobian(m)) return failed(m, fmi2Error);
            row = s->by_state + (k - DX) * NX;
        } else if (k >= O && k < L) {
            if (fresh_output_jacobian(m)) return failed(m, fmi2Error);
            row = s->by_state + (NX + k - O) * NX;
        } else if (k >= X && k < DX) {
            row = NULL;
        } else
            return refuse(m, "fmi2GetDirectionalDerivative: an unknown that is neither derivative nor output");
        result[i] = 0;
        for (size_t j = 0; j < n_known; j++)
            if (row || known[j] == k) result[i] += along[j] * (row ? row[known[j] - X] : 1);
    }
    return fmi2OK;
}
#endif

fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference unknown[], size_t n_unknown,
                                        const fmi2ValueReference known[], size_t n_known, const fmi2Real along[],
                                        fmi2Real result[]) {
    State *s = &M->s;
    double vx[NX + 1], vu[NU + 1], vp[NF + 1], dx[NX + 1], dy[NO + 1], t;
    if (prepare(M)) return failed(M, fmi2Error);
#if BY_STATE
    size_t states = 0;
    while (states < n_known && known[states] >= X && known[states] < DX) states++;
    if (states == n_known) return along_states(M, unknown, n_unknown, known, n_known, along, result);
#endif
    memset(vx, 0, sizeof vx);
    memset(vu, 0, sizeof vu);
    memset(vp, 0, sizeof vp);
    for (size_t i = 0; i < n_known; i++) {
        fmi2ValueReference k = known[i];
        if (k >= X && k < DX) vx[k - X] = along[i];
        else if (k >= U && k < P) vu[k - U] = along[i];
        else if (k >= P && k < P + NF) vp[k - P] = along[i];
        else return refuse(M, "fmi2GetDirectionalDerivative: a known that is neither state, input nor parameter");
    }
    t = inside(s, s->v[TIME]);
    if (NG && loops(M, t, s->v + X)) return failed(M, fmi2Error);
    {
        const double *a[] = { &t, s->v + X, s->v + U, s->v + P, s->v + D, s->r, s->g, vx, vu, vp };
        double *r[] = { dx, dy };
        f_directional(a, r);
    }
    for (size_t i = 0; i < n_unknown; i++) {
        fmi2ValueReference k = unknown[i];
        if (k >= DX && k < U) result[i] = dx[k - DX];
        else if (k >= O && k < L) result[i] = dy[k - O];
        else if (k >= X && k < DX) result[i] = vx[k - X];
        else return refuse(M, "fmi2GetDirectionalDerivative: an unknown that is neither derivative nor output");
    }
    return fmi2OK;
}
