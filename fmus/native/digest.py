"""What a result was made from, as one number: texts, the built-in compiler, the packages it rests on."""

import hashlib
from collections.abc import Iterable
from functools import lru_cache
from importlib.metadata import version
from pathlib import Path

from railgrip.base import units


def digest(parts: Iterable[str]) -> str:
    """Return the SHA-256 of texts and of where each ends."""
    out = hashlib.sha256()
    for part in parts:
        out.update(part.encode() + b"\0")
    return out.hexdigest()


@lru_cache(maxsize=1)
def compiler_digest() -> str:
    """Return a digest over the built-in compiler itself and the packages it rests on."""
    here = Path(__file__).parent
    files = sorted(file for file in here.rglob("*") if file.suffix in (".py", ".c", ".h", ".toml", ".jinja"))
    files += [Path(units.__file__), units.DEFINITIONS]
    packages = [version(name) for name in ("rumoca", "casadi", "numpy", "scipy")]
    return digest([*packages, *(file.read_text(encoding="utf-8") for file in files)])
