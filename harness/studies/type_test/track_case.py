"""The cases of version 2: rails that vary over the track, slip that cleans, blended creep curves, pairs of faults.

As in version 1 a case is a point of a scrambled Sobol sequence with ranks in place of coordinates. Rails that wheels
clean by rolling over them have a sequence of their own, so that the other cases stay as they are.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Final

import numpy as np

from railgrip.base import registry
from railgrip.base.tables import TomlTable
from railgrip.base.units import GRAVITY
from railgrip.scenario.load import read_toml
from railgrip.scenario.surface import named_set
from railgrip.studies.type_test.design import FAULTS, FRICTION, KMH, SPEED, STEEPEST, at, on_log_scale, ranks

MAX_DURATION: Final = 90.0
"""Maximum duration of a stop at six tenths of the friction [s], which limits the speed on a slippery rail."""

RAILS: Final = (
    *("patches", "steps", "random", "leaves") * 2,
    "even", "patches over time", "random over time",
)  # fmt: skip
"""Kinds of rail, each as often as it is in the list; over distance unless the name says otherwise."""

PERIOD: Final = (10.0, 300.0)  # m, of patches and steps; mean distance of the beginnings of patches of leaves
CORRELATION: Final = (0.3, 150.0)  # m
TIMES: Final = (0.3, 12.0)  # s, period or correlation over time

PASSED_RAILS: Final = (
    *("patches over time", "sweep over time", "random over time") * 2,
    "patches", "steps", "sweep", "random", "leaves", "even",
)  # fmt: skip
"""Kinds of rail that passing wheels clean; half of them vary over time, as those of Table 1 of the papers."""

FRACTION: Final = (0.04, 0.36)
"""Share of the gap that each group or wheelset closes; the geometric mean, 0.12, is that of Table 1's rails."""
RECOVERED: Final = (1.1, 1.8)
"""Friction of the rail that wheels have cleaned by rolling, over the mean; 1.30 to 1.44 on Table 1's rails."""

CLEANING: Final[Mapping[str, TomlTable]] = MappingProxyType(
    {
        "none": {},
        # The rate is an estimate: a tenth of that of Allotta et al.; the clean rail is Polach's wet one.
        "weak": {"mu0": 0.2, "A": 0.4, "B": 0.2, "rate": 1.9e-5},
        # Rate: Allotta, Meli, Ridolfi and Rindi, Tribology International 69 (2014) 128; Polach's dry falling friction.
        "strong": {"mu0": 0.3, "A": 0.4, "B": 0.6, "rate": 1.9e-4},
    }
)
_CLEANINGS: Final = ("none", "none", "none", "weak", "strong")
BY_THE_CURVE: Final = "by the curve"
"""Cleaning of a creep curve that has its own law of recovery."""

TRAINS: Final = (*("",) * 15, *("vt642",) * 4, "emu387")
"""Trains, each as often as it is in the list; '' is the train of the command, by default the two-part train.

The tram is left out, because its magnetic track brakes decide its distance."""
FASTEST: Final[Mapping[str, float]] = MappingProxyType({"vt642": 120 / KMH, "emu387": 160 / KMH})
"""Maximum speed of a case by train [m/s]: design speeds, for emu387 below it."""

LOAD, RADIUS, PADS, OF_GROUPS = 0.12, 0.015, 0.15, 0.05
"""Maximum relative deviations: of the load, of the radius of a group, of the pads of all and of single groups."""

_COUNTS: Final = (0, 0, 1, 1, 2)
"""Numbers of faults, each as often as it is in the list."""

_DETAILED: Final = 0.2
"""Share of the cases with detailed mechanics."""

_SHAPE: Final = ("k_A", "k_S", "A", "B")


@dataclass(frozen=True, slots=True, kw_only=True)
class TrackCase:
    """One stop of version 2 that every controller has to make.

    Attributes:
        name: Its number and its set.
        curve: Named creep curve that dominates.
        other: Named creep curve that is blended in, or ''.
        share: Share of `other`, below 0.5 [1].
        rail: How friction changes: one of `RAILS`.
        scale: Period, correlation or mean distance of patches [m], over time [s].
        cleaning: Key of `CLEANING`, or `BY_THE_CURVE`.
        friction: Mean of the maximum friction, on a rail with leaves its maximum in a patch [1].
        speed: At the brake demand [m/s].
        train: Train of the library, or '' for that of the command.
        load: Mass over the one that the controller knows [1].
        radius: Maximum relative deviation of the radius of a group [1].
        pads: Pad friction of all groups over the nominal one [1].
        gradient: Slope over the friction, climbing positive [1].
        faults: Keys of the faults, at most two.
        lot: Seed of sensors, rail, radii and pads.
        passage: Who cleans the rail by rolling over it: "none", "by group" or "by wheelset".
        fraction: Share of the gap to `recovered` that each of them closes [1].
        recovered: Friction of the rail that they clean [1].
    """

    name: str
    curve: str
    other: str
    share: float
    rail: str
    scale: float
    cleaning: str
    friction: float
    speed: float
    train: str
    load: float
    radius: float
    pads: float
    gradient: float
    faults: tuple[str, ...]
    lot: int
    passage: str = "none"
    fraction: float = 0.0
    recovered: float = 1.0

    @property
    def has_bound(self) -> bool:
        """Whether the bound is pointwise and holds: slip does not change the rail, the rigging has no hysteresis."""
        return self.cleaning == "none" and self.mechanics == "simple"

    @property
    def mechanics(self) -> str:
        """Mechanics of the train: in a fifth of the cases not those that the filter assumes."""
        return "detailed" if np.random.default_rng((self.lot, 3)).random() < _DETAILED else "simple"

    @property
    def over(self) -> str:
        """What the friction varies over."""
        return "nothing" if self.rail == "even" else "time" if self.rail.endswith("over time") else "distance"

    @property
    def slope(self) -> float:
        """Gradient, climbing positive [1]."""
        return float(np.clip(self.gradient * self.friction, -STEEPEST, STEEPEST))

    @property
    def horizon(self) -> float:
        """Time after which the train is taken not to stop [s]."""
        return float(round(15.0 + 2.5 * self.speed / (0.6 * self.friction * GRAVITY)))

    def variants(self) -> dict[str, str]:
        """Return its values as people read them."""
        return {
            "case": self.name,
            "curve": self.curve,
            "blend": f"{self.share:.2f} {self.other}" if self.other else "none",
            "over": self.over,
            "rail": self.rail,
            "scale": f"{self.scale:.3g} {'s' if self.over == 'time' else 'm'}",
            "cleaning": self.cleaning,
            "passage": self.passage,
            "strength": f"{self.fraction:.2f} to {self.recovered:.3f}" if self.fraction else "none",
            "friction": f"{self.friction:.3f}",
            "speed": f"{KMH * self.speed:.0f} km/h",
            "train": self.train or "default",
            "load": f"{self.load:.3f}",
            "radius": f"± {100 * self.radius:.1f} %",
            "pads": f"{self.pads:.3f}",
            "gradient": f"{1000 * self.slope:+.0f} ‰",
            "mechanics": self.mechanics,
            "number of faults": str(len(self.faults)),
            "fault": " and ".join(self.faults) or "none",
        }

    def tables(self, groups: int) -> TomlTable:
        """Return the overrides for the scenario of a train with a number of groups."""
        radii, pads = (np.random.default_rng((self.lot, stream)).uniform(-1.0, 1.0, groups) for stream in (1, 2))
        truth = {
            "load": self.load,
            "wheel_radius": [round(float(1.0 + self.radius * deviation), 6) for deviation in radii],
            "pad_friction": [round(float(self.pads * (1.0 + OF_GROUPS * deviation)), 6) for deviation in pads],
            "gradient": self.slope,
            "mechanics": self.mechanics,
        }
        surface: TomlTable = {}
        if self.cleaning not in ("none", BY_THE_CURVE):
            surface["recovery"] = dict(CLEANING[self.cleaning])
        if self.fraction:
            by = self.passage.removeprefix("by ")
            surface["conditioning"] = {"fraction": self.fraction, "recovered": self.recovered, "by": by}
        return {
            "seed": self.lot,
            "start": {"speed": self.speed},
            "truth": truth,
            "adhesion": {"polach": self._polach(), **self._friction(), **surface},
            "limits": {"horizon": self.horizon},
        }

    def fault_tables(self, groups: int) -> TomlTable:
        """Return the tables of its faults; faults of a group are those of a drawn group."""
        group = 1 + self.lot % groups
        rows = [row for fault in self.faults for row in FAULTS[fault].get("faults", ())]
        return {"faults": [row | {"group": group} if "group" in row else row for row in rows]} if rows else {}

    def _polach(self) -> str | TomlTable:
        if not self.other:
            return self.curve
        own, other = named_set(self.curve), named_set(self.other)
        blend: TomlTable = {"name": f"{self.curve}, {self.share:.2f} {self.other}"}
        for name in _SHAPE:
            if name.startswith("k"):  # slopes are factors
                value = own[name] ** (1.0 - self.share) * other[name] ** self.share
            else:
                value = (1.0 - self.share) * own[name] + self.share * other[name]
            blend[name] = float(f"{value:.5g}")
        return blend

    def _friction(self) -> TomlTable:
        mean, scale, draw = self.friction, self.scale, self.lot % 1000 / 1000
        if self.rail == "even":
            return {"kind": "constant", "mu0": mean}
        if self.rail == "leaves":
            return {
                "kind": "leaves", "mu0": round(2.0 * mean, 6), "count": round(1.0 / scale, 6), "shortest": 2.0,
                "longest": 15.0, "edge": 0.5, "minimum": round(0.5 * mean, 6), "maximum": mean,
            }  # fmt: skip
        over, unit = ("time", "s") if self.over == "time" else ("distance", "m")
        if self.rail.startswith("random"):
            return {
                "kind": "random", "over": over, "mean": mean, "deviation": round(0.2 * mean, 6),
                "correlation": f"{scale:.6g} {unit}", "minimum": round(0.4 * mean, 6), "maximum": round(1.6 * mean, 6),
            }  # fmt: skip
        if self.rail.startswith("sweep"):
            # From a period of √8 times the scale to one of the scale over √8, as the sweep of Table 1 with 7 s.
            ratio, rate = math.sqrt(8.0), "Hz" if unit == "s" else "1/m"
            start, end = 1.0 / (ratio * scale), ratio / scale
            return {
                "kind": "sine_sweep", "over": over, "mean": mean, "amplitude": round(0.3 * mean, 6),
                "start_frequency": f"{start:.6g} {rate}", "end_frequency": f"{end:.6g} {rate}",
                "sweep": f"{4.0 * scale:.6g} {unit}",
            }  # fmt: skip
        ramp = 0.05 if self.rail == "steps" else 0.1 * scale
        return {
            "kind": "trapezoid", "over": over, "minimum": round(0.6 * mean, 6), "maximum": round(1.4 * mean, 6),
            "first_fall": f"{(0.2 + draw) * scale:.6g} {unit}", "period": f"{scale:.6g} {unit}",
            "low": f"{0.4 * scale:.6g} {unit}", "ramp": f"{ramp:.6g} {unit}",
        }  # fmt: skip


def track_cases(count: int, seed: int) -> tuple[TrackCase, ...]:
    """Return a number of cases of version 2, the same ones for the same seed and creep curves of the library."""
    return tuple(case for case, _ in _draw(count, seed, RAILS, "v2"))


def passage_cases(count: int, seed: int) -> tuple[TrackCase, ...]:
    """Return a number of cases of version 2 whose rail is cleaned by passing wheels, drawn as `track_cases`."""
    return tuple(
        replace(
            case,
            passage=at(("by group", "by wheelset"), who),
            fraction=on_log_scale(FRACTION, share),
            recovered=round(on_log_scale(RECOVERED, clean) * case.friction, 6),
        )
        for case, (who, share, clean) in _draw(count, seed, PASSED_RAILS, "v2p", further=3)
    )


def _draw(
    count: int, seed: int, rails: Sequence[str], kind: str, further: int = 0
) -> list[tuple[TrackCase, tuple[float, ...]]]:
    """Return cases, each with its place on a number of further axes, in (0, 1).

    Args:
        count: Number of cases.
        seed: Seed of the sequence.
        rails: Kinds of rail, each as often as it is in the list.
        kind: Part of the names of the cases that identifies their set.
        further: Number of further axes.
    """
    if not count:
        return []
    curves = tuple(sorted(registry.files(registry.CREEP_CURVES)))
    faults = tuple(name for name in FAULTS if name != "none")
    axes = 18  # ten numbers, and eight places in lists
    digits = len(str(count))
    design: list[tuple[TrackCase, tuple[float, ...]]] = []
    for number, point in enumerate(ranks(count, axes + further, seed).tolist(), start=1):
        (*numbers, first, second, rail, cleaning, train, many, one, other), rest = point[:axes], tuple(point[axes:])
        slippery, fast, lot, blended, scale, *deviations = numbers
        curve, admixture = at(curves, first), at(curves, second)
        share = round(max(0.0, blended - 0.5), 2)
        has_own_recovery = [set(named_set(name)) != set(_SHAPE) for name in (curve, admixture)]
        if any(has_own_recovery) or curve == admixture or not share:
            admixture, share = "", 0.0
        friction, rail_kind, train_name = on_log_scale(FRICTION, slippery), at(rails, rail), at(TRAINS, train)
        load, radius, pads, gradient = (2.0 * place - 1.0 for place in deviations[:4])
        case = TrackCase(
            name=f"{number:0{digits}d}of{count}{kind}-{seed}",
            curve=curve,
            other=admixture,
            share=share,
            rail=rail_kind,
            scale=on_log_scale(_scales(rail_kind), scale),
            cleaning=BY_THE_CURVE if has_own_recovery[0] else at(_CLEANINGS, cleaning),
            friction=friction,
            speed=_speed(friction, fast, train_name),
            train=train_name,
            load=round(1.0 + LOAD * load, 4),
            radius=round(0.5 * RADIUS * (1.0 + radius), 5),
            pads=round(1.0 + PADS * pads, 4),
            gradient=round(0.25 * gradient, 4),
            faults=_faults(faults, at(_COUNTS, many), one, other),
            lot=int(1e6 * lot),
        )
        design.append((case, rest))
    return design


def _scales(rail: str) -> tuple[float, float]:
    return TIMES if rail.endswith("over time") else CORRELATION if rail == "random" else PERIOD


def _speed(friction: float, place: float, train: str) -> float:
    fastest = min(SPEED[1], FASTEST.get(train, math.inf), 0.6 * friction * GRAVITY * MAX_DURATION)
    slowest = min(SPEED[0], fastest)
    return round(slowest + place * (fastest - slowest), 2)


def _faults(faults: Sequence[str], count: int, first: float, second: float) -> tuple[str, ...]:
    """Return the names of some faults, of different parts of the train."""
    one = at(faults, first)
    part = FAULTS[one]["faults"][0]["part"]
    others = [name for name in faults if FAULTS[name]["faults"][0]["part"] != part]
    return (one, at(others, second))[:count]


TABLE_1: Final = "Table 1"
"""Kind of rail of `PublishedRail`."""
_PUBLISHED: Final = ("trapezoid", "sine_sweep", "random")


@dataclass(frozen=True, slots=True, kw_only=True)
class PublishedRail(TrackCase):
    """A rail of Table 1 of the papers in its scenario of the library, with the valves and sensors of the type test.

    Attributes:
        scenario: Name of the scenario.
    """

    scenario: str

    @property
    def mechanics(self) -> str:
        """Mechanics of the train: those that the filter assumes."""
        return "simple"

    def variants(self) -> dict[str, str]:
        """Return its values as people read them."""
        # A dataclass with slots is another class than the one that super() without arguments refers to.
        shown = TrackCase.variants(self)
        return shown | {"over": self._table()["adhesion"]["over"], "scale": self.scenario}

    def tables(self, groups: int) -> TomlTable:
        """Return the overrides for the scenario of a train with a number of groups."""
        table = self._table()
        return {
            "seed": table["seed"],
            "start": {"speed": self.speed},
            "truth": {"mechanics": self.mechanics},
            "adhesion": dict(table["adhesion"]),
            "limits": {"horizon": table["limits"]["horizon"]},
        }

    def _table(self) -> TomlTable:
        return read_toml(registry.shelf("scenarios")[self.scenario])


def published_rails(count: int, seed: int) -> tuple[PublishedRail, ...]:
    """Return the rails of Table 1 of the papers; only the first ones for a smaller count."""
    return tuple(
        _published_rail(f"{number}of{count}v2t-{seed}", scenario)
        for number, scenario in enumerate(_PUBLISHED[:count], start=1)
    )


def _published_rail(name: str, scenario: str) -> PublishedRail:
    adhesion = read_toml(registry.shelf("scenarios")[scenario])["adhesion"]
    mean, passed = adhesion.get("mean") or 0.5 * (adhesion["minimum"] + adhesion["maximum"]), adhesion["conditioning"]
    return PublishedRail(
        name=name, scenario=scenario, speed=80 / KMH, train="", rail=TABLE_1, scale=0.0, cleaning="none",
        curve=adhesion["polach"], other="", share=0.0, friction=adhesion["calibrated"][adhesion["polach"]] * mean,
        passage=f"by {passed['by']}", fraction=passed["fraction"], recovered=passed["recovered"],
        load=1.0, radius=0.0, pads=1.0, gradient=0.0, faults=(), lot=0,
    )  # fmt: skip


_PATCHES: Final = TrackCase(
    name="patches", curve="wet", other="leaf", share=0.3, rail="patches", scale=60.0, cleaning="none", friction=0.06,
    speed=16.0, train="", load=1.08, radius=0.006, pads=0.95, gradient=0.1, faults=(), lot=271828,
)  # fmt: skip
HEADLINES: Final = (
    _PATCHES,
    replace(_PATCHES, name="leaves", rail="leaves", scale=40.0, friction=0.05, load=0.93),
    replace(_PATCHES, name="cleaned rail", curve="dry", other="", rail="random", scale=5.0, cleaning="strong"),
    replace(
        _PATCHES, name="even cleaned rail", curve="dry", other="", rail="even", cleaning="strong", friction=0.05,
        speed=80 / KMH, load=1.0, radius=0.0, pads=1.0, gradient=0.0, lot=5501,
    ),
    replace(_PATCHES, name="detailed mechanics", lot=271830),
    replace(_PATCHES, name="pair of faults", faults=("radar stuck", "valve slow"), friction=0.09),
)  # fmt: skip
"""Short cases for the regression, which no new creep curve in the library changes."""
