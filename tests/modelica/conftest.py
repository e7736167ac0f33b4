"""The two plants."""

import pytest
from braking import Train


@pytest.fixture(scope="session")
def train() -> Train:
    return Train("TwoPartTrain")


@pytest.fixture(scope="session")
def pneumatic_train() -> Train:
    return Train("TwoPartTrainPneumatic")
