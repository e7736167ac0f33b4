/* Measures the time of each step of the library for inputs from a CSV file, one row for each step, and the memory that a
 * step uses. Each step is repeated REPEATS times, because the shortest time excludes interruptions by the operating
 * system. It requires POSIX and 64 bits.
 *
 * The generated file comes first: the header of the library, and its names as START, STEP, State, Inputs, Outputs, PERIOD
 * and LIBRARY. */
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { REPEATS = 10, STACK = 1 << 20, PAINT = 0xA5, INPUTS = sizeof(Inputs) / sizeof(double) };

static State state;
static Inputs *rows;
static size_t count;

static double seconds(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static void read_rows(const char *file) {
    static char line[1 << 16];
    FILE *stream = fopen(file, "r");
    if (!stream || !fgets(line, sizeof line, stream)) {
        fprintf(stderr, "%s: there are no rows to read\n", file);
        exit(2);
    }
    while (fgets(line, sizeof line, stream)) {
        double values[INPUTS];
        char *at = line;
        for (int i = 0; i < INPUTS; i++) {
            char *end;
            values[i] = strtod(at, &end);
            if (end == at) {
                fprintf(stderr, "%s: row %zu has %d values, wanted are %d\n", file, count + 1, i, (int)INPUTS);
                exit(2);
            }
            at = end + (*end == ',');
        }
        if (count % 4096 == 0) rows = realloc(rows, (count + 4096) * sizeof *rows);
        memcpy(rows + count++, values, sizeof values);
    }
    fclose(stream);
}

static void *nothing(void *unused) { return unused; }
static void *steps(void *unused) {
    Outputs outputs;
    START(&state);
    for (size_t k = 0; k < count; k++) (void)STEP(&state, rows + k, &outputs);
    return unused;
}

/* Number of bytes of its stack that a thread has written. */
static size_t stack_of(void *(*work)(void *)) {
    unsigned char *stack = NULL;
    size_t untouched = 0;
    pthread_attr_t attributes;
    pthread_t thread;
    if (posix_memalign((void **)&stack, 4096, STACK)) exit(2);
    memset(stack, PAINT, STACK);
    pthread_attr_init(&attributes);
    pthread_attr_setstack(&attributes, stack, STACK);
    if (pthread_create(&thread, &attributes, work, NULL) || pthread_join(thread, NULL)) exit(2);
    while (untouched < STACK && stack[untouched] == PAINT) untouched++;
    free(stack);
    return STACK - untouched;
}

static int rising(const void *a, const void *b) {
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

int main(int n, char **arguments) {
    Outputs outputs;
    double *least, most = 0;
    read_rows(n > 1 ? arguments[1] : "readings.csv");
    least = malloc(count * sizeof *least);
    for (size_t repeat = 0; repeat < REPEATS; repeat++) {
        START(&state);
        for (size_t k = 0; k < count; k++) {
            const double begin = seconds();
            const int failed = STEP(&state, rows + k, &outputs);
            const double took = seconds() - begin;
            if (took > most) most = took;
            if (!repeat || took < least[k]) least[k] = took;
            if (failed) {
                fprintf(stderr, "%s: step %zu failed\n", LIBRARY, k);
                return 1;
            }
        }
    }
    qsort(least, count, sizeof *least, rising);
    printf("%s: %zu steps of %g s, each run %d times\n", LIBRARY, count, (double)PERIOD, (int)REPEATS);
    printf("step: median %.2f us, worst %.2f us; longest with interruptions %.2f us\n", 1e6 * least[count / 2],
           1e6 * least[count - 1], 1e6 * most);
    printf("memory: state %zu bytes, stack %zu bytes\n", sizeof(State), stack_of(steps) - stack_of(nothing));
    return 0;
}
