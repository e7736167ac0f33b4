"""The state of this program's own text, so that a result of yesterday's controller is not taken for today's."""

import hashlib
from functools import cache
from pathlib import Path

import controllers
import estimators
import fmus
import harness

_KINDS = {".py", ".c", ".h", ".mo", ".toml", ".jinja"}
_UNCONCERNED = (
    "harness/verdict/",
    "harness/scenario/library/",
    "harness/scenario/campaigns/",
    "harness/scenario/edges/",
    "fmus/lock.toml",
)
"""They read results, or are the question itself (the scenario's digest is their own), or follow from the rest."""


@cache
def sources_digest() -> str:
    """Return a SHA-256 of every source that a stop depends on: the rooms' code and the Modelica library."""
    roots = [Path(room.__file__ or "").parent for room in (controllers, estimators, fmus, harness)]
    modelica = Path(fmus.__file__ or "").parent.parent / "modelica"
    digest = hashlib.sha256()
    for root in (*roots, modelica):
        for path in sorted(found for found in root.rglob("*") if found.suffix in _KINDS):
            name = f"{root.name}/{path.relative_to(root).as_posix()}"
            if not name.startswith(_UNCONCERNED):
                digest.update(name.encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest()
