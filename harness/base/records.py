"""Read files in a folder from any source: with limits on size and depth, and never outside the folder."""

import json
from pathlib import Path
from typing import Any, Final, NoReturn, cast

from pydantic import ValidationError

from railgrip.base.errors import InputError, RecordError, for_user
from railgrip.base.files import read_bytes

LARGEST_JSON: Final = 64 << 20
"""Bytes; the description of a campaign of 100,000 stops has half of that."""
LARGEST_TRACE: Final = 2 << 30
"""Bytes, in the file and unpacked; a trace of an hour in steps of 1 ms has a tenth of that."""
_DEEPEST: Final = 50
"""Maximum depth of nested tables and lists; a scenario has eight levels."""


def inside(folder: Path, name: str) -> Path:
    """Return the path of a file or folder below `folder`, which need not exist.

    Raises:
        RecordError: The path, with its links resolved, leads out of the folder.
    """
    path = folder / name
    try:
        is_below = path.resolve().is_relative_to(folder.resolve())
    except RuntimeError as problem:
        raise RecordError(f"{path}: is a link that leads to itself; remove it") from problem
    except (OSError, ValueError) as problem:  # too long, or a null character
        if isinstance(problem, OSError) and (sentence := for_user(problem)) is not None:
            raise RecordError(str(sentence)) from problem
        raise RecordError(f"{folder}: '{name}' is not a path: {problem}") from problem
    if not is_below:
        raise RecordError(f"{path}: leads out of the folder {folder}; remove the link, or copy what it points to")
    return path


def read_bounded(folder: Path, name: str, largest: int) -> bytes:
    """Return the content of a regular file below a folder.

    Raises:
        FileNotFoundError: The file does not exist.
        RecordError: The file is outside the folder, not a regular file, larger than `largest` bytes or unreadable.
    """
    path = inside(folder, name)
    try:
        return read_bytes(path, largest)
    except InputError as problem:
        if isinstance(problem.__cause__, FileNotFoundError | NotADirectoryError):
            raise FileNotFoundError(str(path)) from problem
        raise RecordError(str(problem)) from problem


def read_json(folder: Path, name: str) -> dict[str, Any]:
    """Return the table in a JSON file below a folder; see `read_json_value`.

    Raises:
        FileNotFoundError: The file does not exist.
        RecordError: The content is not a table in JSON.
    """
    table = read_json_value(folder, name)
    if not isinstance(table, dict):
        raise RecordError(f"{folder / name}: a table in JSON is expected, found {type(table).__name__}")
    return cast("dict[str, Any]", table)


def read_json_value(folder: Path, name: str) -> Any:
    """Return the value in a JSON file below a folder.

    Raises:
        FileNotFoundError: The file does not exist.
        RecordError: See `read_bounded`; or the content is not JSON (RFC 8259), or nested too deeply.
    """
    return parse_json(folder / name, read_bounded(folder, name, LARGEST_JSON))


def parse_json(path: Path, content: bytes) -> dict[str, Any]:
    """Return the table in the content of a JSON file.

    Raises:
        RecordError: The content is not a table in JSON (RFC 8259), or nested too deeply.
    """
    try:
        table = json.loads(content.decode(), parse_constant=_refuse_constant)
        _require_plain(table, _DEEPEST)
    except (ValueError, RecursionError) as problem:
        words = "it is nested too deeply" if isinstance(problem, RecursionError) else str(problem)
        raise RecordError(f"{path}: is not JSON that railgrip has written ({words})") from problem
    return table


def words_of(problem: ValidationError) -> str:
    """Return the first problems of a record, each with its key."""
    errors = problem.errors(include_url=False, include_context=False, include_input=False)
    words = [f"{'.'.join(map(str, error['loc'])) or 'all'}: {error['msg']}"[:200] for error in errors[:3]]
    return "; ".join(words) + (f"; and {len(errors) - 3} more" if len(errors) > 3 else "")


def _refuse_constant(name: str) -> NoReturn:
    raise ValueError(f"JSON has no number {name}")


def _require_plain(value: Any, levels: int) -> None:
    match value:
        case dict() | list() if not levels:
            raise RecursionError
        case dict():
            for key, element in cast("dict[str, Any]", value).items():
                key.encode()
                _require_plain(element, levels - 1)
        case list():
            for element in cast("list[Any]", value):
                _require_plain(element, levels - 1)
        case str():
            value.encode()
        case float() if value in (float("inf"), float("-inf")):
            raise ValueError("a number is too large")
        case int() if abs(value) >= 2**64:
            raise ValueError("a number is too large")
        case _:
            pass
