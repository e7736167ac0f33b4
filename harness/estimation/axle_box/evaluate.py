"""Splits of runs into training and test, and scores: the paper's split, and splits that test unknown runs."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, Final

import numpy as np

from railgrip.base.arrays import generator
from railgrip.estimation.axle_box.instrumented_car import CHANNELS, LabelledRun, spectral_features
from railgrip.estimation.judgement import rms
from railgrip.estimators.belief import Array
from railgrip.estimators.learned.network import Bias, Ensemble, Network, train
from railgrip.estimators.learned.preprocessing import COMBINATIONS, Scale

HIDDEN: Final = 6
TRAINED: Final = 0.8
DECAY: Final = 1e-8
"""Weight of the squared weights relative to the mean squared error. Without it some random starts end in networks with
huge weights, which overfit the training part and are wrong by 0.1 right after it. Chosen on the training part alone, as
the middle of the range without much influence there; see `inside_training` and docs/studies/axle_box.md."""


Labelled = tuple[Array, Array]
"""Blocks, shape (n, channels), and their labels, shape (n,)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Score:
    """Errors over one set of samples.

    Attributes:
        starts: Number of random starts.
        rmse, mae: RMS and mean absolute error of the estimator, means over its random starts.
        best: Lowest mae over the starts.
        worst: Highest mae over the starts.
        mae_of_mean: Mean absolute error of the training's mean label as a constant estimate.
        coverage: Share of labels inside the 90 % interval, for an estimator with interval.
        width: Mean width of that interval.
        mae_of_rule: Of the mean label of training on dry, or on other rails, whichever the run has.
    """

    starts: int
    rmse: float
    mae: float
    best: float
    worst: float
    mae_of_mean: float
    coverage: float | None = None
    width: float | None = None
    mae_of_rule: float | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class ScaledNetwork:
    """A network with the scaling of its inputs."""

    network: Network
    scale: Scale

    def __call__(self, blocks: Array) -> Array:
        """Return friction for block means, shape (n, channels) → (n,)."""
        return self.network(self.scale(blocks))


@dataclass(frozen=True, slots=True, kw_only=True)
class TrainingRecipe:
    """Training of the paper's networks.

    Attributes:
        inputs: Key of `preprocessing.COMBINATIONS`.
        bias: Reading of equation (4).
        chain: Key of `reduction.OTHER_CHAINS`; empty for the paper's chain.
        wheelsets: Number of wheelsets with accelerometers, from the first.
        starts: Random initialisations.
        steps: Number of Levenberg-Marquardt steps.
        decay: Weight of the squared weights, see `network.train`.
        hidden: Number of neurons of the hidden layer.
    """

    inputs: str = "longitudinal"
    bias: Bias = "inside"
    chain: str = ""
    wheelsets: int = 4
    starts: int = 15
    steps: int = 100
    decay: float = DECAY
    hidden: int = HIDDEN

    def blocks(self, run: LabelledRun) -> Array:
        """Return the inputs of the network for a run, before scaling."""
        blocks = run.other_blocks[self.chain] if self.chain else run.blocks
        return np.hstack([blocks[:, CHANNELS[motion]][:, : self.wheelsets] for motion in COMBINATIONS[self.inputs]])

    def data(self, runs: Sequence[LabelledRun]) -> list[Labelled]:
        """Return the inputs of the network and their labels for each run."""
        return [(blocks, np.full(len(blocks), run.friction)) for run in runs for blocks in (self.blocks(run),)]

    def fit(self, data: Sequence[Labelled], purpose: str) -> list[ScaledNetwork]:
        """Return one network for each random start, trained on several runs together."""
        x, y = _join(data)
        scale = Scale.over(x)
        draws = generator(0, f"learn.start.{purpose}").spawn(self.starts)
        return [
            ScaledNetwork(
                network=train(
                    scale(x),
                    y,
                    hidden=self.hidden,
                    bias=self.bias,
                    generator=draw,
                    decay=self.decay,
                    steps=self.steps,
                ),
                scale=scale,
            )
            for draw in draws
        ]


def exchange_labels(runs: Sequence[LabelledRun]) -> list[LabelledRun]:
    """Return runs with labels shifted by half of the runs, so that a label does not match its run."""
    shift = max(1, len(runs) // 2)
    return [replace(run, friction=runs[(k + shift) % len(runs)].friction) for k, run in enumerate(runs)]


def within_runs(runs: Sequence[LabelledRun], recipe: TrainingRecipe) -> Score:
    """Train on the first 80 % of every run of one speed, judge on the last 20 %: the paper's split."""
    early, late = parts_of(runs, recipe)
    return score(recipe.fit(early, f"within.{runs[0].group}"), early, late)


def inside_training(runs: Sequence[LabelledRun], recipe: TrainingRecipe) -> Score:
    """Judge inside of the training part: train on the first 64 % of every run, judge on the following 16 %."""
    early, late = _split(parts_of(runs, recipe)[0])
    return score(recipe.fit(early, f"within.{runs[0].group}"), early, late)


def parts_of(runs: Sequence[LabelledRun], recipe: TrainingRecipe) -> tuple[list[Labelled], list[Labelled]]:
    """Return the first 80 % and the last 20 % of every run."""
    return _split(recipe.data(runs))


def best_of(runs: Sequence[LabelledRun], recipe: TrainingRecipe) -> ScaledNetwork:
    """Return the network with the best fit of those trained on the first 80 % of every run."""
    early, _ = parts_of(runs, recipe)
    x, y = _join(early)
    return min(recipe.fit(early, f"within.{runs[0].group}"), key=lambda network: float(np.abs(network(x) - y).mean()))


def score_of_best(runs: Sequence[LabelledRun], recipe: TrainingRecipe) -> Score:
    """Judge the network of `best_of` on the last 20 % of every run."""
    return score([best_of(runs, recipe)], *parts_of(runs, recipe))


def without_each(runs: Sequence[LabelledRun], recipe: TrainingRecipe) -> Score:
    """Leave one run out at a time and judge on it."""
    scores: list[Score] = []
    for test_run in runs:
        training = recipe.data([run for run in runs if run is not test_run])
        networks = recipe.fit(training, f"without.{test_run.name}")
        scores.append(score(networks, training, recipe.data([test_run])))
    return average(scores)


def evaluate_elsewhere(
    home: Sequence[LabelledRun], away: Mapping[str, Sequence[LabelledRun]], recipe: TrainingRecipe
) -> dict[str, Score]:
    """Train on all runs of the campaign at one speed, judge on other sets of runs at that speed."""
    training = recipe.data(home)
    networks = recipe.fit(training, f"home.{home[0].group}")
    return {name: score(networks, training, recipe.data(runs)) for name, runs in away.items()}


def estimates_of(ensemble: Ensemble, runs: Sequence[LabelledRun]) -> tuple[Array, Array, Array, Array, list[int]]:
    """Return friction, ends of its interval and label at all estimates over runs, and their number in each run."""
    estimates = [ensemble(spectral_features(run)) for run in runs]
    counts = [len(estimate.friction) for estimate in estimates]
    friction, lower, upper = (
        np.concatenate([getattr(estimate, name) for estimate in estimates]) for name in ("friction", "lower", "upper")
    )
    return friction, lower, upper, np.repeat([run.friction for run in runs], counts), counts


def judge(
    ensemble: Ensemble, mean_label: float, runs: Sequence[LabelledRun], rule: Sequence[float] | None = None
) -> Score:
    """Judge the estimator for all speeds on runs outside of its training; one estimate every 20 m.

    Args:
        mean_label: Of its training.
        rule: For each run, the mean label of training on dry, or on other rails, whichever the run has.
    """
    friction, lower, upper, y, counts = estimates_of(ensemble, runs)
    return replace(
        _figures([friction - y], y - mean_label),
        coverage=float(((lower <= y) & (y <= upper)).mean()),
        width=float((upper - lower).mean()),
        mae_of_rule=None if rule is None else float(np.abs(np.repeat(rule, counts) - y).mean()),
    )


def score(networks: Sequence[Callable[[Array], Array]], training: Sequence[Labelled], new: Sequence[Labelled]) -> Score:
    """Return the errors of several networks, and of the mean label of their training as a constant estimate."""
    x, y = _join(new)
    mean = _join(training)[1].mean()
    return _figures([network(x) - y for network in networks], y - mean)


def average(scores: Iterable[Score]) -> Score:
    """Return the mean of every figure that all scores have."""
    first, *others = scores
    means: dict[str, Any] = {}
    for name in (field.name for field in fields(Score) if field.name != "starts"):
        values = [getattr(score, name) for score in (first, *others)]
        means[name] = None if None in values else float(np.mean(values))
    return replace(first, **means)


def _figures(errors: Sequence[Array], of_mean: Array) -> Score:
    absolute = [float(np.abs(e).mean()) for e in errors]
    return Score(
        starts=len(errors),
        rmse=float(np.mean([rms(e) for e in errors])),
        mae=float(np.mean(absolute)),
        best=min(absolute),
        worst=max(absolute),
        mae_of_mean=float(np.abs(of_mean).mean()),
    )


def _join(parts: Sequence[Labelled]) -> Labelled:
    return np.vstack([blocks for blocks, _ in parts]), np.concatenate([labels for _, labels in parts])


def _split(parts: Sequence[Labelled]) -> tuple[list[Labelled], list[Labelled]]:
    cuts = [int(TRAINED * len(labels)) for _, labels in parts]
    early = [(blocks[:cut], labels[:cut]) for (blocks, labels), cut in zip(parts, cuts, strict=True)]
    return early, [(blocks[cut:], labels[cut:]) for (blocks, labels), cut in zip(parts, cuts, strict=True)]
