"""Other programs, found in the absolute folders of PATH alone: a folder that somebody sent must not bring programs."""

import os
import shutil
from pathlib import Path


def find_program(name: str) -> str | None:
    """Return the absolute path of a program, or None if there is none.

    Args:
        name: Searched in the folders of PATH, relative ones such as "." and "" left out; a path, as a user may give it
            in CC, is taken as it is.
    """
    found = shutil.which(name, path=_path())
    if found is None:
        return None
    is_path = Path(name).name != name
    return str(Path(found).absolute()) if is_path or Path(found).is_absolute() else None


def environment_of_programs() -> dict[str, str]:
    """Return the variables for another program, which searches PATH for further ones; relative folders are left out."""
    return {**os.environ, "PATH": _path()}


def _path() -> str:
    folders = os.environ.get("PATH", os.defpath).split(os.pathsep)
    return os.pathsep.join(folder for folder in folders if Path(folder).is_absolute())
