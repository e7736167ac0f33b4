"""Studies: programmes of one paper each, from the cases that they run to a page and headline numbers.

Each folder here is a study: `railgrip study NAME` runs it. The first line of its docstring says what it is, and its
module `study` has the class, `STUDY`. Only the command line knows studies, and an edit here runs no stop again.
"""

from importlib import import_module
from pkgutil import iter_modules


def names() -> list[str]:
    """Return the names of all studies."""
    return [one.name for one in iter_modules(__path__) if one.ispkg]


def summary(name: str) -> str:
    """Return what a study is, in a line."""
    return (import_module(f"{__name__}.{name}").__doc__ or "").partition("\n")[0]
