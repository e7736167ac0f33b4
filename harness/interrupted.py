"""Ctrl-C: a sentence and an exit code, never a traceback and never silence (which typer would make of it)."""

from collections.abc import Callable, Generator
from contextlib import contextmanager

import typer
from rich.console import Console

INTERRUPTED = 130


@contextmanager
def sentence_when_interrupted(console: Console) -> Generator[None]:
    """End with exit code 130 and say that results, each written whole or not at all, are kept."""
    try:
        yield
    except KeyboardInterrupt:
        console.print("Interrupted; what had finished is kept.", highlight=False)
        raise typer.Exit(INTERRUPTED) from None


@contextmanager
def status(console: Console, what: str) -> Generator[Callable[[str], None]]:
    """Show what is being done, `what: step`; yields what tells the step."""
    with sentence_when_interrupted(console), console.status(what) as shown:
        yield lambda step: shown.update(f"{what}: {step}")
