"""Train files by path or by name."""

from pathlib import Path
from typing import Any

from railgrip.rolling_stock.schema import Train
from railgrip.scenario.file import locate
from railgrip.scenario.load import read_toml, require_kind, validate_table

NAMED = ("vt642", "emu387", "loco_coaches", "tram")
"""Folder of the trains of this package."""


def load_train(path: Path) -> Train:
    """Return the train of a TOML file, or of this package by its name.

    Raises:
        ScenarioError: The file is missing, not TOML, or not a train; there is one sentence for each problem, with file
            and key.
    """
    path = locate(path, "trains")
    table = read_toml(path)
    require_kind(table, "train", path)
    return train_of(table, path.name)


def train_of(table: dict[str, Any], origin: str) -> Train:
    """Return the train described by plain tables; `origin` is the name of their source in messages.

    Raises:
        ScenarioError: The tables do not describe a valid train.
    """
    return validate_table(Train, table, directory=Path(), origin=origin)
