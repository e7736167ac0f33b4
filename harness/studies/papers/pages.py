"""The numbers in docs/papers, between marks, so that they cannot say anything but what the files of results say."""

from collections.abc import Mapping
from pathlib import Path

from railgrip.errors import RecordError
from railgrip.files import write_text
from railgrip.report.table import Table


def begin(name: str) -> str:
    """Return the mark before a table."""
    return f"<!-- {name}: written by `railgrip study papers --write` -->"


END = "<!-- end -->"


def with_tables(text: str, tables: Mapping[str, Table]) -> str:
    """Return the text of a page with other tables between its marks.

    Raises:
        RecordError: It has not the marks of one of them.
    """
    for name, table in tables.items():
        before, mark, rest = text.partition(begin(name))
        _, end, after = rest.partition(END)
        if not mark or not end:
            raise RecordError(
                f"the page has not the two lines between which '{name}' belongs, '{begin(name)}', '{END}'"
            )
        text = f"{before}{begin(name)}\n{table}\n{END}{after}"
    return text


def write_tables(page: Path, tables: Mapping[str, Table]) -> None:
    """Write tables between the marks of a page; see `with_tables`."""
    write_text(page, with_tables(page.read_text(encoding="utf-8"), tables))
