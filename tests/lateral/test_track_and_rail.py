"""Track, rail and noise of the lateral wheelset."""

import numpy as np
import pytest
from scipy.signal import welch

from railgrip.estimation.lateral.wheelset import CONDITIONS, PERIOD, TESTS, course, draw_track
from railgrip.fmus.native.dae import LIBRARY


def test_the_largest_deviation_of_the_track_is_its_peak():
    position, _ = draw_track(1, 20_000, 1e-3)
    # One product, rounded once.
    assert np.max(np.abs(position)) == pytest.approx(7e-3, rel=1e-15)


def test_the_velocity_is_the_derivative_of_the_position():
    position, velocity = draw_track(2, 20_000, 1e-4)
    steps = np.diff(position)
    # Trapezoidal rule on a velocity with a kink at every sample: relative error w·T = 1e-3 of a step.
    assert steps == pytest.approx(0.5e-4 * (velocity[1:] + velocity[:-1]), abs=5e-3 * np.max(np.abs(steps)))


def test_the_spectrum_is_the_stated_one():
    """S(f) ∝ 1/(1 + (f/2 Hz)⁴), well below, at and above the corner, over half an hour of track."""
    position, _ = draw_track(3, 200_000, 1e-2)
    f, density = welch(position, fs=100.0, nperseg=2000)
    for low, high in ((0.3, 0.7), (1.8, 2.2), (5.0, 7.0)):
        band = (f >= low) & (f <= high)
        shape = density[band] * (1 + (f[band] / 2.0) ** 4)
        flat = density[(f > 0.3) & (f < 1.0)].mean()
        # 100 segments give 10 % for each line, averaged over four or more; holding the noise over 10 ms adds 2 %.
        assert shape.mean() == pytest.approx(flat, rel=0.15)


def test_the_seed_determines_track_and_noise_on_any_rail():
    tests = [test.shorten(0.05) for test in TESTS]
    first, again, other = (course(tests[0], seed) for seed in (1, 1, 2))
    wet = course(tests[1], 1)
    assert np.array_equal(first.inputs, again.inputs)
    assert np.array_equal(first.noise, again.noise)
    assert not np.array_equal(first.inputs, other.inputs)
    assert np.array_equal(first.inputs[:, 0], wet.inputs[:, 0])
    assert np.array_equal(first.noise, wet.noise)


def test_the_readings_have_the_noise_of_equation_37():
    noise = course(TESTS[0].shorten(1.0), 4).noise
    # 20 000 draws determine a variance to 1 %; four times that is allowed.
    assert noise.var(axis=0) == pytest.approx([1e-7, 1e-13], rel=0.04)


def test_the_transition_changes_every_two_seconds_and_ends_from_worst_to_wet():
    transition = course(TESTS[-1], 1)
    at = [first * PERIOD for first, _ in transition.segments]
    assert at == pytest.approx([0, 2, 4, 6, 8])
    assert [condition.name for condition in transition.conditions] == ["dry", "wet", "poor", "worst", "wet"]
    assert transition.inputs[-1, 1:4] == pytest.approx([0.3, 0.4, 0.2])


def test_the_conditions_are_the_surfaces_of_the_modelica_library():
    """Table 3 is in Python and in Modelica."""
    for condition in CONDITIONS:
        text = (LIBRARY / "Contact" / "Surfaces" / f"Mal{condition.name.title()}.mo").read_text()
        assert f"k_A=1.0, k_S=1.0, mu0={condition.mu0:g}, A={condition.A:g}, B={condition.B:g})" in text
