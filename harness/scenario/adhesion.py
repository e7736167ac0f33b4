"""The rail under the train: the friction of a scenario's profile at each wheelset, and the force of its track."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import assert_never

import numpy as np
from numpy.typing import NDArray

from railgrip.base.arrays import Array, generator, markov
from railgrip.base.errors import ScenarioError
from railgrip.kernel import kernel
from railgrip.scenario.curve import TabulatedQuantity
from railgrip.scenario.profile import (
    LONGEST_RAIL,
    Adhesion,
    Conditioning,
    Constant,
    FromTable,
    Leaves,
    Patch,
    Points,
    Random,
    SineSweep,
    Trapezoid,
)
from railgrip.scenario.schema import Scenario
from railgrip.scenario.surface import SandedRail, Sander, SlipEnergy
from railgrip.scenario.table import FASTEST
from railgrip.scenario.track import TrackForce
from railgrip.vehicle.formation import Formation
from railgrip.vehicle.signals import Layout

_PLACE_STEP = 5e-3  # m; less than a train moves in 1 ms at 20 km/h, and 1e-5 of mu0 on the steepest ramps in use


@dataclass(frozen=True, slots=True, kw_only=True)
class FrictionTable:
    """Friction tabulated on an even grid, for a look-up that is fast enough for every sample.

    The nearest grid point is used: over time the grid is that of the samples, so the look-up is exact; over distance
    the grid is finer than a sample's travel.

    Attributes:
        over_time: Whether the axis is the time since the brake demand [s], else the distance of the first
            wheelset since then [m].
        step: Step of the grid, in the unit of the axis.
        mu0_at: Friction at the grid points, shape (n, wheelsets), lead to trail.
        curve_at: Index of the creep curve at the grid points, shape (n, wheelsets); None if the rail has one curve.
    """

    over_time: bool
    step: float
    mu0_at: Array
    curve_at: NDArray[np.uint8] | None = None

    def table(self, time: Array, distance: Array) -> Array:
        """Return the friction at each wheelset, (n, wheelsets), at times [s] and distances [m] since the demand."""
        return self.mu0_at[self._nearest(time, distance)]

    def curve_numbers(self, time: Array, distance: Array) -> NDArray[np.uint8] | None:
        """Return the index of the creep curve at each wheelset, with arguments and shape as `table`.

        The result is None if the rail has one curve.
        """
        return None if self.curve_at is None else self.curve_at[self._nearest(time, distance)]

    def _nearest(self, time: Array, distance: Array) -> NDArray[np.int_]:
        nearest = ((time if self.over_time else distance) / self.step + 0.5).astype(int)
        return np.clip(nearest, 0, len(self.mu0_at) - 1)


def profile_of(scenario: Scenario, formation: Formation) -> FrictionTable:
    """Return the friction profile of a scenario under each wheelset of a formation, up to its horizon.

    A profile over time reaches all wheelsets at once. One over distance is fixed to the rail: each wheelset reaches it
    later than the leading one, by its position.

    Raises:
        ScenarioError: Level and conditioning raise friction above 1, a list has the wrong number of wheelsets, or their
            positions are not given.
    """
    adhesion, wheelsets = scenario.adhesion, formation.wheelsets
    with scenario.name_errors():
        _require_reached(scenario)
        _require_resolved(adhesion, scenario.periods.communication)
        step, places = _grid(scenario, formation)
        friction = _profile_friction(adhesion, scenario.seed, places, step, wheelsets)
        patches = _patches(adhesion, scenario.seed, places)
        if patches:
            friction = np.array(np.broadcast_to(friction, (len(places), wheelsets)))
        for patch in patches:
            _check_count("[adhesion] patch mu0", len(patch.mu0), wheelsets)
            rows = _rows(patch, places)
            friction[rows] += _inside(patch, places[rows]) * (np.array(patch.mu0) - friction[rows])
        mu0 = _condition_rail(adhesion.factor * friction, adhesion.conditioning, formation)
        if mu0.max() > 1:
            raise ScenarioError(f"[adhesion] level {adhesion.factor:g} brings mu0 to {mu0.max():.3g}, above 1")
        curve_at = _curves(adhesion, patches, places, mu0.shape)
    mu0.flags.writeable = False
    return FrictionTable(
        over_time=not scenario.runs_over_distance,
        step=step,
        mu0_at=mu0,
        curve_at=curve_at,
    )


def _grid(scenario: Scenario, formation: Formation) -> tuple[float, Array]:
    """Return the step of a profile's grid and, at each grid point, the position of each wheelset on its axis.

    Positions have shape (n, wheelsets), or (n, 1) over time, when all wheelsets have the same friction.
    """
    adhesion = scenario.adhesion
    if not scenario.runs_over_distance:
        if adhesion.patch:
            raise ScenarioError(
                "[adhesion.patch] has a place on the rail, but the profile is over time; use a profile over distance"
            )
        step = scenario.periods.communication
        return step, step * np.arange(round(scenario.horizon / step) + 2, dtype=np.float64)[:, None]
    step, position = _PLACE_STEP, position_of(adhesion, formation)
    if isinstance(adhesion, Constant):  # behind its patches nothing changes
        reach = max(p.begin + p.length for p in adhesion.patch) + position.max() + step
        _require_tabulated(reach, "a wheelset meets the last patch")
    else:
        reach = reach_of(scenario)
    return step, step * np.arange(int(reach / step) + 2, dtype=np.float64)[:, None] - position


def _profile_friction(adhesion: Adhesion, seed: int, places: Array, step: float, wheelsets: int) -> Array:
    match adhesion:
        case Constant(mu0=mu0) | Leaves(mu0=mu0):
            _check_count("[adhesion] mu0", len(mu0), wheelsets)
            return np.broadcast_to(mu0, (len(places), wheelsets))
        case Points():
            friction = np.interp(places, adhesion.places, [mu0 for _, mu0 in adhesion.points])
            if adhesion.correlation is None:
                return friction
            correlation = adhesion.extent("correlation")
            spacing = correlation / 20 if adhesion.over == "distance" else step
            points, noise = _noise(correlation, places, spacing, seed)
            return friction * (1.0 + adhesion.scatter * np.interp(places, points, np.clip(noise, -3.0, 3.0)))
        case Trapezoid():
            return _trapezoid(adhesion, places)
        case SineSweep():
            return _sine_sweep(adhesion, places)
        case Random():
            return _random(adhesion, places, seed)
        case FromTable(curve=curve):
            columns = curve.values.shape[1]
            _check_count(f"[adhesion] file {adhesion.file.entry}", columns, wheelsets)
            return _from_curve(curve, np.broadcast_to(places, (len(places), max(places.shape[1], columns))))
        case _:
            assert_never(adhesion)


def _curves(
    adhesion: Adhesion, patches: Sequence[Patch], places: Array, shape: tuple[int, ...]
) -> NDArray[np.uint8] | None:
    of_wheelset = adhesion.polach_of_wheelset or (adhesion.polach,)
    _check_count("[adhesion] polach_of_wheelset", len(of_wheelset), shape[1])
    if len(adhesion.curves) == 1:
        return None
    number = {curve: index for index, curve in enumerate(adhesion.curves)}
    curves = np.array(np.broadcast_to([number[curve] for curve in of_wheelset], shape), dtype=np.uint8)
    for patch in patches:
        if patch.polach is not None:
            rows = _rows(patch, places)
            inside = np.broadcast_to(_inside(patch, places[rows]) >= 0.5, curves[rows].shape)
            curves[rows][inside] = number[patch.polach]
    return curves


def position_of(adhesion: Adhesion, formation: Formation) -> Array:
    """Return the distance of each wheelset behind the leading one [m].

    Raises:
        ScenarioError: The positions of the wheelsets are not given.
    """
    if formation.position is None:
        recovers = "[adhesion] has recovery" if adhesion.cleaning is not None else "[[sanders]] lay sand"
        what = "[adhesion] runs over distance" if adhesion.over == "distance" else recovers
        raise ScenarioError(
            f"{what}, and the plant does not declare the positions of its wheelsets: give [vehicle.formation] "
            "wheelset_position, how far each is behind the leading one"
        )
    return formation.position


def reach_of(scenario: Scenario) -> float:
    """Return an upper bound of the distance until the horizon [m], at start speed or, with traction, the highest speed.

    Raises:
        ScenarioError: The distance is too long for a table.
    """
    reach, fastest = _farthest(scenario), "any train" if scenario.has_traction else "[start] speed"
    with scenario.name_errors():
        _require_tabulated(reach, f"{fastest} goes until [limits] horizon")
    return reach


def _farthest(scenario: Scenario) -> float:
    return (FASTEST if scenario.has_traction else scenario.start.speed) * scenario.horizon


def _require_reached(scenario: Scenario) -> None:
    """Raise an error for places on rail and track of which the train reaches none: they have another origin."""
    adhesion, reach = scenario.adhesion, _farthest(scenario)
    places = {
        "[[adhesion.patch]] begin": [patch.begin for patch in adhesion.patch],
        "[[track.gradient]] begin": [section.begin for section in scenario.track.gradient],
        "[[track.curve]] begin": [section.begin for section in scenario.track.curve],
    }
    if scenario.runs_over_distance:
        if isinstance(adhesion, Points):
            places["[adhesion] points"] = list(adhesion.places)
        elif isinstance(adhesion, FromTable):
            places[f"[adhesion] file {adhesion.file.entry}"] = adhesion.curve.points.tolist()
    for key, distances in places.items():
        if distances and (min(distances) > reach or max(distances) < 0.0):
            has_origin = key.startswith("[adhesion]")
            raise ScenarioError(
                f"{key} is from {min(distances):g} m to {max(distances):g} m from the brake demand, but the train gets "
                f"no farther than {reach:g} m; places are distances from the brake demand"
                + (", or chainages if [adhesion] origin has that of the leading wheelset there" if has_origin else "")
            )


def _require_tabulated(reach: float, what: str) -> None:
    if reach > LONGEST_RAIL:
        raise ScenarioError(
            f"[adhesion] over distance is tabulated as far as {what}, {reach / 1e3:.3g} km; "
            f"{LONGEST_RAIL / 1e3:g} km is the most, shorten it"
        )


def _check_count(what: str, count: int, wheelsets: int) -> None:
    if count not in (1, wheelsets):
        raise ScenarioError(f"{what} is for {count} wheelsets, the vehicle has {wheelsets}")


def _require_resolved(adhesion: Adhesion, period: float) -> None:
    match adhesion:
        case SineSweep() as shape:
            finest = 0.5 / max(shape.frequencies)
            what = f"[adhesion] frequencies reach {max(shape.frequencies):.3g} 1/{shape.unit}"
        case (Random() | Points()) as shape if shape.correlation is not None:
            finest = shape.extent("correlation") / 10
            what = f"[adhesion] correlation is {shape.extent('correlation'):.3g} {shape.unit}"
        case _:
            return
    step = _PLACE_STEP if adhesion.over == "distance" else period
    if finest < step:
        raise ScenarioError(f"{what}, too fine for a rail that is looked at every {step:g} {shape.unit}")


def _trapezoid(shape: Trapezoid, places: Array) -> Array:
    # Start high and stay high until the first fall, so that the stop begins on a good rail.
    fall, ramp, low = shape.extent("first_fall"), shape.extent("ramp"), shape.extent("low")
    into = np.where(places >= fall, (places - fall) % shape.extent("period"), np.inf)
    corners = np.array([0.0, ramp, ramp + low, 2 * ramp + low])
    return np.interp(into, corners, [shape.maximum, shape.minimum, shape.minimum, shape.maximum])


def _sine_sweep(shape: SineSweep, places: Array) -> Array:
    """Return mean − amplitude·sin(phase): friction falls first, as after a brake demand on a worsening rail.

    Frequency is f(x) = f0·(f1/f0)^(x/X) up to X and f1 beyond; the phase is its integral, zero at x ≤ 0.
    """
    first, last = shape.frequencies
    sweep = shape.extent("sweep")
    within = np.clip(places, 0, sweep)
    growth = np.log(last / first) / sweep
    # expm1(g x)/g → x for g → 0: a sweep between equal frequencies is a sine.
    cycles = first * (np.expm1(growth * within) / growth if growth else within)
    phase = 2 * np.pi * (cycles + last * np.clip(places - sweep, 0, None))
    return shape.mean - shape.amplitude * np.sin(phase)


def _random(shape: Random, places: Array, seed: int) -> Array:
    # The noise is exact at points a twentieth of the correlation length apart, and linear between them.
    correlation = shape.extent("correlation")
    points, noise = _noise(correlation, places, correlation / 20, seed)
    return np.interp(places, points, np.clip(shape.mean + shape.deviation * noise, shape.minimum, shape.maximum))


def _noise(correlation: float, places: Array, spacing: float, seed: int) -> tuple[Array, Array]:
    """Return points `spacing` apart around `places`, and first-order Gauss–Markov noise of unit variance there.

    Its persistence is ρ = e^(−h/L): stationary from the first point, autocorrelation e^(−|d|/L).
    """
    # Drawn from the first wheelset's start on, so that a longer train adds points behind without changing those ahead.
    ahead = int(np.ceil(places.max() / spacing)) + 2
    behind = int(np.ceil(-min(places.min(), 0.0) / spacing)) + 2
    persistence = np.exp(-spacing / correlation)
    forward = markov(generator(seed, "adhesion").standard_normal(ahead), persistence)
    # The process is reversible: backwards from its first value it is the same recursion with separate draws.
    behind_it = generator(seed, "adhesion.behind").standard_normal(behind)
    behind_it[0] = forward[0]
    backward = markov(behind_it, persistence)
    noise = np.concatenate([backward[:0:-1], forward])
    points = spacing * np.arange(1 - behind, ahead, dtype=np.float64)
    return points, noise


def _patches(leaves: Adhesion, seed: int, places: Array) -> Sequence[Patch]:
    # Later patches cover earlier ones: leaves first, then the given patches. Leaves are drawn from the start of the
    # first wheelset on, so that a longer train or horizon adds patches without moving any, and backwards from there
    # until no patch reaches the last wheelset.
    if not isinstance(leaves, Leaves):
        return leaves.patch
    ahead = _draw_patches(leaves, generator(seed, "adhesion"), float(places.max()))
    behind = _draw_patches(leaves, generator(seed, "adhesion.behind"), leaves.longest - float(places.min()))
    drawn = [*((-begin, length, mu0) for begin, length, mu0 in reversed(behind)), *ahead]
    return (
        *(
            # Not validated: a patch in a scenario cannot begin behind the first wheelset.
            Patch.model_construct(
                begin=begin, length=length, mu0=(mu0,), edge=leaves.edge, polach=leaves.polach_of_patches
            )
            for begin, length, mu0 in drawn
        ),
        *leaves.patch,
    )


def _draw_patches(leaves: Leaves, rng: np.random.Generator, reach: float) -> list[tuple[float, float, float]]:
    patches: list[tuple[float, float, float]] = []
    place = rng.exponential(1 / leaves.count)
    while place < reach:
        patches.append(
            (place, rng.uniform(leaves.shortest, leaves.longest), rng.uniform(leaves.minimum, leaves.maximum))
        )
        place += rng.exponential(1 / leaves.count)
    return patches


def _rows(patch: Patch, places: Array) -> slice:
    front, rear = places[0].argmax(), places[0].argmin()
    first = np.searchsorted(places[:, front], patch.begin)
    last = np.searchsorted(places[:, rear], patch.begin + patch.length, side="right")
    return slice(max(int(first) - 1, 0), int(last) + 1)  # one more row at either end: sums are rounded


def _inside(patch: Patch, places: Array) -> Array:
    into = places - patch.begin
    inside = np.minimum(into, patch.length - into)
    return np.clip(inside / patch.edge, 0.0, 1.0) if patch.edge else (inside >= 0.0).astype(np.float64)


def _from_curve(curve: TabulatedQuantity, places: Array) -> Array:
    columns = range(places.shape[1])
    last = curve.values.shape[1] - 1
    return np.stack([np.interp(places[:, j], curve.points, curve.values[:, min(j, last)]) for j in columns], axis=1)


def _condition_rail(mu0: Array, conditioning: Conditioning | None, formation: Formation) -> Array:
    """Raise low friction for the wheelsets behind: each one ahead closes a fraction of the gap to `recovered`.

    mu0_j = mu0 + (recovered − mu0)⁺ · (1 − (1 − fraction)^n) with n wheelsets or groups ahead of j. Minima thus rise
    from front to rear, and friction at or above `recovered` is unchanged.
    """
    if conditioning is None:
        return np.array(np.broadcast_to(mu0, (len(mu0), formation.wheelsets)))
    return mu0 + np.clip(conditioning.recovered - mu0, 0, None) * recovery_of(conditioning, formation)


def recovery_of(conditioning: Conditioning, formation: Formation) -> Array:
    """Return the share of the gap to `recovered` that wheelsets ahead have closed for each wheelset."""
    ahead = formation.group_of_wheelset if conditioning.by == "group" else np.arange(formation.wheelsets)
    return np.subtract(1.0, (1 - conditioning.fraction) ** ahead, dtype=np.float64)


class TabulatedRail:
    """Friction and force along the track; the look-up is in `kernel/rail.c`.

    Attributes:
        slip_energy: Slip energy on the rail; None if slip does not change friction.
        sand: Sand on the rail; None without sanders.
        mu0: Maximum friction at each wheelset, shape (wheelsets,), at the last position of the train.
        struct: `Rail` of rail.h.
    """

    def __init__(
        self,
        layout: Layout,
        friction: FrictionTable,
        force: TrackForce,
        slip_energy: SlipEnergy | None = None,
        sand: SandedRail | None = None,
        curves: Array | None = None,
    ) -> None:
        """Create the rail for a vehicle whose leading wheelset is at distance 0.

        Args:
            layout: Layout of the vehicle.
            friction: Untreated friction, and the creep curve, along the track.
            force: Track force by gradient and curve.
            slip_energy: Slip energy on the rail.
            sand: Sand on the rail.
            curves: Polach's k_A, k_S, A and B [s/m] of each creep curve, shape (curves, 4), if there are several.
        """
        self.slip_energy, self.sand, self._kernel = slip_energy, sand, kernel(layout)
        self._energy_places = [layout.output[name] for name in ("adhesion", "wheelset_load")]
        # Wheelsets whose places are not known are at that of the leading one.
        wheelsets = layout.formation.wheelsets
        behind, share = (np.resize(values, wheelsets) for values in (force.behind, force.shares))
        tables = {
            "friction": friction.mu0_at, "begins": force.begins, "forces": force.forces, "rates": force.rates,
            "behind": behind, "share": share,
        }  # fmt: skip
        self.struct = kernel(layout).struct(
            "Rail", grid=friction.step, points=len(friction.mu0_at), over_time=friction.over_time,
            sections=len(force.begins), car=np.ascontiguousarray(layout.formation.car_of_wheelset, dtype=np.int64),
            **{name: np.ascontiguousarray(table, dtype=np.float64) for name, table in tables.items()},
        )  # fmt: skip
        self.mu0 = self.struct.view("mu0")
        if curves is not None and friction.curve_at is not None:
            self.struct.set(curves=np.ascontiguousarray(curves), curve_at=np.ascontiguousarray(friction.curve_at))
        # Where the train starts, before slip or sand have changed anything.
        self.advance(0.0, np.zeros(layout.outputs))
        self.struct.set(recovery=slip_energy and slip_energy.struct, sand=sand and sand.struct)

    def advance(self, time: float, truth: Array) -> None:
        """Compute friction and force at a time, given the plant's outputs, a contiguous array; times come in order."""
        self._kernel.functions.advance_rail(self.struct.pointer, time, self._kernel.doubles(truth))

    def write_inputs(self, inputs: Array) -> None:
        """Write the plant's rail inputs to a contiguous array, for the last position of the train.

        Before the first `advance` this is the start.
        """
        self._kernel.functions.write_rail_inputs(self.struct.pointer, self._kernel.doubles(inputs))

    def check_plant(self, truth: Array) -> None:
        """Raise an error for a plant without the outputs that the rail depends on.

        Raises:
            ScenarioError: Slip changes the rail, and the plant lacks adhesion or load of its wheelsets.
        """
        if self.slip_energy is not None and any(np.isnan(truth[place]).any() for place in self._energy_places):
            raise ScenarioError(
                "[adhesion.recovery] needs the energy of the slip, but the plant does not output adhesion and "
                "wheelset_load of each wheelset: leave it out, or add these outputs by [vehicle.map]"
            )


def rail_of(
    scenario: Scenario, layout: Layout, force: TrackForce, curves: Array, sanders: Sequence[Sander]
) -> TabulatedRail:
    """Return the rail of a scenario, before any wheel has passed.

    Args:
        scenario: Scenario with the friction.
        layout: Layout of the vehicle.
        force: Track force by gradient and curve.
        curves: Polach's k_A, k_S, A and B [s/m] of each creep curve, shape (curves, 4).
        sanders: Sanders of the scenario, else of its train.

    Raises:
        ScenarioError: The positions of the wheelsets are not given, or a sander is at a wheelset that does not exist.
    """
    adhesion, formation, slip_energy, sand = scenario.adhesion, layout.formation, None, None
    with scenario.name_errors():
        if adhesion.cleaning is not None:
            position_of(adhesion, formation)
            *_, share, decay = curves[0].tolist()
            slip_energy = SlipEnergy(layout, adhesion.cleaning, (share, decay), reach_of(scenario))
        if adhesion.sand is not None and sanders:
            for number, sander in enumerate(sanders, start=1):
                if sander.wheelset > formation.wheelsets:
                    raise ScenarioError(
                        f"[sanders[{number}]] is at wheelset {sander.wheelset}, the vehicle has {formation.wheelsets}"
                    )
            position_of(adhesion, formation)
            sand = SandedRail(layout, sanders, reach_of(scenario), adhesion.sand)
    return TabulatedRail(layout, profile_of(scenario, formation), force, slip_energy, sand, curves)
