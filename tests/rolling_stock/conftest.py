"""A train of two cars, as `railgrip train new` begins one, as tables that a test may change."""

import tomllib

import pytest

from railgrip.rolling_stock.files import beginning, train_of


@pytest.fixture
def tables():
    """The tables of a train file."""
    return tomllib.loads(beginning("ours"))


@pytest.fixture
def train(tables):
    """The train of these tables."""
    return train_of(tables, "ours.toml")
