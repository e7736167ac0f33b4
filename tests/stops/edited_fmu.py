"""FMUs with another description."""

import zipfile
from collections.abc import Callable
from functools import reduce
from pathlib import Path

from synthetic import LIBRARY

from railgrip.scenario.load import load
from railgrip.scenario.schema import Scenario


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


def with_own_prediction(file: Path, *, trust: bool = True) -> Path:
    """Write the scenario `trapezoid` with an FMU as prediction next to it."""
    path = file.with_suffix(".toml")
    own = f'kind = "fmu"\nfile = "{file.name}"\ntrust = {str(trust).lower()}\n'
    trapezoid = (LIBRARY / "trapezoid.toml").read_text(encoding="utf-8")
    path.write_text(replaced(trapezoid, ('kind = "fmu"\nmodel = "TrainPrediction"\n', own)))
    return path


def short_stop(file: Path, *changes: str, trust: bool = True) -> Scenario:
    """Return two seconds of a stop with an FMU as prediction."""
    return load(with_own_prediction(file, trust=trust), ["limits.horizon=2 s", *changes])
