"""The two plants, unpacked once."""

import pytest
from braking import Train


@pytest.fixture(scope="session")
def train(tmp_path_factory: pytest.TempPathFactory) -> Train:
    return Train("TwoPartTrain", tmp_path_factory.mktemp("ideal"))


@pytest.fixture(scope="session")
def pneumatic_train(tmp_path_factory: pytest.TempPathFactory) -> Train:
    return Train("TwoPartTrainPneumatic", tmp_path_factory.mktemp("pneumatic"))
