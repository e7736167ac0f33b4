"""Files of results: read from any folder within limits, and replaced only where railgrip has written them.

Files are read with limits on size and depth, and never outside of their folder. Each folder of results has a record of
the files that railgrip has written into it. A file that is not in the record belongs to the user, whatever its name.
"""

import json
import os
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path
from typing import Any, Final, NoReturn, cast

from pydantic import ValidationError

from railgrip.base.errors import InputError, RecordError, for_user
from railgrip.base.files import read_bytes, remove, write_json
from railgrip.base.tables import JsonObject

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


def read_json(folder: Path, name: str) -> JsonObject:
    """Return the table in a JSON file below a folder; see `read_json_value`.

    Raises:
        FileNotFoundError: The file does not exist.
        RecordError: The content is not a table in JSON.
    """
    table = read_json_value(folder, name)
    if not isinstance(table, dict):
        raise RecordError(f"{folder / name}: a table in JSON is expected, found {type(table).__name__}")
    return cast("JsonObject", table)


def read_json_value(folder: Path, name: str) -> Any:
    """Return the value in a JSON file below a folder.

    Raises:
        FileNotFoundError: The file does not exist.
        RecordError: See `read_bounded`; or the content is not JSON (RFC 8259), or nested too deeply.
    """
    return parse_json(folder / name, read_bounded(folder, name, LARGEST_JSON))


def parse_json(path: Path, content: bytes) -> JsonObject:
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
            for key, element in cast("JsonObject", value).items():
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


RECORD: Final = ".railgrip.json"
"""File in each folder of results, with the names of the files that railgrip has written into the folder."""

_KEY: Final = "written"


def make_folder(directory: Path, *files: str) -> None:
    """Create a folder for results, before a long computation starts.

    Raises:
        RecordError: The folder cannot be created or written, or one of the files exists as a folder.
    """
    try:
        directory.mkdir(parents=True, exist_ok=True)
    except OSError as problem:
        raise RecordError(
            f"{directory}: results cannot be written there: {problem.strerror}; name another folder by --out"
        ) from problem
    if not os.access(directory, os.W_OK):
        raise RecordError(
            f"{directory}: results cannot be written there: no permission; make the folder writable, or name another"
        )
    _refuse_folders(directory, files)


def require_free(directory: Path, *files: str) -> None:
    """Check that railgrip may write these files into a folder, which need not exist.

    Raises:
        RecordError: Folders, or files that railgrip has not written, have these names, or a path leads out of the
            folder.
    """
    _refuse_folders(directory, files)
    present = [name for name in files if os.path.lexists(inside(directory, name))]
    _refuse(directory, [name for name in present if not _is_own(directory, name)])


def require_own(directory: Path) -> None:
    """Check that all files directly in a folder, which need not exist, were written by railgrip.

    Raises:
        RecordError: The folder has other files, which a page and its files might replace.
    """
    present = [path.name for path in directory.glob("*") if not path.name.startswith(".") and not path.is_dir()]
    _refuse(directory, [name for name in sorted(present) if not _is_own(directory, name)])


def claim(directory: Path, *files: str) -> None:
    """Create a folder and record that railgrip writes these files into it; called before they are written.

    Raises:
        RecordError: See `make_folder` and `require_free`.
        WriteFailed: The record cannot be written.
    """
    require_free(directory, *files)
    make_folder(directory, *files)
    recorded = _read_record(directory)
    if recorded is None or not recorded.issuperset(files):
        _record(directory, (*(recorded or ()), *files))


def adopt(directory: Path, *files: str) -> None:
    """Record files with names that railgrip uses: release 0.1.0 wrote them without a record.

    Raises:
        WriteFailed: The record cannot be written.
    """
    present = [name for name in files if (directory / name).is_file()]
    if present and _read_record(directory) is None:
        _record(directory, present)


def discard(directory: Path, files: Iterable[str]) -> None:
    """Remove those of the files from a folder that railgrip has written.

    Raises:
        WriteFailed: The folder is not writable.
    """
    own = {name for name in files if os.path.lexists(inside(directory, name)) and _is_own(directory, name)}
    if own:
        remove(directory, *own)
        if (recorded := _read_record(directory)) is not None:
            _record(directory, recorded - own)


def recorded_files(directory: Path) -> frozenset[str]:
    """Return the names of the files that railgrip has recorded in a folder."""
    return _read_record(directory) or frozenset()


def _record(directory: Path, names: Iterable[str]) -> None:
    write_json(directory / RECORD, {_KEY: sorted(set(names))})


def _read_record(directory: Path) -> frozenset[str] | None:
    try:
        names = read_json(directory, RECORD).get(_KEY)
    except (FileNotFoundError, RecordError):
        return None
    return frozenset(name for name in names if isinstance(name, str)) if isinstance(names, list) else None


def _is_own(directory: Path, name: str) -> bool:
    recorded = _read_record(directory)
    if recorded is not None:
        return name in recorded
    # Release 0.1.0 wrote no records: its results are identified by their content.
    with suppress(FileNotFoundError, RecordError):
        page = read_bounded(directory, "index.html", LARGEST_JSON)
        if b'<p class="question">' in page and b"<h2>Provenance</h2>" in page:
            return True
    with suppress(FileNotFoundError, RecordError):
        figures = read_json_value(directory, name) if name == "figures.json" else None
        if isinstance(figures, list) and all(
            isinstance(figure, dict) and {"name", "value", "unit"} <= figure.keys() for figure in figures
        ):
            return True
    is_page = Path(name).suffix in (".html", ".png", ".svg", ".pdf") and not name.startswith("figures/")
    marks = {"stop.json": {"scenario_digest", "sha256"}, "campaign.json": {"name", "description", "stops"}}
    for file, keys in marks.items():
        with suppress(FileNotFoundError, RecordError):
            if not is_page and keys <= read_json(directory, file).keys():
                return True
    return False


def _refuse_folders(directory: Path, files: Iterable[str]) -> None:
    obstacle = next((directory / name for name in files if (directory / name).is_dir()), None)
    if obstacle is not None:
        raise RecordError(
            f"{obstacle}: a file is to be written there, and it is a folder; move it or name another --out"
        )


def _refuse(directory: Path, names: list[str]) -> None:
    if names:
        more = f" and {len(names) - 3} more" if len(names) > 3 else ""
        raise RecordError(
            f"{directory}: contains files that railgrip has not written ({', '.join(names[:3])}{more}) in the place of "
            "its results; move them, or name another folder by --out"
        )
