"""K_dry of a brake: the file of a study, the quasi-static brake, importance sampling of it, and stops in the loop.

The quasi-static brake is the deceleration in steps of speed and the stopping distance, vectorised over draws.
s = v₀ t_e + Σ (v_j² − v_{j+1}²)/(2 a_j), a = (brake force + resistance)/(m + m_rot), the form of EN 14531-1. Names of
parameters are those of the plant `TwoPartTrainPneumatic`, whose pads and discs these are in their steady state.
"""

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from pathlib import Path
from statistics import median
from typing import Annotated

import numpy as np
from pydantic import Field, StrictInt

from railgrip.base.arrays import generator
from railgrip.base.errors import ScenarioError
from railgrip.base.tables import TomlTable
from railgrip.campaign.work import Work
from railgrip.estimators.belief import Array
from railgrip.rolling_stock.check import checked_train
from railgrip.rolling_stock.dispersion import Dispersion, Failures
from railgrip.rolling_stock.schema import Train
from railgrip.scenario.file import locate, merge, read_overrides
from railgrip.scenario.load import load, read_toml, validate_table
from railgrip.scenario.quantity import Magnitude, UnitRange
from railgrip.scenario.schema import Scenario
from railgrip.scenario.table import Name, Seed, Speed, Table, table_error
from railgrip.simulate.run import braking_distance
from railgrip.simulate.vehicle_data import VehicleData
from railgrip.supervision import rare
from railgrip.supervision.dispersed import PARTS, Deviations, DispersedBrake, TrainBrake, speed_steps
from railgrip.supervision.k_dry import QuasiStatic, k_factors, rates_of
from railgrip.supervision.rare import Sample, State
from railgrip.supervision.trains import data_of, maximum_speed
from railgrip.trace.k_wet import Interval
from railgrip.vehicle.brake import BRAKE, air_resistance, pad_force, rolling_resistance
from railgrip.vehicle.formation import Formation
from railgrip.vehicle.parameters import VehicleParameters

LIBRARY = Path(__file__).parent / "library"


class Effort(Table):
    """Numbers of draws."""

    runs: Annotated[StrictInt, Field(ge=2, le=100)] = Field(description="independent ones, for the intervals")
    samples: Annotated[StrictInt, Field(ge=20, le=20_000)] = Field(description="of each failure state, each run")


class LoopEffort(Effort):
    """Subset simulation with the controller in the loop."""

    probability: Annotated[float, UnitRange("1", between=(1e-9, 0.1))] = Field(description="of a lower deceleration")


class KFactorSpecification(Table):
    """The file."""

    name: Name
    description: str = ""
    seed: Seed
    scenario: str | None = Field(
        default=None,
        description="scenario of the stop: a file relative to the folder of this file, or a name of the package; "
        "a train file in place of this file has none",
    )
    speed_steps: tuple[Speed, ...] = Field(description="inner limits of the steps of speed, rising")
    estimate: Effort
    loop: LoopEffort | None = None
    dispersion: Annotated[tuple[Dispersion, ...], Field(min_length=1)]
    failures: Failures

    def _check(self) -> None:
        if list(self.speed_steps) != sorted(set(self.speed_steps)):
            raise table_error(f"speed_steps must rise, got {list(self.speed_steps)} m/s")


def load_specification(path: Path, overrides: Sequence[str] = ()) -> tuple[KFactorSpecification, Scenario | Train]:
    """Return the study of a file, or of the package by its name, and the scenario or train that it is about.

    A train file, or the name of a train, stands for its own study: at most seven steps of speed up to its maximum.

    Raises:
        ScenarioError: In one of the files; each problem in a sentence.
    """
    ours = LIBRARY / f"{path}.toml"
    path = ours if len(path.parts) == 1 and not path.suffix and ours.is_file() else locate(path, "trains")
    table, changes = read_toml(path), read_overrides(overrides)
    if "cars" in table:
        return _study_of_train(checked_train(path), changes, path.name)
    specification = validate_table(KFactorSpecification, merge(table, changes), directory=path.parent, origin=path.name)
    if specification.scenario is None:
        raise ScenarioError(f"{path.name}: has no 'scenario'; it is required")
    file = Path(specification.scenario)
    scenario = load(path.parent / file if file.suffix else file)
    _require_below(specification, path.name, scenario.start.speed, f"[start] speed of {scenario.name}")
    return specification, scenario


def _study_of_train(train: Train, changes: TomlTable, origin: str) -> tuple[KFactorSpecification, Train]:
    data = data_of(train)
    table = {
        "name": train.name,
        "description": train.description,
        "seed": 2026,
        "speed_steps": [float(step) for step in speed_steps(train, maximum_speed(train))[-2:0:-1]],
        "estimate": {"runs": 20, "samples": 500},
        "dispersion": data.dispersion,
        "failures": data.failures,
    }
    specification = validate_table(KFactorSpecification, merge(table, changes), directory=Path(), origin=origin)
    _require_below(specification, origin, maximum_speed(train), "the maximum speed of the train")
    return specification, train


def _require_below(specification: KFactorSpecification, origin: str, speed: float, name: str) -> None:
    if specification.speed_steps and specification.speed_steps[-1] >= speed:
        raise ScenarioError(
            f"{origin}: speed_steps end at {specification.speed_steps[-1]:g} m/s; they must stay below {name}, "
            f"{speed:g} m/s, which is also the unit of a number without one"
        )


_SCALARS = (
    *("speed_effect", "pad_speed_nominal", "temperature_effect", "temperature_nominal", "temperature_range"),
    *("force_effect", "pad_force_nominal", "m_disc", "m_disc_surface", "c_disc", "G_disc", "pad_share"),
    *("mu_bearing", "r_bearing", "e_rolling", "c_drag", "A_drag", "rho_air", "dead_fill", "T_fill", "leak"),
)


class QuasiStaticBrake(DispersedBrake):
    """The brake of a plant with the pads, discs and cylinders of `TwoPartTrainPneumatic`."""

    def __init__(
        self,
        parameters: Mapping[str, float],
        formation: Formation,
        dispersion: Sequence[Dispersion],
        speeds: Sequence[float],
    ) -> None:
        """Create the brake from the plant's parameters, dispersions, and limits of the steps of speed, falling to 0
        [m/s].

        Raises:
            ScenarioError: The plant lacks a parameter.
        """
        try:
            self._of = {name: parameters[name] for name in _SCALARS}
            self._friction, self._first_friction, self._temperature = (
                np.array([parameters[f"{name}[{g + 1}]"] for g in range(formation.groups)])
                for name in ("mu_b_nominal", "mu_b_start", "T_disc_start")
            )
            vehicle = VehicleParameters(formation, parameters)
            brakes, self._wheelset_mass = vehicle.formation.brakes, vehicle.masses
            self._brake = {name: np.array([getattr(brake, name) for brake in brakes]) for name in BRAKE}
        except KeyError as problem:
            raise ScenarioError(
                f"K factors are of a plant with the brake of TwoPartTrainPneumatic; this one lacks {problem}."
            ) from None
        super().__init__([int(count) for count in self._brake["units"]], dispersion, speeds)
        self._finish()

    def plant_parameters(self, available: Sequence[int], standard: Array | None) -> dict[str, float]:
        """Return the plant's parameters of one draw, shape (dimension,), or of the nominal train.

        The plant has one friction for all units of a group and one efficiency for all: what units differ by goes into
        the friction of their group.
        """
        deviations, braking = self._deviations(None if standard is None else standard[None, :]), np.array(available) > 0
        scale = self._torque(available, deviations)[0] / np.maximum(
            self._torque(available, deviations, alike=True)[0], 1e-9
        )
        scale = np.where(braking, scale, 1.0)
        each: dict[str, Array] = {
            "mu_b_nominal": self._friction * scale,
            "mu_b_start": self._first_friction * scale,
            # A disc that is not braked has no heat: its group keeps its units, and has zero pressure.
            "p_max": np.where(braking, self._brake["pressure_max"] + deviations["pressure"][0], 0.0),
            "n_units": np.where(braking, available, self.units),
            "r_wheel": self._brake["wheel_radius"] * deviations["wheel_radius"][0],
            "m_wheelset": self._wheelset_mass * deviations["mass"][0],
        }
        parameters = {
            f"{name}[{i + 1}]": float(value) for name, values in each.items() for i, value in enumerate(values)
        }
        return parameters | {"T_fill": self._of["T_fill"] * float(deviations["build_up"][0, 0])}

    def _pressure(self, deviations: Deviations) -> Array:
        """Return the steady cylinder pressure of each group, less the loss through the leak [Pa]."""
        return self._brake["pressure_max"] + deviations["pressure"] - self._of["leak"] * self._of["T_fill"]

    def _torque(self, available: Sequence[int], deviations: Deviations, *, alike: bool = False) -> Array:
        """Return the torque of each group at nominal speed and pad temperature [N m].

        With `alike` all units have nominal friction, efficiency and radius.
        """
        brake, of, group = self._brake, self._of, self._group
        force = pad_force(
            self._pressure(deviations),
            piston_area=brake["piston_area"],
            spring_force=brake["spring_force"],
            rigging=brake["rigging"],
        )[:, group]
        arm = brake["friction_radius"][group] * self._friction[group]
        if not alike:
            force, arm = (
                force * deviations["efficiency"],
                arm * deviations["friction_radius"] * deviations["pad_friction"],
            )
        torque = force * arm * (1 - of["force_effect"] * (force / of["pad_force_nominal"] - 1))
        of_group = (group == np.arange(len(self.units))[:, None]).astype(np.float64)
        return torque @ (of_group * self._brakes(available)).T

    def _stops(self, available: Sequence[int], deviations: Deviations) -> tuple[Array, Array, Array]:
        """Return the deceleration of each step, slowest first, shape (n, steps), distance and equivalent time."""
        brake, of, count = self._brake, self._of, np.maximum(np.asarray(available), 1)
        torque, radius = self._torque(available, deviations), brake["wheel_radius"] * deviations["wheel_radius"]
        mass = self._wheelset_mass.sum() * deviations["mass"][:, 0]
        inertial = mass + (brake["inertia"] / radius**2).sum(axis=1)
        rolling, drag = rolling_resistance(of, mass, brake["wheel_radius"].mean()), air_resistance(of)
        force = torque / radius
        share = force / np.maximum(force.sum(axis=1, keepdims=True), 1e-9)
        start, disc_share = self.speeds[0], 1.0 - of["pad_share"]
        steps: list[Array] = []
        distance = np.zeros(len(mass))
        for high, low in pairwise(self.speeds):
            width = (high**2 - low**2) / PARTS
            inverse = np.zeros(len(mass))
            for part in range(PARTS):
                square = high**2 - (part + 0.5) * width
                speed = square**0.5
                # The energy in the bulk of a disc is the braking energy less the energy that is still in its surface.
                energy = 0.5 * inertial[:, None] * (start**2 - square) * share / count
                surface = of["m_disc_surface"] * of["c_disc"] * force / count * speed / of["G_disc"]
                warmth = np.maximum(energy - surface, 0.0) * disc_share / (of["m_disc"] * of["c_disc"])
                heat = (self._temperature + warmth - of["temperature_nominal"]) / of["temperature_range"]
                pad_speed = speed * brake["friction_radius"] / radius / of["pad_speed_nominal"]
                steady = (1 + of["speed_effect"] * (1 - pad_speed)) * (1 + of["temperature_effect"] * _saturate(heat))
                deceleration = ((force * steady).sum(axis=1) + rolling + drag * square) / inertial
                inverse += 1 / deceleration
            steps.append(PARTS / inverse)
            distance += 0.5 * width * inverse
        piston = np.maximum(self._pressure(deviations) * brake["piston_area"], 1.0)
        # Pads touch when the pressure has passed the spring, and then their force follows with the same time constant.
        rise = np.where(
            piston > brake["spring_force"], -np.log1p(-np.minimum(brake["spring_force"] / piston, 0.99)), 0.0
        )
        time = of["dead_fill"] + of["T_fill"] * deviations["build_up"][:, 0] * (1 + (share * rise).sum(axis=1))
        return np.stack(steps[::-1], axis=1), distance + start * time, time


def _saturate(x: Array) -> Array:
    # As RailBraking.Friction.saturate.
    return (np.sqrt((x + 1) ** 2 + 0.01) - np.sqrt((x - 1) ** 2 + 0.01)) / 2


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
    speed = maximum_speed(subject) if isinstance(subject, Train) else subject.start.speed
    speeds = (speed, *reversed(specification.speed_steps), 0.0)
    if isinstance(subject, Train):
        return TrainBrake(subject, specification.dispersion, speeds)
    if subject.vehicle.train is not None:
        return TrainBrake(checked_train(subject.vehicle.train.path), specification.dispersion, speeds)
    if subject.actuation.kind != "pneumatic":
        raise ScenarioError(
            f"{subject.name}: [actuation] kind is '{subject.actuation.kind}'; K factors need 'pneumatic', because "
            "pressures and fill times of the cylinders disperse."
        )
    if subject.demand is not None:
        raise ScenarioError(f"{subject.name}: K factors are of full brake from the start on: leave out [demand]")
    vehicle = VehicleData(subject)
    return QuasiStaticBrake(vehicle.true.parameters, vehicle.formation, specification.dispersion, speeds)


def quasi_static(
    specification: KFactorSpecification, brake: DispersedBrake, notify: Callable[[str], None] = lambda what: None
) -> QuasiStatic:
    """Return K of the quasi-static brake for all EBCL; the same specification gives the same numbers."""
    effort = specification.estimate
    seed, runs, samples = specification.seed, effort.runs, effort.samples
    return k_factors(brake, specification.failures, seed=seed, runs=runs, samples=samples, notify=notify)


def scenario_of_draw(
    scenario: Scenario, brake: QuasiStaticBrake, available: Sequence[int], standard: Array | None
) -> Scenario:
    """Return the scenario with the drawn plant, or the nominal one; the controller assumes nominal data."""
    parameters = {name: Magnitude(value) for name, value in brake.plant_parameters(available, standard).items()}
    vehicle = scenario.vehicle.model_copy(update={"parameters": {**scenario.vehicle.parameters, **parameters}})
    return scenario.model_copy(update={"vehicle": vehicle})


@dataclass(frozen=True, slots=True, kw_only=True)
class KOfStops:
    """K of the whole stop with the controller in the loop, with the names of the file of results.

    Attributes:
        method: How it was determined.
        probability: That of a lower deceleration, of [loop].
        k: K; `low` and `high` are the ends of its interval.
        quasi_static: The same of the quasi-static brake, see `plain`.
        states: Number of failure states that were sampled.
        neglected_probability: That of all others together.
        samples: Number of stops.
        estimated_stops: Probability → number of stops that the same samples and runs need.
        seconds: `stop`, the median time of one on one core [s], and `new_stops`, the number of those that were run now.
    """

    method: str = "exact enumeration of failure states, subset simulation within each"
    probability: float
    k: float
    low: float
    high: float
    quasi_static: Mapping[str, float]
    states: int
    neglected_probability: float
    samples: int
    estimated_stops: Mapping[str, int]
    seconds: Mapping[str, float]


def in_the_loop(
    specification: KFactorSpecification,
    scenario: Scenario,
    brake: QuasiStaticBrake,
    nominal_distance: float,
    quasi_static: QuasiStatic,
    work: Work,
    import_from: Sequence[Path] = (),
) -> KOfStops:
    """Return K of the whole stop with the controller in the loop, at the probability of [loop].

    Classes that the scenario names are imported from the folders `import_from`.
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
    found = rare.estimates(runs, [effort.probability], neglected)[0]
    return KOfStops(
        probability=effort.probability,
        k=found.value,
        low=found.low,
        high=found.high,
        quasi_static=plain(estimate),
        states=len(states),
        neglected_probability=neglected,
        samples=len(seconds),
        estimated_stops={f"{p:g}": cost for p, cost in costs.items()},
        seconds={"stop": median(seconds), "new_stops": work.run_count - runs_before},
    )


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
