"""Braking distances of many scenarios, run by processes and kept by content: a study goes on where it stopped."""

import time
from collections.abc import Sequence
from concurrent.futures import Executor
from statistics import median

from railgrip.assemble import braking_distance
from railgrip.assemble.files import plant_description
from railgrip.campaign.store import ground, results_of
from railgrip.scenario.schema import Scenario
from railgrip.sources import sources_digest

KIND = "k-factor-stops"
"""Their shelf in the user's cache."""


class Stops:
    """The stops of a scenario's plant with the sources as they are, run by a pool of processes.

    Attributes:
        requests: Stops that were asked for.
        run: Those of them that were not in the cache.
    """

    def __init__(self, scenario: Scenario, pool: Executor) -> None:
        """Run nothing yet."""
        self._pool, self._ground = pool, ground(sources_digest().encode(), plant_description(scenario).digest.encode())
        self._seconds: list[float] = []
        self.requests = self.run = 0

    def distances(self, scenarios: Sequence[Scenario]) -> list[float | None]:
        """Return the braking distance of each [m], None without a standstill.

        Raises:
            RailgripError: One could not be run; those that were are kept.
        """

        def count(scenario: Scenario, was_there: bool) -> None:
            self.run += not was_there

        results = results_of(KIND, scenarios, _stop, self._pool, self._ground, count, Scenario.digest)
        self.requests += len(results)
        self._seconds += [seconds for _, seconds in results]
        return [distance for distance, _ in results]

    @property
    def seconds(self) -> float:
        """Median time of a stop, of one core that does nothing else."""
        return median(self._seconds)


def _stop(scenario: Scenario) -> tuple[float | None, float]:
    begin = time.process_time()
    return braking_distance(scenario), time.process_time() - begin
