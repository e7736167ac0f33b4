/* FMI 2.0 for Co-Simulation: the FMU integrates. */

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real t, fmi2Real h, fmi2Boolean no_set_state) {
    State *s = &M->s;
    (void)no_set_state;
    if (s->phase != RUNNING) return refuse(M, "fmi2DoStep", "not initialised, or terminated");
    if (!(h > 0)) return refuse(M, "fmi2DoStep", "the step must be positive");
    if (!(fabs(t - s->v[TIME]) <= 1e-6 * h)) {
        failure(M, "fmi2DoStep: asked for a step from %.9g s, but this FMU is at %.9g s", t, s->v[TIME]);
        return failed(M, fmi2Error);
    }
    if (advance(M, t + h)) return failed(M, fmi2Discard);
    for (int i = 0; i < NX; i++)
        if (!isfinite(s->v[X + i])) {
            failure(M, "%s is not a number at time = %.9g s", x_name[i], s->v[TIME]);
            s->phase = FAILED;
            return failed(M, fmi2Error);
        }
    if (NA) {
        if (NG && loops(M, inside(s, s->v[TIME]), s->v + X)) return failed(M, fmi2Discard);
        if (assertions(M)) {
            s->phase = FAILED;
            return failed(M, fmi2Error);
        }
    }
    return fmi2OK;
}
fmi2Status fmi2CancelStep(fmi2Component c) { return refuse(M, "fmi2CancelStep", "steps are never pending"); }

fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Integer order[],
                                       const fmi2Real value[]) {
    (void)vr;
    (void)order;
    (void)value;
    return n ? refuse(M, "fmi2SetRealInputDerivatives", "inputs are held between communication points") : fmi2OK;
}
fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Integer order[],
                                        fmi2Real value[]) {
    (void)vr;
    (void)order;
    (void)value;
    return n ? refuse(M, "fmi2GetRealOutputDerivatives", "not offered") : fmi2OK;
}
fmi2Status fmi2GetStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Status *value) {
    (void)c;
    (void)kind;
    (void)value;
    return fmi2Discard;
}
fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Real *value) {
    if (kind != fmi2LastSuccessfulTime) return fmi2Discard;
    *value = M->s.v[TIME];
    return fmi2OK;
}
fmi2Status fmi2GetIntegerStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Integer *value) {
    (void)c;
    (void)kind;
    (void)value;
    return fmi2Discard;
}
fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean *value) {
    if (kind != fmi2Terminated) return fmi2Discard;
    *value = M->s.phase == TERMINATED ? fmi2True : fmi2False;
    return fmi2OK;
}
fmi2Status fmi2GetStringStatus(fmi2Component c, const fmi2StatusKind kind, fmi2String *value) {
    if (kind != fmi2DoStepStatus && kind != fmi2PendingStatus) return fmi2Discard;
    *value = M->failure;
    return fmi2OK;
}
