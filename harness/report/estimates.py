"""The estimates of a filter as a dataset with a short representation."""

import html
from typing import TYPE_CHECKING, Any

import xarray

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_MAX_STATES = 4


class Estimates(xarray.Dataset):
    """Estimates of a filter over a recording: an xarray dataset with a short representation and a figure."""

    __slots__ = ()

    def plot(self, recording: xarray.Dataset | None = None) -> "Figure":  # pyright: ignore[reportIncompatibleVariableOverride] - a dataset's own plots need names of axes
        """Return a figure (matplotlib) of states ± 2 standard deviations and of the consistency of innovations.

        Of several filters, select one: `estimates.sel(filter="fmu").plot()`.

        Args:
            recording: Recording with the true states, which are drawn with the estimates, such as `stop.trace`.
        """
        from railgrip.report.figures import estimates_figure  # matplotlib takes half a second to load

        return estimates_figure(xarray.Dataset() if recording is None else recording, self, ())

    def __repr__(self) -> str:
        is_of_one = "filter" not in self.sizes and {"time", "state"} <= set(self.sizes)
        if not is_of_one or not {"mean", "sd"} <= set(self) or not self.sizes["time"]:
            return super().__repr__()
        states = [str(state) for state in self["state"].values]
        mean, sd = (self[name].values[-1] for name in ("mean", "sd"))
        ends = [f"{state} {mean[i]:.4g} ± {sd[i]:.2g}" for i, state in enumerate(states[:_MAX_STATES])]
        more = f" and {len(states) - len(ends)} more" if len(states) > len(ends) else ""
        lines = (
            f"Estimates of {self.attrs.get('name') or 'a recording'}: {self.sizes['time']} samples, "
            f"{float(self['time'].values[0]):.2f} s to {float(self['time'].values[-1]):.2f} s",
            f"  {len(states)} states, at the end {', '.join(ends)}{more}",
            f"  median NIS {self.attrs.get('nis_ratio', float('nan')):.3g} of the expected one",
            f"  {self.attrs.get('ended') or 'The filter followed the recording to its end.'}",
            f"  xarray.Dataset with {', '.join(str(name) for name in self.data_vars)}",
        )
        warnings = (f"  warning: {line}" for line in str(self.attrs.get("warnings", "")).splitlines())
        problems = (f"  problem: {line}" for line in str(self.attrs.get("problems", "")).splitlines())
        repairs = (f"  repair: {line}" for line in str(self.attrs.get("repairs", "")).splitlines())
        return "\n".join((*lines, *problems, *repairs, *warnings))

    def _repr_html_(self) -> str:
        return f"<pre>{html.escape(repr(self))}</pre>{super()._repr_html_()}"


def as_estimates(dataset: xarray.Dataset) -> Estimates:
    """Return a dataset of estimates with this representation."""
    parts: dict[Any, Any] = {**dataset.data_vars}
    return Estimates(parts, coords=dataset.coords, attrs=dataset.attrs)
