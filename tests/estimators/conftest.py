"""Fixtures of several tests of the estimators."""

import pytest
from small_models import OSCILLATOR, WHEELSET, oscillator, wheelset

from railgrip.estimators.prediction import CasadiPrediction


@pytest.fixture(scope="session")
def rolling() -> CasadiPrediction:
    """Return the prediction of a rolling wheelset."""
    return CasadiPrediction(wheelset(), WHEELSET)


@pytest.fixture(scope="session")
def linear() -> CasadiPrediction:
    """Return the linear prediction of two masses on springs."""
    return CasadiPrediction(oscillator(), OSCILLATOR)
