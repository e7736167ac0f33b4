"""Fixtures of several tests of the estimators."""

import pytest
from small_models import WHEELSET, wheelset

from railgrip.estimators.prediction import CasadiPrediction


@pytest.fixture(scope="session")
def rolling() -> CasadiPrediction:
    """Return the prediction of a rolling wheelset."""
    return CasadiPrediction(wheelset(), WHEELSET)
