"""Other programs, found in the absolute folders of PATH only, versions that a result depends on, and limits."""

import os
import platform
import re
import shutil
from collections.abc import Mapping
from contextlib import suppress
from functools import cache
from importlib.metadata import requires, version
from pathlib import Path
from typing import Final


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


_PRESENTATION: Final = frozenset(
    {"jinja2", "markdown-it-py", "matplotlib", "pebble", "pillow", "platformdirs", "rich", "typer"}
)
"""Required packages that draw, write or organise, and do not affect numbers."""


def requirements(extra: str = "") -> dict[str, str]:
    """Return the packages that railgrip requires, or those that an extra adds, as name → name and versions.

    Without an extra the C compiler of Windows is left out, as are all that have a marker.
    """
    entries = (entry.partition(";") for entry in requires("railgrip") or ())
    chosen = (package.strip() for package, _, marker in entries if (extra in marker if extra else not marker))
    return {re.split(r"[^\w.-]", package, maxsplit=1)[0]: package for package in chosen}


def installation(extra: str) -> str:
    """Return the command that installs the packages of an extra, wherever railgrip itself was installed from."""
    return f"`python -m pip install {' '.join(map(repr, requirements(extra).values()))}`"


@cache
def versions() -> dict[str, str]:
    """Return the versions of Python, of its machine and C library, and of all packages that may affect numbers.

    The version of the C compiler is that of `_compilers` in railgrip.campaign.run.
    """
    packages = {name: version(name) for name in ("railgrip", *requirements()) if name not in _PRESENTATION}
    machine = " ".join(filter(None, (platform.system(), platform.machine(), *platform.libc_ver())))
    return {"python": platform.python_version(), "machine": machine} | packages


def limit_resources(limits: Mapping[str, int]) -> None:
    """Limit this process by the names of limits in the module `resource`; limits that the system lacks are omitted."""
    if os.name != "posix":
        return
    import resource

    for name, limit in limits.items():
        with suppress(AttributeError, ValueError, OSError):  # macOS cannot limit the address space
            what = getattr(resource, name)
            _, maximum = resource.getrlimit(what)
            value = limit if maximum == resource.RLIM_INFINITY else min(limit, maximum)
            resource.setrlimit(what, (value, value))
