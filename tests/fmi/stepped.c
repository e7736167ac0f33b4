/* A smooth FMI 2.0 co-simulation FMU for tests, with the equations of curved.c:
 *
 *   da/dt = -k a + u1,   db/dt = a b + sin c,   dc/dt = b - c^3 + u2,   y1 = a + b c,   y2 = c + u1.
 *
 * Value references: 0-2 a b c, 3-5 their derivatives, 6-7 u, 8-9 y, 10 k. It integrates by Runge-Kutta steps of order 4,
 * ten in a communication step. VARIANT is a sum of the following:
 *   1    states may be set in step mode, too, as the extension for filters requires, and the mode is not part of a saved
 *        state, so that no step can begin in initialisation mode (OpenModelica)
 *   2    a restored state has the default value of k (OpenModelica issue 15216)
 *   4    a restored state keeps the time; a step from another time is ignored with a warning (FMIKit-Simulink issue 310)
 *   8    a value that is not a state of the FMU acts on a, and is not part of a saved state (PythonFMU pull request 41)
 *   16   it takes steps of 0.1 s, those that end in the communication step (Reference-FMUs issue 203)
 *   32   the equations depend on time
 *   64   values of states are ignored
 *   128  it refuses to save its state in initialisation mode (fmi-standard issue 367)
 *   256  one step of forward Euler
 *   512  its derivatives are those of the last step (they are zero before)                                          */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "fmi2Functions.h"
#include "quiet.h"
#define KEEPS_STATE
#include "reals_only.h"
#define HAS(bit) ((VARIANT) / (bit) % 2)

enum { INSTANTIATED, INITIALISING, STEPPING };
typedef struct { double v[11], time, hidden; int mode; } Model;
#define M ((Model *)c)

static void derivatives(const Model *m, double t, const double *x, double *dx) {
    dx[0] = -m->v[10] * x[0] + m->v[6] + (HAS(8) ? m->hidden : 0) + (HAS(32) ? t : 0);
    dx[1] = x[0] * x[1] + sin(x[2]);
    dx[2] = x[1] - x[2] * x[2] * x[2] + m->v[7];
}
static void runge_kutta(Model *m, double h) {
    double k1[3], k2[3], k3[3], k4[3], at[3], *x = m->v;
    derivatives(m, m->time, x, k1);
    if (HAS(256)) {
        for (int i = 0; i < 3; i++) x[i] += h * k1[i];
        return;
    }
    for (int i = 0; i < 3; i++) at[i] = x[i] + h / 2 * k1[i];
    derivatives(m, m->time + h / 2, at, k2);
    for (int i = 0; i < 3; i++) at[i] = x[i] + h / 2 * k2[i];
    derivatives(m, m->time + h / 2, at, k3);
    for (int i = 0; i < 3; i++) at[i] = x[i] + h * k3[i];
    derivatives(m, m->time + h, at, k4);
    for (int i = 0; i < 3; i++) x[i] += h / 6 * (k1[i] + 2 * k2[i] + 2 * k3[i] + k4[i]);
    m->time += h;
}
fmi2Status fmi2DoStep(fmi2Component c, fmi2Real t, fmi2Real h, fmi2Boolean no) {
    (void)no;
    const int parts = HAS(256) ? 1 : 10;
    if (M->mode != STEPPING) return fmi2Error;
    if (fabs(t - M->time) > 1e-9) return fmi2Warning;
    if (HAS(512)) derivatives(M, t, M->v, M->v + 3);
    if (HAS(16)) {
        while ((floor(M->time / 0.1 + 1e-9) + 1) * 0.1 <= t + h + 1e-12) runge_kutta(M, 0.1);
        M->time = t + h;
        return fmi2OK;
    }
    for (int i = 0; i < parts; i++) runge_kutta(M, h / parts);
    M->time = t + h;
    M->hidden += 100 * h;
    return fmi2OK;
}
fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *call, fmi2Boolean visible, fmi2Boolean logging) {
    (void)name; (void)resources; (void)call; (void)visible; (void)logging;
    if (strcmp(guid, TINY_GUID) || type != fmi2CoSimulation) return NULL;
    Model *m = calloc(1, sizeof *m);
    m->v[10] = 1;
    return m;
}
void fmi2FreeInstance(fmi2Component c) { free(c); }
fmi2Status fmi2Terminate(fmi2Component c) { (void)c; return fmi2OK; }
fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean td, fmi2Real tol, fmi2Real t, fmi2Boolean sd,
                               fmi2Real stop) {
    (void)td; (void)tol; (void)sd; (void)stop;
    M->time = t;
    M->mode = INITIALISING;
    return fmi2OK;
}
fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
    if (M->mode != INITIALISING) return fmi2Error;
    M->mode = STEPPING;
    return fmi2OK;
}
fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Real v[]) {
    for (size_t i = 0; i < n; i++) {
        if (vr[i] > 10 || (vr[i] > 2 && vr[i] < 6) || vr[i] == 8 || vr[i] == 9) return fmi2Error;
        if (vr[i] < 3 && M->mode == STEPPING && !HAS(1)) return fmi2Error;
        if (vr[i] > 2 || !HAS(64)) M->v[vr[i]] = v[i];
    }
    return fmi2OK;
}
fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real v[]) {
    if (!HAS(512)) derivatives(M, M->time, M->v, M->v + 3);
    M->v[8] = M->v[0] + M->v[1] * M->v[2];
    M->v[9] = M->v[2] + M->v[6];
    for (size_t i = 0; i < n; i++) v[i] = M->v[vr[i]];
    return fmi2OK;
}
fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference z[], size_t nz,
                                        const fmi2ValueReference w[], size_t nw, const fmi2Real dw[], fmi2Real dz[]) {
    double s[8] = {0}, d[10] = {0}, *v = M->v;
    for (size_t i = 0; i < nw; i++) { if (w[i] > 7) return fmi2Error; s[w[i]] = dw[i]; }
    d[3] = -v[10] * s[0] + s[6];
    d[4] = v[1] * s[0] + v[0] * s[1] + cos(v[2]) * s[2];
    d[5] = s[1] - 3 * v[2] * v[2] * s[2] + s[7];
    d[8] = s[0] + v[2] * s[1] + v[1] * s[2];
    d[9] = s[2] + s[6];
    for (size_t i = 0; i < nz; i++) dz[i] = d[z[i]];
    return fmi2OK;
}

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state) {
    if (HAS(128) && M->mode == INITIALISING) return fmi2Error;
    if (!*state) *state = malloc(sizeof(Model));
    memcpy(*state, M, sizeof(Model));
    return fmi2OK;
}
fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state) {
    const Model before = *M;
    memcpy(M, state, sizeof(Model));
    if (HAS(1)) M->mode = before.mode;
    if (HAS(2)) M->v[10] = 1;
    if (HAS(4)) M->time = before.time;
    M->hidden = before.hidden;
    return fmi2OK;
}
fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state) {
    (void)c; free(*state); *state = NULL; return fmi2OK;
}

/* Nothing of it is needed for co-simulation of real variables. */
fmi2Status fmi2SetTime(fmi2Component c, fmi2Real t) { (void)c; (void)t; return fmi2Error; }
fmi2Status fmi2SetContinuousStates(fmi2Component c, const fmi2Real x[], size_t n) {
    (void)c; (void)x; (void)n; return fmi2Error;
}
fmi2Status fmi2GetContinuousStates(fmi2Component c, fmi2Real x[], size_t n) {
    (void)c; (void)x; (void)n; return fmi2Error;
}
fmi2Status fmi2GetDerivatives(fmi2Component c, fmi2Real dx[], size_t n) {
    (void)c; (void)dx; (void)n; return fmi2Error;
}
fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind k, fmi2Real *v) {
    (void)c; (void)k; (void)v; return fmi2Discard;
}
fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind k, fmi2Boolean *v) {
    (void)c; (void)k; (void)v; return fmi2Discard;
}
