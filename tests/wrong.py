"""Tables of inputs, in files next to their tests, with words of the sentences that refuse them, or other results."""

import re
import tomllib
from pathlib import Path
from typing import Any


def table(test: str, name: str) -> dict[str, Any]:
    """Return the content of a file in the folder of a test."""
    return tomllib.loads(Path(test).with_name(name).read_text(encoding="utf-8"))


def words(sentence: str) -> str:
    """Return the pattern of a sentence in which "…" is any text."""
    return f"(?s:{'.*'.join(map(re.escape, sentence.split('…')))})"


REMOVED = "<none>"


def change(tables: Any, path: str, value: Any) -> None:
    """Set a key of nested tables and lists, as "cars.0.mass"; `REMOVED` removes it."""
    *above, last = (int(step) if step.isdigit() else step for step in path.split("."))
    for step in above:
        tables = tables[step]
    if value == REMOVED:
        del tables[last]
    else:
        tables[last] = value
