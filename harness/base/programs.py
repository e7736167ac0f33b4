"""Find other programs in the absolute folders of PATH only, so that a downloaded folder cannot supply programs."""

import os
import shutil
from pathlib import Path


def find_program(name: str) -> str | None:
    """Return the absolute path of a program, or None.

    Args:
        name: Name to search in the folders of PATH, without relative ones such as "." and ""; a path, as a user may set
            in CC, is used unchanged.
    """
    found = shutil.which(name, path=_path())
    if found is None:
        return None
    is_path = Path(name).name != name
    return str(Path(found).absolute()) if is_path or Path(found).is_absolute() else None


def environment_of_programs() -> dict[str, str]:
    """Return the environment for another program, which may search PATH in turn; relative folders are removed."""
    return {**os.environ, "PATH": _path()}


def _path() -> str:
    folders = os.environ.get("PATH", os.defpath).split(os.pathsep)
    return os.pathsep.join(folder for folder in folders if Path(folder).is_absolute())
