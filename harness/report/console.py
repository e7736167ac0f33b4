"""Console output: results on standard output, everything else on standard error; text is printed unchanged.

rich is used for tables and bars only: elsewhere it would interpret markup and emoji in users' texts.
"""

import logging
import sys
import textwrap
import time
from collections.abc import Callable, Generator, Iterable
from contextlib import contextmanager, nullcontext, suppress
from functools import partial
from pathlib import Path
from threading import Event, Thread
from typing import TYPE_CHECKING, Any, Final

from rich.console import Console

from railgrip.base.errors import InputError, for_user

if TYPE_CHECKING:
    from railgrip.report.table import ReportTable

REMINDER: Final = 10.0
"""Time between two lines of progress without a terminal [s]."""

_WORD: Final = 10
"""Minimum width of a column with longer texts, and of a header in several lines [characters]."""


def _console(**settings: Any) -> Console:
    return Console(markup=False, emoji=False, highlight=False, **settings)


# Without a terminal, a table is not cut to the width of one.
_out = _console(width=None if sys.stdout and sys.stdout.isatty() else 180)
_err = _console(stderr=True)


_log = logging.getLogger("railgrip")


class _ScreenHandler(logging.Handler):
    def emit(self, record: logging.LogRecord) -> None:
        _err.print(self.format(record), soft_wrap=True)


def show_messages(level: int) -> None:
    """Print messages of this level and above on standard error: DEBUG, INFO, or WARNING for results and errors only."""
    _log.setLevel(level)
    if not any(isinstance(handler, _ScreenHandler) for handler in _log.handlers):
        _log.addHandler(_ScreenHandler())


def _is_quiet() -> bool:
    return _log.level > logging.INFO


def say(text: str) -> None:
    """Print a line of the result."""
    _out.print(text, soft_wrap=True)


def remark(text: str) -> None:
    """Print a line that is not a result on standard error, unless --quiet is set."""
    if not _is_quiet():
        with suppress(OSError):
            _err.print(text, soft_wrap=True)


def complain(text: str) -> None:
    """Print an error on standard error; if that fails, the exit code alone reports it."""
    with suppress(OSError):
        _err.print(text, style="red", soft_wrap=True)


def answer(command: Callable[[], object]) -> None:
    """Run a command; an error that the user can correct ends in a message and its exit code, not in a traceback."""
    try:
        _require_folder()
        command()
    except Exception as problem:
        message = for_user(problem)
        if message is None:
            raise
        complain(str(message))
        sys.exit(message.exit_code)


def _require_folder() -> None:
    """Check that the current folder exists, which paths are relative to.

    Raises:
        InputError: The folder has been removed.
    """
    try:
        Path.cwd()
    except OSError as problem:
        raise InputError("the current folder no longer exists; change to another one") from problem


def show_table(table: "ReportTable", nothing: str = "nothing") -> None:
    """Print a table, or a word if it has no rows."""
    if not table:
        say(f"{table.title}: {nothing}" if table.title else nothing)
        return
    import rich.table

    screen = rich.table.Table(title=table.title or None, box=None, title_justify="left", header_style="bold")
    texts = table.texts
    longest = {column: max(len(row[column]) for row in texts) for column in table.columns}
    is_narrow = sum(2 + max(len(column), size) for column, size in longest.items()) > _out.width
    least = 0
    for column, size in longest.items():
        # A number is never cut; on a narrow screen, headers and texts use more lines.
        number = column not in table.left
        header = textwrap.fill(column, max(size, _WORD), break_long_words=False) if is_narrow else column
        width = max(map(len, header.split("\n"))) if number else min(len(column), _WORD)
        width = max(width, size if number else min(size, _WORD))
        screen.add_column(
            header, justify="right" if number else "left", no_wrap=number, overflow="fold", min_width=width
        )
        least += 2 + width
    for row in texts:
        screen.add_row(*row.values())
    # rich omits text columns if the others fill the screen; beyond its edge they can still be read.
    screen.width = least if least > _out.width else None
    _out.print(screen, crop=False)


def show_all(parts: "Iterable[ReportTable | str]") -> None:
    """Print tables and sentences in their order."""
    for part in parts:
        if isinstance(part, str):
            say(part)
        else:
            show_table(part)


class Progress:
    """The progress of a task: its activity, the amount done, and the total, if it is known."""

    def __init__(self, name: str, total: float | None, is_count: bool) -> None:
        self._name, self._doing, self._amount, self._total, self._is_count = name, "", 0.0, total, is_count
        self._show: Callable[..., object] = lambda **_: None

    def update(self, *, doing: str | None = None, amount: float | None = None, total: float | None = None) -> None:
        """Display the present activity, the amount done, and the total; None leaves a value unchanged."""
        self._doing = self._doing if doing is None else doing
        self._amount = self._amount if amount is None else amount
        self._total = self._total if total is None else total
        self._show(description=self._task, completed=self._amount, total=self._total)

    def advance(self, doing: str | None = None) -> None:
        """Count one more item as done."""
        self.update(doing=doing, amount=self._amount + 1)

    @property
    def _task(self) -> str:
        return f"{self._name}: {self._doing}" if self._doing else self._name

    def __str__(self) -> str:
        if self._total is None:
            return self._task
        if self._is_count:
            return f"{self._task}, {self._amount:.0f} of {self._total:.0f}"
        return f"{self._task}, {100 * self._amount / self._total:.0f} %"

    @contextmanager
    def on_terminal(self) -> Generator[None]:
        """Show a bar."""
        from rich import progress as rich

        text = rich.TextColumn("{task.description}", markup=False)
        measure = () if self._total is None else (rich.BarColumn(), rich.MofNCompleteColumn())[: 1 + self._is_count]
        columns = (rich.SpinnerColumn(), text, *measure, rich.TimeElapsedColumn())
        with rich.Progress(*columns, console=_err, transient=True) as bar:
            self._show = partial(bar.update, bar.add_task(self._name, total=self._total))
            yield

    @contextmanager
    def in_lines(self) -> Generator[None]:
        """Print a line every `REMINDER` seconds."""
        end, start = Event(), time.monotonic()

        def remind() -> None:
            while not end.wait(REMINDER):
                remark(f"{self}, {time.monotonic() - start:.0f} s")

        thread = Thread(target=remind, name="progress", daemon=True)
        thread.start()
        try:
            yield
        finally:
            end.set()
            thread.join()


@contextmanager
def progress(name: str, total: float | None = None, *, is_count: bool = False) -> Generator[Progress]:
    """Show progress on standard error: a bar on a terminal, elsewhere a line every `REMINDER` seconds.

    Args:
        total: Total amount; None if unknown.
        is_count: Whether the total is a number of items, not a share.
    """
    shown = Progress(name, total, is_count)
    with nullcontext() if _is_quiet() else shown.on_terminal() if _err.is_terminal else shown.in_lines():
        yield shown
