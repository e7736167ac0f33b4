"""Folders for results: railgrip replaces and removes only files that it has written.

Each such folder has a record of the files that railgrip has written into it. A file that is not in the record belongs
to the user, whatever its name.
"""

import os
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path
from typing import Final

from railgrip.base.errors import RecordError
from railgrip.base.files import remove, write_json
from railgrip.base.records import LARGEST_JSON, inside, read_bounded, read_json, read_json_value

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
        raise RecordError(f"{directory}: results cannot be written there: no permission; name another folder by --out")
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
