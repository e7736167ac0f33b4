"""A stop that shows itself in a notebook."""

from math import isnan
from typing import TYPE_CHECKING

from railgrip.report.results import Result
from railgrip.report.table import Table
from railgrip.trace import stop
from railgrip.trace.metrics import Metrics, meanings
from railgrip.trace.recorder import thinned

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class Stop(stop.Stop):
    """One run of one scenario: `.outcome`, `.reason`, `.metrics`, `.trace` (xarray), `.write(folder)`, `.plot()`."""

    __slots__ = ()

    def plot(self) -> "Figure":
        """Return a figure (matplotlib) with a column for each group: speed, slip, adhesion, friction and pressure."""
        from railgrip.report.figures import signals_figure  # matplotlib takes half a second to load

        result = Result(name=self.scenario.name, variants={}, record=self.record(), paper_distance=None)
        return signals_figure(result, thinned(self.trace, int(self.scenario.periods.every("trace"))))

    def _repr_html_(self) -> str:
        """Return headline and figures, for notebooks."""
        return (
            f"<pre>{self!r}</pre><details><summary>Figures</summary>{metrics_table(self.metrics).__html__()}</details>"
        )


def metrics_table(metrics: Metrics) -> Table:
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
    return Table(rows, left=("figure", "value", "unit", "meaning"))


def value_text(value: object) -> str:
    """Return a number, or numbers one after the other, with four digits; a dash where there is none."""
    if isinstance(value, tuple):
        return ", ".join(f"({value_text(part)})" if isinstance(part, tuple) else value_text(part) for part in value)
    if value is None or (isinstance(value, float) and isnan(value)):
        return "–"
    return f"{value:.4g}" if isinstance(value, float) else str(value)
