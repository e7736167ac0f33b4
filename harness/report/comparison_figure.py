"""Figures of a comparison."""

from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure

from railgrip.report import palette, style
from railgrip.trace.loss import Loss

_COLOURS = (palette.BLACK, *palette.LINES[:-1])
_MAX_BARS = 40


def track_figure(along: Mapping[str, Loss]) -> Figure:
    """Return a figure of speed, its difference to the first stop, A, and the distance lost against A, over the
    distance.

    Args:
        along: Letter of each other stop → distance that it loses against A along the track.
    """
    drawing, (speeds, differences, losses) = style.panels(10, 8.4, 3, 1, sharex=True)
    first = next(iter(along.values())).first
    speeds.plot(first.place, style.KMH * first.speed, color=_COLOURS[0], linewidth=1.4, label="A")
    for number, (letter, lost) in enumerate(along.items(), start=1):
        colour = _COLOURS[number % len(_COLOURS)]
        course = lost.course
        speeds.plot(course.place, style.KMH * course.speed, color=colour, linewidth=1.2, label=letter)
        differences.plot(course.place, style.KMH * lost.speed_difference, color=colour, linewidth=1.2, label=letter)
        losses.plot(course.place, lost.lost, color=colour, linewidth=1.4, label=f"{letter}, so far")
        losses.annotate(
            f"{lost.total:+.1f} m".replace("-", "−"), (course.place[-1], lost.total), fontsize=9, color=colour,
            xytext=(4, 0), textcoords="offset points", va="center",
        )  # fmt: skip
        if len(along) == 1:
            widths = [section.end - section.begin for section in lost.sections]
            losses.bar(
                [section.begin for section in lost.sections], [section.lost for section in lost.sections], widths,
                align="edge", color=palette.lighter(palette.SKY, 3), edgecolor="white",
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


def stops_figure(differences: Mapping[str, float]) -> Figure:
    """Return a figure of the differences of the stops of two campaigns [m]; only the largest if there are many."""
    largest = sorted(differences, key=lambda name: -abs(differences[name]))[:_MAX_BARS]
    names = [name for name in differences if name in set(largest)]
    values = np.array([differences[name] for name in names])
    drawing, panel = style.panels(10, 1.2 + 0.24 * len(names))
    places = np.arange(len(names))
    panel.barh(places, values, color=np.where(values > 0, palette.VERMILION, palette.BLUE).tolist(), height=0.7)
    panel.set_yticks(places, names, fontsize=8)
    panel.invert_yaxis()
    panel.axvline(0.0, color=palette.BLACK, linewidth=0.8)
    few = f" (the {len(names)} largest of {len(differences)})" if len(names) < len(differences) else ""
    style.dress(panel, x="braking distance of B less that of A [m]", title=f"Difference of each stop{few}")
    panel.grid(visible=False, axis="y")
    return drawing
