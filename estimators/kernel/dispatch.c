/* The one function that Python calls: the widest step this machine can take. */
#if defined(_WIN32)
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif

int step_plain(double *block);
int step_wide(double *block);

EXPORT int step(double *block)
{
#if defined(__x86_64__)
    if (__builtin_cpu_supports("avx2"))
        return step_wide(block);
#endif
    return step_plain(block);
}
