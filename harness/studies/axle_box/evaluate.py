"""How good is it? The paper's split, and the splits that tell recognition of a run from estimation of friction."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, Final

import numpy as np

from railgrip.estimators.belief import Array
from railgrip.estimators.learned.ensemble import Ensemble
from railgrip.estimators.learned.network import Bias, Network, train
from railgrip.estimators.learned.preprocessing import COMBINATIONS, Scale
from railgrip.scenario.seed import generator
from railgrip.studies.axle_box.reduction import CHANNELS, Run, spectral_features

HIDDEN: Final = 6
TRAINED: Final = 0.8
DECAY: Final = 1e-8
"""Weight of the squared weights against the mean squared error. Without it some random starts end in networks of huge
weights, which follow the training part to the last wiggle and are wrong by 0.1 right after it. Chosen on the training
part alone, the middle of the weights that make little difference there; see `inside_training` and the report."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Score:
    """Errors over one set of samples.

    Attributes:
        starts: Random starts.
        rmse, mae: Of the estimator, means over its random starts.
        best: Lowest mae of them.
        worst: Highest mae of them.
        spread: Standard deviation of mae over them.
        mae_of_mean: Of the predictor that always says the mean label of what was trained on.
        coverage: Share of labels inside the 90 % interval, where the estimator gives one.
        width: Mean width of that interval.
        mae_of_rule: Of who is told only whether the rail is dry and says the mean label of training on such rails.
    """

    starts: int
    rmse: float
    mae: float
    best: float
    worst: float
    spread: float
    mae_of_mean: float
    coverage: float | None = None
    width: float | None = None
    mae_of_rule: float | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class ScaledNetwork:
    """A network with the scaling in front of it."""

    network: Network
    scale: Scale

    def __call__(self, blocks: Array) -> Array:
        """Return friction for block means, shape (n, channels) → (n,)."""
        return self.network(self.scale(blocks))


@dataclass(frozen=True, slots=True, kw_only=True)
class Recipe:
    """How the paper's networks are trained.

    Attributes:
        inputs: Key of `channels.COMBINATIONS`.
        bias: Reading of equation (4).
        settled: Whether the high-pass starts at the mean of the first second instead of the first sample.
        starts: Random initialisations.
        steps: Of Levenberg-Marquardt.
        decay: Weight of the squared weights, see `network.train`.
    """

    inputs: str = "longitudinal"
    bias: Bias = "inside"
    settled: bool = False
    starts: int = 15
    steps: int = 100
    decay: float = DECAY

    def blocks(self, run: Run) -> Array:
        """Return what the network sees of a run, before scaling."""
        whole = run.settled if self.settled else run.blocks
        return np.hstack([whole[:, CHANNELS[motion]] for motion in COMBINATIONS[self.inputs]])

    def fit(self, data: Sequence[tuple[Array, Array]], purpose: str) -> list[ScaledNetwork]:
        """Return one network for each random start, trained on (blocks, labels) of several runs linked together."""
        x, y = np.vstack([d[0] for d in data]), np.concatenate([d[1] for d in data])
        scale = Scale.over(x)
        draws = generator(0, f"learn.start.{purpose}").spawn(self.starts)
        return [
            ScaledNetwork(
                network=train(
                    scale(x), y, hidden=HIDDEN, bias=self.bias, generator=draw, decay=self.decay, steps=self.steps
                ),
                scale=scale,
            )
            for draw in draws
        ]


def labels_of(runs: Sequence[Run]) -> dict[str, float]:
    """Return the label of each run, by name."""
    return {run.name: run.friction for run in runs}


def exchanged(runs: Sequence[Run]) -> dict[str, float]:
    """Return labels handed on from run to run: half of the runs away, so that friction no longer fits the run."""
    frictions = [run.friction for run in runs]
    shift = max(1, len(runs) // 2)
    return {run.name: frictions[(k + shift) % len(runs)] for k, run in enumerate(runs)}


Labels = Callable[[Sequence[Run]], Mapping[str, float]]
"""`labels_of`, or `exchanged`: every run under the label of another."""


def within_runs(runs: Sequence[Run], recipe: Recipe, labels: Labels = labels_of) -> Score:
    """Train on the first 80 % of every run, of one speed, judge on the last 20 %: the paper's split."""
    early, late = parts_of(runs, recipe, labels)
    return score(recipe.fit(early, f"within.{runs[0].group}"), early, late)


def inside_training(runs: Sequence[Run], recipe: Recipe) -> Score:
    """Judge inside of the training part: train on the first 64 % of every run, judge on the following 16 %."""
    training, _ = parts_of(runs, recipe)
    early = [(blocks[: _cut(blocks)], labels[: _cut(blocks)]) for blocks, labels in training]
    late = [(blocks[_cut(blocks) :], labels[_cut(blocks) :]) for blocks, labels in training]
    return score(recipe.fit(early, f"within.{runs[0].group}"), early, late)


def parts_of(
    runs: Sequence[Run], recipe: Recipe, labels: Labels = labels_of
) -> tuple[list[tuple[Array, Array]], list[tuple[Array, Array]]]:
    """Return the first 80 % and the last 20 % of every run as (blocks, labels)."""
    label_of = labels(runs)
    parts = [(recipe.blocks(run), label_of[run.name]) for run in runs]
    return (
        [_labelled(blocks[: _cut(blocks)], label) for blocks, label in parts],
        [_labelled(blocks[_cut(blocks) :], label) for blocks, label in parts],
    )


def best_of(runs: Sequence[Run], recipe: Recipe, labels: Labels = labels_of) -> ScaledNetwork:
    """Return, of networks trained on the first 80 % of every run, the one that fits these best."""
    early, _ = parts_of(runs, recipe, labels)
    x, y = np.vstack([d[0] for d in early]), np.concatenate([d[1] for d in early])
    return min(recipe.fit(early, f"within.{runs[0].group}"), key=lambda one: float(np.abs(one(x) - y).mean()))


def without_each(runs: Sequence[Run], recipe: Recipe) -> Score:
    """Leave one run out at a time and judge on it."""
    scores: list[Score] = []
    for test_run in runs:
        training = [_labelled(recipe.blocks(run), run.friction) for run in runs if run is not test_run]
        new = [_labelled(recipe.blocks(test_run), test_run.friction)]
        scores.append(score(recipe.fit(training, f"without.{test_run.name}"), training, new))
    return average(scores)


def elsewhere(home: Sequence[Run], away: Mapping[str, Sequence[Run]], recipe: Recipe) -> dict[str, Score]:
    """Train on all of the campaign at one speed, judge on other sets of runs at that speed."""
    training = [_labelled(recipe.blocks(run), run.friction) for run in home]
    networks = recipe.fit(training, f"home.{home[0].group}")
    return {
        name: score(networks, training, [_labelled(recipe.blocks(run), run.friction) for run in runs])
        for name, runs in away.items()
    }


def judge(ensemble: Ensemble, mean_label: float, runs: Sequence[Run], rule: Sequence[float] | None = None) -> Score:
    """Judge the estimator for all speeds on runs it has not seen; one estimate every 20 m.

    Args:
        mean_label: Of what it was trained on.
        rule: For each run, the mean label of training on rails as dry, or as little dry, as its own.
    """
    estimates, truth, recipes = [], [], []
    for k, run in enumerate(runs):
        estimator = ensemble(spectral_features(run))
        estimates.append(np.column_stack([estimator.friction, estimator.lower, estimator.upper]))
        truth.append(np.full(len(estimator.friction), run.friction))
        if rule is not None:
            recipes.append(np.full(len(estimator.friction), rule[k]))
    whole, y = np.vstack(estimates), np.concatenate(truth)
    return replace(
        _figures([whole[:, 0] - y], y - mean_label),
        coverage=float(((whole[:, 1] <= y) & (y <= whole[:, 2])).mean()),
        width=float((whole[:, 2] - whole[:, 1]).mean()),
        mae_of_rule=float(np.abs(np.concatenate(recipes) - y).mean()) if recipes else None,
    )


def score(
    networks: Sequence[Callable[[Array], Array]],
    training: Sequence[tuple[Array, Array]],
    new: Sequence[tuple[Array, Array]],
) -> Score:
    """Return the errors of several networks, beside those of the mean label of what they have seen."""
    x, y = np.vstack([d[0] for d in new]), np.concatenate([d[1] for d in new])
    mean = np.concatenate([d[1] for d in training]).mean()
    return _figures([one(x) - y for one in networks], y - mean)


def average(scores: Iterable[Score]) -> Score:
    """Return the mean of every figure that all of the scores have."""
    first, *others = scores
    means: dict[str, Any] = {}
    for name in (field.name for field in fields(Score) if field.name != "starts"):
        values = [getattr(one, name) for one in (first, *others)]
        means[name] = None if None in values else float(np.mean(values))
    return replace(first, **means)


def _figures(errors: Sequence[Array], of_mean: Array) -> Score:
    """Return the figures of errors, one for each random start, beside those of the mean label."""
    absolute = [float(np.abs(e).mean()) for e in errors]
    return Score(
        starts=len(errors),
        rmse=float(np.mean([_rms(e) for e in errors])), mae=float(np.mean(absolute)), best=min(absolute),
        worst=max(absolute), spread=float(np.std(absolute)),
        mae_of_mean=float(np.abs(of_mean).mean()),
    )  # fmt: skip


def _labelled(blocks: Array, label: float) -> tuple[Array, Array]:
    return blocks, np.full(len(blocks), label)


def _cut(blocks: Array) -> int:
    return int(TRAINED * len(blocks))


def _rms(error: Array) -> float:
    return float(np.sqrt(np.mean(error**2)))
