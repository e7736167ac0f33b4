"""The cases: conditions of wheel-slide protection, evenly distributed over their ranges.

A case is a point of a scrambled Sobol sequence (Owen, 1998), with each coordinate replaced by its rank: so every value
of every axis occurs equally often for any number of cases, and pairs of axes are as even as in Sobol's sequence. The
speed depends on the friction: a stop from 200 km/h at a friction of 0.02 would take ten minutes without any advantage
over a slower one.
"""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from types import MappingProxyType
from typing import Any, Final, TypeVar

import numpy as np
from numpy.typing import NDArray
from scipy.stats.qmc import Sobol

from railgrip.base.tables import TomlTable
from railgrip.base.units import GRAVITY

T = TypeVar("T")

KMH: Final = 3.6

CASES, SMALL = 240, 24
"""Number of cases of the full set, and of the small one."""

SEED, VALIDATION_SEED, TRAINING_SEED = 15595, 54105, 2021
"""Seeds of the type test, of the validation set for a finished controller, and of the training set.

During the development of slope seeking, results of the validation set were read five times (docs/type_test.md)."""

FRICTION: Final = (0.02, 0.15)
SPEED: Final = (40 / KMH, 200 / KMH)  # m/s
MAX_DURATION: Final = 150.0
"""Maximum duration of a stop at six tenths of the friction [s]; it limits the speed on a slippery rail."""

CURVES: Final = ("dry", "wet", "very_low", "low_steep", "poor_wheelset_study", "soap", "leaf")
RAILS: Final = ("even", "patches", "random")
LOADS: Final = MappingProxyType({"as believed": 1.0, "tare": 0.8, "laden": 1.05})
"""Masses relative to those that the controller assumes: the VT 642 has 67 t empty and 88 t full, its model 84 t."""
RADII: Final = MappingProxyType({"as believed": (1.0,), "worn": (0.99,), "new": (1.01,), "unequal": (1.005, 0.995)})
"""Wheel radii of the groups relative to those that the controller assumes."""
PADS: Final = MappingProxyType({"as believed": 1.0, "weak": 0.85, "strong": 1.15})
"""Pad friction relative to the nominal one: it varies by 15 % with lots and moisture."""
GRADIENTS: Final = MappingProxyType({"level": 0.0, "falling": -0.25, "climbing": 0.25})
"""Gradients as shares of the friction: on a fall steeper than the friction a train does not stop."""
STEEPEST: Final = 0.025


def _fault(part: str, kind: str, **more: Any) -> TomlTable:
    return {"faults": [{"part": part, "kind": kind, **more}]}


FAULTS: Final[Mapping[str, TomlTable]] = MappingProxyType(
    {
        "none": {},
        "radar 1 % high": _fault("radar", "scaled", value=1.01),
        "radar 1 % low": _fault("radar", "scaled", value=0.99),
        "radar stuck": _fault("radar", "stuck", begin="4 s", end="7 s"),
        "radar dead": _fault("radar", "dead", begin="4 s"),
        "wheel speed dead": _fault("speed_sensor", "dead", group=1, begin="4 s"),
        "wheel speed zero": _fault("speed_sensor", "zero", group=1, begin="4 s"),
        "accelerometer off": _fault("accelerometer", "biased", value="0.2 m/s**2"),
        "pressure off": _fault("transducer", "biased", group=1, value="0.3 bar"),
        "valve held": _fault("valve", "held", group=1, begin="4 s"),
        "valve slow": _fault("valve", "slow", value="60 ms"),
        "brake isolated": _fault("brake", "isolated", group=1),
        "supply sagging": _fault("supply", "sagging", value="450 l", pressure="8 bar"),
    }
)
"""Fault → tables of the scenario; `none` occurs as often as all the others together."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    """One stop of the test, the same for every controller.

    Attributes:
        name: Its number and the number of cases.
        curve: Shape of the creep curve.
        rail: How friction changes: a key of `RAILS`.
        friction: Mean of the maximum friction [1].
        speed: Speed at the brake demand [m/s].
        load, radius, pads, gradient, fault: Keys of the tables above.
        lot: Seed of sensors and rail.
    """

    name: str
    curve: str
    rail: str
    friction: float
    speed: float
    load: str
    radius: str
    pads: str
    gradient: str
    fault: str
    lot: int

    @property
    def train(self) -> str:
        """Name of its train: '' for that of the command."""
        return ""

    @property
    def has_bound(self) -> bool:
        """Whether the ideal bound is pointwise: slip does not change the rail."""
        return True

    @property
    def horizon(self) -> float:
        """Time after which the stop counts as failed [s]: three times the duration at six tenths of the friction."""
        return float(round(15.0 + 3.0 * self.speed / (0.6 * self.friction * GRAVITY)))

    @property
    def slope(self) -> float:
        """Gradient, climbing positive [1]."""
        return float(np.clip(GRADIENTS[self.gradient] * self.friction, -STEEPEST, STEEPEST))

    def variants(self) -> dict[str, str]:
        """Return its values as text."""
        rest = {name: str(value) for name, value in asdict(self).items() if name not in ("name", "lot")}
        return {
            "case": self.name,
            **rest,
            "friction": f"{self.friction:.3f}",
            "speed": f"{KMH * self.speed:.0f} km/h",
            "gradient": f"{1000 * self.slope:+.0f} ‰" if self.slope else "level",
        }

    def tables(self, groups: int) -> TomlTable:
        """Return the overrides for the scenario of a train with a number of groups."""
        radii = RADII[self.radius]
        truth = {
            "load": LOADS[self.load],
            "wheel_radius": [radii[group % len(radii)] for group in range(groups)],
            "pad_friction": PADS[self.pads],
            "gradient": self.slope,
        }
        return {
            "seed": self.lot,
            "start": {"speed": self.speed},
            "truth": truth,
            "adhesion": self._adhesion(),
            "limits": {"horizon": self.horizon},
        }

    def fault_tables(self, groups: int) -> TomlTable:
        """Return the tables of its fault."""
        return FAULTS[self.fault]

    def _adhesion(self) -> TomlTable:
        # Patches and noise reach all wheelsets at once, unlike on a real rail. This favours control that compares
        # neighbouring groups.
        mean, draw = self.friction, self.lot % 1000 / 1000
        match self.rail:
            case "patches":
                return {
                    "kind": "trapezoid", "polach": self.curve, "over": "time", "minimum": 0.6 * mean,
                    "maximum": 1.4 * mean, "first_fall": f"{1 + 3 * draw} s", "period": f"{6 + 6 * draw} s",
                    "low": f"{2 + 3 * draw} s", "ramp": f"{0.3 + draw} s",
                }  # fmt: skip
            case "random":
                return {
                    "kind": "random", "polach": self.curve, "over": "time", "mean": mean, "deviation": 0.2 * mean,
                    "correlation": f"{0.3 + draw} s", "minimum": 0.4 * mean, "maximum": 1.6 * mean,
                }  # fmt: skip
            case _:
                return {"kind": "constant", "polach": self.curve, "mu0": mean}


def ranks(count: int, axes: int, seed: int) -> NDArray[np.float64]:
    """Return the points of a scrambled Sobol sequence by the ranks of their coordinates, in (0, 1), (count, axes)."""
    sample = Sobol(axes, rng=np.random.default_rng(seed)).random_base2(max(count - 1, 1).bit_length())[:count]
    return (sample.argsort(axis=0).argsort(axis=0) + 0.5) / count


def at(values: Sequence[T], place: float) -> T:
    """Return the one of some values at a place in (0, 1)."""
    return values[int(place * len(values))]


def on_log_scale(span: tuple[float, float], place: float) -> float:
    """Return the value at a place in (0, 1) of a span on a logarithmic scale, with three digits."""
    return float(f"{span[0] * (span[1] / span[0]) ** place:.3g}")


def cases(count: int = CASES, seed: int = SEED) -> tuple[Case, ...]:
    """Return a number of cases, the same ones for the same seed."""
    axes: Mapping[str, Sequence[str]] = {
        "curve": CURVES, "rail": RAILS, "load": tuple(LOADS), "radius": tuple(RADII), "pads": tuple(PADS),
        "gradient": tuple(GRADIENTS), "fault": (*FAULTS, *["none"] * (len(FAULTS) - 2)),
    }  # fmt: skip
    digits = len(str(count))
    design: list[Case] = []
    for number, (slippery, fast, lot, *places) in enumerate(ranks(count, 3 + len(axes), seed), start=1):
        friction = on_log_scale(FRICTION, slippery)
        fastest = min(SPEED[1], 0.6 * friction * GRAVITY * MAX_DURATION)
        design.append(
            Case(
                name=f"{number:0{digits}d}of{count}-{seed}",
                friction=friction,
                speed=round(SPEED[0] + fast * (fastest - SPEED[0]), 2),
                lot=int(1e6 * lot),
                **{name: at(values, place) for (name, values), place in zip(axes.items(), places, strict=True)},
            )
        )
    return tuple(design)
