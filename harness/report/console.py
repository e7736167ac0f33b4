"""Console output: results on standard output, everything else on standard error; text is printed unchanged.

rich is used for tables and bars only: elsewhere it would interpret markup and emoji in users' texts.
"""

import logging
import math
import sys
import textwrap
import time
from collections.abc import Callable, Generator, Iterable
from contextlib import contextmanager, nullcontext, suppress
from pathlib import Path
from threading import Event, Thread
from typing import TYPE_CHECKING, Any, Final

from rich.console import Console

from railgrip.base.activity import activities
from railgrip.base.errors import InputError, for_user

if TYPE_CHECKING:
    from rich import progress as rich

    from railgrip.report.table import ReportTable

FIRST_LINE, REMINDER = 3.0, 10.0
"""Time until the first line of progress without a terminal, and between two lines [s]."""

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
    show_messages(logging.INFO)  # unless an option of the command asks for others
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
    """The progress of a task: its phase, the amount done, and the total, if it is known.

    The amount is displayed between 0 and the total, but not if the total is unknown or 0, and a share not before it is
    1 %. Compilers that run in this process or its workers are displayed in place of the phase.
    """

    def __init__(self, name: str, phase: str, total: float | None, is_count: bool) -> None:
        self._name, self.phase, self._amount, self._is_count = name, phase, 0.0, is_count
        self._total: float | None = None
        self._bar: tuple[rich.Progress, rich.TaskID] | None = None
        self.update(total=total)

    def update(self, *, phase: str | None = None, amount: float | None = None, total: float | None = None) -> None:
        """Display the present phase, the amount done, and the total; None leaves a value unchanged."""
        self.phase = phase or self.phase
        if amount is not None and math.isfinite(amount):
            self._amount = max(amount, 0.0)
        if total is not None and (total >= 1.0 if self._is_count else total > 0.0) and total < math.inf:
            self._total = total
        self._show()

    def advance(self) -> None:
        """Count one more item as done."""
        self.update(amount=self._amount + 1)

    @property
    def _task(self) -> str:
        return f"{self._name}: {', '.join(activities()) or self.phase}"

    @property
    def _share(self) -> float:
        """Share that is done; 0 if the total is unknown."""
        return min(self._amount / self._total, 1.0) if self._total else 0.0

    @property
    def _measure(self) -> str:
        if self._is_count:
            return f"{self._share * self._total:.0f} of {self._total:.0f}" if self._total else ""
        percent = math.floor(100 * self._share)
        return f"{percent} %" if percent else ""

    def __str__(self) -> str:
        return f"{self._task}, {self._measure}" if self._measure else self._task

    def _show(self) -> None:
        if self._bar is not None:
            bar, task = self._bar
            total = 1.0 if self._measure else None
            bar.update(task, description=self._task, completed=self._share, total=total, measure=self._measure)

    @contextmanager
    def on_terminal(self) -> Generator[None]:
        """Show a bar."""
        from rich import progress as rich

        text, measure = (
            rich.TextColumn(f"{{task.{name}}}", markup=False) for name in ("description", "fields[measure]")
        )
        columns = (rich.SpinnerColumn(), text, rich.BarColumn(), measure, rich.TimeElapsedColumn())
        with rich.Progress(*columns, console=_err, transient=True) as bar:
            self._bar = bar, bar.add_task(self._task, total=None, measure="")
            with self._repeat(self._show, 1.0, 1.0):
                yield

    @contextmanager
    def in_lines(self) -> Generator[None]:
        """Print a line after `FIRST_LINE` seconds and then every `REMINDER` seconds."""
        start = time.monotonic()
        with self._repeat(lambda: remark(f"{self}, {time.monotonic() - start:.0f} s"), FIRST_LINE, REMINDER):
            yield

    @contextmanager
    def _repeat(self, call: Callable[[], None], first: float, period: float) -> Generator[None]:
        """Call a function in a thread, after `first` seconds and then with a period."""
        end = Event()

        def repeat() -> None:
            wait = first
            while not end.wait(wait):
                call()
                wait = period

        thread = Thread(target=repeat, name="progress", daemon=True)
        thread.start()
        try:
            yield
        finally:
            end.set()
            thread.join()


@contextmanager
def progress(name: str, phase: str, total: float | None = None, *, is_count: bool = False) -> Generator[Progress]:
    """Show progress on standard error: a bar on a terminal, elsewhere lines, see `Progress.in_lines`.

    Args:
        name: Name of the task.
        phase: What is done first, such as "running stops".
        total: Total amount; None if unknown.
        is_count: Whether the total is a number of items, not a share.
    """
    shown = Progress(name, phase, total, is_count)
    with nullcontext() if _is_quiet() else shown.on_terminal() if _err.is_terminal else shown.in_lines():
        yield shown
