"""Decisions on top of a law's demands for its groups: limits, shared valves, redistribution, releases that end."""

from collections.abc import Sequence
from dataclasses import asdict
from functools import reduce
from itertools import accumulate
from operator import add
from typing import Literal

from railgrip.controllers.law import GroupObservation, Law, by_name, pressure_for
from railgrip.controllers.law import law as formula_of_law
from railgrip.controllers.sampled import Expression, FormulaBuilder, Symbols, choose, every, time_release
from railgrip.vehicle.brake import Brake
from railgrip.vehicle.signals import TRAIN_INPUTS

Choice = Literal["lowest", "mean"]
"""Demand of groups that share a valve: the lowest of their demands, or the mean."""

PAD_FRICTION = 0.35
"""Friction assumed for pads whose friction is not estimated: the nominal value of the built-in trains."""

T_REDISTRIBUTION = 0.3
"""Time constant [s] of the demand on other groups, longer than a pulse of a slip controller."""


RELEASED = 0.05
"""Share of the driver's demand below which a group counts as released: its pads have no effect worth mentioning."""

T_APPLIED = 1.0
"""Time [s] for which a group is braked after a release that lasted too long, as in `wheel_reference`."""


def pass_through(groups: Sequence[Brake]) -> Law:
    """Return a law whose input `demand` is also its output."""

    def demands(draft: FormulaBuilder, tuning: Symbols, train: Sequence[GroupObservation]) -> list[Expression]:
        return [group.demand for group in train]

    formula = formula_of_law("PassThrough", "Demands its input", len(groups), demands, observed=TRAIN_INPUTS)
    return Law(formula, groups, {})


def within_brake(law: Law, groups: Sequence[Brake]) -> Law:
    """Return a law whose demands are limited to 0 … pressure_max; a demand of NaN becomes full pressure."""
    draft, demands = FormulaBuilder.reopen(law.formula)
    parameters = draft.symbols("parameter")
    most = [parameters[f"pressure_max[{g}]"] for g in range(1, len(demands) + 1)]
    limited = [choose(p <= 0.0, 0.0, choose(p < full, p, full)) for p, full in zip(demands, most, strict=True)]
    return _law(law, groups, draft, limited)


def with_shared_valves(law: Law, groups: Sequence[Brake], groups_per_valve: Sequence[int], choice: Choice) -> Law:
    """Return a law that demands the same share of the highest pressure from all groups of a valve.

    The valve fills or vents all of its cylinders at once, and their highest pressures may differ.
    """
    draft, demands = FormulaBuilder.reopen(law.formula)
    parameters = draft.symbols("parameter")
    shared: list[Expression] = []
    for end, count in zip(accumulate(groups_per_valve), groups_per_valve, strict=True):
        members = range(end - count, end)
        full = [parameters[f"pressure_max[{g + 1}]"] for g in members]
        shares = [demands[g] / pressure for g, pressure in zip(members, full, strict=True)]
        share = reduce(add, shares) / count if choice == "mean" else reduce(_lower, shares)
        # With one group per valve the demand must not change by rounding.
        shared += [share * pressure for pressure in full] if count > 1 else [demands[end - 1]]
    return _law(law, groups, draft, shared)


def with_redistribution(law: Law, groups: Sequence[Brake], *, period: float, adhesion_max: float) -> Law:
    """Return a law that compensates, on groups with spare adhesion, for force that other groups cannot transmit.

    A group provides the lower of the driver's demand and its law's. The missing force, filtered with
    `T_REDISTRIBUTION`, is demanded from the groups whose laws allow more than the driver demands, each by the same
    share of its reserve, up to its highest pressure and to `adhesion_max` of its load. With full brake there is no
    reserve. The loop must not limit the results to the driver's demand again: single groups exceed it, the train does
    not.
    """
    draft, demands = FormulaBuilder.reopen(law.formula)
    inputs, parameters = draft.symbols("input"), draft.symbols("parameter")
    missing, available = 0.0, 0.0
    granted: list[Expression] = []
    reserves: list[Expression] = []
    for g, demand in enumerate(demands, start=1):
        brake = {name: parameters[f"{name}[{g}]"] for name in asdict(groups[0])}
        estimated = inputs[f"pad_friction[{g}]"]
        # The condition is false for NaN, the input without an estimator.
        friction = choose(estimated > 0.0, estimated, PAD_FRICTION)
        # Force at the rail per pressure; the spring force cancels in differences of pressure.
        gain = brake["units"] * friction * brake["friction_radius"] * brake["rigging"] * brake["piston_area"]
        gain = gain / brake["wheel_radius"]
        request = inputs[f"driver_demand[{g}]"]
        grant = _lower(demand, request)
        limit = _lower(demand, pressure_for(adhesion_max * brake["load"] * brake["wheel_radius"], friction, brake))
        reserve = choose(limit > request, limit - request, 0.0)
        missing, available = missing + gain * (request - grant), available + gain * reserve
        granted.append(grant)
        reserves.append(reserve)
    last = _add_state(draft, "missing", "N", "force that groups cannot give, filtered")
    filtered = last + period / (T_REDISTRIBUTION + period) * (missing - last)
    draft.keep(last, filtered)
    share = choose(filtered < available, filtered / choose(available > 0.0, available, 1.0), 1.0)
    results = [grant + share * reserve for grant, reserve in zip(granted, reserves, strict=True)]
    return _law(law, groups, draft, results)


def with_release_limit(law: Law, groups: Sequence[Brake], *, period: float, release_max: float) -> Law:
    """Return a law that demands the driver's pressure from a group after a release of `release_max` [s].

    The group is braked for `T_APPLIED`, whatever the law demands; then it may be released again. It is for what a law
    cannot notice itself, such as a dead speed sensor. EN 15595 requires a monitor of wheel-slide protection.
    """
    draft, demands = FormulaBuilder.reopen(law.formula)
    inputs, results = draft.symbols("input"), list[Expression]()
    for g, demand in enumerate(demands, start=1):
        time = _add_state(draft, f"release_time[{g}]", "s", "since the begin of a release")
        request = inputs[f"driver_demand[{g}]"]
        is_released = demand < RELEASED * request
        results.append(choose(every(time >= release_max, demand < request), request, demand))
        draft.keep(time, time_release(time, is_released, period=period, longest=release_max, applied=T_APPLIED))
    return _law(law, groups, draft, results)


def _add_state(draft: FormulaBuilder, name: str, unit: str, description: str) -> Expression:
    # A user's law may have a state of the same name.
    names = draft.symbols("state")
    while name in names:
        name = f"_{name}"
    return draft.state(name, unit, description)


def _lower(this: Expression, other: Expression) -> Expression:
    return choose(this < other, this, other)


def _law(law: Law, groups: Sequence[Brake], draft: FormulaBuilder, demands: Sequence[Expression]) -> Law:
    for output, demand in zip(law.formula.outputs, demands, strict=True):
        draft.output(output.name, output.unit, output.description, demand)
    # The data of `groups` replace those that the law was made with.
    brakes = by_name(groups)
    values = dict(zip((variable.name for variable in law.formula.parameters), law.parameters.tolist(), strict=True))
    own = {name: value for name, value in values.items() if name not in brakes}
    wrapped = Law(draft.formula(law.formula.name, law.formula.description), groups, own)
    wrapped.needs = law.needs
    # The states of the law come first. Their start values may follow from its parameters, not from the formula.
    wrapped.state[: law.state.size] = law.state
    return wrapped
