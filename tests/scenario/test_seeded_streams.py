"""Random draws belong to a seed and a purpose."""

import numpy as np

from railgrip.scenario.seed import generator


def test_a_purpose_has_its_own_numbers_and_always_the_same():
    draws = {purpose: generator(7, purpose).standard_normal(4) for purpose in ("adhesion", "sensors.wheel")}
    assert np.array_equal(draws["adhesion"], generator(7, "adhesion").standard_normal(4))
    assert not np.array_equal(draws["adhesion"], draws["sensors.wheel"])
    assert not np.array_equal(draws["adhesion"], generator(8, "adhesion").standard_normal(4))
