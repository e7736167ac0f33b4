/* The contact law at many points, which the search for the peak of the creep curve evaluates a million times per stop.

   contact.h is generated next to this file: `contact`, a function of (point, curve, fixed) by CasADi, and the positions
   of slip, speed, load and mu0 in a point. */

#include <stddef.h>

#include "contact.h"

#if defined(_WIN32)
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif

/* `curves` is CURVE x `different`: one curve per point, different = count, or one for all, different = 1. */
EXPORT void contact_at(size_t count, const double *slip, const double *speed, const double *load, const double *mu0,
                       const double *curves, size_t different, const double *fixed, double *adhesion)
{
    double point[4], curve[CURVE];

    for (size_t i = 0; i < count; i++) {
        const double *arguments[ARGUMENTS] = {point, curve, fixed};
        double *results[RESULTS] = {adhesion + i};
        point[SLIP] = slip[i];
        point[SPEED] = speed[i];
        point[LOAD] = load[i];
        point[MU0] = mu0[i];
        for (int j = 0; j < CURVE; j++)
            curve[j] = curves[j * different + (different == 1 ? 0 : i)];
        call(contact, arguments, results);
    }
}
