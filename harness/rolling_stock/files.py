"""Train files by path or by name."""

from pathlib import Path
from typing import Any

from railgrip.rolling_stock.schema import Train
from railgrip.scenario.file import locate
from railgrip.scenario.load import read_toml, require_kind, validate_table

NAMED = ("vt642", "emu387", "loco_coaches", "tram")
"""Trains that come with this package."""


def load_train(path: Path) -> Train:
    """Return the train of a TOML file, or of this package by its name.

    Raises:
        ScenarioError: The file is missing, not TOML, or no train; each problem in one sentence with file and key.
    """
    path = locate(path, "trains")
    table = read_toml(path)
    require_kind(table, "train", path)
    return train_of(table, path.name)


def train_of(table: dict[str, Any], origin: str) -> Train:
    """Return the train that plain tables describe; `origin` is what sentences call their source.

    Raises:
        ScenarioError: They describe none.
    """
    return validate_table(Train, table, directory=Path(), origin=origin)
