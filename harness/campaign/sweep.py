"""Every combination of values of a scenario, as one table."""

import html
import itertools
import math
import pickle
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas
import xarray
from numpy.typing import NDArray

from railgrip.base.errors import InputError, RailgripError, ScenarioError
from railgrip.base.units import short
from railgrip.campaign.workers import answer, ended
from railgrip.campaign.workers import workers as processes
from railgrip.report.console import progress
from railgrip.scenario.schema import Scenario
from railgrip.simulate.parts import CustomParts
from railgrip.simulate.run import run_stop
from railgrip.trace.metrics import Metrics, meanings

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True, slots=True)
class Result:
    """What became of one combination.

    Attributes:
        outcome: Of the stop; `refused` or `failed` where there is none.
        reason: In one sentence.
        metrics: None without a stop.
    """

    outcome: str
    reason: str
    metrics: Metrics | None


@dataclass(frozen=True, slots=True)
class Sweep:
    """The stops of every combination of values, in the order of the axes, the last one fastest.

    Attributes:
        axes: Key → values.
        results: Of each combination.
    """

    axes: Mapping[str, tuple[Any, ...]]
    results: tuple[Result, ...]

    @property
    def distances(self) -> NDArray[np.float64]:
        """Braking distances, shape as the axes [m]; NaN without a standstill."""
        shape = tuple(len(values) for values in self.axes.values())
        each = [math.nan if result.metrics is None else result.metrics.distance for result in self.results]
        return np.array(each).reshape(shape)

    def __repr__(self) -> str:
        """Return what a reader wants to know first, in five lines."""
        combinations = list(itertools.product(*self.axes.values()))
        known = sorted((d, i) for i, d in enumerate(self.distances.ravel().tolist()) if math.isfinite(d))
        outcomes = Counter(result.outcome for result in self.results)

        def line(rank: int) -> str:
            if not known:
                return "none"
            distance, number = known[rank]
            values = zip(self.axes, combinations[number], strict=True)
            return f"{distance:.2f} m with {', '.join(f'{key} = {value}' for key, value in values) or 'no axis'}"

        lines = (
            f"Sweep of {len(self.results)} stops over "
            f"{', '.join(f'{key} ({len(values)})' for key, values in self.axes.items()) or 'nothing'}",
            f"  {', '.join(f'{count} {outcome}' for outcome, count in outcomes.items())}",
            f"  shortest {line(0)}",
            f"  median {line(len(known) // 2)}",
            f"  longest {line(-1)}",
        )
        return "\n".join(lines)

    def _repr_html_(self) -> str:
        """Return the short form and the table, for notebooks."""
        return f"<pre>{html.escape(repr(self))}</pre>{self.to_pandas().to_html(max_rows=20, max_cols=12)}"

    def plot(self) -> "Figure":
        """Return a figure (matplotlib) of the braking distances over the longest axis."""
        from railgrip.report.sweep_figure import sweep_figure  # matplotlib takes half a second to load

        return sweep_figure(self.axes, self.distances)

    def to_pandas(self) -> pandas.DataFrame:
        """Return a row for each stop: its values, outcome, reason and figures; `slip[2]` is the second group's."""
        rows = [
            dict(zip(self.axes, values, strict=True))
            | {"outcome": result.outcome, "reason": result.reason}
            | (_flat(result.metrics.to_plain()) if result.metrics else {})
            for values, result in zip(itertools.product(*self.axes.values()), self.results, strict=True)
        ]
        return pandas.DataFrame(rows)

    def to_xarray(self) -> xarray.Dataset:
        """Return outcome, reason and figures over the axes, and over groups and wheelsets, lead to trail.

        A figure that a stop does not have is NaN.
        """
        shape = tuple(len(values) for values in self.axes.values())
        variables: dict[str, Any] = {
            name: (tuple(self.axes), np.array([getattr(result, name) for result in self.results]).reshape(shape))
            for name in ("outcome", "reason")
        }
        metrics = [result.metrics.to_plain() for result in self.results if result.metrics]
        for name, (unit, meaning) in meanings().items():
            sample = next((plain[name] for plain in metrics if plain[name] is not None), None)
            if sample is None:
                continue
            first = np.asarray(sample, dtype=np.float64)
            values = [
                np.full(first.shape, np.nan)
                if result.metrics is None or (value := result.metrics.to_plain()[name]) is None
                else np.asarray(value, dtype=np.float64)
                for result in self.results
            ]
            each = "wheelset" if "wheelset" in meaning else "group" if "group" in meaning else ""
            if not each:  # of the train, in a list of one
                first, values = first.reshape(()), [value.reshape(()) for value in values]
            further = (each, "slip_class")[: first.ndim]
            stacked = np.stack(values).reshape(*shape, *first.shape)
            variables[name] = ((*self.axes, *further), stacked, {"units": unit, "long_name": meaning})
        return xarray.Dataset(variables, coords={axis: list(values) for axis, values in self.axes.items()})


def swept(
    name: str,
    variant: Callable[[Mapping[str, Any]], tuple[Scenario, CustomParts]],
    axes: Mapping[str, Sequence[Any]],
    workers: Any,
) -> Sweep:
    """Run every combination of values.

    Args:
        name: Of the scenario, for the progress.
        variant: Returns the scenario with values laid over it by key, and the user's objects for it.

    Raises:
        ScenarioError: A combination is no scenario, or an axis has no value; nothing was run.
    """
    empty = next((axis for axis, values in axes.items() if not len(values)), None)
    if empty is not None:
        raise ScenarioError(f"sweep: the axis '{empty}' has no value")
    if not isinstance(workers, int) or workers < 1:
        raise ScenarioError(f"sweep: workers is 1 or more, got {short(workers)}")
    stops = [variant(dict(zip(axes, values, strict=True))) for values in itertools.product(*axes.values())]
    results: dict[int, Result] = {}
    is_portable = workers > 1 and all(_portable(objects) for _, objects in stops)
    with progress(name, len(stops), is_count=True) as bar:
        for number, result in _in_processes(stops, workers) if is_portable else _here(stops):
            results[number] = result
            bar.advance()
    return Sweep({axis: tuple(values) for axis, values in axes.items()}, tuple(results[n] for n in range(len(stops))))


def _here(stops: Sequence[tuple[Scenario, CustomParts]]) -> Iterator[tuple[int, Result]]:
    for number, (scenario, objects) in enumerate(stops):
        yield number, _result(scenario, objects)


def _in_processes(stops: Sequence[tuple[Scenario, CustomParts]], workers: int) -> Iterator[tuple[int, Result]]:
    with processes(min(workers, len(stops)), main=False) as pool:
        running = {pool.submit(_result, *stop): number for number, stop in enumerate(stops)}
        for number, result in ended(running):
            yield number, _failed(result) if isinstance(result, RailgripError) else result


def _portable(objects: CustomParts) -> bool:
    """Return whether another process can have these objects: their classes are in modules that it can import."""
    parts = (objects.controller, objects.estimator, objects.sensors, objects.plant)
    if any(type(part).__module__ == "__main__" for part in parts):
        return False
    try:
        pickle.dumps(objects)
    except Exception:  # whatever a user's object raises when it is pickled
        return False
    return True


def _result(scenario: Scenario, objects: CustomParts) -> Result:
    stop = answer(lambda: run_stop(scenario, objects=objects))
    return _failed(stop) if isinstance(stop, RailgripError) else Result(stop.outcome.value, stop.reason, stop.metrics)


def _failed(problem: RailgripError) -> Result:
    return Result("refused" if isinstance(problem, InputError) else "failed", str(problem), None)


def _flat(plain: Mapping[str, Any]) -> dict[str, Any]:
    """Return figures with those of groups and wheelsets as one each, counted from 1."""
    flat: dict[str, Any] = {}
    for name, value in plain.items():
        if isinstance(value, list):
            flat |= _flat({f"{name}[{i}]": element for i, element in enumerate(value, start=1)})
        else:
            flat[name] = math.nan if value is None else value
    return flat
