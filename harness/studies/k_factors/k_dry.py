"""K_dry of a brake: by importance sampling of the quasi-static brake, by subset simulation of stops in the loop."""

import time
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np

from railgrip.base.arrays import generator
from railgrip.base.errors import ScenarioError
from railgrip.campaign.work import Work
from railgrip.estimators.belief import Array
from railgrip.rolling_stock.check import checked_train
from railgrip.rolling_stock.schema import Train
from railgrip.scenario.quantity import Magnitude
from railgrip.scenario.schema import Scenario
from railgrip.simulate.run import braking_distance
from railgrip.simulate.vehicle_data import VehicleData
from railgrip.studies.k_factors.brake import QuasiStaticBrake
from railgrip.studies.k_factors.specification import KFactorSpecification
from railgrip.supervision import rare
from railgrip.supervision.dispersed import DispersedBrake, TrainBrake
from railgrip.supervision.k_dry import DispersingBrake, QuasiStatic, k_factors, rates_of
from railgrip.supervision.rare import Sample, State
from railgrip.supervision.trains import maximum_speed
from railgrip.trace.k_wet import Interval

_NEGLECT_IN_LOOP = 0.25
"""Maximum probability of neglected failure states, as a share of the probability of [loop]; each takes hundreds of
stops, and the interval shows the loss of accuracy."""
_SCALING = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6)


def brake_of(specification: KFactorSpecification, subject: Scenario | Train) -> DispersedBrake:
    """Return the quasi-static brake of a train file, or of the train or the plant of a scenario.

    Raises:
        ScenarioError: The plant of a scenario has another brake, its cylinders are not filled by valves, or the demand
            is not full brake.
        InputError: A train file is wrong, or its train does not stop.
    """
    if isinstance(subject, Train):
        return TrainBrake(subject, specification.dispersion, _speeds(specification, maximum_speed(subject)))
    if subject.vehicle.train is not None:
        train = checked_train(subject.vehicle.train.path)
        return TrainBrake(train, specification.dispersion, _speeds(specification, subject.start.speed))
    return brake_of_scenario(specification, subject)


def _speeds(specification: KFactorSpecification, speed: float) -> tuple[float, ...]:
    return (speed, *reversed(specification.speed_steps), 0.0)


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
    speeds = _speeds(specification, scenario.start.speed)
    return QuasiStaticBrake(vehicle.true.parameters, vehicle.formation, specification.dispersion, speeds)


def quasi_static(
    specification: KFactorSpecification, brake: DispersingBrake, notify: Callable[[str], None] = lambda what: None
) -> QuasiStatic:
    """Return K of the quasi-static brake for all EBCL; the same specification gives the same numbers."""
    effort = specification.estimate
    return k_factors(
        brake,
        specification.failures,
        seed=specification.seed,
        runs=effort.runs,
        samples=effort.samples,
        notify=notify,
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
    specification: KFactorSpecification, units: Sequence[int | Sequence[int]], neglect: float
) -> tuple[tuple[State, ...], float]:
    return rare.states_of(units, rates_of(specification.failures), neglect=neglect)


def _cost(specification: KFactorSpecification, units: Sequence[int | Sequence[int]], probability: float) -> int:
    assert specification.loop is not None
    samples = specification.loop.samples
    states, _ = _states(specification, units, _NEGLECT_IN_LOOP * probability)
    inside = [min(probability / state.probability, 1.0) for state in states]
    return specification.loop.runs * sum(rare.subset_cost(stop, samples) for stop in inside)
