"""What MkDocs runs when it starts."""

import shutil
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[1]
COPY = ROOT / "build" / "docs" / "railgrip"


def on_startup(**_: Any) -> None:
    """Copy the packages under the names by which they are imported, where mkdocstrings reads them.

    mkdocstrings drops search paths that do not exist when it is configured, so that docs/generate.py would be too late.
    """
    shutil.rmtree(COPY, ignore_errors=True)
    only_python = shutil.ignore_patterns("__pycache__", "library", "kernel")
    shutil.copytree(ROOT / "harness", COPY, ignore=only_python)
    for package in ("controllers", "estimators", "fmus"):
        shutil.copytree(ROOT / package, COPY / package, ignore=only_python)
