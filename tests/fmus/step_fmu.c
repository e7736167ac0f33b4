/* Step the library of a co-simulation FMU by FMI 2.0 and print its outputs after each step.

   step_fmu LIBRARY GUID PERIOD STEPS [REFERENCE=VALUE ...] [REFERENCE ...]: inputs, which are held, and outputs. */
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmi2FunctionTypes.h"

#ifdef _WIN32
#include <windows.h>
#define OPEN(file) ((void *)LoadLibraryA(file))
#define FIND(library, name) ((void *)GetProcAddress((HMODULE)(library), name))
#else
#include <dlfcn.h>
#define OPEN(file) dlopen(file, RTLD_NOW)
#define FIND(library, name) dlsym(library, name)
#endif

enum { MOST = 64 };

static void say(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status, fmi2String category, fmi2String text, ...)
{
    va_list arguments;

    (void)environment, (void)name, (void)status, (void)category;
    va_start(arguments, text);
    vfprintf(stderr, text, arguments);
    va_end(arguments);
}

static void require(int holds, const char *what)
{
    if (!holds) {
        fprintf(stderr, "%s failed\n", what);
        exit(1);
    }
}

int main(int count, char **arguments)
{
    static const fmi2CallbackFunctions callbacks = {say, calloc, free, NULL, NULL};
    fmi2ValueReference inputs[MOST], outputs[MOST];
    fmi2Real given[MOST], shown[MOST];
    size_t taken = 0, wanted = 0;

    require(count > 4, "reading the arguments");
    for (int i = 5; i < count; i++) {
        const char *value = strchr(arguments[i], '=');
        require(taken < MOST && wanted < MOST, "reading the arguments");
        if (value) {
            inputs[taken] = strtoul(arguments[i], NULL, 10);
            given[taken++] = strtod(value + 1, NULL);
        } else
            outputs[wanted++] = strtoul(arguments[i], NULL, 10);
    }
    void *library = OPEN(arguments[1]);
    require(library != NULL, "loading the library");
#define CALL(name) ((name##TYPE *)FIND(library, #name))
    const double period = strtod(arguments[3], NULL);
    fmi2Component fmu = CALL(fmi2Instantiate)("fmu", fmi2CoSimulation, arguments[2], "", &callbacks, fmi2False, fmi2False);
    require(fmu != NULL, "fmi2Instantiate");
    require(CALL(fmi2SetupExperiment)(fmu, fmi2False, 0.0, 0.0, fmi2False, 0.0) == fmi2OK, "fmi2SetupExperiment");
    require(CALL(fmi2EnterInitializationMode)(fmu) == fmi2OK, "fmi2EnterInitializationMode");
    require(CALL(fmi2SetReal)(fmu, inputs, taken, given) == fmi2OK, "fmi2SetReal");
    require(CALL(fmi2ExitInitializationMode)(fmu) == fmi2OK, "fmi2ExitInitializationMode");
    for (long step = 0; step < strtol(arguments[4], NULL, 10); step++) {
        require(CALL(fmi2SetReal)(fmu, inputs, taken, given) == fmi2OK, "fmi2SetReal");
        require(CALL(fmi2DoStep)(fmu, step * period, period, fmi2True) == fmi2OK, "fmi2DoStep");
        require(CALL(fmi2GetReal)(fmu, outputs, wanted, shown) == fmi2OK, "fmi2GetReal");
        for (size_t i = 0; i < wanted; i++)
            printf("%.17g%c", shown[i], i + 1 < wanted ? ' ' : '\n');
    }
    require(CALL(fmi2Terminate)(fmu) == fmi2OK, "fmi2Terminate");
    CALL(fmi2FreeInstance)(fmu);
    return 0;
}
