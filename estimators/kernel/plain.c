/* The step for any machine: vectors of two doubles, which every x86-64 and ARM64 supports. */
#define LANE_BYTES 16
#define STEP step_plain
#include "step.h"
