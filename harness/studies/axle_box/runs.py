"""Which passes of the instrumented car are simulated, and what for."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Final

import numpy as np

from railgrip.scenario.seed import generator
from railgrip.studies.axle_box.instrumented_car import MPH, Pass

SPEEDS: Final = (16, 26, 40, 60)
"""mph."""

LABELS: Final[Mapping[int, tuple[tuple[str, float], ...]]] = {
    16: (("dry", 0.31), ("friction modifier", 0.14), ("friction modifier", 0.17), ("wet", 0.161),
         ("detergent", 0.18), ("paper tape", 0.16)),
    26: (("dry", 0.29), ("friction modifier", 0.19), ("wet", 0.191), ("detergent", 0.21),
         ("paper tape", 0.16), ("paper tape", 0.22)),
    40: (("dry", 0.31), ("dry", 0.37), ("friction modifier", 0.17), ("wet", 0.24), ("detergent", 0.22),
         ("paper tape", 0.10)),
    60: (("dry", 0.30), ("dry", 0.35), ("friction modifier", 0.16), ("wet", 0.27), ("detergent", 0.24),
         ("paper tape", 0.11)),
}  # fmt: skip
"""Table 2 of Abduraxman et al. (2024): measured friction of the six runs at each speed."""

TRACK: Final = "erri-low"
HOME: Final = 1
"""Seed of the test track's irregularities; the 24 runs of the campaign share it."""

RANGES: Final[Mapping[str, tuple[float, float]]] = {
    "dry": (0.24, 0.45), "friction modifier": (0.12, 0.25), "wet": (0.14, 0.30), "detergent": (0.10, 0.26),
    "paper tape": (0.05, 0.24),
}  # fmt: skip
"""Friction that each condition spans in the design, around what Tables 1 and 2 of the paper report for it."""


def campaign(*, length: float = 400.0) -> tuple[Pass, ...]:
    """Return the 24 runs of the paper."""
    return tuple(
        Pass(
            name=f"{speed} mph, {condition}, {friction:g}, {k + 1}",
            speed=speed * MPH, condition=condition, friction=friction,
            track=TRACK, track_seed=HOME, seed=1, length=length,
        )
        for speed in SPEEDS
        for k, (condition, friction) in enumerate(LABELS[speed])
    )  # fmt: skip


def abroad(passes: tuple[Pass, ...], *, length: float = 200.0) -> dict[str, tuple[Pass, ...]]:
    """Return the same runs repeated, and elsewhere: each set changes one thing and every noise.

    On one surface for all, friction is what it was, but the slope of the creep curve no longer goes with it. An
    estimator of friction has as much to tell there as elsewhere; one that knows which film lies on the rail, nothing.
    """
    return {
        "same track, another day": tuple(replace(p, length=length, seed=2) for p in passes),
        "other irregularities": tuple(replace(p, length=length, seed=3, track_seed=2) for p in passes),
        "other direction": tuple(replace(p, length=length, seed=4, backwards=True) for p in passes),
        "one surface for all": tuple(replace(p, length=length, seed=6, condition="wet") for p in passes),
        "other track class": tuple(replace(p, length=length, seed=5, track="erri-high", track_seed=3) for p in passes),
    }


def design(count: int, *, length: float = 200.0) -> tuple[Pass, ...]:
    """Return runs that span speed, friction, condition, track and direction, for the estimator that shall generalise.

    Its tracks (ERRI low and FRA 6, seeds of their own) are none of those it is judged on; ERRI high is not among them.
    """
    draw = generator(11, "learn.design")
    passes: list[Pass] = []
    conditions = list(RANGES)
    for k in range(count):
        condition = conditions[k % len(conditions)]
        low, high = RANGES[condition]
        passes.append(
            Pass(
                name=f"design {k}",
                # Even in the logarithm, because 16 to 26 mph is as large a change as 37 to 60.
                speed=float(np.exp(draw.uniform(np.log(15.0), np.log(63.0)))) * MPH,
                condition=condition, friction=round(float(draw.uniform(low, high)), 3),
                track=("erri-low", "fra-6")[k // len(conditions) % 2], track_seed=100 + k, seed=100 + k,
                backwards=bool(draw.random() < 0.5), length=length,
            )
        )  # fmt: skip
    return tuple(passes)
