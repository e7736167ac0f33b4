"""All inputs of a result besides its scenario, so that results of another version of the program are not reused."""

import hashlib
from functools import cache
from importlib import import_module
from pathlib import Path

from railgrip.base.errors import CompilerMissing
from railgrip.base.programs import versions
from railgrip.fmus import openmodelica
from railgrip.fmus.build import choose
from railgrip.fmus.native.toolchain import compiler
from railgrip.fmus.recipe import MODELICA

SOURCES = "sources"
"""Key of the digest of this program's source in the versions of a result."""

_PACKAGES = ("railgrip", "railgrip.controllers", "railgrip.estimators", "railgrip.fmus")
_KINDS = {".py", ".c", ".h", ".mo", ".toml", ".txt", ".jinja"}
_UNCONCERNED = ("railgrip/cli/", "railgrip/report/", "railgrip/studies/", "railgrip.fmus/lock.toml")
"""Files that read results or produce other ones, or that follow from the rest."""
_QUESTIONS = ("railgrip/scenario/library/", "railgrip/scenario/campaigns/", "railgrip/scenario/equipment/")
"""Files that define stops; the digest of the scenario covers them."""


@cache
def sources_digest(study: str | None = None) -> str:
    """Return a SHA-256 of every source that a stop depends on: the package's code and the Modelica library.

    With the name of a study, also of its module or folder and of all scenario files, on which the study's results
    depend.
    """
    roots = {name: Path(import_module(name).__path__[0]) for name in _PACKAGES} | {"modelica": MODELICA}
    digest = hashlib.sha256()
    for name, root in roots.items():
        for path in sorted(file for file in root.rglob("*") if file.suffix in _KINDS):
            # In an installation, the other packages are inside the package's folder.
            if any(
                path.is_relative_to(other) for other in roots.values() if other != root and other.is_relative_to(root)
            ):
                continue
            place = f"{name}/{path.relative_to(root).as_posix()}"
            is_of_study = study is not None and place.startswith(
                (f"railgrip/studies/{study}/", f"railgrip/studies/{study}.")
            )
            if is_of_study or not place.startswith(_UNCONCERNED if study else (*_UNCONCERNED, *_QUESTIONS)):
                digest.update(place.encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest()


def input_versions(study: str | None = None) -> dict[str, str]:
    """Return name → version of all inputs of a result besides its scenario.

    These are the sources, by their digest as `SOURCES`, Python, packages, machine, and the compilers of C and FMUs.

    Args:
        study: As for `sources_digest`.
    """
    return {SOURCES: sources_digest(study), **versions(), **_compilers()}


@cache
def _compilers() -> dict[str, str]:
    try:
        c_compiler = compiler().version
    except CompilerMissing:
        c_compiler = "none"
    fmu_compiler = openmodelica.version_line() if choose("auto") == "openmodelica" else "built-in"
    return {"C compiler": c_compiler, "FMU compiler": fmu_compiler}
