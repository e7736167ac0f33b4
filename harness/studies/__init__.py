"""Studies: programmes of one paper each, from the cases that they run to a page and headline numbers.

Each module here but `study`, and each package, is a study: `railgrip study NAME` runs it. The first line of its
docstring describes it; it, or the module `study` of a package, has the class as `STUDY`. Only the command line imports
studies, and no stop is run again when one of them changes.
"""

import ast
from importlib.util import find_spec
from pathlib import Path
from pkgutil import iter_modules

_STUDIES = {one.name: one.ispkg for one in iter_modules(__path__) if one.name != "study"}


def names() -> list[str]:
    """Return the names of all studies."""
    return list(_STUDIES)


def summary(name: str) -> str:
    """Return a description of a study in one line."""
    # Read, not imported: a module of a study takes seconds to import.
    spec = find_spec(f"{__name__}.{name}")
    source = Path(spec.origin).read_text(encoding="utf-8") if spec is not None and spec.origin else ""
    return (ast.get_docstring(ast.parse(source)) or "").partition("\n")[0]


def module_of(name: str) -> str:
    """Return the full name of the module with the class of a study."""
    return f"{__name__}.{name}.study" if _STUDIES[name] else f"{__name__}.{name}"
