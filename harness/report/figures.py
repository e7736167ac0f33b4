"""Figures of signals: friction and adhesion of wheelsets, all of a stop, stops along the track, and estimates."""

from collections.abc import Mapping, Sequence
from math import ceil, isfinite
from pathlib import Path
from typing import Any

import numpy as np
import xarray
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullLocator

from railgrip.base.groups import gather
from railgrip.base.names import ElementName
from railgrip.recording.samples import knows, reading_of, truth_of, unit_of
from railgrip.report import palette, style
from railgrip.report.signals import SignalLine, SignalPanel, signal_panels
from railgrip.trace.measures import Loss
from railgrip.trace.metrics import Metrics


def draw_wheelsets(panel: Axes, time: np.ndarray, mu0: np.ndarray) -> None:
    """Draw maximum friction over time, shape (samples, wheelsets), from blue, the first wheelset, to purple."""
    colours = palette.lead_to_trail(mu0.shape[1])
    for wheelsets in style.alike(list(mu0.T)):
        axles = f"wheelset{'s' if len(wheelsets) > 1 else ''} {style.one_based(wheelsets)}"
        panel.plot(time, mu0[:, wheelsets[0]], color=colours[wheelsets[0]], linewidth=1.4, label=axles)


def draw_adhesion(panel: Axes, traces: Mapping[str, xarray.Dataset], limit: float, wheelset: int = 0) -> None:
    """Draw adhesion of a wheelset and the greatest possible in a stop with SBC and one with another law, and the limit.

    The greatest possible is that of the rail at the speed of each stop, before the operator's limit.

    Args:
        wheelset: Zero-based number.
    """
    colours = ((palette.BLUE, palette.GREY), (palette.ORANGE, palette.BLACK))
    for (name, trace), (colour, _) in zip(traces.items(), colours, strict=True):
        panel.plot(trace["time"].values, trace["adhesion"].values[:, wheelset], color=colour, linewidth=0.9, label=name)
    for (name, trace), (_, colour) in zip(traces.items(), colours, strict=True):
        if "peak_adhesion" not in trace:
            continue  # a plant that does not output its brakes has no bound
        greatest = trace["peak_adhesion"].values[:, int(trace["group_of_wheelset"].values[wheelset]) - 1]
        name = f"greatest possible, {name.partition(',')[0]}"
        # Wide and in the background, so that adhesion that has reached it stays visible.
        panel.plot(trace["time"].values, greatest, color=colour, linewidth=2.6, label=name, zorder=1.5)
    panel.axhline(limit, color=palette.VERMILION, linewidth=1.0, linestyle="--", label=f"limit {limit:g}")
    panel.set_xlim(0, max(float(trace["time"].values[-1]) for trace in traces.values()))


_STOP_MARGINS = {"left": 0.055, "right": 0.875, "wspace": 0.06, "hspace": 0.1}


_MAX_COLUMNS = 8
"""Maximum number of groups side by side, so that panels stay readable; those of a longer train follow below."""


_SIGNALS: dict[str, dict[str, Any]] = {
    "train": {"color": palette.BLACK, "linewidth": 1.4},
    "optimum": {"color": palette.BLACK, "linewidth": 1.2},
    "group": {"color": palette.BLUE, "linewidth": 0.9},
    "estimate": {"color": palette.VERMILION, "linewidth": 1.0, "linestyle": (0, (2, 1.2))},
}
"""Role of a line → its style; lines of other roles are not drawn."""


def signals_figure(trace: xarray.Dataset, metrics: Metrics, title: str) -> Figure:
    """Return the figure of one stop: a column for each group, rows from speed to pressure.

    A train of many groups continues below, in bands with the same axes. Signals that a foreign plant does not output,
    and that are not estimated, have no row.
    """
    time = trace["time"].values
    quantities = [panel for panel in signal_panels(trace) if any(line.role in _SIGNALS for line in panel.lines)]
    outside = {"adhesion": metrics.adhesion_outside, "pad friction": metrics.pad_friction_outside}
    drawing, panels = _columns(trace.sizes["group"], len(quantities))
    for row, quantity in zip(panels, quantities, strict=True):
        shares = outside.get(quantity.label)
        for group, panel in enumerate(row):
            for line in quantity.lines:
                if line.role in _SIGNALS:
                    _draw_signal(panel, time, line, group)
            if shares is not None and isfinite(shares[group]):
                panel.text(0.98, 0.96, f"{100 * shares[group]:.0f} % outside ±2σ", transform=panel.transAxes,
                           ha="right", va="top", fontsize=8)  # fmt: skip
            style.dress(panel, y=quantity.label if panel.get_subplotspec().is_first_col() else "")
        _scale(row, quantity)
        style.legend(row[_wide(len(row)) - 1], loc="center left", bbox_to_anchor=(1.0, 0.5))
    for group in range(trace.sizes["group"]):
        panels[0, group].set_title(f"group {group + 1}", fontsize=10)
        panels[-1, group].set_xlabel("time [s]")
        panels[0, group].set_xlim(0, time[-1])
    # Smaller letters for a long title, such as that of a user's class: 150 of eleven points fill the width.
    size = min(11.0, 1650.0 / max(len(title), 1))
    drawing.suptitle(title, x=0.01, y=1 - 0.22 / drawing.get_figheight(), ha="left", fontsize=size)
    return drawing


def _draw_signal(panel: style.Axes, time: np.ndarray, line: SignalLine, group: int) -> None:
    values = line.values if line.role == "train" else line.values[:, group]
    if line.deviation is not None:
        half_width = 2 * line.deviation[:, group]
        style.band(panel, time, values - half_width, values + half_width, palette.ORANGE, 0.3, label="±2σ")
    panel.plot(time, values, label=line.label, **_SIGNALS[line.role])


def _scale(row: np.ndarray, quantity: SignalPanel) -> None:
    # Setting the limits of a panel freezes them, so this comes after all lines.
    low, high = quantity.limits or (0, max(panel.get_ylim()[1] for panel in row))
    for panel in row:
        if quantity.log_ticks:
            panel.set_yscale("log")
            panel.set_yticks(quantity.log_ticks, [f"{tick:g}" for tick in quantity.log_ticks])
            panel.yaxis.set_minor_locator(NullLocator())
        panel.set_ylim(low, high)


def _wide(groups: int) -> int:
    return ceil(groups / ceil(groups / _MAX_COLUMNS))


def _columns(groups: int, rows: int) -> tuple[Figure, np.ndarray]:
    """Return a figure and its panels, shape (rows, groups), in as many bands as their width requires."""
    bands = ceil(groups / _MAX_COLUMNS)
    wide = _wide(groups)
    above, below, between, block = 0.77, 0.5, 0.85, 0.03 + 1.94 * rows  # inches
    height = above + bands * block + (bands - 1) * between + below
    drawing = style.figure(14, height, _STOP_MARGINS)
    parts: list[np.ndarray] = []
    for band in range(bands):
        top = above + band * (block + between)
        grid = drawing.add_gridspec(
            rows, wide, top=1 - top / height, bottom=1 - (top + block) / height, **_STOP_MARGINS
        )
        panels = grid.subplots(sharex=True, sharey="row", squeeze=False)
        for spare in panels[:, groups - band * wide :].flat:
            spare.remove()
        parts.append(panels[:, : groups - band * wide])
    return drawing, np.hstack(parts)


def track_figure(along: Mapping[str, Loss]) -> Figure:
    """Return a figure of speed, its difference to the first stop, A, and the distance lost against A, over the
    distance.

    Args:
        along: Letter of each other stop → distance that it loses against A along the track.
    """
    drawing, (speeds, differences, losses) = style.panels(10, 8.4, 3, 1, sharex=True)
    first, colours = next(iter(along.values())).first, (palette.BLACK, *palette.LINES[:-1])
    speeds.plot(first.place, style.KMH * first.speed, color=palette.BLACK, linewidth=1.4, label="A")
    for number, (letter, lost) in enumerate(along.items(), start=1):
        colour = colours[number % len(colours)]
        course = lost.course
        speeds.plot(course.place, style.KMH * course.speed, color=colour, linewidth=1.2, label=letter)
        differences.plot(course.place, style.KMH * lost.speed_difference, color=colour, linewidth=1.2, label=letter)
        losses.plot(course.place, lost.lost, color=colour, linewidth=1.4, label=f"{letter}, so far")
        losses.annotate(
            f"{lost.total:+.1f} m".replace("-", "−"), (course.place[-1], lost.total), fontsize=9, color=colour,
            xytext=(4, 0), textcoords="offset points", va="center",
        )  # fmt: skip
        if len(along) == 1:
            begin, end, lost_in = (lost.sections[name] for name in ("begin", "end", "lost"))
            losses.bar(
                begin, lost_in, end - begin, align="edge", color=palette.lighter(palette.SKY, 3), edgecolor="white",
                label=f"{letter}, in the section",
            )  # fmt: skip
    style.dress(speeds, y="speed [km/h]", title="Speed")
    style.dress(differences, y="difference [km/h]", title="Speed less that of A at the same place")
    style.dress(
        losses,
        x="distance since the brake demand [m]",
        y="distance lost [m]",
        title="How far the stop is behind A at the same speed",
    )
    for panel in (differences, losses):
        panel.axhline(0.0, color=palette.BLACK, linewidth=0.8)
    furthest = max(float(lost.course.place[-1]) for lost in along.values())
    speeds.set_xlim(0, 1.07 * max(furthest, float(first.place[-1])))
    speeds.set_ylim(bottom=0)
    for panel in (speeds, losses):
        style.legend(panel, loc="best")
    return drawing


_ELEMENT_COLOURS = (palette.BLUE, palette.ORANGE, palette.GREEN, palette.PURPLE, palette.SKY, palette.VERMILION)


_STATE_COLOURS = (palette.BLUE, palette.BLACK, *palette.LINES[1:-1])


_DASHES = ("-", "--", ":", "-.")


_WORDS = {
    "speed": "speed [m/s]",
    "wheelset_speed": "wheelset speed [rad/s]",
    "pad_friction": "pad friction",
    "group_adhesion": "adhesion",
    "dz": "deflection [m]",
    "ddz": "rate of deflection [m/s]",
    "d": "disturbance [m/s²]",
    "bias": "bias [m/s²]",
}


_SETTLED = 0.02
"""Share of the time after which values determine the scale of a state.

Initial estimates may be arbitrarily uncertain.
"""


def estimates_figure(recording: xarray.Dataset, estimates: xarray.Dataset, inputs: Sequence[str]) -> Figure:
    """Return a figure of inputs, states ± 2 standard deviations with the truth (dashed), and innovation consistency.

    Args:
        recording: Recording that the filter was run over.
        estimates: Estimates of the filter, see `railgrip.estimation.run.estimate`.
        inputs: Names of readings.
    """
    states = _families([str(state) for state in estimates["state"].values])
    families = _families(inputs)
    drawing = style.figure(10, 1.9 * (len(families) + len(states) + 1))
    panels = list(np.atleast_1d(drawing.subplots(len(families) + len(states) + 1, 1, sharex=True)))
    time = estimates["time"].values
    for panel, (family, names) in zip(panels, families.items(), strict=False):
        factor, unit = style.readable(unit_of(recording, names[0]))
        for name, colour in _with_colours(names):
            panel.plot(time, factor * reading_of(recording, name), color=colour, lw=0.9, label=_label(name, names))
        style.dress(panel, y=f"{family.replace('_', ' ')} [{unit}]")
        _legend(panel, len(names))
    later = time >= time[0] + _SETTLED * (time[-1] - time[0])
    for panel, (family, names) in zip(panels[len(families) :], states.items(), strict=False):
        bands: list[np.ndarray] = []
        for name, colour in _with_colours(names):
            mean, sd = (estimates[what].sel(state=name).values for what in ("mean", "sd"))
            style.band(panel, time, mean - 2 * sd, mean + 2 * sd, colour, min(0.15, 1.0 / len(names)))
            panel.plot(time, mean, color=colour, lw=1.0, label=_label(name, names))
            bands.append(mean[later])
            if knows(recording, name):
                panel.plot(time, truth_of(recording, name), color=colour, lw=1.0, ls="--")
                bands.append(truth_of(recording, name)[later])
        style.dress(panel, y=_WORDS.get(family, family))
        panel.set_ylim(*_reach(np.concatenate(bands)))
        _legend(panel, len(names))
    last = panels[-1]
    nis_of_reading = estimates["nis"].values / np.maximum(estimates["readings"].values, 1.0)
    last.semilogy(time, nis_of_reading, ".", color=palette.GREY, ms=1.5)
    last.axhline(1.0, color=palette.BLACK, lw=0.8, ls=":")
    # Most samples of a filter that is lost are beyond a hundred.
    last.set_ylim(1e-2, max(1e2, 10.0 * float(np.nanmedian(nis_of_reading))))
    style.dress(last, x="time [s]", y="NIS per reading\n(expected: 1)")
    truth = "; dashed: truth" if any(knows(recording, str(state)) for state in estimates["state"].values) else ""
    nis = f"; median NIS {estimates.attrs['nis_ratio']:.2g} of the expected one"
    names = [estimates.attrs[kind] for kind in ("estimation", "name") if estimates.attrs.get(kind)]
    title = f"{' of '.join(names)}: " if names else ""
    drawing.suptitle(f"{title}estimates ± 2 sd{truth}{nis}", fontsize=10)
    return drawing


def _families(names: Sequence[str]) -> Mapping[str, list[str]]:
    return gather((ElementName.of(name).array, name) for name in names)


def _with_colours(names: Sequence[str]) -> list[tuple[str, str]]:
    colours = _ELEMENT_COLOURS if len(names) <= len(_ELEMENT_COLOURS) else palette.lead_to_trail(len(names))
    return list(zip(names, colours, strict=False))


def _label(name: str, names: Sequence[str]) -> str:
    """Return the number of an element; of many elements only the first and the last one have a label."""
    is_labelled = len(names) <= len(_ELEMENT_COLOURS) or name in (names[0], names[-1])
    return ElementName.of(name).label if is_labelled else "_"


def _legend(panel: Axes, count: int) -> None:
    if count > 1:
        # Outside the axes, where no line runs.
        style.legend(panel, loc="upper left", bbox_to_anchor=(1.0, 1.0))


def _reach(values: np.ndarray) -> tuple[float, float]:
    finite = values[np.isfinite(values)]
    if not finite.size:
        return 0.0, 1.0
    low, high = np.percentile(finite, (0.2, 99.8))
    margin = 0.15 * max(high - low, 1e-6)
    return float(low - margin), float(high + margin)


def information(recording: xarray.Dataset, windows: xarray.Dataset, path: Path, *, inputs: tuple[str, ...]) -> Path:
    """Draw the inputs, and below them the smallest singular value of the Gramian, for all states and for each.

    A window without information on a state has no point on the logarithmic axis: the line is interrupted there.
    """
    drawing, (above, below) = style.panels(10, 6.5, 2, 1, sharex=True, height_ratios=(1, 2))
    for name, color in zip(inputs, (palette.ORANGE, palette.BLUE), strict=False):
        factor, unit = style.readable(unit_of(recording, name))
        above.plot(
            recording["time"], factor * reading_of(recording, name), color=color, lw=0.8, label=f"{name} [{unit}]"
        )
    style.dress(above, title=f"{windows.attrs['name']}: windows of {windows.attrs['window']:g} s")
    style.legend(above, loc="upper left")
    time = windows["time"].values
    families: dict[str, int] = {}
    for state in windows["state"].values:
        # One colour per kind of state, one dash pattern per element.
        family = ElementName.of(str(state)).array
        color = _STATE_COLOURS[list(families).index(family) if family in families else len(families)]
        families[family] = families.get(family, -1) + 1
        values = windows["singular"].sel(state=state).values
        below.semilogy(
            time,
            np.where(values > 0.0, values, np.nan),
            color=color,
            ls=_DASHES[families[family] % len(_DASHES)],
            lw=1.1,
            label=str(state),
        )
    smallest = windows["smallest"].values
    positive = np.where(np.isfinite(windows["deviation"].values).all(axis=1), smallest, np.nan)
    below.semilogy(time, positive, color="#999999", lw=2.5, alpha=0.6, label="smallest of all")
    below.axhline(1.0, color=palette.BLACK, lw=0.7, ls=":")
    style.dress(below, x="time [s]", y="(typical size / deviation)²")
    style.legend(below, ncols=8, loc="lower left", bbox_to_anchor=(0.0, 1.0))
    return style.save(drawing, path)
