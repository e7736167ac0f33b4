/* The step for x86-64 with AVX2: vectors of four doubles, the same bits in about 60 % of the time. */
#if defined(__x86_64__)
#if defined(__clang__)
#pragma clang attribute push(__attribute__((target("avx2"))), apply_to = function)
#else
#pragma GCC target("avx2")
#endif
#define LANE_BYTES 32
#define STEP step_wide
#include "step.h"
#if defined(__clang__)
#pragma clang attribute pop
#endif
#endif
