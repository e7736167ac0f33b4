"""A stop that shows itself in a notebook."""

from typing import TYPE_CHECKING, Any

from railgrip.report.results import Result
from railgrip.report.table import Table
from railgrip.trace import stop
from railgrip.trace.metrics import meanings
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
        return signals_figure(result, thinned(self.trace, self.scenario.periods.every("trace")))

    def _repr_html_(self) -> str:
        """Return headline and figures, for notebooks."""
        rows: list[dict[str, Any]] = [
            {"figure": name, "value": _text(getattr(self.metrics, name)), "unit": unit, "meaning": meaning}
            for name, (unit, meaning) in meanings().items()
        ]
        table = Table(rows, left=("figure", "value", "unit", "meaning"))
        return f"<pre>{self!r}</pre><details><summary>Figures</summary>{table.__html__()}</details>"


def _text(value: object) -> str:
    if isinstance(value, tuple):
        return ", ".join(f"({_text(one)})" if isinstance(one, tuple) else _text(one) for one in value)
    return f"{value:.4g}" if isinstance(value, float) else "" if value is None else str(value)
