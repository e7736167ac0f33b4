"""Pages on the published papers in docs/papers: a study writes its tables between marks, and its figures.

Schematic drawings are block diagrams, and bodies with their forces.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from railgrip.base.files import write_json
from railgrip.report import palette, style
from railgrip.report.table import Form, ReportTable, percent, text, write_tables

FOLDER = Path("docs/papers")
"""Folder of the pages relative to that of the project; their figures are in its folder `figures`."""

Point = tuple[float, float]


@dataclass(frozen=True, slots=True)
class PaperRow:
    """A quantity of a published figure or table and its reproduction: a row of `comparison`.

    Attributes:
        figure: Figure or table of the paper, such as "Fig. 4" or "Table 1".
        quantity: Name of the quantity, with its unit unless `form` has it.
        published: A number, the bounds (low, high) of a range, or text if the paper has no number; the bounds may be
            infinite.
        ours: Reproduced number, or text.
        form: Format of numbers, such as "{:.1f} m".
        difference: Text for a difference that is not computed from numbers.
        is_chosen: Whether the reproduced number was chosen to match the published one, so that the difference has no
            meaning.
    """

    figure: str
    quantity: str
    published: float | tuple[float, float] | str
    ours: float | str
    form: Form = "{:.3g}"
    difference: str = ""
    is_chosen: bool = False


def comparison(rows: Sequence[PaperRow]) -> ReportTable:
    """Return the table of a page: figure, quantity, published, ours and difference.

    The difference from a number is a change in percent; from zero it is the reproduced number; from a range it is
    "within" or the distance to its nearer bound. A number that was chosen to match has the difference "*chosen*".
    """
    return ReportTable(
        [
            {
                "figure": row.figure,
                "quantity": row.quantity,
                "published": _range(*row.published, row.form)
                if isinstance(row.published, tuple)
                else text(row.published, row.form),
                "ours": text(row.ours, row.form),
                "difference": "*chosen*" if row.is_chosen else row.difference or _difference(row),
            }
            for row in rows
        ],
        left=("figure", "quantity"),
    )


def write_results(
    page: str,
    tables: Mapping[str, ReportTable | str],
    figures: Mapping[str, Figure] | None = None,
    measures: Mapping[str, Any] | None = None,
) -> None:
    """Write tables between the marks of a page, and figures and their measures into `figures`.

    Args:
        page: File name of the page in `FOLDER`.
        tables: Tables by the names in the marks.
        figures: Figures by file names, which begin with that of the page because all pages have the same folder.
        measures: JSON values from which tables are made, so that tests need not run the study; see `measures_of`.

    Raises:
        RecordError: The page cannot be read, or lacks a mark.
    """
    write_tables(FOLDER / page, tables)
    for name, figure in (figures or {}).items():
        path = style.save(figure, FOLDER / "figures" / name)
        if path.suffix == ".png":
            style.reduce_colours(path)
    if measures is not None:
        write_json(_measures_file(page), measures)


def measures_of(page: str, project: Path = Path()) -> Any:
    """Return the measures of a page that `write_results` wrote into the folder of a project."""
    return json.loads((project / _measures_file(page)).read_text(encoding="utf-8"))


def _measures_file(page: str) -> Path:
    return (FOLDER / "figures" / page).with_suffix(".json")


def _range(low: float, high: float, form: Form) -> str:
    if low == float("-inf"):
        return f"≤ {text(high, form)}"
    return f"≥ {text(low, form)}" if high == float("inf") else f"{text(low, form)} to {text(high, form)}"


def _difference(row: PaperRow) -> str:
    published, ours = row.published, row.ours
    if isinstance(ours, str) or isinstance(published, str):
        return ""
    if not isinstance(published, tuple):
        return percent(ours / published - 1) if published else text(ours, row.form)
    low, high = published
    if low <= ours <= high:
        return "within"
    return f"{text(ours - high, row.form)} above" if ours > high else f"{text(low - ours, row.form)} below"


def canvas(width: float, height: float) -> tuple[Figure, Axes]:
    """Return a figure with formulas and without axes, whose coordinates are inches from the lower left corner."""
    drawing = style.figure(width, height, {"left": 0, "right": 1, "bottom": 0, "top": 1})
    drawing.has_formulas = True
    axes = drawing.subplots()
    axes.set_xlim(0, width)
    axes.set_ylim(0, height)
    axes.axis("off")
    return drawing, axes


def box(axes: Axes, corner: Point, size: Point, title: str, lines: str = "", linestyle: str = "-") -> None:
    """Draw a block with a title in bold over its other lines."""
    axes.add_patch(Rectangle(corner, *size, fill=False, linestyle=linestyle, linewidth=1.4))
    x, y = corner[0] + size[0] / 2, corner[1] + size[1] / 2
    count = lines.count("\n") + 1 if lines else 0
    axes.text(x, y + 0.09 * count, title, ha="center", va="center", fontsize=10, weight="bold")
    axes.text(x, y - 0.1, lines, ha="center", va="center", fontsize=8.5, linespacing=1.25)


def arrow(
    axes: Axes,
    begin: Point,
    end: Point,
    label: str = "",
    at: Point | None = None,
    color: str = palette.BLACK,
    ha: str = "center",
) -> None:
    """Draw an arrow with a label at a point, in the middle unless given."""
    axes.annotate(
        "", end, begin, arrowprops={"arrowstyle": "-|>", "color": color, "lw": 1.3, "shrinkA": 0, "shrinkB": 0}
    )
    place = at or ((begin[0] + end[0]) / 2, (begin[1] + end[1]) / 2)
    axes.text(*place, label, ha=ha, va="center", fontsize=9, color=color)


def dimension(axes: Axes, begin: Point, end: Point, label: str, offset: Point) -> None:
    """Draw a dimension between two points; its label is shifted from the middle."""
    axes.annotate(
        "", end, begin, arrowprops={"arrowstyle": "<->", "color": palette.GREY, "lw": 0.9, "shrinkA": 0, "shrinkB": 0}
    )
    x, y = (begin[0] + end[0]) / 2 + offset[0], (begin[1] + end[1]) / 2 + offset[1]
    axes.text(x, y, label, ha="center", va="center", fontsize=9, color=palette.GREY)
