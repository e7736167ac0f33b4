"""Track, rail and noise of the lateral wheelset."""

import numpy as np
import pytest
from scipy.signal import welch

from railgrip.fmus.native.dae import LIBRARY
from railgrip.studies.lateral.run import Case, prediction
from railgrip.studies.lateral.wheelset import (
    ACCELEROMETER,
    CONDITIONS,
    GYROSCOPE,
    PERIOD,
    PLANTS,
    READINGS,
    TESTS,
    Irregularity,
    course,
    output_columns,
    wheelset,
)  # fmt: skip
from railgrip.trace.samples import knows, period_of, recording_of, samples, truth_of


def recording_of_case(case):
    """Return readings and known inputs of a run on the grid of 50 µs, and the true states of `LateralPrediction`.

    Row k has what was read at the end of step k and the inputs that were held during it.
    """
    realisation = course(case.test, case.seed, case.irregularity)
    with wheelset(case.speed, PLANTS[case.plant].parameters) as plant:
        plant.start(realisation.inputs[0])
        outputs = plant.follow(realisation.inputs)
    states = {"y": "lateral_position", "dy": "lateral_velocity", "psi": "yaw_angle", "dpsi": "yaw_rate"}
    units = {"y": "m", "dy": "m/s", "psi": "rad", "dpsi": "rad/s"}
    places = output_columns((*READINGS, *states.values(), "speed"))
    return recording_of(
        {
            **{
                name: (outputs[:, places[name]][:, 0] + realisation.noise[:, i], unit)
                for i, (name, unit) in enumerate(READINGS.items())
            },
            "track": (realisation.inputs[:, 0], "m"),
            "speed": (outputs[:, places["speed"]][:, 0], "m/s"),
        },
        truth={
            **{state: (outputs[:, places[name]][:, 0], units[state]) for state, name in states.items()},
            "log_mu0": (np.log(realisation.inputs[:, 1]), "1"),
        },
        period=PERIOD,
        start=PERIOD,
        name=f"lateral {case.test.name}, {case.speed:g} m/s, seed {case.seed}",
    )


def test_the_track_deviates_by_exactly_its_peak():
    position, _ = Irregularity().draw(1, 20_000, 1e-3)
    # One scaling: the product rounds once.
    assert np.max(np.abs(position)) == pytest.approx(7e-3, rel=1e-15)


def test_the_velocity_is_the_derivative_of_the_position():
    position, velocity = Irregularity().draw(2, 20_000, 1e-4)
    steps = np.diff(position)
    # Trapezoidal rule on a velocity whose slope jumps at every sample: off by a share w·T = 1e-3 of a step.
    assert steps == pytest.approx(0.5e-4 * (velocity[1:] + velocity[:-1]), abs=5e-3 * np.max(np.abs(steps)))


def test_the_spectrum_is_the_stated_one():
    """S(f) ∝ 1/(1 + (f/2 Hz)⁴): compared well below, at and above the corner, over half an hour of track."""
    position, _ = Irregularity().draw(3, 200_000, 1e-2)
    f, density = welch(position, fs=100.0, nperseg=2000)
    for low, high in ((0.3, 0.7), (1.8, 2.2), (5.0, 7.0)):
        band = (f >= low) & (f <= high)
        shape = density[band] * (1 + (f[band] / 2.0) ** 4)
        flat = density[(f > 0.3) & (f < 1.0)].mean()
        # 100 segments give 10 % a line, averaged over four lines and more; holding the noise over 10 ms adds 2 %.
        assert shape.mean() == pytest.approx(flat, rel=0.15)


def test_a_seed_decides_the_run_and_the_rail_does_not_move_the_track():
    tests = [test.shortened(0.05) for test in TESTS]
    first, again, other = (course(tests[0], seed, Irregularity()) for seed in (1, 1, 2))
    wet = course(tests[1], 1, Irregularity())
    assert np.array_equal(first.inputs, again.inputs)
    assert np.array_equal(first.noise, again.noise)
    assert not np.array_equal(first.inputs, other.inputs)
    assert np.array_equal(first.inputs[:, 0], wet.inputs[:, 0])
    assert np.array_equal(first.noise, wet.noise)


def test_the_readings_carry_the_noise_of_equation_37():
    noise = course(TESTS[0].shortened(1.0), 4, Irregularity()).noise
    # 20 000 draws: 0.5 % in a standard deviation, four times that is allowed.
    assert noise.std(axis=0) == pytest.approx([ACCELEROMETER, GYROSCOPE], rel=0.02)
    assert pytest.approx((1e-7, 1e-13)) == (ACCELEROMETER**2, GYROSCOPE**2)


def test_the_transition_changes_every_two_seconds_and_ends_from_worst_to_wet():
    transition = course(TESTS[-1], 1, Irregularity())
    at = [first * PERIOD for first, _ in transition.segments]
    assert at == pytest.approx([0, 2, 4, 6, 8])
    assert [condition.name for condition in transition.conditions] == ["dry", "wet", "poor", "worst", "wet"]
    assert transition.inputs[-1, 1:4] == pytest.approx([0.3, 0.4, 0.2])


def test_the_conditions_are_the_surfaces_of_the_modelica_library():
    """Table 3 stands in both languages."""
    for condition in CONDITIONS:
        text = (LIBRARY / "Contact" / "Surfaces" / f"Mal{condition.name.title()}.mo").read_text()
        assert f"k_A=1.0, k_S=1.0, mu0={condition.mu0:g}, A={condition.A:g}, B={condition.B:g})" in text


def test_a_recording_has_what_the_prediction_wants():
    """Inputs and readings by the prediction's names, truth by its states, on an even grid."""
    recording = recording_of_case(Case(test=TESTS[0].shortened(0.02), speed=25.0, plant="paper", seed=1))
    model = prediction("known_track")
    assert samples(recording, model.inputs, ("m/s", "m")).shape == (400, 2)
    readings = samples(recording, model.outputs, ("m/s2", "rad/s"))
    assert period_of(recording) == PERIOD
    rate = truth_of(recording, "dpsi")
    # Five standard deviations: one draw in two million is further off, and there are 400.
    assert np.max(np.abs(readings[:, 1] - rate)) < 5 * GYROSCOPE
    assert {name for name in model.states if knows(recording, name)} == set(model.states)
