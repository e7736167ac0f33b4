"""Write tables between two marks of a page, so that its numbers agree with the results.

A page encloses a table by the lines `<!-- NAME: written by `COMMAND` -->` and `<!-- end -->`.
"""

import re
from collections.abc import Mapping
from pathlib import Path

from railgrip.base.errors import InputError, RecordError
from railgrip.base.files import read_text, write_text
from railgrip.report.table import ReportTable

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


def write_tables(path: Path, tables: Mapping[str, ReportTable | str]) -> None:
    """Write tables between the marks of a page; see `with_tables`.

    Raises:
        RecordError: The page cannot be read, or lacks one of the marks.
    """
    text = page_text(path)
    try:
        written = with_tables(text, tables)
    except RecordError as problem:
        raise RecordError(f"{path}: {problem}") from problem
    write_text(path, written)


def page_text(path: Path) -> str:
    """Return the text of a page.

    Raises:
        RecordError: The page cannot be read.
    """
    try:
        return read_text(path)
    except InputError as problem:
        raise RecordError(str(problem)) from problem
