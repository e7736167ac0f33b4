"""Figures of the roller rig: what it did, what was estimated, and adhesion over slip."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import xarray
from matplotlib.axes import Axes

from railgrip.report import style
from railgrip.trace.samples import reading_of, truth_of

RADIUS = 0.46  # m, of the rig's wheelset


def rig_run(recording: xarray.Dataset, estimates: xarray.Dataset, path: Path, *, title: str) -> Path:
    """Draw speeds and pad force above, adhesion and pad friction below (Schwarz and Keck, 2020, figures 4 and 5)."""
    time = recording["time"].values
    drawing, (above, below) = style.panels(10, 6.5, 2, 1, sharex=True)
    above.plot(time, style.KMH * reading_of(recording, "speed"), color=style.BLACK, lw=1.2, label="roller")
    above.plot(
        time,
        style.KMH * RADIUS * reading_of(recording, "wheelset_speed"),
        color=style.BLUE,
        lw=0.8,
        label="wheelset, at the rim",
    )
    drawing.suptitle(title, fontsize=10)
    style.dress(above, y="speed [km/h]")
    force = style.second_scale(above, "pad force [kN]")
    force.plot(
        time, reading_of(recording, "pad_force") / 1e3, color=style.ORANGE, lw=0.7, alpha=0.8, label="pad force (right)"
    )
    force.set_ylim(0, None)
    _legend(above, force)
    measured = reading_of(recording, "contact_force") / reading_of(recording, "wheelset_load")
    adhesion, pads = (estimates["mean"].sel(state=state) for state in ("alpha", "mu_b"))
    below.plot(time, measured, color=style.ORANGE, lw=2.0, label="adhesion by load cells")
    below.plot(time, adhesion, color=style.BLUE, lw=0.7, label="adhesion, estimated")
    top = 1.1 * float(np.nanmax(measured))
    below.set_ylim(-0.01, top)
    style.dress(below, x="time [s]", y="adhesion")
    friction = style.second_scale(below, "pad friction")
    friction.plot(
        time, truth_of(recording, "mu_b"), color=style.BLACK, lw=1.0, ls="--", label="pad friction, true (right)"
    )
    friction.plot(time, pads, color=style.VERMILION, lw=1.0, label="pad friction, estimated (right)")
    friction.set_ylim(0.0, 0.5)
    _legend(below, friction)
    return style.save(drawing, path)


def over_slip(
    recording: xarray.Dataset,
    estimates: Mapping[str, xarray.Dataset],
    path: Path,
    *,
    between: tuple[float, float],
    limit: float,
) -> Path:
    """Draw adhesion over slip and its error (figure 6), for every filter, from `between[0]` to `between[1]` seconds."""
    part = recording.sel(time=slice(*between))
    slip = truth_of(part, "slip")
    drawing, (above, below) = style.panels(10, 7, 2, 1, sharex=True)
    above.plot(
        slip,
        reading_of(part, "contact_force") / reading_of(part, "wheelset_load"),
        color=style.GREY,
        lw=2.0,
        label="load cells",
    )
    for (name, estimate), color in zip(estimates.items(), (style.VERMILION, style.BLUE, style.GREEN), strict=False):
        adhesion = estimate.sel(time=slice(*between))["mean"].sel(state="alpha").values
        above.plot(slip, adhesion, color=color, lw=0.9, label=name)
        below.plot(slip, np.abs(adhesion - truth_of(part, "alpha")), ".-", color=color, lw=0.6, ms=2.5, label=name)
    style.dress(above, y="adhesion", title=f"{part.attrs['name']}, {between[0]:g} to {between[1]:g} s")
    style.legend(above)
    below.axhline(limit, color=style.BLACK, lw=0.8, ls=":")
    style.dress(below, x="slip", y="|error| of adhesion")
    return style.save(drawing, path)


def tunings(recording: xarray.Dataset, estimates: Mapping[str, xarray.Dataset], path: Path) -> Path:
    """Draw error and claimed spread of adhesion and pad friction, one column a filter."""
    drawing, axes = style.panels(10, 6, 2, len(estimates), sharex=True, squeeze=False)
    time = recording["time"].values
    for column, (name, estimate) in enumerate(estimates.items()):
        for row, (state, word) in enumerate((("alpha", "adhesion"), ("mu_b", "pad friction"))):
            at = axes[row, column]
            error = estimate["mean"].sel(state=state).values - truth_of(recording, state)
            spread = 2.0 * estimate["sd"].sel(state=state).values
            reach = max(1.3 * float(np.nanmax(np.abs(error[time >= time[0] + 0.5]))), 1e-3)
            style.band(at, time, -spread, spread, style.SKY, 0.35, label="± 2 sd claimed")
            at.plot(time, error, color=style.VERMILION, lw=0.6, label="error")
            at.set_ylim(-reach, reach)
            style.dress(at, x="time [s]" if row else "", y=f"error of {word}" if column == 0 else "", title=name)
            style.legend(at, loc="upper right")
    return style.save(drawing, path)


def _legend(axes: Axes, other: Axes) -> None:
    """Name the lines of both scales above the axes, where none of them runs."""
    lines = [*axes.get_lines(), *other.get_lines()]
    names = [str(line.get_label()) for line in lines]
    style.legend(axes, lines, names, loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=4)
