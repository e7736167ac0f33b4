/* The track: friction, sand and track force. */
#ifndef RAIL_H
#define RAIL_H

#include "export.h"
#include "layout.h"

/* Symbols are those of `SlipEnergy` in scenario/surface.py. */
typedef struct {
    double *energy;                              /* slip energy dissipated in each cell, per wheel of each pair [J/m] */
    const double *position;                      /* distance of each wheelset behind the leading one */
    const long long *group;                      /* group of each wheelset */
    double origin, length;                       /* start of the first cell; length of a cell */
    double rate;                                 /* tau [m/J] */
    double clean, clean_A, clean_B;              /* friction of the clean rail, and its fall with slip speed */
    double A[WHEELSETS], B[WHEELSETS];           /* the same fall for the untreated rail, at each wheelset */
    double location[WHEELSETS], loss[WHEELSETS]; /* at the last sample: place on the track [m]; W, per wheel [J/m] */
    double energy_ahead[WHEELSETS];              /* E: energy in the present cell by the wheelsets ahead [J/m] */
    double energy_own[WHEELSETS];                /* energy in the present cell by this wheelset [J] */
    long long cell[WHEELSETS];
    long long cells, has_started; /* has_started: whether `location`, `cell` and `loss` are set */
} Recovery;

typedef struct {
    double rate, density; /* per rail: maximum rate [kg/s]; density kept while the rate suffices [kg/m] */
    double begin, end;    /* interval in which sand reaches the rail [s] */
    double delay, filled; /* from the box to the rail [s]; time of the demand for sand, at most `delay` [s] */
    long long wheelset;   /* in front of which the sand falls */
    long long is_flowing; /* whether the demand for sand has reached the rail */
} Sander;

typedef struct {
    double *deposited;      /* of each cell: sand for the wheelsets to come [kg/m] */
    const double *position; /* distance of each wheelset behind the leading one */
    Sander *sanders;
    const double *is_demanded;       /* whether the controller demands sand; null: throughout */
    double origin, length;           /* start of the first cell; length of a cell */
    double time;                     /* of the last sample */
    double mu0, density;             /* friction with plenty of sand; sand for 1 - 1/e of the gain */
    double remaining_share;          /* sand behind a wheelset, as a share of the sand ahead of it */
    double density_ahead[WHEELSETS]; /* sand in the present cell [kg/m] */
    long long cell[WHEELSETS];
    long long count, cells, has_started; /* count: number of sanders */
} Sand;

typedef struct {
    const double *friction;                /* untreated, on an even grid: points x WHEELSETS */
    const double *curves;                  /* k_A, k_S, A, B of each creep curve */
    const unsigned char *curve_at;         /* index of the curve: points x WHEELSETS; null: the plant has a fixed one */
    const double *begins, *forces, *rates; /* force of the track if the train were at one place: linear in sections */
    const double *behind, *share;          /* of each wheelset: distance behind the leading one; share of the mass */
    const long long *car;                  /* of each wheelset */
    double grid, force;                    /* spacing of the grid [m, or s with over_time]; present track force */
    double mu0[WHEELSETS];
    double curve[4 * WHEELSETS];   /* k_A of each wheelset, then k_S, A, B */
    double car_force[CARS];        /* track force on each car, beyond its share by mass */
    long long section[WHEELSETS];  /* in which each wheelset is */
    long long points, over_time, sections;
    Recovery *recovery;                             /* null: slip does not change friction */
    Sand *sand;                                     /* null: no sander */
} Rail;

void advance_rail(Rail *rail, double time, const double *outputs);
void write_rail_inputs(const Rail *rail, double *inputs);

#endif
