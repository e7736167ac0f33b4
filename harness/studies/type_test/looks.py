"""How often the results of a set of cases were looked at, counted in the user's cache."""

import json
from collections.abc import Iterable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Final

from railgrip.base import cache
from railgrip.base.errors import RecordError
from railgrip.base.files import write_json
from railgrip.report.table import ReportTable

_FILE: Final = Path("type_test") / "looks.json"


def count_look(case_set: str, digests: Iterable[str]) -> Mapping[str, Mapping[str, int]]:
    """Count one look at the results of controllers in a set; return set → digest of a controller → number of looks.

    The file has no dates: it is the same for the same looks.

    Raises:
        RecordError: The file cannot be written.
    """
    path = cache.folder() / _FILE
    counts = _counts(path)
    of_set = counts.setdefault(case_set, {})
    for digest in digests:
        of_set[digest] = of_set.get(digest, 0) + 1
    path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
    write_json(path, counts)
    return counts


def _counts(path: Path) -> dict[str, dict[str, int]]:
    """Return the counts in a file; none if it does not exist.

    Raises:
        RecordError: The file is damaged, so that earlier looks would be lost.
    """
    with suppress(FileNotFoundError):
        try:
            return json.loads(path.read_text(encoding="utf-8"))
        except ValueError as problem:
            raise RecordError(f"{path}: is not a count of looks; move it away to begin a new one") from problem
    return {}


def table_of_looks(counts: Mapping[str, Mapping[str, int]], case_set: str) -> ReportTable:
    """Return the number of looks at each set and the maximum of one controller; the present set comes first."""
    rows = [
        {
            "set": name,
            "looks": sum(counts[name].values()),
            "controllers": len(counts[name]),
            "maximum of one controller": max(counts[name].values()),
        }
        for name in sorted(counts, key=lambda name: (name != case_set, name))
    ]
    return ReportTable(rows, left=("set",))
