"""A filter that learns the load of the train, against the truth of stops."""

import pytest
from filter_errors import errors_of


@pytest.mark.parametrize("load", [0.8, 1.12])
def test_an_unknown_load_is_learned_during_a_stop(load):
    """Adhesion is unbiased and consistent; the noises were not chosen on this seed."""
    own, other = (errors_of("sine_sweep", load, "none", 4, name) for name in ("loaded", "disturbed"))
    assert own["rmse"] < 0.8 * other["rmse"]
    assert abs(own["bias"]) < 0.25 * abs(other["bias"])
    assert 0.3 < own["nees"] < 2.0 < other["nees"]
