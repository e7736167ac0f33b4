"""A table as a value, displayed on a screen or written as Markdown, HTML or CSV, or between two marks of a page.

Texts of users are escaped. A page encloses a table by the lines `<!-- NAME: written by `COMMAND` -->` and
`<!-- end -->`, so that its numbers agree with the results.
"""

import csv
import math
import re
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final, Self

from markupsafe import Markup

from railgrip.base.files import replacing

if TYPE_CHECKING:
    import pandas

from railgrip.base.errors import RecordError
from railgrip.base.files import read_text, write_text

TEXT_COLUMNS = frozenset(
    {"scenario", "actuation", "sensors", "creep curve", "controller", "estimator", "draws", "stop", "figure", "state",
     "unit", "breaks"}
)  # fmt: skip
"""Columns that are left-aligned by default; all others are numbers."""

Form = str | Callable[[Any], str]
"""A format such as "{:.1f} m", or a function that returns the text of a value."""

_NAMES = 8

_WIDE = 130
"""Characters of a row beyond which a table has small letters, and its page is printed in landscape."""

_WRAPPED = 30
"""Characters of a text after which it is wrapped."""

_MARKDOWN: Final = re.compile(
    r"[&<`*\[\]|~\\]"
    r"|(?<![^\W_])_|_(?![^\W_])"  # an underscore inside a word is not emphasis (CommonMark 0.31, section 6.2)
    r"|^[#+=>-]"  # headings, lists, quotes and rules at the start of a line
)
"""Characters that CommonMark interprets in a text of one line."""
_HTML: Final = re.compile(rf"{_MARKDOWN.pattern}|[>\"']")
_UNIT: Final = re.compile(r"(?<=\d) (?=[^\W\d]|%)")
"""Space between a number and its unit, at which no line is broken."""
_JOINT: Final = re.compile(r"(?<=[^\W_]{3})(_)(?=[^\W_]{3})")
"""Underscore between the words of a name, after which a line may be broken."""
_BAR: Final = re.compile(r"(?<!\\)((?:\\\\)*)\|")
"""A bar of a Markdown cell that would end it: one that no backslash escapes."""
_NAMED: Final = {"&": "&amp;", "<": "&lt;", ">": "&gt;"}


class Link(str):
    """A text that an HTML page links to an address; elsewhere it is plain text."""

    __slots__ = ("address",)

    address: str

    def __new__(cls, text: str, address: str) -> Self:
        """Return a text with an address, relative to the page."""
        link = super().__new__(cls, text)
        link.address = address
        return link


@dataclass(frozen=True, slots=True)
class ReportTable:
    """Values in rows of equal columns.

    In a template of HTML it is an HTML table, in any other one a Markdown table.

    Attributes:
        rows: Column → value; None and NaN are empty cells, strings are unchanged.
        forms: Column → format of its values; `str` by default.
        left: Columns of texts.
        title: Title on a screen.
    """

    rows: Sequence[Mapping[str, Any]]
    forms: Mapping[str, Form] = field(default_factory=dict[str, Form])
    left: Collection[str] = TEXT_COLUMNS
    title: str = ""

    @classmethod
    def of(
        cls,
        columns: Sequence[str] | Mapping[str, Form],
        rows: Iterable[Sequence[Any]],
        form: Form = "{}",
        *,
        left: int | Collection[str] = 1,
        title: str = "",
    ) -> Self:
        """Return a table of rows as sequences.

        Args:
            columns: Names of the columns; or column → form of its numbers.
            rows: Values in the order of the columns.
            form: Form of all numbers, if columns have none.
            left: Columns of texts, or their number if they are the first ones.
            title: Title on a screen.
        """
        forms = columns if isinstance(columns, Mapping) else dict.fromkeys(columns, form)
        records = [dict(zip(columns, row, strict=True)) for row in rows]
        return cls(records, forms, list(columns)[:left] if isinstance(left, int) else left, title)

    @classmethod
    def of_frame(
        cls,
        frame: "pandas.DataFrame",
        forms: Mapping[str, Form] = MappingProxyType({}),
        left: Collection[str] = TEXT_COLUMNS,
        title: str = "",
    ) -> Self:
        """Return a view of a frame, without its index; NaN is an empty cell."""
        rows = [
            {str(name): None if _is_nan(value) else value for name, value in row.items()}
            for row in frame.to_dict("records")
        ]
        return cls(rows, forms, left, title)

    @property
    def columns(self) -> list[str]:
        """Names of the columns; empty without rows."""
        return list(self.rows[0]) if self.rows else []

    @property
    def texts(self) -> list[dict[str, str]]:
        """Rows as formatted text."""
        return [
            {column: text(value, self.forms.get(column, "{}")) for column, value in row.items()} for row in self.rows
        ]

    def __bool__(self) -> bool:
        return bool(self.rows)

    def without(self, columns: Collection[str]) -> Self:
        """Return the table without some columns."""
        return replace(self, rows=[{name: row[name] for name in row if name not in columns} for row in self.rows])

    def drop_empty_columns(self) -> Self:
        """Return the table without empty columns."""
        return self.without({column for column in self.columns if not any(row[column] for row in self.texts)})

    def parts(self, addresses: Sequence[str | None] = ()) -> "list[ReportTable | str]":
        """Return a sentence on the text columns that are equal in all rows, and the table without them.

        A table of one row keeps all columns; one without rows has no parts.

        Args:
            addresses: Page to which the first cell of each row is linked, or None; empty for no links.
        """
        if not self:
            return []
        first, *others = self.texts
        same = {
            name: cell
            for name, cell in first.items()
            if name in self.left and others and all(row[name] == cell for row in others)
        }
        table = self.without(same)
        if addresses:
            column = table.columns[0]
            pairs = zip(table.rows, addresses, strict=True)
            linked = [{**row, column: Link(str(row[column]), to)} if to else row for row, to in pairs]
            table = replace(table, rows=linked)
        sentence = f"Same in all rows: {'; '.join(map(' '.join, same.items()))}."
        return [sentence, table] if same else [table]

    def with_texts(self, convert: Callable[[str], str]) -> Self:
        """Return the table with its strings converted; numbers are unchanged."""
        rows = [
            {column: convert(value) if isinstance(value, str) else value for column, value in row.items()}
            for row in self.rows
        ]
        return replace(self, rows=rows)

    def __str__(self) -> str:
        """Return the table as Markdown, whose cells may have emphasis and links; see `with_texts` for users' texts."""
        rules = ("---" if column in self.left else "--:" for column in self.columns)
        rows = (self.columns, *(row.values() for row in self.texts))
        # No cell ends the cell or the row.
        safe = ((_BAR.sub(r"\1\|", _one_line(cell)) for cell in cells) for cells in rows)
        head, *lines = (f"| {' | '.join(cells)} |" for cells in safe)
        return "\n".join((head, f"|{'|'.join(rules)}|", *lines))

    _repr_markdown_ = __str__

    def __html__(self) -> str:
        """Return the table as HTML; columns of texts are of the class `text`, numbers keep their values for sorting."""
        kind = "data wide" if self._width() > _WIDE else "data"
        head = "".join(self._cell("th", column, column) for column in self.columns)
        rows = zip(self.rows, self.texts, strict=True)
        lines = ("".join(self._cell("td", name, cells[name], row[name]) for name in cells) for row, cells in rows)
        body = "".join(f"<tr>{line}</tr>" for line in lines)
        columns = f' style="--columns: {len(self.columns)}"'
        return f'<table class="{kind}"{columns}><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>'

    def _width(self) -> int:
        """Return the characters of a row, with two between columns."""
        longest = {column: max(len(cells[column]) for cells in self.texts) for column in self.columns}
        return sum(2 + (min(size, _WRAPPED) if column in self.left else size) for column, size in longest.items())

    def _cell(self, tag: str, column: str, cell: str, value: Any = None) -> str:
        is_long = len(cell) > _WRAPPED / 2
        kind = f' class="text{" long" * is_long}"' if column in self.left else ""
        number = f' data-value="{value:.9g}"' if isinstance(value, int | float) and not _is_nan(value) else ""
        shown = re.sub("&#96;(.+?)&#96;", r"<code>\1</code>", _UNIT.sub("\u00a0", str(as_html(cell))))
        shown = _JOINT.sub(r"\1<wbr>", shown)
        if isinstance(value, Link):
            shown = f'<a href="{as_html(value.address)}">{shown}</a>'
        return f"<{tag}{kind}{number}>{shown}</{tag}>"

    def write_csv(self, path: Path) -> None:
        """Write the values, not their formatted texts, completely or not at all."""
        with replacing(path) as partial, partial.open("w", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, self.columns)
            writer.writeheader()
            writer.writerows(self.rows)


def text(value: Any, form: Form = "{}") -> str:
    """Return a formatted value, '' for None and NaN."""
    if isinstance(value, str):
        return value
    if value is None or _is_nan(value):
        return ""
    return form.format(value).replace("-", "−") if isinstance(form, str) else form(value)


def _is_nan(value: Any) -> bool:
    return isinstance(value, float) and math.isnan(value)


def percent(value: float | None, *, negate: bool = False, sign: bool = True) -> str:
    """Return a share in percent; `negate` turns a reduction into a change: −12.9 %."""
    if value is None or not math.isfinite(value):
        return ""
    return text(-100 * value if negate else 100 * value, "{:+.1f} %" if sign else "{:.1f} %")


def percent_or_endless(value: float) -> str:
    """Return a change in percent, "endless" for a stop without standstill."""
    return percent(value) or "endless"


def change(reduction: float) -> str:
    """Return a reduction, 1 − distance over that of another, as a change in percent."""
    return percent(reduction, negate=True)


def share(value: float) -> str:
    """Return a share without a sign."""
    return percent(value, sign=False)


def with_interval(
    value: Any, interval: tuple[Any, Any] | None, form: Form, unit: str = "", *, without: float | None = None
) -> str:
    """Return a value with its interval in brackets, if there is one.

    Args:
        value: Value in its form.
        interval: Ends of the interval.
        form: Form of all three numbers.
        unit: Text that follows the value.
        without: Value without a difference. If the interval contains it, the text says that no difference is shown.
    """
    shown = f"{text(value, form)}{unit}"
    if interval is None:
        return shown
    low, high = interval
    words = "; no difference shown" if without is not None and low <= without <= high else ""
    return f"{shown} [{text(low, form)}, {text(high, form)}]{words}"


def yes_no(value: bool) -> str:
    """Return "yes" or "no"."""
    return "yes" if value else "no"


def names(stops: Sequence[str]) -> str:
    """Return names for a sentence: all of a few, else the first ones and the number of the others."""
    more = f" and {len(stops) - _NAMES} more" if len(stops) > _NAMES else ""
    return ", ".join(stops[:_NAMES]) + more


def as_html(text: str) -> Markup:
    """Return a text for an HTML page, or for Markdown that becomes HTML: one line, special characters as entities."""
    return Markup(_escape(text, _HTML, lambda character: _NAMED.get(character, f"&#{ord(character)};")))


def as_markdown(text: str) -> str:
    """Return a text for a Markdown file: one line, special characters escaped by a backslash."""
    return _escape(text, _MARKDOWN, lambda character: f"\\{character}")


def _escape(text: str, special: re.Pattern[str], spell: Callable[[str], str]) -> str:
    line, head = _one_line(text), ""
    if number := re.match(r"(\d{1,9})([.)])(?=\s|$)", line, re.ASCII):  # an item of a list
        head, line = number[1] + spell(number[2]), line[number.end() :]
    return head + special.sub(lambda match: spell(match[0]), line)


def _one_line(text: str) -> str:
    """Return a text without line breaks and control characters, which would start another block."""
    return " ".join(re.sub(r"[\x00-\x1f\x7f-\x9f\u2028\u2029]", " ", text).split())


END = "<!-- end -->"
"""Mark after each table."""


def names_in(text: str) -> list[str]:
    """Return the names of the tables that a page has marks for."""
    return re.findall(r"^<!-- ([^:>]+): written by `[^`\n]+` -->$", text, re.MULTILINE)


def with_tables(text: str, tables: Mapping[str, ReportTable | str]) -> str:
    """Return the text of a page with these tables between their marks.

    Args:
        text: Text of the page.
        tables: Tables by name.

    Raises:
        RecordError: The page lacks one of the marks; the message begins with a verb.
    """
    for name, table in tables.items():
        mark = re.compile(rf"^<!-- {re.escape(name)}: written by `[^`\n]+` -->$", re.MULTILINE).search(text)
        end = text.find(END, mark.end()) if mark else -1
        if mark is None or end < 0:
            begin = f"<!-- {name}: written by `COMMAND` -->"
            raise RecordError(f"lacks a line that encloses the table; add '{begin}' and '{END}'")
        text = f"{text[: mark.end()]}\n{table}\n{text[end:]}"
    return text


def bulleted(sentences: Iterable[str]) -> str:
    """Return sentences as a list in Markdown."""
    return "\n".join(f"- {sentence}" for sentence in sentences)


def write_tables(path: Path, tables: Mapping[str, ReportTable | str]) -> None:
    """Write tables between the marks of a page; see `with_tables`.

    Raises:
        InputError: The page cannot be read, or lacks one of the marks.
    """
    text = read_text(path)
    try:
        written = with_tables(text, tables)
    except RecordError as problem:
        raise RecordError(f"{path}: {problem}") from problem
    write_text(path, written)
