/* A smooth FMI 2.0 model-exchange FMU for tests, with Jacobians known in closed form:
 *
 *   da/dt = -k a + u1,   db/dt = a b + sin c,   dc/dt = b - c^3 + u2,   y1 = a + b c,   y2 = c + u1.
 *
 * Value references: 0-2 a b c, 3-5 their derivatives, 6-7 u, 8-9 y, 10 k, 11 how often values were sent, 12 how often
 * derivatives, values or directional derivatives were asked for. dc/dt is NaN where c > 1000.
 *
 * With FORGETS defined it does as OpenModelica's FMUs up to 1.27.0: once its derivatives were read it takes its outputs
 * for evaluated, too, until a state or input is set; its directional derivatives are those of the point where it last
 * evaluated everything.                                                                                            */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "quiet.h"
#include "reals_only.h"

typedef struct { double v[13], at[13]; int moved; } Model; /* at: v where everything was last evaluated */
#define M ((Model *)c)
#define V (M->v)

static void derivatives(const double *v, double *dx) {
    dx[0] = -v[10] * v[0] + v[6];
    dx[1] = v[0] * v[1] + sin(v[2]);
    dx[2] = v[2] > 1000 ? NAN : v[1] - v[2] * v[2] * v[2] + v[7];
}
static void outputs(const double *v, double *y) {
    y[0] = v[0] + v[1] * v[2];
    y[1] = v[2] + v[6];
}
static void evaluate(Model *m) {
#ifdef FORGETS
    if (!m->moved) return;
#endif
    derivatives(m->v, m->v + 3); outputs(m->v, m->v + 8);
    memcpy(m->at, m->v, sizeof m->at);
    m->moved = 0;
}
fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *call, fmi2Boolean visible, fmi2Boolean logging) {
    (void)name; (void)type; (void)resources; (void)call; (void)visible; (void)logging;
    if (strcmp(guid, TINY_GUID)) return NULL;
    Model *m = calloc(1, sizeof *m);
    m->v[10] = m->moved = 1;
    return m;
}
void fmi2FreeInstance(fmi2Component c) { free(c); }
fmi2Status fmi2Terminate(fmi2Component c) { (void)c; return fmi2OK; }
fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean td, fmi2Real tol, fmi2Real t, fmi2Boolean sd,
                               fmi2Real stop) {
    (void)c; (void)td; (void)tol; (void)t; (void)sd; (void)stop; return fmi2OK;
}
fmi2Status fmi2ExitInitializationMode(fmi2Component c) { (void)c; return fmi2OK; }
fmi2Status fmi2SetTime(fmi2Component c, fmi2Real t) { (void)c; (void)t; return fmi2OK; }

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Real v[]) {
    V[11]++;
    for (size_t i = 0; i < n; i++) V[vr[i]] = v[i];
    M->moved = 1;
    return fmi2OK;
}
fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real v[]) {
    V[12]++;
    evaluate(c);
    for (size_t i = 0; i < n; i++) v[i] = V[vr[i]];
    return fmi2OK;
}
fmi2Status fmi2SetContinuousStates(fmi2Component c, const fmi2Real x[], size_t n) {
    if (n != 3) return fmi2Error;
    V[11]++; memcpy(V, x, 3 * sizeof *x); M->moved = 1; return fmi2OK;
}
fmi2Status fmi2GetContinuousStates(fmi2Component c, fmi2Real x[], size_t n) {
    if (n != 3) return fmi2Error;
    memcpy(x, V, 3 * sizeof *x); return fmi2OK;
}
fmi2Status fmi2GetDerivatives(fmi2Component c, fmi2Real dx[], size_t n) {
    if (n != 3) return fmi2Error;
    V[12]++; derivatives(V, dx); M->moved = 0; return fmi2OK;
}
fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference z[], size_t nz,
                                        const fmi2ValueReference w[], size_t nw, const fmi2Real dw[], fmi2Real dz[]) {
    double s[8] = {0}, d[10] = {0}, *v = M->at;
    V[12]++;
    evaluate(c);
    for (size_t i = 0; i < nw; i++) { if (w[i] > 7) return fmi2Error; s[w[i]] = dw[i]; }
    d[3] = -v[10] * s[0] + s[6];
    d[4] = v[1] * s[0] + v[0] * s[1] + cos(v[2]) * s[2];
    d[5] = s[1] - 3 * v[2] * v[2] * s[2] + s[7];
    d[8] = s[0] + v[2] * s[1] + v[1] * s[2];
    d[9] = s[2] + s[6];
    for (size_t i = 0; i < nz; i++) dz[i] = d[z[i]];
    return fmi2OK;
}

/* Nothing of it is needed for co-simulation. */
fmi2Status fmi2DoStep(fmi2Component c, fmi2Real t, fmi2Real h, fmi2Boolean no) {
    (void)c; (void)t; (void)h; (void)no; return fmi2Error;
}
fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind k, fmi2Real *v) {
    (void)c; (void)k; (void)v; return fmi2Discard;
}
fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind k, fmi2Boolean *v) {
    (void)c; (void)k; (void)v; return fmi2Discard;
}
