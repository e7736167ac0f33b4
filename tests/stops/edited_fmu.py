"""FMUs with another description."""

import zipfile
from collections.abc import Callable
from functools import reduce
from pathlib import Path


def with_description(source: Path, file: Path, change: Callable[[str], str]) -> Path:
    """Write a copy of an FMU whose modelDescription.xml is changed by a function, and return it."""
    with zipfile.ZipFile(source) as old, zipfile.ZipFile(file, "w") as new:
        for name in old.namelist():
            content = old.read(name)
            new.writestr(name, change(content.decode()) if name == "modelDescription.xml" else content)
    return file


def replaced(text: str, *edits: tuple[str, str]) -> str:
    assert all(before in text for before, _ in edits)
    return reduce(lambda text, edit: text.replace(*edit), edits, text)


def with_own_prediction(trapezoid: str, file: Path, more: str = "trust = true") -> Path:
    """Write the scenario of a text with an FMU as prediction next to it."""
    path = file.with_suffix(".toml")
    own = f'kind = "fmu"\nfile = "{file.name}"\n{more}\n'
    path.write_text(replaced(trapezoid, ('kind = "fmu"\nmodel = "TrainPrediction"\n', own)))
    return path
