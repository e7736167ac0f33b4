/* FMI 2.0 for Model Exchange: the importer integrates. */

/* Note that the present values are those of the trajectory. */
static void settle(State *s) {
    s->settled = s->v[TIME];
    memcpy(s->settled_g, s->g, sizeof s->g);
}

fmi2Status fmi2EnterEventMode(fmi2Component c) {
    (void)c;
    return fmi2OK;
}
fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo *info) {
    State *s = &M->s;
    int jumped;
    dependent_parameters(s);
    if (events(M, 0, &jumped) || assertions(M)) return failed(M, fmi2Error);
    settle(s);
    info->newDiscreteStatesNeeded = info->terminateSimulation = info->nominalsOfContinuousStatesChanged = fmi2False;
    info->valuesOfContinuousStatesChanged = jumped ? fmi2True : fmi2False;
    info->nextEventTimeDefined = isfinite(s->hi) ? fmi2True : fmi2False;
    info->nextEventTime = isfinite(s->hi) ? s->hi : 0;
    return fmi2OK;
}
fmi2Status fmi2EnterContinuousTimeMode(fmi2Component c) {
    (void)c;
    return fmi2OK;
}
fmi2Status fmi2CompletedIntegratorStep(fmi2Component c, fmi2Boolean no_set_state, fmi2Boolean *event, fmi2Boolean *terminate) {
    State *s = &M->s;
    double z[NZ + 1];
    (void)no_set_state;
    *event = *terminate = fmi2False;
    if (NG && loops(M, inside(s, s->v[TIME]), s->v + X)) return failed(M, fmi2Error);
    indicators(s, s->v[TIME], s->v + X, z);
    settle(s);
    /* A root that the importer's root finder missed still becomes an event, and so does one without a change of sign. */
    for (int i = 0; i < NZ; i++)
        if (contradicts(s, i, z[i]) && (z[i] == 0 || fabs(z[i]) > 2 * EVENT_EPS)) *event = fmi2True;
    return assertions(M) ? failed(M, fmi2Error) : fmi2OK;
}
fmi2Status fmi2SetTime(fmi2Component c, fmi2Real t) {
    M->s.v[TIME] = t;
    stale(&M->s);
    return fmi2OK;
}
fmi2Status fmi2SetContinuousStates(fmi2Component c, const fmi2Real x[], size_t n) {
    if (n != NX) return refuse(M, "fmi2SetContinuousStates: wrong number of states");
    memcpy(M->s.v + X, x, NX * sizeof *x);
    stale(&M->s);
    return fmi2OK;
}
fmi2Status fmi2GetContinuousStates(fmi2Component c, fmi2Real x[], size_t n) {
    if (n != NX) return refuse(M, "fmi2GetContinuousStates: wrong number of states");
    if (prepare(M)) return failed(M, fmi2Error);
    memcpy(x, M->s.v + X, NX * sizeof *x);
    return fmi2OK;
}
fmi2Status fmi2GetDerivatives(fmi2Component c, fmi2Real dx[], size_t n) {
    if (n != NX) return refuse(M, "fmi2GetDerivatives: wrong number of states");
    if (fresh_derivatives(M)) return failed(M, fmi2Error);
    for (int i = 0; i < NX; i++) {
        if (!isfinite(M->s.v[DX + i])) {
            failure(M, "der(%s) is not a number at time = %.9g s", x_name[i], M->s.v[TIME]);
            if (M->s.v[TIME] == M->s.settled) { /* no smaller step avoids it */
                M->s.phase = FAILED;
                return failed(M, fmi2Error);
            }
            return failed(M, fmi2Discard); /* the importer may try a smaller step */
        }
        dx[i] = M->s.v[DX + i];
    }
    return fmi2OK;
}
fmi2Status fmi2GetEventIndicators(fmi2Component c, fmi2Real z[], size_t n) {
    State *s = &M->s;
    if (n != NZ) return refuse(M, "fmi2GetEventIndicators: wrong number of event indicators");
    if (prepare(M) || (NG && loops(M, inside(s, s->v[TIME]), s->v + X))) return failed(M, fmi2Error);
    indicators(s, s->v[TIME], s->v + X, z);
    /* Hysteresis: when the importer locates the root, the relation has certainly changed. */
    for (int i = 0; i < NZ; i++) z[i] += s->r[indicator_relation[i]] > 0.5 ? EVENT_EPS : -EVENT_EPS;
    return fmi2OK;
}
fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component c, fmi2Real x[], size_t n) {
    if (n != NX) return refuse(M, "fmi2GetNominalsOfContinuousStates: wrong number of states");
    memcpy(x, nominal_x, NX * sizeof *x);
    return fmi2OK;
}
