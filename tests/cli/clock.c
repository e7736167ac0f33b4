/* A wall clock that is put forward and back by days and years at each reading; other clocks run on. */
#define _GNU_SOURCE
#include <sys/syscall.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>
#define OWN __attribute__((visibility("default")))
static long jump(void) {
    static const long days[] = {0, -400, 2, -12000, 4000};
    static unsigned calls;
    return 86400 * days[calls++ % 5];
}
OWN int clock_gettime(clockid_t clock, struct timespec *now) {
    long failed = syscall(SYS_clock_gettime, clock, now);
    if (!failed && clock == CLOCK_REALTIME) now->tv_sec += jump();
    return (int)failed;
}
OWN time_t time(time_t *seconds) {
    struct timespec now;
    clock_gettime(CLOCK_REALTIME, &now);
    if (seconds) *seconds = now.tv_sec;
    return now.tv_sec;
}
OWN int gettimeofday(struct timeval *restrict value, void *restrict zone) {
    struct timespec now;
    clock_gettime(CLOCK_REALTIME, &now);
    *value = (struct timeval){now.tv_sec, now.tv_nsec / 1000};
    (void)zone;
    return 0;
}
