/* The onboard parts in a sample: readings, estimate, decision. */
#ifndef ONBOARD_H
#define ONBOARD_H

#include "cycle.h"

void complete_slip(Cycle *c);
void read_sensors(Cycle *c);
void see(Cycle *c);
int filters(const Cycle *c);
void show_filter(Cycle *c);
void look(Cycle *c);
int believe(Cycle *c);
void observe(Cycle *c);
void observe_with_estimates(Cycle *c);
int command(Cycle *c);

#endif
