/* The function that Python calls: the step with the widest vectors that this machine supports. */
#if defined(_WIN32)
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif

int step_plain(double *block);
int step_wide(double *block);

#if defined(__x86_64__)
#include <cpuid.h>

/* Whether processor and operating system support AVX2. Not __builtin_cpu_supports: in a shared library it requires a
   symbol that some compilers' runtimes lack. */
static int has_avx2(void)
{
    unsigned a, b, c, d, saved, unused;
    if (!__get_cpuid(1, &a, &b, &c, &d) || !(c & (1u << 27)) || !(c & (1u << 28)))
        return 0; /* no XSAVE by the system, or no AVX */
    __asm__("xgetbv" : "=a"(saved), "=d"(unused) : "c"(0));
    if ((saved & 6) != 6)
        return 0; /* the system does not save vector registers */
    return __get_cpuid_count(7, 0, &a, &b, &c, &d) && (b & (1u << 5));
}

int dispatch(double *block)
{
    static int wide = -1; /* queried once: on a virtual machine the query takes microseconds */
    if (wide < 0)
        wide = has_avx2();
    return wide ? step_wide(block) : step_plain(block);
}
#else
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
