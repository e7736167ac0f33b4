"""From stops to headway: stops of each variant, K_wet and M_NVAVADH, and seconds, with intervals of one resampling."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Final

import numpy as np

from railgrip.base.arrays import Array, generator
from railgrip.base.errors import InputError
from railgrip.base.files import write_text
from railgrip.base.registry import shelf
from railgrip.base.tables import TomlTable
from railgrip.base.units import GRAVITY
from railgrip.report.statistics import FEWEST_DRAWS
from railgrip.rolling_stock.check import checked_train
from railgrip.rolling_stock.schema import load_train
from railgrip.rolling_stock.stopping import by_hand
from railgrip.scenario.file import inline_toml, merge
from railgrip.scenario.load import read_toml, scenario_of
from railgrip.scenario.outcome import Outcome
from railgrip.scenario.schema import Scenario
from railgrip.scenario.surface import Sander
from railgrip.simulate.run import run_stop
from railgrip.studies.benefit.line import LIBRARY, LineOfStudy, Measure, SeasonalRail
from railgrip.supervision.curve import Steps
from railgrip.supervision.headway import Headway, headways
from railgrip.supervision.model import BrakingModel
from railgrip.supervision.national import NationalValues
from railgrip.supervision.trains import model_of_train

BASE: Final = "without"
ALL: Final = "all together"
FIGURES: Final = ("distance", "sand", "air", "energy")
"""Figures of a stop: distance [m], sand [kg], air [m3], energy dissipated by the wheels [J]."""
_ENDS: Final = (0.025, 0.975)
_RESAMPLES, _SEED, _KNOTS = 1000, 49, 16
_SLOWEST, _LONGEST = 0.5, 200.0  # of the deceleration that the lowest friction allows; s, reach of the tabulated rail


@dataclass(frozen=True, slots=True, kw_only=True)
class Variant:
    """A train with measures.

    Attributes:
        name: Names of the measures.
        train: Its train file.
        changes: Tables laid over its stops.
    """

    name: str
    train: Path
    changes: TomlTable


def variants_of(train: Path, measures: Mapping[str, Measure], controller: str, folder: Path) -> list[Variant]:
    """Return the train without measures, with each of them, and with all together if there are several.

    Args:
        train: Train file.
        measures: Measures by name.
        controller: Law of the train without measures.
        folder: Folder for train files that measures change.

    Raises:
        InputError: A changed train is wrong; the message names its file.
    """
    table = read_toml(train)
    sets: dict[str, tuple[str, ...]] = {BASE: (), **{name: (name,) for name in measures}}
    if len(measures) > 1:
        sets[ALL] = tuple(measures)
    variants: list[Variant] = []
    for name, chosen in sets.items():
        changed = _train_table(table, measures, chosen)
        file = train
        if changed != table:
            # Published distances are those of the train as it is, and limit no other one.
            changed["reference"] = [{**stop, "limit": False} for stop in changed.get("reference", ())]
            file = folder / f"{train.stem}_{'_'.join(chosen) or BASE}.toml"
            write_text(file, "".join(f"{key} = {inline_toml(value)}\n" for key, value in changed.items()))
            try:
                checked_train(file)
            except InputError as problem:
                raise InputError(
                    f"--measures {','.join(chosen)}: {train.name} with it is wrong: {problem} Leave it out, or give "
                    "the train its own equipment for it."
                ) from problem
        changes: TomlTable = {"controller": {"kind": controller}}
        for each in chosen:
            changes = merge(changes, measures[each].scenario)
        variants.append(Variant(name=name, train=file, changes=changes))
    return variants


def _train_table(table: TomlTable, measures: Mapping[str, Measure], chosen: Sequence[str]) -> TomlTable:
    """Return the tables of a train with some measures, and without what the others add."""
    changed = dict(table)
    for name, measure in measures.items():
        kinds: TomlTable = changed["bogies"]
        has_own = any(key in bogie for bogie in kinds.values() for key in measure.bogie)
        if name not in chosen:
            kept = {kind: {k: v for k, v in bogie.items() if k not in measure.bogie} for kind, bogie in kinds.items()}
            for bogie in kept.values():
                if isinstance(bogie.get("estimated"), list):
                    bogie["estimated"] = [key for key in bogie["estimated"] if key not in measure.bogie]
            changed["bogies"] = kept
        elif not has_own:
            changed["bogies"] = {kind: {**bogie, **measure.bogie} for kind, bogie in kinds.items()}
            changed = merge(measure.train, changed)
    return changed


def scenario_for(variant: Variant, line: LineOfStudy, rail: SeasonalRail | None, draw: int, speed: float) -> Scenario:
    """Return a stop of a variant on a rail, or on dry rail for None.

    Level and seed depend on rail and draw alone, so that all variants stop on the same rails.
    """
    service = read_toml(shelf("equipment")["service"])
    tables: TomlTable = merge(read_toml(LIBRARY / "stop.toml"), {"sensors": service["sensors"]})
    tables = merge(tables, {"vehicle": {"train": variant.train.name}, "start": {"speed": speed}, "seed": draw})
    if rail is None:
        tables = merge(tables, {"controller": {"kind": "full_brake"}})
    else:
        level = generator(draw, f"benefit {rail.name}").uniform(*rail.level)
        changes = {name: table for name, table in variant.changes.items() if name != "adhesion"}
        adhesion = merge({**rail.adhesion, "level": float(level)}, variant.changes.get("adhesion", {}))
        tables = merge({**tables, "adhesion": adhesion}, changes)
    what = f"{line.name}: {variant.name}, {'dry' if rail is None else rail.name}"
    scenario = scenario_of(tables, directory=variant.train.parent, origin=what)
    # Friction or the brakes limit the deceleration.
    longest = max(
        speed / (_SLOWEST * GRAVITY * scenario.adhesion.lowest), by_hand(load_train(variant.train), speed).duration
    )
    horizon = min(longest + 30.0, _LONGEST)
    return scenario_of(merge(tables, {"limits": {"horizon": horizon}}), directory=variant.train.parent, origin=what)


def figures_of(scenario: Scenario) -> dict[str, float]:
    """Run a stop and return `FIGURES`; an infinite distance without standstill."""
    stop = run_stop(scenario)
    metrics, trace = stop.metrics, stop.trace
    assert scenario.vehicle.train is not None
    sanders = scenario.sanders or load_train(scenario.vehicle.train.path).sanders
    is_sanded = scenario.adhesion.sand is not None
    stands = stop.outcome is Outcome.STANDSTILL
    return {
        "distance": metrics.distance if stands else np.inf,
        "sand": sand_mass(sanders if is_sanded else (), trace["time"].values, trace["speed"].values),
        "air": metrics.air_used,
        "energy": float(sum(metrics.tread_energy)),
    }


def sand_mass(sanders: Sequence[Sander], time: Array, speed: Array) -> float:
    """Return the sand that leaves the nozzles on both rails [kg]: the rate, or less at a set density."""
    mass = 0.0
    for sander in sanders:
        rate = np.full(time.size, sander.rate)
        if sander.density is not None:
            rate = np.minimum(rate, sander.density * speed)
        on = (time >= sander.begin) & (time <= (np.inf if sander.end is None else sander.end))
        mass += 2 * float(np.trapezoid(rate * on, time))
    return mass


def model_for(train: Path, national: NationalValues) -> BrakingModel:
    """Return the braking model of a train file; its K_wet is not used."""
    return model_of_train(checked_train(train), national)[0]


def weighted_quantile(values: Array, weights: Array, share: float) -> Array:
    """Return the smallest value that a share of the weight does not exceed, along the last axis."""
    order = np.argsort(values, axis=-1)
    total = np.cumsum(np.take_along_axis(np.broadcast_to(weights, values.shape), order, -1), axis=-1)
    place = np.argmax(total >= share * total[..., -1:] - 1e-9, axis=-1)
    return np.take_along_axis(np.take_along_axis(values, order, -1), place[..., None], -1)[..., 0]


@dataclass(frozen=True, eq=False)
class BenefitChain:
    """The stops of all variants on the same draws, and what follows from them.

    Attributes:
        line: The line.
        variants: Variants, first that without measures.
        speed: At the brake demand [m/s].
        models: Braking model of each variant.
        dry: Distance on dry rail of each variant [m].
        times: Equivalent time of each variant [s].
        figures: `FIGURES` → values, shape (variants, rails, draws).
    """

    line: LineOfStudy
    variants: Sequence[Variant]
    speed: float
    models: Sequence[BrakingModel]
    dry: Array
    times: Array
    figures: Mapping[str, Array]

    @property
    def draws(self) -> int:
        """Stops on each rail."""
        return self.figures["distance"].shape[2]

    def interval(self, values: Array) -> tuple[float, float] | None:
        """Return the 95 % percentile interval of resampled values, whose first is the estimate; None with few draws.

        Args:
            values: Shape (resamples + 1,).
        """
        if self.draws < FEWEST_DRAWS:
            return None
        low, high = np.quantile(values[1:], _ENDS)
        return float(low), float(high)

    @cached_property
    def weights(self) -> Array:
        """Share of the year of each draw, shape (rails · draws,)."""
        return np.repeat([rail.probability for rail in self.line.rail], self.draws) / self.draws

    @cached_property
    def resampled(self) -> Mapping[str, Array]:
        """Figures of draws that are resampled within each rail, the same for all variants and figures.

        Shape (variants, resamples, rails · draws); the first resample has the draws themselves.
        """
        shape = (_RESAMPLES + 1, *self.figures["distance"].shape[1:])
        places = np.random.default_rng(_SEED).integers(shape[2], size=shape)
        places[0] = np.arange(shape[2])
        return {
            name: np.take_along_axis(values[:, None], places[None], axis=-1).reshape(len(values), shape[0], -1)
            for name, values in self.figures.items()
        }

    @cached_property
    def ratios(self) -> Array:
        """Deceleration distance on dry rail over that of each stop, as `resampled`."""
        gone = (self.times * self.speed)[:, None, None]
        return (self.dry[:, None, None] - gone) / (self.resampled["distance"] - gone)

    @cached_property
    def k_wet(self) -> Array:
        """K_wet_rst of each variant: by mean distances on rails that are not dry, shape (variants, resamples)."""
        wet = self.weights * np.repeat([not rail.dry for rail in self.line.rail], self.draws)
        gone = (self.times * self.speed)[:, None]
        mean = (self.resampled["distance"] @ wet) / wet.sum()
        return np.minimum((self.dry[:, None] - gone) / (mean - gone), 1.0)

    @cached_property
    def m_nvavadh(self) -> Array:
        """M_NVAVADH, shape (resamples,): that of the line, or one for the train without measures.

        It is a value of the network, which no measure of one train changes: the one with which K_wet_rst + M_NVAVADH
        (1 − K_wet_rst) is the ratio that the covered share of the stops reaches, from 0 to 1.
        """
        if "M_NVAVADH" in self.line.national.model_fields_set:
            return np.full(_RESAMPLES + 1, self.line.national.M_NVAVADH)
        reached, k = weighted_quantile(self.ratios[0], self.weights, 1 - self.line.cover), self.k_wet[0]
        return np.clip((reached - k) / np.maximum(1 - k, 1e-9), 0.0, 1.0)

    @cached_property
    def factors(self) -> Array:
        """K_wet_rst + M_NVAVADH (1 − K_wet_rst), shape (variants, resamples)."""
        return self.k_wet + self.m_nvavadh * (1 - self.k_wet)

    def headways_for(self, variant: int, factor: float) -> tuple[Headway, Headway]:
        """Return the headways of a variant at one factor for wet rail."""
        # K_wet_rst = factor without M_NVAVADH is the same product.
        model = replace(self.models[variant], k_wet=Steps.constant(factor))
        return headways(self.line, model, self.line.national.model_copy(update={"M_NVAVADH": 0.0}))

    @cached_property
    def deciding(self) -> list[tuple[Headway, Headway]]:
        """The headways of each variant, with what decides them."""
        return [self.headways_for(number, float(factors[0])) for number, factors in enumerate(self.factors)]

    @cached_property
    def seconds(self) -> Array:
        """Headway with fixed and with moving blocks [s], shape (2, variants, resamples).

        Between knots of the factor, headway is linear in its inverse, as braking distances are.
        """
        found = np.empty((2, *self.factors.shape))
        tables: dict[int, tuple[Array, Array]] = {}
        inverse = 1 / self.factors
        for number, model in enumerate(self.models):
            if id(model) not in tables:
                alike = np.array([other is model for other in self.models])
                knots = np.unique(np.linspace(inverse[alike].min(), inverse[alike].max(), _KNOTS))
                values = [[each.seconds for each in self.headways_for(number, float(1 / knot))] for knot in knots]
                tables[id(model)] = knots, np.array(values)
            knots, values = tables[id(model)]
            for system in range(2):
                found[system, number] = np.interp(inverse[number], knots, values[:, system])
                found[system, number, 0] = self.deciding[number][system].seconds
        return found

    def mean(self, figure: str) -> Array:
        """Return the mean of a figure over a year, shape (variants, resamples)."""
        return self.resampled[figure] @ self.weights

    def quantile(self, share: float) -> Array:
        """Return a quantile of the distance over a year [m], shape (variants, resamples)."""
        return weighted_quantile(self.resampled["distance"], self.weights, share)

    def beyond(self) -> Array:
        """Return the share of the stops with a lower deceleration than the factor allows for, shape (variants,)."""
        first = self.ratios[:, 0] < self.factors[:, :1] * (1 - 1e-9)
        return first @ self.weights

    def require_stops(self) -> None:
        """Raise an error for stops without standstill, which have no K_wet.

        Raises:
            InputError: A variant does not stop in a draw.
        """
        names = ["dry, of K_wet", *(rail.name for rail in self.line.rail)]
        for variant, dry, of_variant in zip(self.variants, self.dry, self.figures["distance"], strict=True):
            for rail, distances in zip(names, [np.array([dry]), *of_variant], strict=True):
                if lost := int((~np.isfinite(distances)).sum()):
                    raise InputError(
                        f"{self.line.name}: {variant.name}: the train does not come to a standstill in {lost} of "
                        f"{len(distances)} stops from {3.6 * self.speed:g} km/h on the rail '{rail}', so that "
                        "there is no K_wet; raise the friction of the rail or reduce the speed of the line"
                    )
