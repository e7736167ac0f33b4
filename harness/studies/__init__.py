"""Studies: the cases, page and headline numbers of one subject each.

Each module here except `study`, and each package, is a study: `railgrip study NAME` runs it. The first line of its
docstring describes it; the module, or the module of a package whose name ends with _study, has the class as `STUDY`.
Only the command line imports studies, and a change of a study does not cause a stop to be run again.
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
    return f"{__name__}.{name}.{name}_study" if _STUDIES[name] else f"{__name__}.{name}"
