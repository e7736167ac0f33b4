"""A train of two cars, as created by `railgrip new train`, as tables that a test may change."""

import tomllib
from dataclasses import astuple

import pytest
from small_train import BEGINNING
from synthetic import POSITION_R

from railgrip.rolling_stock.schema import train_of


@pytest.fixture
def railgrip(tmp_path, monkeypatch, command):
    """Run a command in an empty folder; return exit code, output and errors."""
    monkeypatch.chdir(tmp_path)
    return lambda *arguments: astuple(command(*arguments))


@pytest.fixture
def tables():
    """The tables of a train file."""
    return tomllib.loads(BEGINNING.replace("NAME", "ours"))


@pytest.fixture
def piped(tables):
    """The same with a brake pipe, tables of a distributor in position R, and an accelerator that no car uses."""
    tables["command"] = {
        "kind": "brake_pipe", "diameter": "32 mm", "branch_volume": 0, "fill_time": "4 s", "reservoir": "0.1 m3",
        "estimated": True,
    }  # fmt: skip
    tables["distributors"] = {"R": POSITION_R.copy()}
    tables["accelerators"] = {
        "quick": {
            "conductance": "2e-7 m3/(s.Pa)", "opening_rate": "0.7 bar/s", "closing_pressure": "2.5 bar",
            "sensing_time": "0.3 s", "estimated": True,
        }
    }  # fmt: skip
    return tables


@pytest.fixture
def train(tables):
    """The train described by these tables."""
    return train_of(tables, "ours.toml")
