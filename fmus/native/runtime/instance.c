/* FMI 2.0: functions common to all FMUs of this project.
 *
 * Before it State is defined, with the values `v` and `phase`, and Instance, with a State `s`, `callbacks`, `logging`,
 * `failure` and, last, `name`. State is everything that get, set and serialise FMU state have to copy. */
#define M ((Instance *)c)

static void message(Instance *m, fmi2Status status, const char *category, const char *format, ...) {
    char text[1024], escaped[2 * sizeof text], *to = escaped;
    va_list arguments;
    if (!m->callbacks.logger || (status < fmi2Warning && !m->logging)) return;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    /* The text itself is the format, not an argument of "%s", because loggers in Python do not get the arguments. */
    for (const char *from = text; *from; from++) {
        if (*from == '%') *to++ = '%';
        *to++ = *from;
    }
    *to = 0;
    m->callbacks.logger(m->callbacks.componentEnvironment, m->name, status, category, escaped);
}

static int failure(Instance *m, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(m->failure, sizeof m->failure, format, arguments);
    va_end(arguments);
    return 1;
}

/* Status of a call that wrote a message to `failure`. */
static fmi2Status failed(Instance *m, fmi2Status status) {
    message(m, status, "logStatusError", "%s", m->failure);
    return status;
}

static fmi2Status refuse(Instance *m, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(m->failure, sizeof m->failure, format, arguments);
    va_end(arguments);
    return failed(m, fmi2Error);
}

/* Start values. */
static void reset(State *s);
/* Return a new instance, or 0, with a message, if the FMU does not have that type. */
static int begin(Instance *m, fmi2Type type);

const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
const char *fmi2GetVersion(void) { return fmi2Version; }

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t n, const fmi2String categories[]) {
    (void)n;
    (void)categories;
    M->logging = on;
    return fmi2OK;
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
    if (strcmp(guid, MODEL_GUID))
        refuse(m, "the GUID %s is not that of this FMU, %s", guid, MODEL_GUID);
    else if (begin(m, type))
        return m;
    free(m);
    return NULL;
}
void fmi2FreeInstance(fmi2Component c) { free(c); }

fmi2Status fmi2Reset(fmi2Component c) {
    reset(&M->s);
    return fmi2OK;
}
fmi2Status fmi2Terminate(fmi2Component c) {
    M->s.phase = TERMINATED;
    return fmi2OK;
}

/* ---- value types that these FMUs do not have ---- */
fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2String value[]) {
    (void)vr;
    (void)value;
    return n ? refuse(M, "fmi2GetString: there are no String variables") : fmi2OK;
}
fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2String value[]) {
    (void)vr;
    (void)value;
    return n ? refuse(M, "fmi2SetString: there are no String variables") : fmi2OK;
}

/* ---- FMU state ---- */
fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state) {
    if (!*state && !(*state = malloc(sizeof(State)))) return refuse(M, "fmi2GetFMUstate: out of memory");
    memcpy(*state, &M->s, sizeof(State));
    return fmi2OK;
}
fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state) {
    if (!state) return refuse(M, "fmi2SetFMUstate: no state given");
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
    if (size < sizeof(State)) return refuse(M, "fmi2SerializeFMUstate: the buffer is too small");
    memcpy(bytes, state, sizeof(State));
    return fmi2OK;
}
fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state) {
    if (size != sizeof(State)) return refuse(M, "fmi2DeSerializeFMUstate: these bytes are not a state of this FMU");
    if (!*state && !(*state = malloc(size))) return refuse(M, "fmi2DeSerializeFMUstate: out of memory");
    memcpy(*state, bytes, size);
    return fmi2OK;
}
