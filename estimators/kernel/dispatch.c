/* The function that Python calls: the step with the widest vectors that this machine supports, the only one compiled. */
#if defined(_WIN32)
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif

#if defined(WIDE)
#define STEP step_wide
#else
#define STEP step_plain
#endif

int STEP(double *block);

int dispatch(double *block)
{
    return STEP(block);
}

/* Not called within this library: the C library also has a `step`, which the linker might choose. */
EXPORT int step(double *block)
{
    return dispatch(block);
}
