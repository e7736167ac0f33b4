"""Evaluate a function of a user in many cases, and return or read the results as one table."""

import sys
from collections.abc import Callable, Iterable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

import pandas

from railgrip.base.errors import InputError
from railgrip.base.files import write_text
from railgrip.campaign.work import call, work

Rows = Mapping[str, Any] | Iterable[Mapping[str, Any]]
"""Results of a case: a row, or several."""


def evaluate(
    function: Callable[..., Rows], cases: Iterable[Mapping[str, Any]], file: Path | None, workers: int
) -> pandas.DataFrame:
    """Return case and results in a row; see `railgrip.evaluate`."""
    asked = [dict(case) for case in cases]
    if not asked:
        raise InputError("evaluate: there are no cases; give one mapping of arguments or more")
    if file is not None and file.exists():
        stored = _read(file)
        of_cases = stored[[name for name in asked[0] if name in stored]]
        if _csv(pandas.DataFrame(of_cases).drop_duplicates()) == _csv(pandas.DataFrame(asked).drop_duplicates()):
            return stored
    source = getattr(sys.modules[function.__module__], "__file__", None)
    is_importable = source is not None and function.__module__ != "__main__"
    with work(Path(str(source)) if is_importable else function.__name__, workers=max(workers, 1)) as job:
        tasks = [partial(function, **case) for case in asked]
        results = job.map(call, tasks) if is_importable and workers else job.measure_times(call, tasks)
    frame = pandas.DataFrame(
        [
            case | dict(row)
            for case, found in zip(asked, results, strict=True)
            for row in ([found] if isinstance(found, Mapping) else found)
        ]
    )
    if file is None:
        return frame
    write_text(file, _csv(frame))
    return _read(file)


def _read(file: Path) -> pandas.DataFrame:
    return pandas.read_csv(file, engine="python", keep_default_na=False, na_values=[""])


def _csv(frame: pandas.DataFrame) -> str:
    return frame.to_csv(index=False, lineterminator="\n")
