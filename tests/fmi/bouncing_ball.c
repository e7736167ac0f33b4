/* A bouncing ball as a Model Exchange FMU 3.0 with arrays, for tests.
 *
 * dh/dt = v, dv/dt = -g + lift, and 1 m/s2 more from `gust_at` on; at h = 0 the ball leaves with e times its speed.
 * Value references: 1 x[2] = h, v (states), 2 der(x)[2], 3 constants[2] = g, e, 4 lift (input), 5 indicator,
 * 6 bounces (Int32), 7 gust_at. With e < 0 the derivatives fail.
 * With e = 5 the gust comes in two events at one instant, with e = 6 that event repeats for ever. Below 0.9 m, with e = 2 the indicator, with e = 3 the second derivative, and with e = 4 the next event is NaN. */
#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

enum { OK = 0, ERROR = 3 };
typedef void Log(void *, int, const char *, const char *);
typedef struct {
    double t, x[2], constants[2], lift, gust_at, gust;
    int bounces;
    void *environment;
    Log *log;
} Ball;

static void slopes(const Ball *b, double *dx) {
    dx[0] = b->x[1];
    dx[1] = b->lift - b->constants[0] + b->gust;
}
static bool is_ill(const Ball *b, double e) { return b->constants[1] == e && b->x[0] < 0.9; }
static double *place(Ball *b, unsigned reference, size_t *size) {
    *size = reference == 1 || reference == 3 ? 2 : 1;
    return reference == 1 ? b->x : reference == 3 ? b->constants : reference == 4 ? &b->lift : &b->gust_at;
}

void *fmi3InstantiateModelExchange(const char *name, const char *token, const char *resources, bool visible, bool logging,
                                   void *environment, Log *log) {
    Ball *b = calloc(1, sizeof *b);
    (void)name; (void)token; (void)resources; (void)visible; (void)logging;
    b->x[0] = 1; b->constants[0] = 9.81; b->constants[1] = 0.7; b->gust_at = 1e9;
    b->environment = environment; b->log = log;
    return b;
}
void fmi3FreeInstance(void *c) { free(c); }
const char *fmi3GetVersion(void) { return "3.0"; }
int fmi3SetDebugLogging(void *c, bool on, size_t n, const char *const names[]) {
    (void)c; (void)on; (void)n; (void)names; return OK;
}
int fmi3EnterInitializationMode(void *c, bool a, double b, double start, bool d, double e) {
    (void)a; (void)b; (void)d; (void)e; ((Ball *)c)->t = start; return OK;
}
int fmi3ExitInitializationMode(void *c) { (void)c; return OK; }
int fmi3EnterEventMode(void *c) { (void)c; return OK; }
int fmi3EnterContinuousTimeMode(void *c) { (void)c; return OK; }
int fmi3Terminate(void *c) { (void)c; return OK; }
int fmi3SetTime(void *c, double t) { ((Ball *)c)->t = t; return OK; }
int fmi3UpdateDiscreteStates(void *c, bool *again, bool *end, bool *nominals, bool *values, bool *defined, double *next) {
    Ball *b = c;
    *again = *end = *nominals = *values = false;
    if (b->x[0] <= 0 && b->x[1] < 0) {
        b->x[0] = 0;
        b->x[1] *= -b->constants[1];
        b->bounces++;
        *values = true;
    }
    if (b->t >= b->gust_at) b->gust = b->constants[1] < 5 || b->gust > 0 ? 1 : 0.5;
    *defined = b->gust < 1 || b->constants[1] == 6;
    *next = is_ill(b, 4) ? NAN : b->gust_at;
    return OK;
}
int fmi3CompletedIntegratorStep(void *c, bool no, bool *event, bool *end) { (void)c; (void)no; *event = *end = false; return OK; }
int fmi3GetNumberOfContinuousStates(void *c, size_t *n) { (void)c; *n = 2; return OK; }
int fmi3GetNumberOfEventIndicators(void *c, size_t *n) { (void)c; *n = 1; return OK; }
int fmi3GetContinuousStates(void *c, double *x, size_t n) { (void)n; memcpy(x, ((Ball *)c)->x, sizeof(double[2])); return OK; }
int fmi3SetContinuousStates(void *c, const double *x, size_t n) { (void)n; memcpy(((Ball *)c)->x, x, sizeof(double[2])); return OK; }
int fmi3GetNominalsOfContinuousStates(void *c, double *x, size_t n) { (void)c; for (size_t i = 0; i < n; i++) x[i] = 0; return OK; }
int fmi3GetContinuousStateDerivatives(void *c, double *dx, size_t n) {
    Ball *b = c;
    (void)n;
    slopes(b, dx);
    if (is_ill(b, 3)) dx[1] = NAN;
    if (b->constants[1] >= 0) return OK;
    b->log(b->environment, ERROR, "logStatusError", "the ball is no ball");
    return ERROR;
}
int fmi3GetEventIndicators(void *c, double *z, size_t n) {
    Ball *b = c;
    (void)n;
    z[0] = is_ill(b, 2) ? NAN : b->x[0] == 0 && b->x[1] > 0 ? 1e-300 : b->x[0];
    return OK;
}
int fmi3GetFloat64(void *c, const unsigned vr[], size_t n, double value[], size_t n_values) {
    Ball *b = c;
    double *end = value + n_values, dx[2];
    for (size_t i = 0; i < n; i++) {
        size_t size = 2;
        const double *from = dx;
        slopes(b, dx);
        if (vr[i] == 5) { from = b->x; size = 1; }
        else if (vr[i] != 2) from = place(b, vr[i], &size);
        memcpy(value, from, size * sizeof *value);
        value += size;
    }
    return value == end ? OK : ERROR;
}
int fmi3SetFloat64(void *c, const unsigned vr[], size_t n, const double value[], size_t n_values) {
    const double *end = value + n_values;
    for (size_t i = 0; i < n; i++) {
        size_t size;
        double *to = place(c, vr[i], &size);
        memcpy(to, value, size * sizeof *value);
        value += size;
    }
    return value == end ? OK : ERROR;
}
int fmi3GetInt32(void *c, const unsigned vr[], size_t n, int32_t value[], size_t n_values) {
    (void)vr; (void)n_values;
    for (size_t i = 0; i < n; i++) value[i] = ((Ball *)c)->bounces;
    return OK;
}

/* Not called in the tests; importers require these functions. */
#define IDLE(NAME) int fmi3##NAME(void) { return ERROR; }
#define IDLE_VALUES(TYPE) IDLE(Get##TYPE) IDLE(Set##TYPE)
IDLE_VALUES(Float32) IDLE_VALUES(Int8) IDLE_VALUES(UInt8) IDLE_VALUES(Int16) IDLE_VALUES(UInt16) IDLE_VALUES(UInt32)
IDLE_VALUES(Int64) IDLE_VALUES(UInt64) IDLE_VALUES(Boolean) IDLE_VALUES(String) IDLE_VALUES(Binary) IDLE_VALUES(Clock)
IDLE_VALUES(FMUState) IDLE_VALUES(IntervalDecimal) IDLE_VALUES(IntervalFraction) IDLE_VALUES(ShiftDecimal)
IDLE_VALUES(ShiftFraction) IDLE(SetInt32) IDLE(InstantiateCoSimulation) IDLE(InstantiateScheduledExecution) IDLE(Reset)
IDLE(GetNumberOfVariableDependencies) IDLE(GetVariableDependencies) IDLE(FreeFMUState) IDLE(SerializedFMUStateSize)
IDLE(SerializeFMUState) IDLE(DeserializeFMUState) IDLE(GetDirectionalDerivative) IDLE(GetAdjointDerivative)
IDLE(EnterConfigurationMode) IDLE(ExitConfigurationMode) IDLE(EvaluateDiscreteStates) IDLE(EnterStepMode)
IDLE(GetOutputDerivatives) IDLE(DoStep) IDLE(ActivateModelPartition)
