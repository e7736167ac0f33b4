"""Load results from folders as the values that `railgrip.run` and `railgrip.sweep` return, and write them as tables."""

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from railgrip.base.errors import InputError, RecordError
from railgrip.base.files import replacing
from railgrip.campaign.sweep import Result, Sweep
from railgrip.report.console import remark
from railgrip.report.results import read_results
from railgrip.report.stop import CAMPAIGN_FILE, STOP_FILE, Stop, others_like, read_stop
from railgrip.report.table import names

if TYPE_CHECKING:
    import pandas

FORMATS = (".csv", ".parquet")
"""Suffixes of the files that a table can be written to."""


def load_results(folder: Path) -> Stop | Sweep:
    """Return the results in a folder: the stop of a run, or the stops of a campaign over its axes.

    Stops of a campaign without a result are omitted; a message lists them.

    Raises:
        RecordError: The folder has no result, a result is unreadable, or the samples of the stop were not kept.
        ScenarioError: A file that the scenario of the stop names is missing.
    """
    if (folder / CAMPAIGN_FILE).exists():
        return _campaign(folder)
    if (folder / STOP_FILE).exists():
        return _stop(folder)
    like = others_like(folder) or "; name the folder of a run or campaign"
    raise RecordError(f"{folder}: has neither {CAMPAIGN_FILE} nor {STOP_FILE}{like}")


def _stop(folder: Path) -> Stop:
    stop = read_stop(folder)
    if stop.trace_digest is None:
        raise RecordError(
            f"{folder}: the samples of this stop were not kept; load its campaign for the metrics, or run the stop "
            "again with `railgrip run`"
        )
    return replace(stop, parsed=stop.scenario, samples=stop.trace)


def _campaign(folder: Path) -> Sweep:
    results = read_results(folder)
    if results.missing:
        remark(f"{folder}: {len(results.missing)} stops have no result: {names(results.missing)}")
    keys = dict.fromkeys(axis for stop in results.stops for axis in stop.variants)
    # Stops without draws have no variant of that axis.
    chosen = tuple(tuple(stop.variants.get(axis, "") for axis in keys) for stop in results.stops)
    axes = {axis: tuple(dict.fromkeys(column)) for axis, column in zip(keys, zip(*chosen, strict=True), strict=True)}
    found = tuple(Result(stop.outcome.value, stop.reason, stop.metrics) for stop in results.stops)
    return Sweep(axes, found, chosen)


def write_table(frame: "pandas.DataFrame", path: Path) -> None:
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
            raise InputError(
                f"{path}: Parquet needs pyarrow; install it with `pip install 'railgrip[parquet]'`."
            ) from problem


def csv_of(frame: "pandas.DataFrame") -> str:
    """Return a table as CSV, with units in the names of the columns."""
    return with_units(frame).to_csv(index=any(frame.index.names))


def with_units(frame: "pandas.DataFrame") -> "pandas.DataFrame":
    """Return a table with units in the names of index and columns, as "speed [m/s]"."""
    units = frame.attrs.get("units", {})
    names = {name: f"{name} [{unit}]" for name, unit in units.items() if unit not in ("", "1")}
    # An axis of a campaign may have the name of a metric.
    axes = {name: f"{name} (axis)" for name in frame.index.names if name in frame.columns}
    return frame.rename(columns=names).rename_axis(index=lambda name: axes.get(name) or names.get(name, name))
