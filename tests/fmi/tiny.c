/* A tiny FMI 2.0 FMU for tests: dx/dt = -rate x + gain u, stepped exactly, and one way to misbehave.
 *
 * Value references: 0 x, 1 der(x), 2 u, 3 rate, 4 gain, 5 y = 2 x + u, 6 flag = x > 0.5 (Boolean), 7 count of steps
 * (Integer), 8 label (String; 'strict' about time), 9 steps allowed (Integer parameter), 10 mode (Integer input).
 * MISBEHAVIOUR happens in the step after `steps allowed`.                                                       */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "quiet.h"

#define WELL 0
#define ERROR_STATUS 1
#define DISCARD 2
#define NAN_OUTPUT 3
#define NEVER_STOPS 4
#define CRASH 5
#define FATAL 6
#define ENDS 7
#define REFUSES 8
#define BAD_INITIALISATION 9
#define PENDING 10
#define EXITS 12
#define NO_STATUS 13
#define WARNS 14                  /* about two variables in each step, with the time */
#define WARNS_ALWAYS_OTHERWISE 15 /* in other words in each step */
#define WARNS_SOMEBODY_ELSE 16    /* not the one who created it */
#define WARNS_IN_COLOUR 17
#define REQUIRES_END 18 /* a stop time, after which it is not stepped */

#ifndef MISBEHAVIOUR
#define MISBEHAVIOUR WELL
#endif

typedef struct {
    double t, x, u, rate, gain, end;
    int steps, allowed, mode, broken;
} State;

typedef struct {
    State s;
    const fmi2CallbackFunctions *call;
    char label[64];
} Tiny;

static void say(Tiny *m, fmi2Status status, const char *text, double value) {
    m->call->logger(m->call->componentEnvironment, "tiny", status, "logStatusError", "%s %g", text, value);
}
/* The steady part is solved in closed form, so that a step of any length is exact. */
static double after(const State *s, double h) {
    double rest = s->gain * s->u / s->rate;
    return rest + (s->x - rest) * exp(-s->rate * h);
}
static void protest(const char *text) {
    /* Seen by the test even if nobody listens to the logger any more. */
    const char *path = getenv("TINY_PROTEST");
    FILE *f = path ? fopen(path, "a") : NULL;
    if (f) { fprintf(f, "%s\n", text); fclose(f); }
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *call, fmi2Boolean visible, fmi2Boolean logging) {
    (void)type; (void)resources; (void)visible; (void)logging;
    if (MISBEHAVIOUR == REFUSES || strcmp(guid, TINY_GUID)) {
        call->logger(call->componentEnvironment, name, fmi2Error, "logStatusError", "no licence for %s", name);
        return NULL;
    }
    Tiny *m = call->allocateMemory(1, sizeof *m);
    m->call = call;
    m->s.x = 1; m->s.rate = 2; m->s.gain = 3; m->s.allowed = 3;
    strcpy(m->label, "tiny");
    return m;
}
void fmi2FreeInstance(fmi2Component c) {
    Tiny *m = c;
    if (!m) return;
    if (m->s.broken == FATAL) protest("freed after fmi2Fatal");
    else protest("freed");
    m->call->freeMemory(m);
}
fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean td, fmi2Real tol, fmi2Real t, fmi2Boolean sd, fmi2Real stop) {
    Tiny *m = c;
    (void)td; (void)tol;
    m->s.t = t; m->s.end = stop;
    if (MISBEHAVIOUR == REQUIRES_END && !sd) { say(m, fmi2Error, "no stop time, begin", t); return fmi2Error; }
    return fmi2OK;
}
fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
    Tiny *m = c;
    if (MISBEHAVIOUR == BAD_INITIALISATION) {
        say(m, fmi2Error, "the rate does not suit it:", m->s.rate); m->s.broken = ERROR_STATUS; return fmi2Error;
    }
    return fmi2OK;
}
fmi2Status fmi2Terminate(fmi2Component c) {
    Tiny *m = c;
    if (m->s.broken) protest("terminated after an error");
    return fmi2OK;
}

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real v[]) {
    State *s = &((Tiny *)c)->s;
    for (size_t i = 0; i < n; i++) switch (vr[i]) {
        case 0: v[i] = s->x; break;
        case 1: v[i] = -s->rate * s->x + s->gain * s->u; break;
        case 2: v[i] = s->u; break;
        case 3: v[i] = s->rate; break;
        case 4: v[i] = s->gain; break;
        case 5: v[i] = MISBEHAVIOUR == NAN_OUTPUT && s->steps > s->allowed ? NAN : 2 * s->x + s->u; break;
        default: return fmi2Error;
    }
    return fmi2OK;
}
fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Integer v[]) {
    State *s = &((Tiny *)c)->s;
    for (size_t i = 0; i < n; i++) v[i] = vr[i] == 7 ? s->steps : vr[i] == 9 ? s->allowed : s->mode;
    return fmi2OK;
}
fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Boolean v[]) {
    State *s = &((Tiny *)c)->s;
    (void)vr;
    for (size_t i = 0; i < n; i++) v[i] = s->x > 0.5;
    return fmi2OK;
}
fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2String v[]) {
    (void)vr;
    for (size_t i = 0; i < n; i++) v[i] = ((Tiny *)c)->label;
    return fmi2OK;
}
fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Real v[]) {
    State *s = &((Tiny *)c)->s;
    for (size_t i = 0; i < n; i++) switch (vr[i]) {
        case 0: s->x = v[i]; break;
        case 2: s->u = v[i]; break;
        case 3: s->rate = v[i]; break;
        case 4: s->gain = v[i]; break;
        default: return fmi2Error;
    }
    return fmi2OK;
}
fmi2Status fmi2SetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Integer v[]) {
    State *s = &((Tiny *)c)->s;
    for (size_t i = 0; i < n; i++) { if (vr[i] == 9) s->allowed = v[i]; else s->mode = v[i]; }
    return fmi2OK;
}
fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2String v[]) {
    (void)vr;
    if (n) { strncpy(((Tiny *)c)->label, v[0], 63); }
    return fmi2OK;
}
fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state) {
    if (!*state) *state = malloc(sizeof(State));
    memcpy(*state, &((Tiny *)c)->s, sizeof(State)); return fmi2OK;
}
fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state) {
    memcpy(&((Tiny *)c)->s, state, sizeof(State)); return fmi2OK;
}
fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state) {
    (void)c; protest("state freed"); free(*state); *state = NULL; return fmi2OK;
}
fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference z[], size_t nz,
                                        const fmi2ValueReference w[], size_t nw, const fmi2Real dw[], fmi2Real dz[]) {
    State *s = &((Tiny *)c)->s;
    double dx = 0, du = 0;
    for (size_t i = 0; i < nw; i++) { if (w[i] == 0) dx = dw[i]; else if (w[i] == 2) du = dw[i]; else return fmi2Error; }
    for (size_t i = 0; i < nz; i++) dz[i] = z[i] == 1 ? -s->rate * dx + s->gain * du : z[i] == 5 ? 2 * dx + du : dx;
    return fmi2OK;
}

/* Co-simulation */
fmi2Status fmi2DoStep(fmi2Component c, fmi2Real t, fmi2Real h, fmi2Boolean no) {
    Tiny *m = c;
    State *s = &m->s;
    (void)no;
    /* To the last bit: a sum of a thousand steps would differ. */
    if (!strcmp(m->label, "strict") && t != s->steps * h) { say(m, fmi2Error, "called at the wrong time", t); s->broken = ERROR_STATUS; return fmi2Error; }
    if (MISBEHAVIOUR == REQUIRES_END && t + h > s->end + 1e-12) { say(m, fmi2Error, "after its end", t + h); return fmi2Error; }
    s->steps++;
    if (s->steps > s->allowed) switch (MISBEHAVIOUR) {
        case ERROR_STATUS: say(m, fmi2Error, "the wheel came off at", t); s->broken = ERROR_STATUS; return fmi2Error;
        case DISCARD: s->x = after(s, 0.5 * h); s->t = t + 0.5 * h; say(m, fmi2Discard, "could not pass", s->t); return fmi2Discard;
        case ENDS: s->mode = -1; s->t = t; return fmi2Discard;
        case FATAL: s->broken = FATAL; say(m, fmi2Fatal, "beyond repair at", t); return fmi2Fatal;
        case PENDING: return fmi2Pending;
        case NO_STATUS: return (fmi2Status)-5;
        case NEVER_STOPS: for (volatile int k = 0;; k = 0) { (void)k; }
        case CRASH: { volatile int *nowhere = NULL; *nowhere = 1; break; }
        case EXITS: exit(7);
        case WARNS: say(m, fmi2Warning, "#r0# is late by", t); say(m, fmi2Warning, "#r5# is late by", t); break;
        case WARNS_ALWAYS_OTHERWISE: {
            const char text[] = { (char)('a' + (s->steps - 1) % 26), 0 };
            m->call->logger(m->call->componentEnvironment, "tiny", fmi2Warning, "logStatusWarning", "%s", text);
            break;
        }
        case WARNS_SOMEBODY_ELSE: m->call->logger(m, "tiny", fmi2Warning, NULL, "hello"); break;
        case WARNS_IN_COLOUR:
            m->call->logger(m->call->componentEnvironment, "tiny", fmi2Warning, "logStatusWarning", "\033[31mred\n\033line");
            break;
        default: break;
    }
    s->x = after(s, h); s->t = t + h;
    return fmi2OK;
}
fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind k, fmi2Real *v) {
    if (k != fmi2LastSuccessfulTime) return fmi2Discard;
    *v = ((Tiny *)c)->s.t; return fmi2OK;
}
fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind k, fmi2Boolean *v) {
    if (k != fmi2Terminated) return fmi2Discard;
    *v = ((Tiny *)c)->s.mode == -1; return fmi2OK;
}

/* Model Exchange */
fmi2Status fmi2SetTime(fmi2Component c, fmi2Real t) { ((Tiny *)c)->s.t = t; return fmi2OK; }
fmi2Status fmi2SetContinuousStates(fmi2Component c, const fmi2Real x[], size_t n) { if (n != 1) return fmi2Error; ((Tiny *)c)->s.x = x[0]; return fmi2OK; }
fmi2Status fmi2GetContinuousStates(fmi2Component c, fmi2Real x[], size_t n) { if (n != 1) return fmi2Error; x[0] = ((Tiny *)c)->s.x; return fmi2OK; }
fmi2Status fmi2GetDerivatives(fmi2Component c, fmi2Real x[], size_t n) {
    State *s = &((Tiny *)c)->s;
    if (n != 1) return fmi2Error;
    x[0] = -s->rate * s->x + s->gain * s->u; return fmi2OK;
}
