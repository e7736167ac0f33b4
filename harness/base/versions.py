"""Versions of the software, besides this program, that a result depends on."""

import platform
import re
from functools import cache
from importlib.metadata import requires, version
from typing import Final

_PRESENTATION: Final = frozenset(
    {"jinja2", "markdown-it-py", "matplotlib", "pebble", "pillow", "platformdirs", "plotly", "rich", "typer"}
)
"""Required packages that draw, write or organise, and do not affect numbers."""


@cache
def versions() -> dict[str, str]:
    """Return the versions of Python, of its machine and C library, and of all packages that may affect numbers."""
    names = [re.split(r"[^\w.-]", entry, maxsplit=1)[0] for entry in requires("railgrip") or () if "extra" not in entry]
    packages = {name: version(name) for name in ("railgrip", *names) if name not in _PRESENTATION}
    machine = " ".join(filter(None, (platform.system(), platform.machine(), *platform.libc_ver())))
    return {"python": platform.python_version(), "machine": machine} | packages
