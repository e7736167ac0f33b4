"""Figures of recordings and estimates.

They show the information in the readings over time, and every state with its uncertainty.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import xarray
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from railgrip.base.names import ElementName
from railgrip.recording.samples import knows, reading_of, truth_of, unit_of
from railgrip.report import palette, style

_COLOURS = (palette.BLUE, palette.ORANGE, palette.GREEN, palette.PURPLE, palette.SKY, palette.VERMILION)
_STATE_COLOURS = (
    palette.BLUE,
    palette.BLACK,
    palette.VERMILION,
    palette.GREEN,
    palette.ORANGE,
    palette.PURPLE,
    palette.SKY,
)
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
    families: dict[str, list[str]] = {}
    for name in names:
        families.setdefault(ElementName.of(name).array, []).append(name)
    return families


def _with_colours(names: Sequence[str]) -> list[tuple[str, str]]:
    colours = _COLOURS if len(names) <= len(_COLOURS) else palette.lead_to_trail(len(names))
    return list(zip(names, colours, strict=False))


def _label(name: str, names: Sequence[str]) -> str:
    """Return the number of an element; of many elements only the first and the last one have a label."""
    is_labelled = len(names) <= len(_COLOURS) or name in (names[0], names[-1])
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
