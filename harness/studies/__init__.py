"""Studies: programmes of one paper each, from the cases that they run to a page and headline numbers.

Each module here but `study`, and each package, is a study: `railgrip study NAME` runs it. The first line of its
docstring describes it; it, or the module `study` of a package, has the class as `STUDY`. Only the command line imports
studies, and no stop is run again when one of them changes.
"""

from pkgutil import iter_modules

from railgrip.base import registry

_STUDIES = {module.name: module.ispkg for module in iter_modules(__path__) if module.name != "study"}


def names() -> list[str]:
    """Return the names of all studies."""
    return list(_STUDIES)


def summary(name: str) -> str:
    """Return a description of a study in one line."""
    return registry.summary(__name__, name)


def module_of(name: str) -> str:
    """Return the full name of the module with the class of a study."""
    return f"{__name__}.{name}.study" if _STUDIES[name] else f"{__name__}.{name}"
