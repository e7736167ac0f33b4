/* The parts of a sample that the loop and exported FMUs share. */
#ifndef ONBOARD_H
#define ONBOARD_H

#include "cycle.h"

const double *driver_demand(const Cycle *c);
void complete_slip(Plant *plant);
void read_sensors(Instruments *instruments, long long sample, const double *outputs);
void store_readings(Cycle *c);
int filter_is_due(const Cycle *c);
void prepare_filter(Cycle *c);
void read_states(Cycle *c);
int read_estimate(Cycle *c);
void observe(Cycle *c);
void replace_by_estimates(Onboard *onboard);
int compute_command(Cycle *c);
void update_rail_inputs(Cycle *c);
void evaluate(const Formula *formula, const double *input, double *output);

#endif
