import pytest

from railgrip.supervision import trains


@pytest.fixture
def few(monkeypatch: pytest.MonkeyPatch) -> None:
    """Draw few samples in tests that do not depend on them."""
    monkeypatch.setattr(trains, "_RUNS", 2)
    monkeypatch.setattr(trains, "_SAMPLES", 20)
    monkeypatch.setattr("railgrip.supervision.k_dry._RATES", 10)
