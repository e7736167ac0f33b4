/* A train as an FMI 2.0 FMU for tests, with the names and units of this project: it slows down as it is braked, and
 * after a tenth of a second, or at the start, it misbehaves in one way.
 *
 * Value references: 0-3 pressure_command, 4-9 mu0, 10 start_speed, 11 distance, 12 speed, 13 acceleration,
 * 14-17 wheelset_speed, 18-21 cylinder_pressure.                                                                */
#define _GNU_SOURCE
#include <fcntl.h>
#include <math.h>
#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/prctl.h>
#include <unistd.h>
#include "quiet.h"
#include "reals_only.h"

#define WELL 0
#define ERROR_STATUS 1
#define DISCARD 2
#define NAN_OUTPUT 3
#define NEVER_RETURNS 4
#define NEVER_HALTS 5
#define CRASH 6
#define NEVER_STARTS 7
#define NEVER_INSTANTIATES 8
#define FORKS 9             /* processes that leave group and session and never end */
#define KILLS_PARENT 10     /* having left such a process behind, and refusing to go with its parent */
#define ALLOCATES 11
#define OPENS_FILES 12
#define FORGES 13           /* sends a forged answer on every open socket */
#define TALKS 14            /* as OpenModelica's FMUs do of their solver */
#define LOGS 15             /* ten thousand messages a step */
#define PRINTS 16           /* two megabytes a step */
#define CLOSES 17           /* every descriptor that it finds open */
#define CRASHES_IN_TERMINATE 18
#define CRASHES_IN_FREE 19
#define TALKS_AT_ONCE 20
#define SLEEPS 21          /* a fifth of a second a step */
#define WARNS 22           /* in each step, with the time */
#define WARNS_IN_SILENCE 23
#define LOGS_FROM_A_THREAD 24
#define REFERS 25          /* to variables by their references */

#ifndef RADIUS
#define RADIUS 0.38
#endif
#ifndef SIGN
#define SIGN 1 /* of the acceleration that it shows */
#endif
#ifndef GRIP
#define GRIP 9.81 /* m/s2 at friction of 1 */
#endif
#ifndef SPEED_UNIT
#define SPEED_UNIT 1 /* m/s */
#endif
#ifndef PRESSURE_UNIT
#define PRESSURE_UNIT 1 /* Pa */
#endif
#define SOON 0.1 /* s */
#define RATE 4e-6 /* m/s2 per Pa */

typedef struct {
    const fmi2CallbackFunctions *call;
    double t, v[22];
} FaultyFmu;

static void *speak(void *c) {
    FaultyFmu *m = c;
    m->call->logger(m->call->componentEnvironment, "faulty_fmu", fmi2Warning, "logStatusWarning", "a worker speaks");
    return NULL;
}
/* A process that belongs to nobody; its number goes to a file that the test reads. */
static void leave_one_behind(void) {
    int written[2];
    char end;
    if (pipe(written)) return;
    if (fork() == 0) {
        setsid();
        if (fork() == 0) {
            FILE *f = fopen(getenv("MULE_LEFT_BEHIND"), "a");
            fprintf(f, "%d\n", (int)getpid());
            fclose(f);
            close(written[1]);
            for (;;) pause();
        }
        _exit(0);
    }
    close(written[1]);
    while (read(written[0], &end, 1) > 0) continue; /* until the process has closed it */
}

static void talk(void) {
    printf("first word\nLOG_SOLVER        | info    | CVODE linear multistep method CV_BDF\n");
    printf("LOG_SOLVER        | info    | CVODE maximum integration order CV_ITER_NEWTON\n");
    printf("|                 | |       | | CVODE use equidistant time grid YES\nlast word\n");
}
fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *call, fmi2Boolean visible, fmi2Boolean logging) {
    (void)name; (void)type; (void)guid; (void)resources; (void)visible; (void)logging;
    if (MISBEHAVIOUR == NEVER_INSTANTIATES) for (volatile int k = 0;; k = 0) { (void)k; }
    FaultyFmu *m = call->allocateMemory(1, sizeof *m);
    m->call = call;
    m->v[10] = 20;
    if (MISBEHAVIOUR == TALKS_AT_ONCE) talk();
    return m;
}
void fmi2FreeInstance(fmi2Component c) { if (MISBEHAVIOUR == CRASHES_IN_FREE) abort(); if (c) ((FaultyFmu *)c)->call->freeMemory(c); }
fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean td, fmi2Real tol, fmi2Real t, fmi2Boolean sd, fmi2Real stop) {
    (void)c; (void)td; (void)tol; (void)t; (void)sd; (void)stop;
    if (MISBEHAVIOUR == TALKS) talk();
    return fmi2OK;
}
static void show(FaultyFmu *m) {
    for (int i = 0; i < 4; i++) { m->v[14 + i] = m->v[12] / RADIUS; m->v[18 + i] = m->v[i]; }
}
fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
    FaultyFmu *m = c;
    m->v[12] = m->v[10];
    show(m);
    return MISBEHAVIOUR == NEVER_STARTS ? fmi2Error : fmi2OK;
}
fmi2Status fmi2Terminate(fmi2Component c) { (void)c; if (MISBEHAVIOUR == CRASHES_IN_TERMINATE) abort(); return fmi2OK; }
static double unit_of(fmi2ValueReference vr) {
    return vr == 12 ? SPEED_UNIT : vr < 4 || vr > 17 ? PRESSURE_UNIT : 1;
}
fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real v[]) {
    for (size_t i = 0; i < n; i++) v[i] = ((FaultyFmu *)c)->v[vr[i]] / unit_of(vr[i]);
    return fmi2OK;
}
fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Real v[]) {
    for (size_t i = 0; i < n; i++) ((FaultyFmu *)c)->v[vr[i]] = v[i] * unit_of(vr[i]);
    return fmi2OK;
}
fmi2Status fmi2DoStep(fmi2Component c, fmi2Real t, fmi2Real h, fmi2Boolean no) {
    FaultyFmu *m = c;
    (void)no;
    if (t >= SOON) switch (MISBEHAVIOUR) {
        case ERROR_STATUS:
            m->call->logger(m->call->componentEnvironment, "faulty_fmu", fmi2Error, "logStatusError", "the wheel came off");
            return fmi2Error;
        case DISCARD: return fmi2Discard;
        case NEVER_RETURNS:
            if (getenv("FAULTY_MARKER")) fclose(fopen(getenv("FAULTY_MARKER"), "w"));
            for (volatile int k = 0;; k = 0) { (void)k; }
        case CRASH: { volatile int *nowhere = NULL; *nowhere = 1; break; }
        case FORKS:
            for (int k = 0; k < 3; k++) leave_one_behind();
            return fmi2Error;
        case KILLS_PARENT:
            leave_one_behind();
            prctl(PR_SET_PDEATHSIG, 0);
            kill(getppid(), SIGKILL);
            for (;;) pause();
        case ALLOCATES:
            for (;;) { volatile char *more = malloc(1 << 24); for (size_t k = 0; k < 1 << 24; k += 4096) more[k] = 1; }
        case OPENS_FILES: {
            char text[64];
            int count = 0;
            while (open("/dev/null", O_RDONLY) >= 0 && count < 100000) count++;
            snprintf(text, sizeof text, "%s", count < 1000 ? "no more files" : "as many files as it likes");
            m->call->logger(m->call->componentEnvironment, "faulty_fmu", fmi2Error, "logStatusError", text);
            return fmi2Error;
        }
        case FORGES: {
            /* FAILED, five bytes long, and as a pickle: call exit. */
            const unsigned char answer[] = { FORGED };
            for (int k = 3; k < 64; k++) if (write(k, answer, sizeof answer) < 0) continue;
            for (;;) pause();
        }
        case LOGS:
            for (int k = 0; k < 10000; k++)
                m->call->logger(m->call->componentEnvironment, "faulty_fmu", fmi2OK, "logStatusError", "a word");
            break;
        case PRINTS:
            for (int k = 0; k < 20000; k++) printf("%99d\n", k);
            fflush(stdout);
            break;
        case LOGS_FROM_A_THREAD: {
            pthread_t worker;
            pthread_create(&worker, NULL, speak, m);
            pthread_join(worker, NULL);
            break;
        }
        case WARNS:
            m->call->logger(m->call->componentEnvironment, "faulty_fmu", fmi2Warning, "logStatusWarning",
                            "table of brake force is extrapolated at %g s", t);
            break;
        case REFERS:
            m->call->logger(m->call->componentEnvironment, "faulty_fmu", fmi2Error, "logStatusError",
                            "#r12# is above #r99#, see ##5");
            return fmi2Error;
        case SLEEPS: usleep(200000); break;
        case CLOSES:
            for (int k = 0; k < 1024; k++) close(k);
            break;
        default: break;
    }
    const double braked = fmin(RATE * (m->v[0] + m->v[1] + m->v[2] + m->v[3]) / 4, GRIP * m->v[4]);
    m->v[13] = SIGN * (MISBEHAVIOUR == NEVER_HALTS && m->v[12] < 5 ? 0 : -braked);
    m->v[11] += h * m->v[12];
    m->v[12] = fmax(0, m->v[12] + h * SIGN * m->v[13]);
    show(m);
    if (MISBEHAVIOUR == NAN_OUTPUT && t >= SOON) m->v[12] = NAN;
    return (MISBEHAVIOUR == WARNS || MISBEHAVIOUR == WARNS_IN_SILENCE) && t >= SOON ? fmi2Warning : fmi2OK;
}
fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference z[], size_t nz,
                                        const fmi2ValueReference w[], size_t nw, const fmi2Real dw[], fmi2Real dz[]) {
    (void)c; (void)z; (void)nz; (void)w; (void)nw; (void)dw; (void)dz; return fmi2Error;
}
fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind k, fmi2Real *v) {
    (void)c; (void)k; (void)v; return fmi2Discard;
}
fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind k, fmi2Boolean *v) {
    (void)c; (void)k; (void)v; return fmi2Discard;
}
