"""Tables of texts: numbers as people read them, and the same columns as Markdown and as HTML."""

import html
import math
from collections.abc import Collection, Mapping, Sequence

Texts = Sequence[Mapping[str, str]]
"""Rows of a table, column → cell; all rows have the same columns."""

TEXT_COLUMNS = frozenset(
    {"scenario", "actuation", "sensors", "creep curve", "controller", "estimator", "stop", "figure", "state", "unit"}
)
"""What is read from the left; all other columns are numbers."""


_NAMES = 8


def number(value: float | None, form: str) -> str:
    """Return a number for people, nothing where there is none."""
    return "" if value is None or math.isnan(value) else form.format(value).replace("-", "−")


def percent(value: float | None, *, negate: bool = False, sign: bool = True) -> str:
    """Return a share for people; `negate` shows a reduction as the change it is: −12.9 %."""
    if value is None or not math.isfinite(value):
        return ""
    return number(-100 * value if negate else 100 * value, "{:+.1f} %" if sign else "{:.1f} %")


def filled(texts: Texts) -> Texts:
    """Return a table without the columns that have nothing in them."""
    columns = [column for column in (texts[0] if texts else ()) if any(text[column] for text in texts)]
    return [{column: text[column] for column in columns} for text in texts]


def names(stops: Sequence[str]) -> str:
    """Return names for a sentence: all of a few, else the first of them and how many more there are."""
    more = f" and {len(stops) - _NAMES} more" if len(stops) > _NAMES else ""
    return ", ".join(stops[:_NAMES]) + more


def markdown_table(texts: Texts, *, without: Collection[str] = (), left: Collection[str] = TEXT_COLUMNS) -> list[str]:
    """Return a table as lines of Markdown, some of its columns left out; those of texts are `left`."""
    columns = [column for column in texts[0] if column not in without]
    return [
        f"| {' | '.join(columns)} |",
        f"|{'|'.join('---' if column in left else '--:' for column in columns)}|",
        *(f"| {' | '.join(text[column] for column in columns)} |" for text in texts),
    ]


def html_table(texts: Texts) -> str:
    """Return a table as HTML; columns of texts are of the class `text`."""
    head = {column: column for column in texts[0]}
    return f"<table>{_html_row('th', head)}{''.join(_html_row('td', text) for text in texts)}</table>"


def _html_row(tag: str, cells: Mapping[str, str]) -> str:
    opened = {column: f'<{tag} class="text">' if column in TEXT_COLUMNS else f"<{tag}>" for column in cells}
    return f"<tr>{''.join(f'{opened[column]}{html.escape(cell)}</{tag}>' for column, cell in cells.items())}</tr>"
