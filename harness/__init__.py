"""The open bench for railway braking at low adhesion.

import railgrip as rg

stop = rg.run(rg.Scenario.load("trapezoid"))
stop.metrics.distance
"""

from importlib import import_module
from importlib.metadata import version
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from railgrip import api, testing
    from railgrip.api import *  # noqa: F403 - the names are listed there

    __version__: str
    __all__ = ["__version__", "testing"]
    __all__ += api.__all__


def __getattr__(name: str) -> Any:
    """Import a name when it is used: a command line that only prints its help must not wait for pydantic (PEP 562)."""
    if name == "__version__":
        return version("railgrip")
    if name == "testing":
        return import_module("railgrip.testing")
    if name == "__all__":
        return ["__version__", "testing", *import_module("railgrip.api").__all__]
    names = [] if name.startswith("_") else __getattr__("__all__")
    if name in names:
        return getattr(import_module("railgrip.api"), name)
    raise AttributeError(f"module 'railgrip' has no attribute '{name}'; it has {', '.join(names)}")


def __dir__() -> list[str]:
    return sorted({*globals(), *__getattr__("__all__")})
