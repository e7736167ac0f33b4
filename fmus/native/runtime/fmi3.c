/* FMI 3.0 for Co-Simulation over the functions of FMI 2.0, which come before it: other names, the same instance.
 *
 * Value references are the same in both versions; Float64 is Real, Int32 is Integer. Nothing else of FMI 3.0 is
 * supported. */
#include "fmi3Functions.h"

typedef struct {
    fmi3InstanceEnvironment environment;
    fmi3LogMessageCallback log;
} Log;

/* The logger of FMI 2.0. */
static void pass_on(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status, fmi2String category,
                    fmi2String format, ...) {
    const Log *to = environment;
    char text[1024];
    va_list arguments;
    (void)name;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    if (to->log) to->log(to->environment, (fmi3Status)status, category, text);
}

const char *fmi3GetVersion(void) { return fmi3Version; }

fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                         fmi3Boolean logging, fmi3Boolean event_mode, fmi3Boolean early_return,
                                         const fmi3ValueReference intermediate[], size_t n,
                                         fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
                                         fmi3IntermediateUpdateCallback update) {
    fmi2CallbackFunctions callbacks = { pass_on, 0, 0, 0, 0 };
    fmi2Component made;
    Log *to = malloc(sizeof *to);
    (void)event_mode;
    (void)early_return;
    (void)intermediate;
    (void)n;
    (void)update;
    if (!to) return NULL;
    to->environment = environment;
    to->log = log;
    callbacks.componentEnvironment = to;
    made = fmi2Instantiate(name, fmi2CoSimulation, token, resources, &callbacks, visible, logging);
    if (!made) free(to);
    return made;
}
void fmi3FreeInstance(fmi3Instance c) {
    if (!c) return;
    free(M->callbacks.componentEnvironment);
    fmi2FreeInstance(c);
}

fmi3Status fmi3SetDebugLogging(fmi3Instance c, fmi3Boolean on, size_t n, const fmi3String categories[]) {
    return (fmi3Status)fmi2SetDebugLogging(c, on, n, categories);
}
fmi3Status fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean has_tolerance, fmi3Float64 tolerance, fmi3Float64 start,
                                       fmi3Boolean has_stop, fmi3Float64 stop) {
    fmi2Status status = fmi2SetupExperiment(c, has_tolerance, tolerance, start, has_stop, stop);
    return (fmi3Status)(status == fmi2OK ? fmi2EnterInitializationMode(c) : status);
}
fmi3Status fmi3ExitInitializationMode(fmi3Instance c) { return (fmi3Status)fmi2ExitInitializationMode(c); }
fmi3Status fmi3Terminate(fmi3Instance c) { return (fmi3Status)fmi2Terminate(c); }
fmi3Status fmi3Reset(fmi3Instance c) { return (fmi3Status)fmi2Reset(c); }

fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 t, fmi3Float64 h, fmi3Boolean no_set_state, fmi3Boolean *event,
                      fmi3Boolean *terminate, fmi3Boolean *early, fmi3Float64 *last) {
    fmi2Status status = fmi2DoStep(c, t, h, no_set_state);
    *event = *terminate = *early = false;
    *last = M->s.v[TIME];
    return (fmi3Status)status;
}

/* ---- values ---- */
#define SAME(NAME, TYPE, FMI2, CONST)                                                                              \
    fmi3Status NAME(fmi3Instance c, const fmi3ValueReference vr[], size_t n, CONST TYPE value[], size_t n_values) { \
        if (n_values != n) return (fmi3Status)refuse(M, #NAME ": every variable is a scalar");                    \
        return (fmi3Status)FMI2(c, vr, n, value);                                                                   \
    }
SAME(fmi3GetFloat64, fmi3Float64, fmi2GetReal, )
SAME(fmi3SetFloat64, fmi3Float64, fmi2SetReal, const)
SAME(fmi3GetInt32, fmi3Int32, fmi2GetInteger, )
SAME(fmi3SetInt32, fmi3Int32, fmi2SetInteger, const)
SAME(fmi3GetString, fmi3String, fmi2GetString, )
SAME(fmi3SetString, fmi3String, fmi2SetString, const)

fmi3Status fmi3GetBoolean(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3Boolean value[], size_t n_values) {
    (void)n_values;
    for (size_t i = 0; i < n; i++) {
        fmi2Boolean one = 0;
        fmi2Status status = fmi2GetBoolean(c, vr + i, 1, &one);
        if (status != fmi2OK) return (fmi3Status)status;
        value[i] = one != fmi2False;
    }
    return fmi3OK;
}
fmi3Status fmi3SetBoolean(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3Boolean value[],
                          size_t n_values) {
    (void)n_values;
    for (size_t i = 0; i < n; i++) {
        fmi2Boolean one = value[i] ? fmi2True : fmi2False;
        fmi2Status status = fmi2SetBoolean(c, vr + i, 1, &one);
        if (status != fmi2OK) return (fmi3Status)status;
    }
    return fmi3OK;
}

/* ---- FMU state ---- */
fmi3Status fmi3GetFMUState(fmi3Instance c, fmi3FMUState *state) { return (fmi3Status)fmi2GetFMUstate(c, state); }
fmi3Status fmi3SetFMUState(fmi3Instance c, fmi3FMUState state) { return (fmi3Status)fmi2SetFMUstate(c, state); }
fmi3Status fmi3FreeFMUState(fmi3Instance c, fmi3FMUState *state) { return (fmi3Status)fmi2FreeFMUstate(c, state); }
fmi3Status fmi3SerializedFMUStateSize(fmi3Instance c, fmi3FMUState state, size_t *size) {
    return (fmi3Status)fmi2SerializedFMUstateSize(c, state, size);
}
fmi3Status fmi3SerializeFMUState(fmi3Instance c, fmi3FMUState state, fmi3Byte bytes[], size_t size) {
    return (fmi3Status)fmi2SerializeFMUstate(c, state, (fmi2Byte *)bytes, size);
}
fmi3Status fmi3DeserializeFMUState(fmi3Instance c, const fmi3Byte bytes[], size_t size, fmi3FMUState *state) {
    return (fmi3Status)fmi2DeSerializeFMUstate(c, (const fmi2Byte *)bytes, size, state);
}

fmi3Status fmi3GetDirectionalDerivative(fmi3Instance c, const fmi3ValueReference unknown[], size_t n_unknown,
                                        const fmi3ValueReference known[], size_t n_known, const fmi3Float64 along[],
                                        size_t n_along, fmi3Float64 result[], size_t n_result) {
    (void)n_along;
    (void)n_result;
    return (fmi3Status)fmi2GetDirectionalDerivative(c, unknown, n_unknown, known, n_known, along, result);
}

/* ---- unsupported features: some importers require every function of the standard to exist ---- */
#define NO_VALUES(NAME, TYPE, CONST)                                                                               \
    fmi3Status NAME(fmi3Instance c, const fmi3ValueReference vr[], size_t n, CONST TYPE value[], size_t n_values) { \
        (void)vr;                                                                                                   \
        (void)value;                                                                                                \
        (void)n_values;                                                                                             \
        return n ? (fmi3Status)refuse(M, #NAME ": there are no such variables") : fmi3OK;                          \
    }
#define NO_TYPE(KIND) NO_VALUES(fmi3Get##KIND, fmi3##KIND, ) NO_VALUES(fmi3Set##KIND, fmi3##KIND, const)
NO_TYPE(Float32)
NO_TYPE(Int8)
NO_TYPE(UInt8)
NO_TYPE(Int16)
NO_TYPE(UInt16)
NO_TYPE(UInt32)
NO_TYPE(Int64)
NO_TYPE(UInt64)

#define NONE_OF(NAME, ...) \
    fmi3Status NAME(fmi3Instance c, ##__VA_ARGS__) { return (fmi3Status)refuse(M, #NAME ": not offered"); }
#define VARIABLES const fmi3ValueReference vr[], size_t n
NONE_OF(fmi3GetBinary, VARIABLES, size_t size[], fmi3Binary value[], size_t n_values)
NONE_OF(fmi3SetBinary, VARIABLES, const size_t size[], const fmi3Binary value[], size_t n_values)
NONE_OF(fmi3GetClock, VARIABLES, fmi3Clock value[])
NONE_OF(fmi3SetClock, VARIABLES, const fmi3Clock value[])
NONE_OF(fmi3GetNumberOfVariableDependencies, fmi3ValueReference vr, size_t *n)
NONE_OF(fmi3GetVariableDependencies, fmi3ValueReference vr, size_t of[], fmi3ValueReference on[], size_t element[],
        fmi3DependencyKind kind[], size_t n)
NONE_OF(fmi3GetAdjointDerivative, VARIABLES, const fmi3ValueReference known[], size_t n_known, const fmi3Float64 seed[],
        size_t n_seed, fmi3Float64 result[], size_t n_result)
NONE_OF(fmi3EnterConfigurationMode)
NONE_OF(fmi3ExitConfigurationMode)
NONE_OF(fmi3EnterEventMode)
NONE_OF(fmi3EnterStepMode)
NONE_OF(fmi3EvaluateDiscreteStates)
NONE_OF(fmi3UpdateDiscreteStates, fmi3Boolean *update, fmi3Boolean *terminate, fmi3Boolean *nominals, fmi3Boolean *values,
        fmi3Boolean *has_next, fmi3Float64 *next)
NONE_OF(fmi3GetIntervalDecimal, VARIABLES, fmi3Float64 interval[], fmi3IntervalQualifier qualifier[])
NONE_OF(fmi3GetIntervalFraction, VARIABLES, fmi3UInt64 counter[], fmi3UInt64 resolution[], fmi3IntervalQualifier qualifier[])
NONE_OF(fmi3GetShiftDecimal, VARIABLES, fmi3Float64 shift[])
NONE_OF(fmi3GetShiftFraction, VARIABLES, fmi3UInt64 counter[], fmi3UInt64 resolution[])
NONE_OF(fmi3SetIntervalDecimal, VARIABLES, const fmi3Float64 interval[])
NONE_OF(fmi3SetIntervalFraction, VARIABLES, const fmi3UInt64 counter[], const fmi3UInt64 resolution[])
NONE_OF(fmi3SetShiftDecimal, VARIABLES, const fmi3Float64 shift[])
NONE_OF(fmi3SetShiftFraction, VARIABLES, const fmi3UInt64 counter[], const fmi3UInt64 resolution[])
NONE_OF(fmi3GetOutputDerivatives, VARIABLES, const fmi3Int32 order[], fmi3Float64 value[], size_t n_values)
NONE_OF(fmi3EnterContinuousTimeMode)
NONE_OF(fmi3CompletedIntegratorStep, fmi3Boolean no_set_state, fmi3Boolean *enter, fmi3Boolean *terminate)
NONE_OF(fmi3SetTime, fmi3Float64 time)
NONE_OF(fmi3SetContinuousStates, const fmi3Float64 x[], size_t n)
NONE_OF(fmi3GetContinuousStateDerivatives, fmi3Float64 dx[], size_t n)
NONE_OF(fmi3GetEventIndicators, fmi3Float64 z[], size_t n)
NONE_OF(fmi3GetContinuousStates, fmi3Float64 x[], size_t n)
NONE_OF(fmi3GetNominalsOfContinuousStates, fmi3Float64 x[], size_t n)
NONE_OF(fmi3GetNumberOfEventIndicators, size_t *n)
NONE_OF(fmi3GetNumberOfContinuousStates, size_t *n)
NONE_OF(fmi3ActivateModelPartition, fmi3ValueReference clock, fmi3Float64 time)

static fmi3Instance no_instance(fmi3InstanceEnvironment environment, fmi3LogMessageCallback log) {
    if (log) log(environment, fmi3Error, "logStatusError", "this FMU is for co-simulation only");
    return NULL;
}
fmi3Instance fmi3InstantiateModelExchange(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                          fmi3Boolean logging, fmi3InstanceEnvironment environment,
                                          fmi3LogMessageCallback log) {
    (void)name;
    (void)token;
    (void)resources;
    (void)visible;
    (void)logging;
    return no_instance(environment, log);
}
fmi3Instance fmi3InstantiateScheduledExecution(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                               fmi3Boolean logging, fmi3InstanceEnvironment environment,
                                               fmi3LogMessageCallback log, fmi3ClockUpdateCallback update,
                                               fmi3LockPreemptionCallback lock, fmi3UnlockPreemptionCallback unlock) {
    (void)name;
    (void)token;
    (void)resources;
    (void)visible;
    (void)logging;
    (void)update;
    (void)lock;
    (void)unlock;
    return no_instance(environment, log);
}
