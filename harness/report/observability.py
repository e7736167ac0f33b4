"""A figure of what readings can tell along a trajectory."""

from pathlib import Path

import numpy as np
import xarray

from railgrip.report import style
from railgrip.trace.samples import reading_of, unit_of

_COLORS = (style.BLUE, style.BLACK, style.VERMILION, style.GREEN, style.ORANGE, style.PURPLE, style.SKY)
_DASHES = ("-", "--", ":", "-.")


def information(recording: xarray.Dataset, windows: xarray.Dataset, path: Path, *, inputs: tuple[str, ...]) -> Path:
    """Draw the inputs, and below them the smallest singular value of the Gramian, of all and of each state.

    Windows that tell nothing of a state have no point on the logarithmic axis: the line is broken there.
    """
    drawing, (above, below) = style.panels(10, 6.5, 2, 1, sharex=True, height_ratios=(1, 2))
    for name, color in zip(inputs, (style.ORANGE, style.BLUE), strict=False):
        factor, unit = style.readable(unit_of(recording, name))
        above.plot(
            recording["time"], factor * reading_of(recording, name), color=color, lw=0.8, label=f"{name} [{unit}]"
        )
    style.dress(above, title=f"{windows.attrs['name']}: windows of {windows.attrs['window']:g} s")
    style.legend(above, loc="upper left")
    time = windows["time"].values
    families: dict[str, int] = {}
    for state in windows["state"].values:
        # A colour a kind of state, a dash an element of it.
        family = str(state).partition("[")[0]
        color = _COLORS[list(families).index(family) if family in families else len(families)]
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
    below.axhline(1.0, color=style.BLACK, lw=0.7, ls=":")
    style.dress(below, x="time [s]", y="(typical size / deviation)²")
    style.legend(below, ncols=8, loc="lower left", bbox_to_anchor=(0.0, 1.0))
    return style.save(drawing, path)
