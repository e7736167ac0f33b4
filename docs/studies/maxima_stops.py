"""Stops on rails that slip cleans and heats, the shortest known stops there, and the flash temperature."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from table1_stops import OWN_WAY, RAILS

import railgrip as rg
from railgrip.base.arrays import Vector
from railgrip.scenario.file import merge
from railgrip.scenario.load import scenario_of
from railgrip.scenario.surface import named_set
from railgrip.simulate.creep_curves import CLEAN, curves, maxima
from railgrip.simulate.creep_curves import SLIPS as STEADY_SLIPS
from railgrip.simulate.ideal import tracking_stop
from railgrip.simulate.run import run_stop
from railgrip.studies.type_test.entrants import LIBRARY, entrants, train_of

CAUSES = {"film alone": (), "heat": ("temperature_loss",), "cleaning": ("recovery",),
          "cleaning and heat": ("temperature_loss", "recovery")}  # fmt: skip
"""Keys of the creep curve that are switched on."""

LAWS: Mapping[str, Mapping[str, Any]] = {
    "slip up to 5 %": {"kind": "slip_two_state", "parameters": {"low": 0.035, "high": 0.05}},
    "slip of 20 to 30 %": {"kind": "slip_two_state", "parameters": {"low": 0.20, "high": 0.30}},
    "full brake": {"kind": "full_brake"},
}
"""Laws, one for each maximum and one that locks the wheels."""


def stop_of(rail: str, causes: str, law: str) -> rg.Stop:
    """Return the stop on a rail with the causes that are switched on, under a law."""
    name, mu0 = RAILS[rail]
    keys = set(named_set(name)) - {"temperature_loss", "recovery"} | set(CAUSES[causes])
    polach = {key: value for key, value in named_set(name).items() if key in keys}
    changes = {"adhesion.polach": polach, "adhesion.mu0": mu0, "controller": LAWS[law], "estimator": {"kind": "none"},
               "limits.horizon": "200 s", "periods.trace": "1 ms"}  # fmt: skip
    return rg.run(rg.Scenario.load("plain", changes))


def energy_error(stop: rg.Stop) -> float:
    """Return the largest deviation of the energy from that at the start, relative to it."""
    parts = ("kinetic_energy", "contact_heat", "pad_heat", "resistance_work")
    energy = np.sum([stop.trace[name].values for name in parts], axis=0)
    return float(np.abs(energy / energy[0] - 1.0).max())


def slide_of(stop: rg.Stop) -> tuple[Vector, Vector]:
    """Return slip and adhesion of wheelset 1 until it locks or its slip falls, on a grid coarser than the samples."""
    slip, adhesion = stop.trace["slip"].values[:, 0], stop.trace["adhesion"].values[:, 0]
    end = int(np.argmax(slip >= 0.995)) or len(slip)
    rising = np.maximum.accumulate(slip[:end])
    grid = np.geomspace(5e-3, min(rising[-1], 0.98), 60)
    return grid, np.interp(grid, rising, adhesion[:end])


def maxima_of(slip: Vector, adhesion: Vector) -> list[float]:
    """Return the slips at the maxima of a slide."""
    return [float(slip[place]) for place in maxima(adhesion) if place < slip.size - 1]


def stop_row(rail: str, causes: str, law: str) -> dict[str, Any]:
    """Return distance [m] and energy error of a stop, and the slips at the maxima of its slide as text."""
    stop = stop_of(rail, causes, law)
    places = ", ".join(f"{100 * slip:.0f} %" for slip in maxima_of(*slide_of(stop)))
    return {"distance": stop.metrics.distance, "energy": energy_error(stop), "maxima": places}


def curve_rows(rail: str) -> list[dict[str, Any]]:
    """Return adhesion over slip with cleaning and heat, in steady slip and in the slide under a full brake."""
    slide = slide_of(stop_of(rail, "cleaning and heat", "full brake"))
    _, steady = curves(*RAILS[rail], way=OWN_WAY)
    return [
        {"kind": kind, "slip": slip, "adhesion": adhesion}
        for kind, curve in (("steady", (STEADY_SLIPS, steady[:, 0])), ("until wheelset 1 locks", slide))
        for slip, adhesion in zip(*curve, strict=True)
    ]


PECLETS = (0.0, 1.0, 3.0, 10.0, 30.0)
"""Péclet numbers V a/(2 κ) of the contact's motion; a rolling wheel has some thousands."""


def mean_rise(peclet: float, cells: int = 128) -> float:
    """Return the mean temperature rise under a moving circle of uniform heat, times k/(q a), by quadrature.

    The kernel is Rosenthal's moving point source on a half-space, e^(−Pe (R + ξ))/(2 π R), where ξ is the distance
    ahead of the source. Its pole is integrated over its cell.
    """
    width = 2.0 / cells
    axis = width * (np.arange(cells) - (cells - 1) / 2)
    inside = np.add.outer(axis**2, axis**2) <= 1.0
    offset = width * np.arange(1 - cells, cells)
    ahead, across = np.meshgrid(offset, offset, indexing="ij")
    distance = np.hypot(ahead, across)
    pole = distance == 0.0
    distance[pole] = 1.0
    kernel = np.exp(-peclet * (distance + ahead)) / (2 * np.pi * distance) * width**2
    kernel[pole] = 4 * width * np.log(1 + np.sqrt(2)) / (2 * np.pi)
    shape = [2 * cells + cells - 2] * 2
    rise = np.fft.irfft2(np.fft.rfft2(kernel, shape) * np.fft.rfft2(inside.astype(float), shape), shape)
    return float(rise[cells - 1 : 2 * cells - 1, cells - 1 : 2 * cells - 1][inside].mean())


def interpolated_rise(peclet: float) -> float:
    """Return the same by `RailBraking.Contact.flashResistance`."""
    return 1.2204 / np.sqrt(np.pi * (0.658 + peclet))


KNOWN: Mapping[str, Mapping[str, Any]] = {
    "dry": {"adhesion.mu0": 0.05},
    "dry that slip cleans": {"adhesion.mu0": 0.05, "adhesion.recovery": CLEAN.model_dump()},
    "wet, cleaning and heat": {"adhesion.polach": "wet_two_maxima", "adhesion.mu0": 0.15},
    "leaves, cleaning and heat": {"adhesion.polach": "leaves_two_maxima", "adhesion.mu0": 0.06},
}
"""Known rails: changes of the scenario `plain`."""

SLIPS = (0.02, 0.05, 0.1, 0.2, 0.35, 0.5, 0.7, 1.0)
"""Slips that a group may hold."""


def shortest_held(scenario: rg.Scenario, groups: int, held: Sequence[float]) -> tuple[float, Sequence[float]]:
    """Return the distance and the slips of the shortest stop in which each group holds one of some slips.

    From locked wheels on, the slip of one group after the other is chosen, the last one first: its slip matters to no
    other.
    """
    slips = [1.0] * groups
    distance = tracking_stop(scenario, slips=slips).metrics.distance
    for group in reversed(range(groups)):
        for slip in held:
            changed = [*slips[:group], slip, *slips[group + 1 :]]
            other = tracking_stop(scenario, slips=changed).metrics.distance
            if other < distance:
                distance, slips = other, changed
    return distance, slips


def shortest_row(rail: str, held: int = len(SLIPS)) -> dict[str, Any]:
    """Return the distances [m] of the bound, of held slips, the first ones of `SLIPS`, and of laws."""
    changes = {**KNOWN[rail], "limits.alpha_max": 1.0, "limits.horizon": "200 s"}
    without = {**changes, "estimator": {"kind": "none"}}
    bound = rg.run(rg.Scenario.load("plain", {**without, "controller.kind": "ideal_bound"}))
    full = rg.Scenario.load("plain", {**without, "controller.kind": "full_brake"})
    distance, slips = shortest_held(full, bound.trace.sizes["group"], SLIPS[:held])
    stops = {law: {**without, "controller": dict(table)} for law, table in LAWS.items()}
    # These laws use the estimates of the scenario.
    stops |= {law.replace("_", " "): {**changes, "controller.kind": law} for law in ("slope_seeking", "two_maxima")}
    return {
        "ideal bound": bound.metrics.distance,
        "held slips": distance,
        "slips held": ", ".join(f"{100 * slip:.0f} %" for slip in slips),
    } | {law: rg.run(rg.Scenario.load("plain", each)).metrics.distance for law, each in stops.items()}


_CLEANED: Mapping[str, Any] = {
    "name": "cleaned_rail",
    "seed": 5501,
    "start": {"speed": 80 / 3.6},
    "limits": {"horizon": 250.0},
    "adhesion": {"kind": "constant", "polach": "dry", "mu0": 0.05, "recovery": CLEAN.model_dump()},
}


def in_service(law: str) -> dict[str, float]:
    """Return the distance of a law of version 2 of the type test on the dry rail that slip cleans [m], or NaN."""
    tables = merge(merge(train_of(None), _CLEANED), entrants(2)[law].tables)
    scenario = scenario_of(tables, directory=LIBRARY, origin=f"cleaned rail, {law}")
    return {"distance": run_stop(scenario).metrics.distance}
