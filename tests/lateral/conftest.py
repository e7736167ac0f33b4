from pathlib import Path

import pytest


@pytest.fixture(scope="session")
def kept() -> Path:
    """Where compiled code is kept: with the rest of what is built, so that a second run of the tests finds it."""
    return Path("build")
