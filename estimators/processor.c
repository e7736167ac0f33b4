/* What the processor of this machine supports. */
#if defined(_WIN32)
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif

#if defined(__x86_64__)
#include <cpuid.h>

/* Whether processor and operating system support AVX2. Not __builtin_cpu_supports: in a shared library it requires a
   symbol that some compilers' runtimes lack. */
EXPORT int has_avx2(void)
{
    unsigned a, b, c, d, saved, unused;
    if (!__get_cpuid(1, &a, &b, &c, &d) || !(c & (1u << 27)) || !(c & (1u << 28)))
        return 0; /* no XSAVE by the system, or no AVX */
    __asm__("xgetbv" : "=a"(saved), "=d"(unused) : "c"(0));
    if ((saved & 6) != 6)
        return 0; /* the system does not save vector registers */
    return __get_cpuid_count(7, 0, &a, &b, &c, &d) && (b & (1u << 5));
}
#else
EXPORT int has_avx2(void)
{
    return 0;
}
#endif
