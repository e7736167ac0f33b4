"""Case 6 measured again and again: what of the errors is the draw of one set of sensors."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from railgrip.estimation.track.braking import braking_of
from railgrip.studies.field.filtering import filter_of, follow, prediction, task_of
from railgrip.studies.field.noise import Noise
from railgrip.studies.field.runs import TEST
from railgrip.studies.field.score import Score, TrackScore, score, track_score
from railgrip.twins.field_scenario import FieldScenario
from railgrip.twins.field_train import driven, measured

SEEDS = tuple(range(1, 13))


@dataclass(frozen=True, slots=True)
class Spread:
    """Errors in case 6, one for each seed.

    Attributes:
        tracks: Of what was recovered.
        scores: Of the filter, by the title of its noises.
    """

    tracks: tuple[TrackScore, ...]
    scores: Mapping[str, tuple[Score, ...]]


def over_seeds(
    scenario: FieldScenario,
    noises: Mapping[str, Noise],
    seeds: Sequence[int],
    tell: Callable[[str], None] = lambda what: None,
) -> Spread:
    """Return the errors with sensors of every seed; the train is driven once.

    Raises:
        EstimationError: See `driven` and `braking_of`.
    """
    model = prediction()
    filter_ = filter_of(model, scenario.period)
    train = driven(scenario, TEST)
    tracks: list[TrackScore] = []
    scores: dict[str, list[Score]] = {title: [] for title in noises}
    for number, seed in enumerate(seeds, start=1):
        tell(f"sensors {number} of {len(seeds)}")
        run = measured(scenario, train, seed)
        braking = braking_of(run, scenario.train.mass, curve_law=scenario.track.curve_law)
        tracks.append(track_score(run, braking))
        task = task_of(braking, model)
        for title, noise in noises.items():
            scores[title].append(score(task, follow(task, filter_, noise)))
    return Spread(tuple(tracks), {title: tuple(found) for title, found in scores.items()})
