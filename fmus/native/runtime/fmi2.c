/* FMI 2.0: what Model Exchange and Co-Simulation share. */
#define M ((Instance *)c)

static fmi2Status refuse(Instance *m, const char *function, const char *why) {
    message(m, fmi2Error, "logStatusError", "%s: %s", function, why);
    return fmi2Error;
}
/* Status of a call that left a sentence in `failure`. */
static fmi2Status failed(Instance *m, fmi2Status status) {
    message(m, status, "logStatusError", "%s", m->failure);
    return status;
}

const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
const char *fmi2GetVersion(void) { return fmi2Version; }

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t n, const fmi2String categories[]) {
    (void)n;
    (void)categories;
    M->logging = on;
    return fmi2OK;
}

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
    s->stale_parameters = s->stale_start = 1;
    s->lo = -INFINITY;
    s->hi = s->h = INFINITY;
    stale(s);
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *callbacks, fmi2Boolean visible, fmi2Boolean logging) {
    Instance *m;
    (void)resources;
    (void)visible;
    if (!name || !guid || !(m = calloc(1, sizeof *m + strlen(name)))) return NULL;
    strcpy(m->name, name);
    if (callbacks) m->callbacks = *callbacks;
    m->logging = logging;
    m->co_simulation = type == fmi2CoSimulation;
    if (strcmp(guid, MODEL_GUID)) {
        message(m, fmi2Error, "logStatusError", "the GUID %s is not that of this FMU, %s", guid, MODEL_GUID);
        free(m);
        return NULL;
    }
    reset(&m->s);
    return m;
}
void fmi2FreeInstance(fmi2Component c) { free(c); }

fmi2Status fmi2Reset(fmi2Component c) {
    reset(&M->s);
    return fmi2OK;
}

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean has_tolerance, fmi2Real tolerance, fmi2Real start,
                               fmi2Boolean has_stop, fmi2Real stop) {
    (void)has_stop;
    (void)stop;
    if (M->s.phase != INSTANTIATED) return refuse(M, "fmi2SetupExperiment", "only before initialisation");
    M->s.v[TIME] = start;
    if (has_tolerance && tolerance > 0) M->s.v[TOLERANCE] = tolerance;
    return fmi2OK;
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
    State *s = &M->s;
    if (s->phase != INSTANTIATED) return refuse(M, "fmi2EnterInitializationMode", "only once, after instantiation or reset");
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
    if (s->phase != INITIALIZING) return refuse(M, "fmi2ExitInitializationMode", "not in initialisation mode");
    if (prepare(M) || assertions(M)) {
        s->phase = FAILED;
        return failed(M, fmi2Error);
    }
    for (int i = 0; i < NX; i++)
        if (!isfinite(s->v[X + i])) {
            failure(M, "%s is not a number after initialisation", x_name[i]);
            return failed(M, fmi2Error);
        }
    s->phase = RUNNING;
    if (M->co_simulation && s->hi <= s->v[TIME] && events(M, 0, &jumped)) return failed(M, fmi2Error);
    s->v[EVENTS] = s->v[EVALUATIONS] = 0;
    s->inputs_set = 0;
    return fmi2OK;
}

fmi2Status fmi2Terminate(fmi2Component c) {
    M->s.phase = TERMINATED;
    return fmi2OK;
}

/* ---- values ---- */
static int fresh(Instance *m, fmi2ValueReference k) {
    if (k >= NV) return failure(m, "there is no variable with value reference %u", k);
    if (k >= O && k < L) return m->s.stale_outputs && fresh_algebraics(m, 0);
    if (k >= L && k < D) return m->s.stale_locals && fresh_algebraics(m, 1);
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
GETTER(fmi2GetInteger, fmi2Integer, (fmi2Integer)lround)
GETTER(fmi2GetBoolean, fmi2Boolean, 0.0 != )

static fmi2Status set(Instance *m, fmi2ValueReference k, double value) {
    State *s = &m->s;
    if (k >= U && k < P) {
        if (s->v[k] == value) return fmi2OK;
        s->inputs_set = 1;
    } else if (k >= P && k < P + NF) {
        s->stale_parameters = 1;
    } else if (k >= X && k < DX) {
        if (s->phase < RUNNING) {
            s->x0[k - X] = value;
            s->x_set[k - X] = 1;
        } else if (m->co_simulation)
            return refuse(m, "set", "states can be set before initialisation only");
    } else if (k >= D && k < TOLERANCE && s->phase < RUNNING) {
        s->d0[k - D] = value;
    } else if (k == TOLERANCE) {
        if (!(value > 0 && value < 1)) return refuse(m, "set", "_tolerance must lie between 0 and 1");
    } else if (k == SOLVER) {
        if (value != 3 && value != 4) return refuse(m, "set", "_solver is 3 (RODAS3) or 4 (RODAS4)");
    } else {
        message(m, fmi2Error, "logStatusError", "the variable with value reference %u cannot be set", k);
        return fmi2Error;
    }
    s->v[k] = value;
    s->stale_derivatives = s->stale_outputs = s->stale_locals = 1;
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

fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2String value[]) {
    (void)vr;
    (void)value;
    return n ? refuse(M, "fmi2GetString", "there are no String variables") : fmi2OK;
}
fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2String value[]) {
    (void)vr;
    (void)value;
    return n ? refuse(M, "fmi2SetString", "there are no String variables") : fmi2OK;
}

/* ---- FMU state ---- */
fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state) {
    if (!*state && !(*state = malloc(sizeof(State)))) return refuse(M, "fmi2GetFMUstate", "out of memory");
    memcpy(*state, &M->s, sizeof(State));
    return fmi2OK;
}
fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state) {
    if (!state) return refuse(M, "fmi2SetFMUstate", "no state given");
    memcpy(&M->s, state, sizeof(State));
    return fmi2OK;
}
fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state) {
    (void)c;
    if (state) {
        free(*state);
        *state = NULL;
    }
    return fmi2OK;
}
fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t *size) {
    (void)c;
    (void)state;
    *size = sizeof(State);
    return fmi2OK;
}
fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size) {
    if (size < sizeof(State)) return refuse(M, "fmi2SerializeFMUstate", "the buffer is too small");
    memcpy(bytes, state, sizeof(State));
    return fmi2OK;
}
fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state) {
    if (size != sizeof(State)) return refuse(M, "fmi2DeSerializeFMUstate", "these bytes are not a state of this FMU");
    if (!*state && !(*state = malloc(size))) return refuse(M, "fmi2DeSerializeFMUstate", "out of memory");
    memcpy(*state, bytes, size);
    return fmi2OK;
}

/* ---- directional derivatives: of derivatives and outputs, along states, inputs and parameters ---- */
fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference unknown[], size_t n_unknown,
                                        const fmi2ValueReference known[], size_t n_known, const fmi2Real along[],
                                        fmi2Real result[]) {
    State *s = &M->s;
    double vx[NX + 1], vu[NU + 1], vp[NF + 1], dx[NX + 1], dy[NO + 1], t;
    memset(vx, 0, sizeof vx);
    memset(vu, 0, sizeof vu);
    memset(vp, 0, sizeof vp);
    for (size_t i = 0; i < n_known; i++) {
        fmi2ValueReference k = known[i];
        if (k >= X && k < DX) vx[k - X] = along[i];
        else if (k >= U && k < P) vu[k - U] = along[i];
        else if (k >= P && k < P + NF) vp[k - P] = along[i];
        else return refuse(M, "fmi2GetDirectionalDerivative", "a known that is neither state, input nor parameter");
    }
    if (prepare(M)) return failed(M, fmi2Error);
    t = inside(s, s->v[TIME]);
    if (NG && loops(M, t, s->v + X)) return failed(M, fmi2Error);
    {
        const double *a[] = { &t, s->v + X, s->v + U, s->v + P, s->v + D, s->r, s->g, vx, vu, vp };
        double *r[] = { dx, dy };
        f_directional(a, r, 0, 0, 0);
    }
    for (size_t i = 0; i < n_unknown; i++) {
        fmi2ValueReference k = unknown[i];
        if (k >= DX && k < U) result[i] = dx[k - DX];
        else if (k >= O && k < L) result[i] = dy[k - O];
        else if (k >= X && k < DX) result[i] = vx[k - X];
        else return refuse(M, "fmi2GetDirectionalDerivative", "an unknown that is neither derivative nor output");
    }
    return fmi2OK;
}
