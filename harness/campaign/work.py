"""Run the cases of a study in processes or on a cluster, with progress, and cache every result by content."""

import hashlib
import json
import pickle
import zlib
from collections.abc import Callable, Generator, Iterable, Mapping, Sequence
from concurrent.futures import Executor
from contextlib import ExitStack, contextmanager
from dataclasses import fields, is_dataclass
from functools import partial
from pathlib import Path
from typing import Any, Final, TypeVar

import numpy as np
import xarray
from pydantic import BaseModel

from railgrip.base import cache
from railgrip.base.errors import InputError, RailgripError
from railgrip.base.interrupted import Interrupted
from railgrip.campaign import workers as processes
from railgrip.campaign.run import CampaignRun, Report, Runner, State, input_versions, run_campaigns
from railgrip.report.console import Progress, complain, progress
from railgrip.scenario.schema import Scenario

C = TypeVar("C")
R = TypeVar("R")

KIND: Final = "studies"
"""Folder of the results in the user's cache."""
_NAME: Final = "result"
_PREPARING, _RUNNING, _EVALUATING = "preparing", "running cases", "evaluating results"
"""Phases of a study that names none."""


class Work:
    """Runs the cases of a study; created by `work`.

    Attributes:
        folder: Folder for the output of the study.
        count: Number of processes.
        scheduler: Address of a Dask cluster in place of local processes, or None.
        fresh: Whether to run cases that have a result.
        run_count: Number of cases that were run, because the cache had no result.
    """

    def __init__(
        self,
        bar: Progress,
        stack: ExitStack,
        study: str | Path,
        folder: Path,
        count: int,
        scheduler: str | None,
        fresh: bool,
    ) -> None:
        self.folder, self.count, self.scheduler, self.fresh, self.run_count = folder, count, scheduler, fresh, 0
        self._bar, self._stack, self._study = bar, stack, study
        self._count = self._total = 0
        self._pool: tuple[Executor, Callable[[], None]] | None = None

    def notify(self, doing: str) -> None:
        """Display the present phase."""
        self._bar.update(phase=doing)

    def expect(self, count: int) -> None:
        """Increase the total number of cases by `count`."""
        self._total += count
        self._bar.update(total=self._total)
        self._replace_phase(_RUNNING)

    def advance(self) -> None:
        """Count one more case as done."""
        self._count += 1
        self._bar.update(amount=self._count)
        if self._count == self._total:
            self._replace_phase(_EVALUATING)

    def _replace_phase(self, phase: str) -> None:
        # A phase that the study has named stays until it names the next one.
        if self._bar.phase in (_PREPARING, _RUNNING, _EVALUATING):
            self._bar.update(phase=phase)

    def map(self, function: Callable[[C], R], cases: Iterable[C], *, keep: bool = True) -> list[R]:
        """Return the result of each case; those that are not in the cache are run, in their order.

        The cache is searched for the same function and case, computed by the same sources, packages and compilers.
        Results are stored at once, so that an interrupted study continues from there.

        Args:
            function: Function of a module, or a `partial` of one; it runs in other processes.
            cases: Cases that consist of numbers, strings, arrays, dataclasses, tables and scenarios.
            keep: Whether to cache results; False if a case names a user's code, whose dependencies are unknown.

        Raises:
            RailgripError: The first error of a case.
        """
        order = list(cases)
        maker = input_versions(self._study)
        keys = [hashlib.sha256(_text([maker, function, case]).encode()).hexdigest() for case in order]
        case_of = dict(zip(keys, order, strict=True))
        self.expect(len(case_of))
        results: dict[str, R] = {}
        for key in case_of if keep and not self.fresh else ():
            # Unpickling is safe: the cache has only files of this user's processes, as for the libraries that are
            # loaded from it.
            if (file := cache.find(KIND, key, _NAME)) is not None:
                results[key] = pickle.loads(zlib.decompress(file.read_bytes()))
                self.advance()
        missing = [key for key in case_of if key not in results]
        if missing and self._pool is None:
            self._pool = self._stack.enter_context(processes.pool(self.count, self.scheduler))
        pool, check = self._pool or (None, lambda: None)
        running = {pool.submit(function, case_of[key]): key for key in missing} if pool else {}
        try:
            for key, result in processes.collect(running, check):
                if isinstance(result, RailgripError):
                    raise result
                if keep:
                    cache.keep(KIND, key, _NAME, zlib.compress(pickle.dumps(result)))
                results[key] = result
                self.run_count += 1
                self.advance()
        except Interrupted as end:
            end.kept += "" if keep else ", except for the cases of the last step"
            raise
        return [results[key] for key in keys]

    def measure_times(self, function: Callable[[C], R], cases: Sequence[C]) -> list[R]:
        """Return the result of each case with measured times: one by one, in this process, and never cached."""
        self.expect(len(cases))
        results: list[R] = []
        for case in cases:
            results.append(function(case))
            self.advance()
        return results

    def stops(
        self,
        runs: Sequence[CampaignRun],
        runner: Runner,
        *,
        import_from: Sequence[Path] = (),
        is_any_outcome: bool = False,
    ) -> int:
        """Run the stops of campaigns into their folders; print errors, and return the exit code.

        Args:
            runs: As for `run_campaigns`.
            runner: As there.
            import_from: As there.
            is_any_outcome: Whether a stop may have another outcome than its campaign expects.
        """
        self.notify("running stops")
        self.expect(sum(len(run.campaign.stops) for run in runs))
        fine: set[State] = {"found", "done", "unexpected"} if is_any_outcome else {"found", "done"}
        code = 0

        def notify(report: Report) -> None:
            nonlocal code
            self.advance()
            if report.state not in fine:
                complain(f"{report.stop.name}: {report.sentence}")
                is_refused = report.state == "refused" or code == InputError.exit_code
                code = InputError.exit_code if is_refused else RailgripError.exit_code

        options: dict[str, Any] = {"scheduler": self.scheduler, "fresh": self.fresh, "import_from": import_from}
        run_campaigns(runs, runner, workers=self.count, notify=notify, **options)
        return code


def call(task: Callable[[], R]) -> R:
    """Return the result of a `partial`: a function for `Work.map` if each case has a different one."""
    return task()


@contextmanager
def work(
    study: str | Path, folder: Path = Path(), *, workers: int = 2, scheduler: str | None = None, fresh: bool = False
) -> Generator[Work]:
    """Yield an object that runs the cases of a study, with progress; after an exception, stored results are kept.

    Args:
        study: Name of a study, or the file of a module with the functions of one.
        folder: As for `Work`.
        workers: Number of processes.
        scheduler: As for `Work`.
        fresh: As for `Work`.

    Raises:
        InputError: `scheduler` is not an address.
    """
    if scheduler is not None:
        processes.require_address(scheduler)
    with (
        progress(study.stem if isinstance(study, Path) else study, _PREPARING, is_count=True) as bar,
        ExitStack() as stack,
    ):
        yield Work(bar, stack, study, folder, workers, scheduler, fresh)


def _text(value: object) -> str:
    return json.dumps(value, default=_plain, sort_keys=True)


def _plain(value: Any) -> object:
    match value:
        case Scenario():
            return value.digest()
        case BaseModel():
            return value.model_dump(mode="json")
        case np.ndarray():
            return [value.shape, str(value.dtype), hashlib.sha256(value.tobytes()).hexdigest()]
        case xarray.Dataset():
            return [
                value.attrs,
                {name: [variable.dims, variable.values, variable.attrs] for name, variable in value.variables.items()},
            ]
        case np.generic():
            return value.item()
        case Mapping():
            return dict(value)
        case Path():
            return str(value)
        case partial():
            return [value.func, value.args, value.keywords]
        case _ if is_dataclass(value) and not isinstance(value, type):
            return [type(value).__qualname__, {field.name: getattr(value, field.name) for field in fields(value)}]
        case _:
            return f"{value.__module__}.{value.__qualname__}"
