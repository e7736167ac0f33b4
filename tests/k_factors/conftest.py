"""Fixtures of the tests of K factors."""

import pytest


@pytest.fixture
def few_rates(monkeypatch: pytest.MonkeyPatch) -> None:
    """Draw ten failure rates instead of a thousand in tests that do not check their intervals."""
    monkeypatch.setattr("railgrip.supervision.k_dry._RATES", 10)
