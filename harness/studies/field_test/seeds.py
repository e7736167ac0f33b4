"""Case 6 over twelve seeds of the sensors: what of the errors is the draw of one set of them."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from railgrip.campaign.workers import ended, workers
from railgrip.errors import RailgripError
from railgrip.scenario.schema import Scenario
from railgrip.studies.field_test.filtering import filter_of, follow, prediction, task_of
from railgrip.studies.field_test.noise import Noise
from railgrip.studies.field_test.runs import TEST, run
from railgrip.studies.field_test.score import Score, TrackScore, score, track_score

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
    scenario: Scenario,
    noises: Mapping[str, Noise],
    seeds: Sequence[int],
    tell: Callable[[str], None] = lambda what: None,
    count: int = 2,
) -> Spread:
    """Return the errors with sensors of every seed, in the order of the seeds; `count` runs at a time.

    Raises:
        EstimationError: See `railgrip.studies.field_test.runs.run`.
    """
    by_seed: dict[int, tuple[TrackScore, dict[str, Score]]] = {}
    with workers(count) as pool:
        tasks = {pool.submit(_errors, scenario.model_copy(update={"seed": seed}), noises): seed for seed in seeds}
        for seed, errors in ended(tasks):
            if isinstance(errors, RailgripError):
                raise errors
            by_seed[seed] = errors
            tell(f"sensors {len(by_seed)} of {len(seeds)}")
    rows = [by_seed[seed] for seed in seeds]
    scores = {title: tuple(of_noises[title] for _, of_noises in rows) for title in noises}
    return Spread(tuple(track for track, _ in rows), scores)


def _errors(scenario: Scenario, noises: Mapping[str, Noise]) -> tuple[TrackScore, dict[str, Score]]:
    """Return the errors of a run: of its track, and of the filter by the title of its noises."""
    model, field_run = prediction(), run(scenario, TEST)
    task = task_of(field_run.braking, model)
    filter_ = filter_of(model, task.period)
    return track_score(field_run), {title: score(task, follow(task, filter_, noise)) for title, noise in noises.items()}
