"""Tables of inputs, in files next to their tests, with words of the sentences that refuse them, or other results."""

import re
import tomllib
from collections.abc import Callable, Iterator
from functools import reduce
from operator import getitem
from pathlib import Path
from typing import Any

from hypothesis import strategies as st

from railgrip.base.errors import RailgripError


def table(test: str, name: str) -> dict[str, Any]:
    """Return the content of a file in the folder of a test."""
    return tomllib.loads(Path(test).with_name(name).read_text(encoding="utf-8"))


def words(sentence: str) -> str:
    """Return the pattern of a sentence in which "…" is any text."""
    return f"(?s:{'.*'.join(map(re.escape, sentence.split('…')))})"


def answered(
    question: Callable[[], object], error: type[Exception] = RailgripError, longest: int = 2000, words: str = ""
) -> None:
    """Call a function that returns or refuses in sentences with these words; other exceptions fail the test.

    Lines of the sentences are shorter than `longest`.
    """
    sentences = words or "an answer"
    try:
        question()
    except error as refusal:
        sentences = str(refusal)
    assert sentences
    assert words in sentences
    assert all(len(line) < longest for line in sentences.splitlines())


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


def places(value: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Yield every place in nested tables and lists."""
    inner = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, element in inner:
        yield (*path, key)
        yield from places(element, (*path, key))


def mutate(tables: Any, draw: Callable[[st.SearchStrategy[Any]], Any], values: st.SearchStrategy[Any]) -> None:
    """Give one place another value, remove it, or rename it."""
    *above, last = draw(st.sampled_from(sorted(places(tables), key=repr)))
    holder = reduce(getitem, above, tables)
    match draw(st.sampled_from(["value", "value", "value", "value", "gone", "renamed"])):
        case "value":
            holder[last] = draw(values)
        case "renamed" if isinstance(holder, dict):
            holder[draw(st.text(max_size=10))] = holder.pop(last)
        case _:
            del holder[last]
