"""Run every combination of values of a scenario, load results from folders, and write both as one table."""

import html
import itertools
import json
import math
import pickle
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

import numpy as np
import pandas
import xarray
from numpy.typing import NDArray

from railgrip.base.errors import InputError, RailgripError, RecordError, ScenarioError
from railgrip.base.files import replacing
from railgrip.base.names import ElementName
from railgrip.base.programs import installation
from railgrip.base.units import short
from railgrip.campaign.workers import answer, collect
from railgrip.campaign.workers import workers as processes
from railgrip.report.console import progress, remark
from railgrip.report.results import read_results
from railgrip.report.stop import Stop, is_campaign, read_stop
from railgrip.report.table import names
from railgrip.scenario.schema import Scenario
from railgrip.simulate.run import run_stop
from railgrip.simulate.user_parts import CustomParts
from railgrip.trace.metrics import FIGURES, Metrics

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True, slots=True)
class Result:
    """Result of one combination.

    Attributes:
        outcome: Outcome of the stop; `refused` or `failed` without a stop.
        reason: Reason, one sentence.
        metrics: Metrics of the stop, or None.
    """

    outcome: str
    reason: str
    metrics: Metrics | None

    @classmethod
    def of(cls, stop: Stop | RailgripError) -> Self:
        """Return the result of a stop, or of the error in its place."""
        if isinstance(stop, Stop):
            return cls(stop.outcome.value, stop.reason, stop.metrics)
        return cls("refused" if isinstance(stop, InputError) else "failed", str(stop), None)


@dataclass(frozen=True, slots=True)
class Sweep:
    """Stops over combinations of values, in the order of the axes, the last one fastest.

    Attributes:
        axes: Key → values.
        results: Result of each combination.
        chosen: Values of each result, in the order of the axes, if only some combinations have a result, as in a
            campaign that excludes some; None if all have one.
    """

    axes: Mapping[str, tuple[Any, ...]]
    results: tuple[Result, ...]
    chosen: tuple[tuple[Any, ...], ...] | None = None

    @property
    def combinations(self) -> list[tuple[Any, ...]]:
        """Values of each result, in the order of the axes."""
        return list(itertools.product(*self.axes.values())) if self.chosen is None else list(self.chosen)

    @property
    def distances(self) -> NDArray[np.float64]:
        """Braking distances, shape as the axes [m]; NaN without a standstill or a result."""
        each = [math.nan if result.metrics is None else result.metrics.distance for result in self.results]
        return self._on_axes(np.array(each, dtype=np.float64), math.nan)

    def _on_axes(self, values: NDArray[Any], missing: object) -> NDArray[Any]:
        """Arrange the values of each result, shape (results, …), on the axes in place of the results."""
        shape = tuple(len(values) for values in self.axes.values())
        if self.chosen is None:
            return values.reshape(*shape, *values.shape[1:])
        grid = np.full((*shape, *values.shape[1:]), missing, dtype=values.dtype)
        for value, combination in zip(values, self.chosen, strict=True):
            place = [axis.index(choice) for axis, choice in zip(self.axes.values(), combination, strict=True)]
            grid[tuple(place)] = value
        return grid

    def __repr__(self) -> str:
        combinations, outcomes = self.combinations, Counter(result.outcome for result in self.results)
        distances = [math.nan if result.metrics is None else result.metrics.distance for result in self.results]
        known = pandas.Series(distances, dtype=float).dropna().sort_values(kind="stable")

        def line(rank: int) -> str:
            if known.empty:
                return "none"
            values = zip(self.axes, combinations[known.index[rank]], strict=True)
            return (
                f"{known.iloc[rank]:.2f} m with {', '.join(f'{key} = {value}' for key, value in values) or 'no axis'}"
            )

        lines = (
            f"Sweep of {len(self.results)} stops over "
            f"{', '.join(f'{key} ({len(values)})' for key, values in self.axes.items()) or 'nothing'}",
            f"  {', '.join(f'{count} {outcome}' for outcome, count in outcomes.items())}",
            f"  shortest {line(0)}",
            f"  median {f'{known.median():.2f} m of {len(known)} with standstill' if len(known) else 'none'}",
            f"  longest {line(-1)}",
        )
        return "\n".join(lines)

    def _repr_html_(self) -> str:
        return f"<pre>{html.escape(repr(self))}</pre>{self.to_pandas().to_html(max_rows=20, max_cols=12)}"

    def plot(self) -> "Figure":
        """Return a figure (matplotlib) of the braking distances over the longest axis."""
        from railgrip.report.campaign_figures import sweep_figure  # matplotlib takes half a second to load

        return sweep_figure(self.axes, self.distances)

    def to_pandas(self) -> pandas.DataFrame:
        """Return outcome, reason and metrics of each stop, indexed by the values of the axes.

        Metrics are in SI units, which `attrs["units"]` has by column; `longest_lock[2]` is that of the second group.
        """
        rows = [
            {"outcome": result.outcome, "reason": result.reason} | (result.metrics.flat() if result.metrics else {})
            for result in self.results
        ]
        combinations = [tuple(map(_hashable, values)) for values in self.combinations]
        index = pandas.MultiIndex.from_tuples(combinations, names=list(self.axes)) if self.axes and rows else None
        if index is not None and len(self.axes) == 1:
            index = index.get_level_values(0)
        frame = pandas.DataFrame(rows, index=index)
        frame.attrs["units"] = {
            column: figure.unit
            for column in frame.columns
            if (figure := FIGURES.get(ElementName.of(column).array)) is not None
        }
        return frame

    def to_xarray(self) -> xarray.Dataset:
        """Return outcome, reason and figures over the axes, and over groups and wheelsets, from lead to trail.

        Missing figures of a stop are NaN.
        """
        variables: dict[str, Any] = {
            name: (tuple(self.axes), self._on_axes(np.array([getattr(result, name) for result in self.results]), ""))
            for name in ("outcome", "reason")
        }
        for name, figure in FIGURES.items():
            found = [getattr(result.metrics, name) if result.metrics else None for result in self.results]
            known = [np.asarray(value, dtype=np.float64) for value in found if value is not None]
            if not known:
                continue
            shape = () if figure.extent == "train" else known[0].shape  # speed_rmse is a tuple of one
            values = [np.broadcast_to(np.nan, shape) if value is None else np.reshape(value, shape) for value in found]
            dimensions = (*self.axes, *(figure.extent, "slip_class")[: len(shape)])
            about = {"units": figure.unit, "long_name": figure.meaning}
            variables[name] = dimensions, self._on_axes(np.array(values, dtype=np.float64), np.nan), about
        return xarray.Dataset(variables, coords={axis: list(values) for axis, values in self.axes.items()})


def swept(
    name: str,
    variant: Callable[[Mapping[str, Any]], tuple[Scenario, CustomParts]],
    axes: Mapping[str, Sequence[Any]],
    workers: Any,
) -> Sweep:
    """Run every combination of values.

    Args:
        name: Name of the scenario, for the progress.
        variant: Function that returns the scenario with values by key, and the user's objects for it.

    Raises:
        ScenarioError: A combination is not a valid scenario, or an axis has no values; nothing was run.
    """
    empty = next((axis for axis, values in axes.items() if not len(values)), None)
    if empty is not None:
        raise ScenarioError(f"sweep: the axis '{empty}' has no value")
    if not isinstance(workers, int) or workers < 1:
        raise ScenarioError(f"sweep: workers is 1 or more, got {short(workers)}")
    stops = [variant(dict(zip(axes, values, strict=True))) for values in itertools.product(*axes.values())]
    results: dict[int, Result] = {}
    is_portable = workers > 1 and all(_portable(objects) for _, objects in stops)
    with progress(name, "running stops", len(stops), is_count=True) as bar:
        here = ((number, _result(*stop)) for number, stop in enumerate(stops))
        for number, result in _in_processes(stops, workers) if is_portable else here:
            results[number] = result
            bar.advance()
    return Sweep({axis: tuple(values) for axis, values in axes.items()}, tuple(results[n] for n in range(len(stops))))


def _in_processes(stops: Sequence[tuple[Scenario, CustomParts]], workers: int) -> Iterator[tuple[int, Result]]:
    with processes(min(workers, len(stops)), main=False) as pool:
        running = {pool.submit(_result, *stop): number for number, stop in enumerate(stops)}
        for number, result in collect(running):
            yield number, result if isinstance(result, Result) else Result.of(result)


def _portable(objects: CustomParts) -> bool:
    """Return whether these objects can be sent to other processes, which must be able to import their classes."""
    parts = (objects.controller, objects.estimator, objects.sensors, objects.plant)
    if any(type(part).__module__ == "__main__" for part in parts):
        return False
    try:
        pickle.dumps(objects)
    except Exception:  # a user's object may raise any exception when it is pickled
        return False
    return True


def _result(scenario: Scenario, objects: CustomParts) -> Result:
    return Result.of(answer(lambda: run_stop(scenario, objects=objects)))


def _hashable(value: Any) -> Any:
    return json.dumps(value, ensure_ascii=False, default=str) if isinstance(value, list | tuple | Mapping) else value


FORMATS = (".csv", ".parquet")
"""Suffixes of the files that a table can be written to."""


def load_results(folder: Path) -> Stop | Sweep:
    """Return the results in a folder: the stop of a run, or the stops of a campaign over its axes.

    Stops of a campaign without a result are omitted; a message lists them.

    Raises:
        RecordError: The folder has no result, a result is unreadable, or the samples of the stop were not kept.
        ScenarioError: A file that the scenario of the stop names is missing.
    """
    if not is_campaign(folder):
        stop = read_stop(folder)
        if stop.trace_digest is None:
            raise RecordError(
                f"{folder}: the samples of this stop were not kept; load its campaign for the metrics, or run the stop "
                "again with `railgrip run`"
            )
        return replace(stop, parsed=stop.scenario, samples=stop.trace)
    results = read_results(folder)
    if results.missing:
        remark(f"{folder}: {len(results.missing)} stops have no result: {names(results.missing)}")
    keys = dict.fromkeys(axis for stop in results.stops for axis in stop.variants)
    # Stops without draws have no variant of that axis.
    chosen = tuple(tuple(stop.variants.get(axis, "") for axis in keys) for stop in results.stops)
    axes = {axis: tuple(dict.fromkeys(column)) for axis, column in zip(keys, zip(*chosen, strict=True), strict=True)}
    return Sweep(axes, tuple(map(Result.of, results.stops)), chosen)


def write_table(frame: pandas.DataFrame, path: Path) -> None:
    """Write a table as CSV or Parquet, by its suffix; units are in the names of the columns.

    Raises:
        InputError: The suffix is another one, or pyarrow is not installed.
    """
    if path.suffix.lower() not in FORMATS:
        raise InputError(f"{path}: a table is written as {' or '.join(FORMATS)}; end its name with one of them.")
    with replacing(path) as partial:
        if path.suffix.lower() == ".csv":
            partial.write_text(csv_of(frame), encoding="utf-8")
            return
        try:
            with_units(frame).reset_index(drop=not any(frame.index.names)).to_parquet(partial, engine="pyarrow")
        except ImportError as problem:
            raise InputError(f"{path}: Parquet needs pyarrow; install it with {installation('parquet')}.") from problem


def csv_of(frame: pandas.DataFrame) -> str:
    """Return a table as CSV, with units in the names of the columns."""
    return with_units(frame).to_csv(index=any(frame.index.names))


def with_units(frame: pandas.DataFrame) -> pandas.DataFrame:
    """Return a table with units in the names of index and columns, as "speed [m/s]"."""
    units = frame.attrs.get("units", {})
    names = {name: f"{name} [{unit}]" for name, unit in units.items() if unit not in ("", "1")}
    # An axis of a campaign may have the name of a metric.
    axes = {name: f"{name} (axis)" for name in frame.index.names if name in frame.columns}
    return frame.rename(columns=names).rename_axis(index=lambda name: axes.get(name) or names.get(name, name))
