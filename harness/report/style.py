"""Style of all figures: colours, sizes and helpers; without pyplot, whose state is global."""

from collections.abc import Callable, Mapping, Sequence
from functools import cache
from io import BytesIO
from pathlib import Path
from typing import Any, cast
from unicodedata import bidirectional

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.axis import Axis, Tick
from matplotlib.backend_bases import RendererBase
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties, findfont, get_font
from matplotlib.text import Text
from matplotlib.ticker import FuncFormatter
from PIL import Image

from railgrip.base.files import replacing
from railgrip.base.groups import gather
from railgrip.report.palette import BLACK

KMH = 3.6


_READABLE = {"Pa": (1e-5, "bar"), "N": (1e-3, "kN"), "m-1": (1e3, "1/km")}


def readable(unit: str) -> tuple[float, str]:
    """Return factor and unit for display of a quantity in an SI unit."""
    return _READABLE.get(unit, (1.0, unit))


@cache
def advance(character: str) -> float | None:
    """Return the width of a character over the size of the font of figures; None if it cannot be drawn.

    Right-to-left scripts have glyphs, which would be drawn from left to right and unjoined.
    """
    font = get_font(findfont(FontProperties(family="DejaVu Sans")))
    font.set_size(_SIZE, 72)
    if ord(character) not in font.get_charmap() or bidirectional(character) in ("R", "AL"):
        return None
    return font.load_char(ord(character)).linearHoriAdvance / 65536 / _SIZE


_SIZE = 100


def legible(text: str) -> str:
    """Return a text with the codes of characters that cannot be drawn, which would be boxes."""
    return "".join(c if c.isspace() or advance(c) is not None else f"[U+{ord(c):04X}]" for c in text)


class Drawing(Figure):
    """A figure whose texts are drawn as they are written: matplotlib takes what is between two dollars for a formula.

    Characters that its font lacks are drawn as their codes.

    Attributes:
        has_formulas: Whether they are formulas; for figures without texts of the user.
    """

    has_formulas = False

    def draw(self, renderer: RendererBase) -> None:
        """Draw the figure; powers of ten on logarithmic axes are always formulas."""
        scales = cast(list[Axis], self.findobj(lambda part: isinstance(part, Axis) and part.get_scale() == "log"))
        powers = {text for scale in scales for tick in scale.findobj(Tick) for text in tick.findobj(Text)}

        def coded(label: Callable[..., str]) -> Callable[[float, int | None], str]:
            return lambda x, place: legible(label(x, place))

        for text in self.findobj(Text):
            text.set_parse_math(self.has_formulas or text in powers)
            text.set_text(legible(text.get_text()))
        ticks = [axis.get_major_formatter() for axis in self.findobj(Axis)]
        labels = {each: each.func for each in ticks if isinstance(each, FuncFormatter)}
        for each, label in labels.items():
            each.func = coded(label)
        super().draw(renderer)
        for each, label in labels.items():
            each.func = label


def figure(width: float, height: float, margins: Mapping[str, float] | None = None) -> Drawing:
    """Return an empty figure of a size in inches.

    Its parts are placed automatically, or within `margins`, shares of the figure as for
    `matplotlib.figure.Figure.subplots_adjust`: the automatic layout of twenty panels takes longer than drawing them.
    """
    drawing = Drawing(figsize=(width, height), layout=None if margins else "constrained")
    if margins:
        drawing.subplots_adjust(**margins)
    FigureCanvasAgg(drawing)
    return drawing


def panels(
    width: float, height: float, rows: int = 1, columns: int = 1, *, label: str = "", **options: Any
) -> tuple[Drawing, Any]:
    """Return a figure of a size in inches and its axes, with the options of `matplotlib.figure.Figure.subplots`.

    On a page of a study, its label is read to those who do not see it.
    """
    drawing = figure(width, height)
    drawing.set_label(label)
    return drawing, drawing.subplots(rows, columns, **options)


def band(axes: Axes, x: Any, low: Any, high: Any, color: str, alpha: float, label: str | None = None) -> None:
    """Shade the area between two lines."""
    axes.fill_between(x, low, high, color=color, alpha=alpha, linewidth=0, label=label)


def legend(axes: Axes | Figure, *handles: Any, **options: Any) -> None:
    """Name the lines of axes or a figure in small letters without a frame, with the options of their `legend`."""
    axes.legend(*handles, fontsize=8, frameon=False, **options)


def second_scale(axes: Axes, label: str, color: str = BLACK) -> Axes:
    """Return axes over the same x with their scale on the right."""
    other = axes.twinx()
    other.set_ylabel(label, color=color)
    other.spines["top"].set_visible(False)
    return other


def dress(axes: Axes, *, x: str = "", y: str = "", title: str = "", **more: Any) -> None:
    """Label axes and remove the lines that carry no information; `more` is for `Axes.set`, such as limits."""
    axes.set(xlabel=x, ylabel=y, **more)
    axes.set_title(title, loc="left", fontsize=10)
    axes.grid(visible=True, color="#DDDDDD", linewidth=0.6)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)


def save(drawing: Figure, path: Path, description: str | None = None) -> Path:
    """Write a figure as PNG, SVG or PDF by its name, whole or not at all; the same figure gives the same bytes.

    Args:
        description: Text for the metadata of an SVG.
    """
    dates: dict[str, dict[str, str | None]] = {
        ".svg": {"Date": None},
        ".pdf": {"CreationDate": None},
        ".png": {"Software": None},
    }
    if description is not None:
        dates[".svg"]["Description"] = description
    kind = path.suffix if path.suffix in dates else ".png"
    with replacing(path) as partial, rc_context({"svg.hashsalt": path.name}):
        drawing.savefig(partial, format=kind[1:], dpi=150, metadata=cast(Any, dates[kind]))
    return path


def picture(file: str, words: str, draw: Callable[[], Figure]) -> str:
    """Return a PNG file as a picture in Markdown, after it was drawn unless it exists: pages of studies store those of
    long runs.
    """
    if not Path(file).exists():
        reduce_colours(save(draw(), Path(file)))
    return f"![{words}]({file})"


def reduce_colours(path: Path) -> None:
    """Write a PNG file anew with a palette, sufficient for lines in a few colours: the file is a third as large."""
    drawn = Image.open(path).convert("RGB")
    drawn.quantize(128, Image.Quantize.MAXCOVERAGE).save(path, optimize=True)


def save_as(drawing: Figure, path: Path, formats: Sequence[str]) -> None:
    """Write a figure in several formats, which replace the suffix of a path."""
    drawing.draw_without_rendering()
    drawing.set_layout_engine(None)  # all parts are placed; "none" would draw again for each format
    for suffix in formats:
        save(drawing, path.with_suffix(f".{suffix}"))


def svg(drawing: Figure) -> bytes:
    """Return a figure as SVG whose texts are texts, so that a printed page can be searched.

    A browser without the font of figures takes one as wide, or a narrower one.
    """
    buffer = BytesIO()
    with rc_context({"svg.hashsalt": "", "svg.fonttype": "none"}):
        drawing.savefig(buffer, format="svg", metadata=cast(Any, {"Date": None}))
    return buffer.getvalue()


def alike(columns: Sequence[np.ndarray]) -> list[list[int]]:
    """Return the numbers of equal columns as groups, so that a line drawn once can be labelled for all."""
    return [*gather((column.tobytes(), number) for number, column in enumerate(columns)).values()]


def one_based(numbers: Sequence[int]) -> str:
    """Return zero-based numbers as one-based text: [0, 1] → "1, 2"."""
    return ", ".join(str(number + 1) for number in numbers)
