"""Braking distances of many scenarios, run by processes and kept by content: a study goes on where it stopped."""

import hashlib
import json
import time
from collections.abc import Generator, Sequence
from concurrent.futures import Executor
from contextlib import contextmanager
from pathlib import Path
from statistics import median

from railgrip.assemble import braking_distance
from railgrip.assemble.files import plant_description
from railgrip.campaign import workers as processes
from railgrip.errors import RailgripError
from railgrip.scenario.schema import Scenario
from railgrip.sources import sources_digest


class Stops:
    """A pool of processes and the journal of the stops they have run.

    Attributes:
        requests: Stops that were asked for.
        run: Those of them that were not in the journal.
    """

    def __init__(self, journal: Path, pool: Executor) -> None:
        """Read what is known."""
        self._journal, self._pool = journal, pool
        self._known: dict[str, tuple[float | None, float]] = {}
        self.requests = self.run = 0
        for line in journal.read_text(encoding="utf-8").splitlines() if journal.exists() else ():
            try:
                digest, distance, seconds = json.loads(line)
            except ValueError:  # half a line, of a study that was killed while it wrote
                continue
            self._known[digest] = distance, seconds

    def distances(self, scenarios: Sequence[Scenario]) -> list[float | None]:
        """Return the braking distance of each [m], None without a standstill.

        Raises:
            RailgripError: One could not be run; those that were are kept.
        """
        digests = [scenario.digest() for scenario in scenarios]
        new = {digest: one for digest, one in zip(digests, scenarios, strict=True) if digest not in self._known}
        running = {self._pool.submit(_stop, scenario): digest for digest, scenario in new.items()}
        with self._journal.open("a", encoding="utf-8") as file:
            for digest, result in processes.ended(running):
                if isinstance(result, RailgripError):
                    raise result
                self._known[digest] = result
                # A line of its own, whatever was before.
                file.write(f"\n{json.dumps([digest, *result])}")
                file.flush()
        self.requests, self.run = self.requests + len(digests), self.run + len(running)
        return [self._known[digest][0] for digest in digests]

    @property
    def seconds(self) -> float:
        """Median time of a stop in the journal, of one core that does nothing else."""
        return median(seconds for _, seconds in self._known.values())


@contextmanager
def open_stops(scenario: Scenario, folder: Path, workers: int) -> Generator[Stops]:
    """Yield the stops of a scenario's plant with the sources as they are; the journal is in `folder`."""
    digest = hashlib.sha256(f"{sources_digest()} {plant_description(scenario).digest}".encode()).hexdigest()
    with processes.workers(workers) as pool:
        yield Stops(folder / f"stops-{digest[:16]}.jsonl", pool)


def _stop(scenario: Scenario) -> tuple[float | None, float]:
    begin = time.process_time()
    return braking_distance(scenario), time.process_time() - begin
