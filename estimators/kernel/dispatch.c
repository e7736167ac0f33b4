/* The function that Python calls: the step with the widest vectors that this machine supports, the only one compiled. */
#if defined(_WIN32)
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif

#if defined(WIDE)
int step_wide(double *block);

int dispatch(double *block)
{
    return step_wide(block);
}
#else
int step_plain(double *block);

int dispatch(double *block)
{
    return step_plain(block);
}
#endif

/* Not called within this library: the C library also has a `step`, which the linker might choose. */
EXPORT int step(double *block)
{
    return dispatch(block);
}
