"""Passes of the instrumented car that are simulated, and training and judgement on them."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any, Final

import numpy as np

from railgrip.base.arrays import generator
from railgrip.base.files import replacing
from railgrip.base.records import claim
from railgrip.estimation.axle_box.evaluate import (
    ScaledNetwork,
    TrainingRecipe,
    evaluate_elsewhere,
    exchange_labels,
    inside_training,
    score_of_best,
    within_runs,
    without_each,
)
from railgrip.estimation.axle_box.instrumented_car import (
    MPH,
    OTHER_CHAINS,
    PAPER,
    SLOW,
    SPECTRAL,
    LabelledRun,
    Pass,
    spectral_features,
)
from railgrip.estimators.learned.network import Ensemble, fit
from railgrip.estimators.learned.preprocessing import BLOCKS, COMBINATIONS, Chain
from railgrip.estimators.learned.trained import GeneralEstimator, PaperEstimator, Trained, save
from railgrip.fmus.native.discrete import sources
from railgrip.fmus.native.package import pack

SPEEDS: Final = (16, 26, 40, 60)
"""mph."""

LABELS: Final[Mapping[int, Sequence[tuple[str, float]]]] = {int(mph): runs for mph, runs in PAPER["labels"].items()}
"""Table 2 of Abduraxman et al. (2024): measured friction of the six runs at each speed."""

TRACK: Final = "erri-low"
HOME: Final = 1
"""Seed of the irregularities of the test track, common to the 24 runs of the campaign."""

RANGES: Final[Mapping[str, tuple[float, float]]] = {name: one["friction"] for name, one in PAPER["conditions"].items()}
"""Range of friction of each condition in the design, around the values of Tables 1 and 2 of the paper."""


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


def vary_circumstances(passes: tuple[Pass, ...], *, length: float = 200.0) -> dict[str, tuple[Pass, ...]]:
    """Return the same runs under other conditions: each set changes one condition and all noises.

    With one surface for all, friction is unchanged but independent of the slope of the creep curve. An estimator of
    friction works there as elsewhere; one that recognises the film on the rail does not.
    """
    return {
        "same track, another day": tuple(replace(p, length=length, seed=2) for p in passes),
        "other irregularities": tuple(replace(p, length=length, seed=3, track_seed=2) for p in passes),
        "other direction": tuple(replace(p, length=length, seed=4, backwards=True) for p in passes),
        "one surface for all": tuple(replace(p, length=length, seed=6, condition="wet") for p in passes),
        "other track class": tuple(replace(p, length=length, seed=5, track="erri-high", track_seed=3) for p in passes),
    }


def design(count: int, *, length: float = 200.0) -> tuple[Pass, ...]:
    """Return runs over the ranges of speed, friction, condition, track and direction, to train the general estimator.

    No track (ERRI low and FRA 6, other seeds) is one of the judgement; ERRI high is not among them.
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
                # Uniform in the logarithm, because 16 to 26 mph is as large a change as 37 to 60.
                speed=float(np.exp(draw.uniform(np.log(15.0), np.log(63.0)))) * MPH,
                condition=condition, friction=round(float(draw.uniform(low, high)), 3),
                track=("erri-low", "fra-6")[k // len(conditions) % 2], track_seed=100 + k, seed=100 + k,
                backwards=bool(draw.random() < 0.5), length=length,
            )
        )  # fmt: skip
    return tuple(passes)


DECAYS: Final = (0.0, 1e-9, 1e-8, 1e-7, 1e-6)
"""Weights of the squared weights compared inside of the training part."""

NEURONS: Final = (2, 4, 6, 9)
"""Sizes of the hidden layer that are compared; the paper chose 6."""

STATEMENTS: Final[Mapping[str, Mapping[str, Any]]] = {
    "four wheelsets, the chain of the paper": {},
    **{f"{name} wheelset{'s' if count > 1 else ''}": {"wheelsets": count}
       for count, name in ((3, "three"), (2, "two"), (1, "one"))},
    **{name: {"chain": name} for name in OTHER_CHAINS if name != "first second is zero"},
}  # fmt: skip
"""Variants by which statements of the paper are tested → their values of the recipe: at least four states are
necessary, signals drift without the high-pass, and the length of the blocks has almost no effect."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Size:
    """Amount of simulation and training.

    Attributes:
        speeds: mph.
        starts: Random starts of the paper's networks; honest_starts: with every run left out once.
        design: Number of runs for the general estimator; members: of its networks.
        length: Of the runs of the campaign, m; away: of all others, m.
    """

    speeds: tuple[int, ...]
    starts: int
    honest_starts: int
    design: int
    members: int
    length: float
    away: float


FULL: Final = Size(speeds=SPEEDS, starts=15, honest_starts=3, design=80, members=20, length=400.0, away=200.0)
QUICK: Final = Size(speeds=(60,), starts=3, honest_starts=1, design=6, members=3, length=200.0, away=200.0)
"""Form that checks that the study runs; its numbers have no meaning."""


def passes(size: Size) -> dict[str, tuple[Pass, ...]]:
    """Return every run of the study by set; estimators are trained on `campaign` and `design`."""
    home = tuple(p for p in campaign(length=size.length) if int(p.name.split()[0]) in size.speeds)
    return {
        "campaign": home,
        "design": design(size.design, length=size.away),
        **vary_circumstances(home, length=size.away),
    }


def judgements(
    runs: Sequence[LabelledRun], away: Mapping[str, Sequence[LabelledRun]], recipe: TrainingRecipe, few: TrainingRecipe
) -> dict[tuple[str, str], Callable[[], Any]]:
    """Return the judgements of the paper's networks at one speed, by table and row; each returns a `Score`.

    `split` is the paper's split, with variants that explain it; `decays` is trained on the first 64 % of each run and
    judged on the following 16 %, source of `evaluate.DECAY`; `inputs`, `neurons` and `statements` are the paper's split
    with each combination of motions, size of the hidden layer and of `STATEMENTS`; `best` is the network with the best
    fit; `honest` are runs outside of the training, of which the row "" returns several scores by row.

    Args:
        runs: Runs of the campaign.
        away: Other sets of runs at this speed.
        recipe: Recipe with all random starts.
        few: Recipe with fewer starts, for means over speeds or runs.
    """
    free = replace(recipe, decay=0.0)
    exchanged = exchange_labels(runs)
    split = {
        "bias inside": partial(within_runs, runs, free),
        "bias outside": partial(within_runs, runs, replace(free, bias="outside")),
        "bias inside, weights kept small": partial(within_runs, runs, recipe),
        "bias outside, weights kept small": partial(within_runs, runs, replace(recipe, bias="outside")),
        "labels exchanged": partial(within_runs, exchanged, recipe),
        "first second is zero": partial(within_runs, runs, replace(recipe, chain="first second is zero")),
    }
    return {
        **{("split", name): task for name, task in split.items()},
        **{("decays", f"{decay:g}"): partial(inside_training, runs, replace(few, decay=decay)) for decay in DECAYS},
        **{("inputs", name): partial(within_runs, runs, replace(few, inputs=name)) for name in COMBINATIONS},
        **{("statements", name): partial(within_runs, runs, replace(few, **each)) for name, each in STATEMENTS.items()},
        **{("neurons", f"{count}"): partial(within_runs, runs, replace(few, hidden=count)) for count in NEURONS},
        ("best", "one of the best networks"): partial(score_of_best, runs, few),
        ("honest", "a run left out"): partial(without_each, runs, few),
        ("honest", ""): partial(evaluate_elsewhere, runs, away, recipe),
    }


def estimators_of(
    ensemble: Ensemble, networks: Mapping[int, ScaledNetwork], recipe: TrainingRecipe
) -> dict[str, Trained]:
    """Return the trained estimators by the name of their file.

    Args:
        ensemble: The general estimator.
        networks: Networks of the paper's kind, by speed class in mph, each with its filters and scaling.
        recipe: Recipe of these networks.
    """
    papers = {
        f"friction_{speed}mph": PaperEstimator(
            chain=Chain(rate=SLOW.rate, block=BLOCKS[speed]),
            scale=fitted.scale,
            networks=(fitted.network,),
            inputs=recipe.inputs,
        )
        for speed, fitted in networks.items()
    }
    return {"friction": GeneralEstimator(slow=SLOW, spectral=SPECTRAL, ensemble=ensemble), **papers}


def export(trained: Mapping[str, Trained], folder: Path) -> None:
    """Write estimators into a folder that exists: NAME.json for `railgrip ride`, and NAME.fmu."""
    claim(folder, *(f"{name}.{kind}" for name in trained for kind in ("json", "fmu")))
    for name, each in trained.items():
        with replacing(folder / f"{name}.json") as partial_file:
            save(each, partial_file)
        pack(sources(each.online()), folder / f"{name}.fmu")


def general(runs: Sequence[LabelledRun], members: int) -> tuple[Ensemble, float]:
    """Train the general estimator; return it and the mean label of its training.

    It has two stages if the slope of the creep curve is known for every run, as in simulations.
    """
    features = [spectral_features(run) for run in runs]
    labels = np.concatenate([np.full(len(f), run.friction) for f, run in zip(features, runs, strict=True)])
    number = np.concatenate([np.full(len(f), k, dtype=np.int64) for k, f in enumerate(features)])
    values = [run.slope for run in runs if run.slope is not None]
    slopes = np.array(values)[number] if len(values) == len(runs) else None
    network = fit(
        np.vstack(features), labels, number, generator=generator(0, "learn.ensemble"), slope=slopes, members=members
    )
    return network, float(labels.mean())


def dry_or_not(sets: Mapping[str, Sequence[Pass]]) -> dict[str, dict[str, float]]:
    """Return for each pass of each set the mean label of the design's passes on dry, or on other rails.

    A dry rail is distinguished from a covered one without an estimator; an estimator must be better than this.
    """
    labels = {dry: [p.friction for p in sets["design"] if (p.condition == "dry") is dry] for dry in (True, False)}
    mean = {dry: float(np.mean(values)) for dry, values in labels.items()}
    return {name: {p.name: mean[p.condition == "dry"] for p in part} for name, part in sets.items()}
