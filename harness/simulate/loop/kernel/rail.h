/* What the track does to the train. */
#ifndef RAIL_H
#define RAIL_H

#include "export.h"
#include "layout.h"

typedef struct {
    double *energy;                              /* of each cell: what slip has dissipated in it, of one wheel of each pair [J/m] */
    const double *position;                      /* of each wheelset behind the leading one */
    const long long *group;                      /* that it belongs to */
    double origin, length;                       /* where the first cell begins; of a cell */
    double rate;                                 /* of the recovery [m/J] */
    double clean, clean_A, clean_B;              /* friction of the clean rail, and how it falls with slip speed */
    double A[WHEELSETS], B[WHEELSETS];           /* how that of the rail as laid does, at each wheelset */
    double place[WHEELSETS], loss[WHEELSETS];   /* at the last sample: where, and the energy of the slip [J/m] */
    double met[WHEELSETS], left[WHEELSETS];      /* in the present cell: left by those ahead [J/m], by the wheelset itself [J] */
    long long cell[WHEELSETS];
    long long cells, begun;
} Recovery;

typedef struct {
    double rate, density;                        /* of one rail: the most [kg/s], and what it keeps on it if that allows [kg/m] */
    double begin, end;                           /* while sand comes to the rail [s] */
    long long wheelset;                          /* in front of which it lies */
} Sander;

typedef struct {
    double *lying;                               /* of each cell: for the wheelsets to come [kg/m] */
    const double *position;                      /* of each wheelset behind the leading one */
    const Sander *sanders;
    double origin, length;                       /* where the first cell begins; of a cell */
    double mu0, density, left;                   /* friction with plenty of sand; sand that gains 63 % of it; share that a wheelset leaves */
    double met[WHEELSETS];                       /* in the present cell [kg/m] */
    long long cell[WHEELSETS];
    long long count, cells, begun;               /* count: of the sanders */
} Sand;

typedef struct {
    const double *friction;                      /* as it lies, on an even grid: points x WHEELSETS */
    const double *curves;                        /* k_A, k_S, A, B of each creep curve */
    const unsigned char *curve_at;               /* which of them lies there: points x WHEELSETS; null: the plant has its own */
    const double *begins, *forces, *rates;       /* of the force: straight in sections */
    double grid, force;
    double mu0[WHEELSETS];
    double curve[4 * WHEELSETS];                 /* k_A of each wheelset, k_S, A, B */
    long long points, over_time, sections, section;   /* section: the last one */
    Recovery *recovery;                          /* null: slip leaves friction as it lies */
    Sand *sand;                                  /* null: no sander */
} Rail;

void advance_rail(Rail *its, double time, const double *truth);
void write_rail_inputs(const Rail *its, double *inputs);

#endif
