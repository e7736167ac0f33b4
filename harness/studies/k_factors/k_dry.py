"""K_dry of a brake: by importance sampling of the quasi-static brake, by subset simulation of stops in the loop."""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np
from scipy.special import ndtri

from railgrip.base.errors import ScenarioError
from railgrip.campaign.work import Work
from railgrip.estimators.belief import Array
from railgrip.scenario.quantity import Magnitude
from railgrip.scenario.schema import Scenario
from railgrip.scenario.seed import generator
from railgrip.simulate.run import braking_distance
from railgrip.simulate.vehicle import VehicleData
from railgrip.studies.k_factors import rare
from railgrip.studies.k_factors.brake import QuasiStaticBrake
from railgrip.studies.k_factors.rare import Rates, Sample, State
from railgrip.studies.k_factors.specification import Failures, KFactorSpecification
from railgrip.trace.k_wet import Interval

PROBABILITIES = (0.5, *(10.0**-level for level in range(1, 10)))
"""Probability of a deceleration below K times the nominal one, for EBCL 0 to 9 (SUBSET-040, K_dry_rst)."""

_CONFIDENCE = 0.95
_RATES = 1000
"""Draws of the failure rates, of which 25 are beyond either end of an interval."""

_NEGLECT = 1e-3
"""Maximum probability of neglected failure states, as a share of the smallest probability required."""
_NEGLECT_IN_LOOP = 0.25
"""The same if each state takes hundreds of stops; the interval shows the loss of accuracy."""
_SCALING = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class QuasiStatic:
    """K of the quasi-static brake.

    Attributes:
        runs: For each output, the sample of each run.
        k: For each output, K of EBCL 0 to 9, with the interval of sampling alone.
        k_of_rates: The same with the interval that also holds the uncertainty of the failure rates.
        states: Failure states that were sampled.
        neglected: Probability of all other failure states.
    """

    runs: tuple[tuple[Sample, ...], ...]
    k: tuple[tuple[Interval, ...], ...]
    k_of_rates: tuple[tuple[Interval, ...], ...]
    states: tuple[State, ...]
    neglected: float
    seconds: float

    @property
    def draws(self) -> int:
        """Draws in all runs."""
        return sum(len(run.values) for run in self.runs[0])


def brake_of_scenario(specification: KFactorSpecification, scenario: Scenario) -> QuasiStaticBrake:
    """Return the quasi-static brake of a scenario's plant.

    Raises:
        ScenarioError: The plant is not such a train, its cylinders are not filled by valves, or the demand is not full
            brake.
    """
    if scenario.actuation.kind != "pneumatic":
        raise ScenarioError(
            f"{scenario.name}: [actuation] kind is '{scenario.actuation.kind}'; K factors need 'pneumatic', because "
            "pressures and fill times of the cylinders disperse."
        )
    if scenario.demand is not None:
        raise ScenarioError(f"{scenario.name}: K factors are of full brake from the start on: leave out [demand]")
    vehicle = VehicleData(scenario)
    speeds = (scenario.start.speed, *reversed(specification.speed_steps), 0.0)
    return QuasiStaticBrake(vehicle.true.parameters, vehicle.formation, specification.dispersion, speeds)


def quasi_static(
    specification: KFactorSpecification, brake: QuasiStaticBrake, notify: Callable[[str], None] = lambda what: None
) -> QuasiStatic:
    """Return K of the quasi-static brake for all EBCL; the same specification gives the same numbers."""
    begin = time.perf_counter()
    effort, smallest = specification.estimate, PROBABILITIES[-1]
    rates = _rates(specification.failures)
    # As deep and as many as the highest rates require, because the intervals include these rates.
    highest = _rates(specification.failures, float(ndtri((1 + _CONFIDENCE) / 2)))
    deep, neglected = rare.states_of(brake.units, highest, neglect=_NEGLECT * smallest)
    available = [state.available for state in deep]
    probabilities = rates.of_states(brake.units, available).tolist()
    states = tuple(State(*state) for state in zip(available, probabilities, strict=True))
    parts: list[list[list[Sample]]] = [[[] for _ in range(effort.runs)] for _ in brake.outputs]
    for number, state in enumerate(deep, start=1):
        notify(f"failure state {number} of {len(deep)}")
        performance = partial(brake.ratios, state.available)
        points = rare.worst_points(performance, brake.dimension, rare.depth(state, smallest))
        random = generator(specification.seed, f"k_factors {state.available}")
        for run in range(effort.runs):
            ratios, weights = rare.importance_sample(performance, points, effort.samples, random)
            for output, of_output in enumerate(parts):
                of_output[run].append(Sample(ratios[:, output], weights))
    shares = [state.probability for state in states]
    runs = tuple(tuple(rare.pool_samples(part, shares) for part in of_output) for of_output in parts)
    k = tuple(rare.estimates(of_output, PROBABILITIES, neglected) for of_output in runs)
    counts = np.array(available)
    drawn = np.array([numbers.of_states(brake.units, counts) for numbers in _draw_rates(specification)])
    equal = [1 / effort.runs] * effort.runs
    k_of_rates = tuple(
        rare.widen(of, [rare.pool_samples(state, equal) for state in zip(*part, strict=True)], drawn, PROBABILITIES)
        for of, part in zip(k, parts, strict=True)
    )
    return QuasiStatic(
        runs=runs,
        k=k,
        k_of_rates=k_of_rates,
        states=states,
        neglected=neglected,
        seconds=time.perf_counter() - begin,
    )


def scenario_of_draw(
    scenario: Scenario, brake: QuasiStaticBrake, available: Sequence[int], standard: Array | None
) -> Scenario:
    """Return the scenario with the drawn plant, or the nominal one; the controller assumes nominal data."""
    parameters = {name: Magnitude(value) for name, value in brake.plant_parameters(available, standard).items()}
    vehicle = scenario.vehicle.model_copy(update={"parameters": {**scenario.vehicle.parameters, **parameters}})
    return scenario.model_copy(update={"vehicle": vehicle})


def in_the_loop(
    specification: KFactorSpecification,
    scenario: Scenario,
    brake: QuasiStaticBrake,
    nominal_distance: float,
    quasi_static: QuasiStatic,
    work: Work,
    import_from: Sequence[Path] = (),
) -> dict[str, Any]:
    """Return K of the whole stop with the controller in the loop, at the probability of [loop].

    It has the form of the file of results; `seconds` has the median time of a `stop` on one core and the number of
    stops that were run now. Classes that the scenario names are imported from the folders `import_from`.
    """
    effort = specification.loop
    assert effort is not None, "requested before anything was run"
    states, neglected = _states(specification, brake.units, _NEGLECT_IN_LOOP * effort.probability)
    nominal = brake.equivalent_deceleration(nominal_distance)
    costs = {p: _cost(specification, brake.units, p) for p in _SCALING}
    seconds: list[float] = []
    runs_before = work.run_count
    one_stop = partial(_stop, import_from=tuple(import_from))

    def performance(state: State, standard: Array) -> Array:
        draws = [scenario_of_draw(scenario, brake, state.available, draw) for draw in standard]
        stops = work.map(one_stop, draws, keep=not import_from)
        seconds.extend(processor for _, processor in stops)
        # A train that does not stop has braked with nothing.
        return np.array([0.0 if d is None else brake.equivalent_deceleration(d) / nominal for d, _ in stops])

    runs: list[Sample] = []
    for run in range(effort.runs):
        parts = [
            rare.subset_sample(
                partial(performance, state),
                brake.dimension,
                min(effort.probability / state.probability, 1.0),
                effort.samples,
                generator(specification.seed, f"k_factors loop {run} {state.available}"),
            )
            for state in states
        ]
        runs.append(rare.pool_samples(parts, [state.probability for state in states]))
    estimate = rare.estimates(quasi_static.runs[-1], [effort.probability], quasi_static.neglected)[0]
    return {
        "method": "exact enumeration of failure states, subset simulation within each",
        "probability": effort.probability,
        **plain(rare.estimates(runs, [effort.probability], neglected)[0]),
        "quasi_static": plain(estimate),
        "states": len(states),
        "neglected_probability": neglected,
        "samples": len(seconds),
        "estimated_stops": {f"{p:g}": cost for p, cost in costs.items()},
        "seconds": {"stop": median(seconds), "new_stops": work.run_count - runs_before},
    }


def _stop(scenario: Scenario, import_from: Sequence[Path]) -> tuple[float | None, float]:
    begin = time.process_time()
    return braking_distance(scenario, import_from), time.process_time() - begin


def plain(k: Interval) -> dict[str, float]:
    """Return K and its interval as the file of results has them."""
    return {"k": k.value, "low": k.low, "high": k.high}


def _states(
    specification: KFactorSpecification, units: Sequence[int], neglect: float
) -> tuple[tuple[State, ...], float]:
    return rare.states_of(units, _rates(specification.failures), neglect=neglect)


def _rates(failures: Failures, *standard: float) -> Rates:
    isolated, stuck = failures.isolated_unit, failures.stuck_valve
    first, last = (standard[0], standard[-1]) if standard else (0.0, 0.0)
    return Rates(
        isolated=isolated.quantile(first),
        stuck=stuck.quantile(last),
        isolated_beta=isolated.common_cause.beta,
        stuck_beta=stuck.common_cause.beta,
    )


def _draw_rates(specification: KFactorSpecification) -> list[Rates]:
    random = generator(specification.seed, "k_factors rates")
    standard = ndtri((np.arange(_RATES) + 0.5) / _RATES)
    pairs = zip(standard, random.permutation(standard), strict=True)
    return [_rates(specification.failures, float(first), float(last)) for first, last in pairs]


def _cost(specification: KFactorSpecification, units: Sequence[int], probability: float) -> int:
    assert specification.loop is not None
    samples = specification.loop.samples
    states, _ = _states(specification, units, _NEGLECT_IN_LOOP * probability)
    inside = [min(probability / state.probability, 1.0) for state in states]
    return specification.loop.runs * sum(rare.subset_cost(stop, samples) for stop in inside)
