"""Samples at any instants, put on an even grid: averaged, interpolated, or set down where they are nearest."""

import numpy as np

from railgrip.base.arrays import Vector
from railgrip.recording.flag import Flag, Kind


def on_grid(signal: str, time: Vector, values: Vector, grid: Vector, period: float) -> tuple[Vector, list[Flag]]:
    """Return a reading at every instant of `grid`, NaN where nothing is new, and how far samples were moved.

    A signal twice as fast as the grid, or more, is averaged over each period about its instant; one about as fast is
    interpolated between neighbouring samples, never across a missing one; samples of a slower one are moved to the
    nearest instants, by half a period or less, with NaN in between.

    Args:
        signal: Name, for the flags.
        time: Rising instants of the remaining samples [s], shape (k,).
        values: Shape (k,).
        grid: Even instants [s].
        period: Of the grid [s].
    """
    spacing = float(np.median(np.diff(time)))
    flags: list[Flag] = []
    if spacing > 1.5 * period:
        result = np.full(grid.size, np.nan)
        nearest = np.rint((time - grid[0]) / period).astype(np.int64)
        inside = (nearest >= 0) & (nearest < grid.size)
        result[nearest[inside]] = values[inside]
        off = float(np.max(np.abs(time[inside] - grid[nearest[inside]]), initial=0.0))
        if off > 0.01 * period:
            flags.append(
                Flag(
                    signal=signal,
                    kind="timing",
                    begin=float(grid[0]),
                    end=float(grid[-1]),
                    samples=int(inside.sum()),
                    remark=f"by up to {1e3 * off:.3g} ms",
                )
            )
        return result, flags
    if spacing <= 0.5 * period:
        return _average(time, values, grid, period), flags
    return interpolate(time, values, grid, 1.5 * max(spacing, period)), flags


def input_on_grid(
    signal: str, time: Vector, values: Vector, grid: Vector, period: float, longest_gap: float
) -> tuple[Vector, list[Flag]]:
    """Return a signal at every instant of `grid`, and flags of bridged gaps.

    It is interpolated between its samples.

    A fast one is averaged as in `on_grid`. What neither gives is NaN: a gap longer than `longest_gap`.
    """
    spacing = float(np.median(np.diff(time)))
    longest = max(longest_gap, 1.5 * spacing)
    samples = interpolate(time, values, grid, longest)
    if spacing <= 0.5 * period:
        means = _average(time, values, grid, period)
        samples = np.where(np.isfinite(means), means, samples)
    return samples, [
        f for f in gaps_of(signal, time, grid, 1.5 * max(spacing, period), "bridged") if f.end - f.begin <= longest
    ]


def interpolate(time: Vector, values: Vector, grid: Vector, longest_gap: float) -> Vector:
    """Return a signal interpolated at every instant of `grid`; NaN in longer gaps and beyond the ends."""
    samples = np.interp(grid, time, values, left=np.nan, right=np.nan)
    after = np.clip(np.searchsorted(time, grid, side="left"), 1, time.size - 1)
    apart = time[after] - time[after - 1]
    # An instant that has a sample needs no bridge, however far the next one is.
    exact = (np.abs(time[after] - grid) < 1e-9) | (np.abs(time[after - 1] - grid) < 1e-9)
    return np.where((apart > longest_gap) & ~exact, np.nan, samples)


def _average(time: Vector, values: Vector, grid: Vector, period: float) -> Vector:
    """Return the mean of the samples within half a period of every instant; NaN without samples."""
    place = np.floor((time - grid[0]) / period + 0.5).astype(np.int64)
    inside = (place >= 0) & (place < grid.size)
    count = np.bincount(place[inside], minlength=grid.size)
    total = np.bincount(place[inside], weights=values[inside], minlength=grid.size)
    with np.errstate(invalid="ignore"):
        return np.where(count > 0, total / np.maximum(count, 1), np.nan)


def gaps_of(signal: str, time: Vector, grid: Vector, longest: float, kind: Kind) -> list[Flag]:
    """Return the intervals of the grid without samples for longer than `longest` [s]."""
    edges = np.concatenate([[min(float(grid[0]), float(time[0]))], time, [max(float(grid[-1]), float(time[-1]))]])
    apart = np.diff(edges)
    return [
        Flag(signal=signal, kind=kind, begin=float(edges[i]), end=float(edges[i + 1]), samples=0)
        for i in np.flatnonzero(apart > longest)
        if edges[i + 1] > grid[0] and edges[i] < grid[-1]
    ]
