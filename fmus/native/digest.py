"""Digests over everything that a result depends on: texts, the built-in compiler, the packages that it uses."""

import hashlib
from collections.abc import Iterable
from functools import lru_cache
from importlib.metadata import version
from pathlib import Path

from railgrip.base import units


def digest(parts: Iterable[str]) -> str:
    """Return the SHA-256 of texts, each followed by a zero byte."""
    out = hashlib.sha256()
    for part in parts:
        out.update(part.encode() + b"\0")
    return out.hexdigest()


@lru_cache(maxsize=1)
def compiler_digest() -> str:
    """Return a digest over the source of the built-in compiler and the versions of packages that it uses."""
    here = Path(__file__).parent
    files = sorted(file for file in here.rglob("*") if file.suffix in (".py", ".c", ".h", ".toml", ".jinja"))
    files += [Path(units.__file__), units.DEFINITIONS]
    packages = [version(name) for name in ("rumoca", "casadi", "numpy", "scipy")]
    return digest([*packages, *(file.read_text(encoding="utf-8") for file in files)])
