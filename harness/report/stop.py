"""A stop with representations for notebooks."""

from math import isnan
from typing import TYPE_CHECKING, Any

from railgrip.report.results import Result
from railgrip.report.table import ReportTable
from railgrip.trace import stop
from railgrip.trace.metrics import Metrics, meanings
from railgrip.trace.recorder import thin

if TYPE_CHECKING:
    import pandas
    from matplotlib.figure import Figure


class Stop(stop.Stop):
    """One run of one scenario: `.outcome`, `.reason`, `.metrics`, `.trace` (xarray).

    `.to_pandas()` returns the samples, `.write(folder)` writes the stop to files, `.plot()` draws it.
    """

    __slots__ = ()

    def plot(self) -> "Figure":
        """Return a figure (matplotlib) with a column for each group: speed, slip, adhesion, friction and pressure."""
        from railgrip.report.figures import signals_figure  # matplotlib takes half a second to load

        result = Result(name=self.scenario.name, variants={}, record=self.record(), paper_distance=None)
        return signals_figure(result, thin(self.trace, int(self.scenario.periods.every("trace"))))

    def to_pandas(self) -> "pandas.DataFrame":
        """Return the samples over time [s]; `slip[2]` is the slip of the second group.

        Values are in SI units, which `attrs["units"]` has by column.
        """
        import pandas

        columns: dict[str, Any] = {}
        units: dict[str, str] = {}
        for name, variable in self.trace.data_vars.items():
            if variable.dims[:1] != ("time",):
                continue
            values = variable.values.reshape(variable.sizes["time"], -1)
            for number, column in enumerate(values.T, start=1):
                label = f"{name}[{number}]" if variable.ndim > 1 else str(name)
                columns[label] = column
                units[label] = variable.attrs.get("units", "1")
        frame = pandas.DataFrame(columns, index=pandas.Index(self.trace["time"].values, name="time"))
        frame.attrs["units"] = {"time": "s", **units}
        return frame

    def _repr_html_(self) -> str:
        figures = metrics_table(self.record().figures)
        return f"<pre>{self!r}</pre><details><summary>Figures</summary>{figures.__html__()}</details>"


def metrics_table(metrics: Metrics) -> ReportTable:
    """Return the figures of a stop with units and definitions."""
    rows = [
        {
            "figure": name.replace("_", " "),
            "value": value_text(getattr(metrics, name)),
            "unit": unit,
            "meaning": meaning,
        }
        for name, (unit, meaning) in meanings().items()
    ]
    return ReportTable(rows, left=("figure", "value", "unit", "meaning"))


def value_text(value: object) -> str:
    """Return a number, or comma-separated numbers, with four digits; a dash for None and NaN."""
    if isinstance(value, tuple):
        return ", ".join(f"({value_text(part)})" if isinstance(part, tuple) else value_text(part) for part in value)
    if value is None or (isinstance(value, float) and isnan(value)):
        return "–"
    return f"{value:.4g}" if isinstance(value, float) else str(value)
