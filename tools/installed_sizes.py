"""Sizes of the packages that an installation of railgrip consists of, and what each is for."""

import sys
from collections.abc import Iterator, Mapping
from functools import cache
from importlib import metadata
from pathlib import Path
from typing import Final

from packaging.requirements import Requirement

from railgrip.base.errors import InputError
from railgrip.report.table import ReportTable

_SMALL: Final = 10e6  # bytes
_USES: Final = {
    "casadi": "derivatives of filters, C code of predictions, the ideal bound",
    "scipy": "filters, searches, statistics",
    "cmake": "nothing that railgrip does; FMPy compiles FMUs from sources with it",
    "numpy": "arrays",
    "rumoca": "the front end of the built-in Modelica compiler",
    "pandas": "tables of campaigns and sweeps, recordings",
    "matplotlib": "figures",
    "pillow": "figures",
    "fonttools": "fonts in figures",
    "fmpy": "FMUs, and CVODE for Model Exchange",
    "lxml": "descriptions of FMUs",
    "h5py": "files of traces and estimates",
}
"""Uses of large packages."""
EXTRAS: Final = {
    "compiler": "a C compiler where there is none, and `--platforms` of `railgrip export`",
    "parquet": "recordings and tables in Parquet",
    "mf4": "recordings of vehicle loggers, mf4 and mdf",
    "cluster": "stops on the workers of a Dask cluster",
}
"""Uses of the extras of railgrip."""


@cache
def _distribution(name: str) -> metadata.Distribution:
    # Development has Dask next to the environment.
    path = [*sys.path, str(Path(sys.prefix) / "cluster")]
    found = next(iter(metadata.distributions(name=name, path=path)), None)
    if found is None:
        raise InputError(f"{name}: is not installed; `make install` installs railgrip with all its extras.")
    return found


def _requirements(name: str, extra: str = "") -> Iterator[Requirement]:
    for entry in _distribution(name).requires or ():
        requirement = Requirement(entry)
        if requirement.marker is None or requirement.marker.evaluate({"extra": extra}):
            yield requirement


def required_packages(extra: str = "") -> Mapping[str, str]:
    """Return the packages that railgrip requires with an extra, directly or not, and which package requires each."""
    found: dict[str, str] = {}
    pending = [(requirement, "railgrip") for requirement in _requirements("railgrip", extra)]
    for requirement, by in pending:  # which grows
        name = requirement.name.lower().replace("_", "-")
        if name not in found:
            found[name] = by
            pending += [(one, name) for part in ("", *requirement.extras) for one in _requirements(name, part)]
    return found


def _size(name: str) -> int:
    """Return the size of a package's files [bytes], without bytecode, which Python writes when it imports them."""
    files = [Path(str(file.locate())) for file in _distribution(name).files or () if file.suffix != ".pyc"]
    return sum(file.stat().st_size for file in files if file.is_file())


def sizes_table() -> ReportTable:
    """Return the sizes of an installation: packages from 10 MB on, all others, their sum, and what each extra adds."""
    base = required_packages()
    sizes = {name: _size(name) for name in base}
    large = sorted((name for name in base if sizes[name] >= _SMALL), key=lambda name: -sizes[name])
    if unknown := [name for name in large if name not in _USES]:
        raise InputError(f"{', '.join(unknown)}: state in tools/installed_sizes.py what railgrip uses it for.")
    others = sum(sizes.values()) - sum(sizes[name] for name in large)
    rows = [(name, sizes[name], base[name], _USES[name]) for name in large]
    rows.append((f"{len(base) - len(large)} others", others, "", ""))
    rows.append((f"all {len(base)}", sum(sizes.values()), "", ""))
    for extra, use in EXTRAS.items():
        added = sum(_size(name) for name in required_packages(extra) if name not in base)
        rows.append((f"extra `{extra}`", added, "", use))
    columns = ("package", "size", "required by", "for")
    return ReportTable.of(columns, [(name, f"{size / 1e6:.0f} MB", *rest) for name, size, *rest in rows], left=4)
