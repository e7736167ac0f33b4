"""Tables that commands write between two marks of a page, so that its numbers agree with the results."""

from collections.abc import Mapping
from pathlib import Path

from railgrip.base.errors import RecordError
from railgrip.base.files import write_text
from railgrip.report.table import Table

END = "<!-- end -->"
"""Mark after each table that a study writes."""


def mark(name: str, study: str) -> str:
    """Return the mark before a table that `railgrip study STUDY --write` writes."""
    return f"<!-- {name}: written by `railgrip study {study} --write` -->"


def with_tables(text: str, tables: Mapping[str, Table | str], end: str = END) -> str:
    """Return the text of a page with these tables between their marks.

    Args:
        text: Of the page.
        tables: By the mark before each.
        end: Mark after each.

    Raises:
        RecordError: The page lacks one of the marks; the sentence begins with a verb.
    """
    for begin, table in tables.items():
        before, mark, rest = text.partition(begin)
        _, closing, after = rest.partition(end)
        if not mark or not closing:
            raise RecordError(f"lacks a line that encloses the table; add '{begin}' and '{end}'")
        text = f"{before}{begin}\n{table}\n{end}{after}"
    return text


def write_marked(path: Path, tables: Mapping[str, Table]) -> list[str]:
    """Write those tables for which a page has a mark `<!-- NAME: written by ...`; return their names.

    Raises:
        RecordError: The page cannot be read, or has no such mark.
    """
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except OSError as problem:
        raise RecordError(f"{path}: cannot be read: {problem.strerror}") from problem
    marks = {name: line for name in tables for line in lines if line.startswith(f"<!-- {name}: written by ")}
    if not marks:
        raise RecordError(f"{path}: has none of the marks {', '.join(f'<!-- {name}: written by …' for name in tables)}")
    write_tables(path, {mark: tables[name] for name, mark in marks.items()})
    return list(marks)


def write_tables(path: Path, tables: Mapping[str, Table | str], end: str = END) -> None:
    """Write tables between the marks of a page; see `with_tables`.

    Raises:
        RecordError: The page cannot be read, or lacks one of the marks.
    """
    try:
        text = path.read_text(encoding="utf-8")
    except OSError as problem:
        raise RecordError(f"{path}: cannot be read: {problem.strerror}") from problem
    try:
        written = with_tables(text, tables, end)
    except RecordError as problem:
        raise RecordError(f"{path}: {problem}") from problem
    write_text(path, written)
