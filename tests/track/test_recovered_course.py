"""The recovered track equals the true one, within the bandwidth of the low-pass."""

import numpy as np
import pytest
from filterpy.kalman import KalmanFilter

from railgrip.base.errors import EstimationError
from railgrip.estimation.motion import course_of, motion_of, smooth
from railgrip.estimation.spec import LowPass, SensorDeviations
from railgrip.scenario.track_geometry import Place, TrackAlignment, grades_of
from railgrip.scenario.track_geometry import course_of as laid_course

LOW_PASS = LowPass(plan=60.0, height=60.0, base=10.0)
TRACK = TrackAlignment(
    origin=Place(latitude=50.6, longitude=12.7, height=300.0),
    middle=0.0,
    length=1200.0,
    heading=0.5,
    curvature=laid_course([(300, 0), (80, 1 / 500), (400, 1 / 500), (80, 0), (340, 0)]),
    slope=grades_of(-0.006, ((600.0, 0.004, 8000.0),)),
)


def test_exact_positions_give_back_curvature_and_slope():
    distance = np.arange(0.0, 1200.0, 1.7)
    course = course_of(distance, TRACK.plan().horizontal_at(distance), TRACK.height_at(distance), LOW_PASS)
    inside = (course.distance > 100) & (course.distance < 1100)
    # Corners of κ, which changes by 2.5e-5/m in the transitions, are rounded over L/2π = 10 m: an error of half of
    # that.
    assert np.abs(course.curvature - TRACK.curvature(course.distance))[inside].max() < 1.25e-4
    arc = (course.distance > 480) & (course.distance < 680)
    # Within the arc nothing is rounded; the remaining error is the effect of its ends, over a wavelength away.
    assert np.abs(course.curvature[arc] - 1 / 500).max() < 4e-6
    # Likewise for the slope, which changes by 1/8000 per metre.
    assert np.abs(course.slope - TRACK.slope(course.distance))[inside].max() < 6e-4


def test_a_wave_of_the_cut_off_length_is_halved():
    """1/(1 + (L/l)⁴) at l = L, for a sinusoidal height."""
    distance = np.arange(0.0, 2000.0, 1.0)
    wave = 2 * np.pi * distance / LOW_PASS.height
    straight = np.column_stack([distance, np.zeros_like(distance)])
    course = course_of(distance, straight, np.sin(wave), LOW_PASS)
    inside = slice(300, -300)
    amplitude = np.sqrt(2) * np.std(course.height[inside])
    # Up to one of 23 whole waves is inside: 1/46 of the amplitude.
    assert amplitude == pytest.approx(0.5, abs=0.02)


def test_positions_over_a_few_metres_are_refused():
    with pytest.raises(EstimationError, match="do not determine curvature over 10 m"):
        course_of(np.linspace(0, 4, 9), np.zeros((9, 2)), np.zeros(9), LOW_PASS)


def test_the_smoother_is_that_of_filterpy():
    """With missing readings, and an observation matrix that changes with time."""
    random = np.random.default_rng(4)
    observation, noise = random.normal(size=(12, 2, 2)), np.array([0.5, 2.0])
    readings = random.normal(size=(12, 2))
    readings[3, 0] = readings[7] = np.nan
    reference, filtered = KalmanFilter(dim_x=2, dim_z=1), []
    reference.F, reference.Q = np.array([[1.0, 0.5], [0.0, 0.9]]), np.array([[0.3, 0.1], [0.1, 0.2]])
    reference.x, reference.P = np.array([0.4, -0.2]), np.array([[2.0, 0.3], [0.3, 1.0]])
    start, start_covariance = reference.x, reference.P
    for j, read in enumerate(np.isfinite(readings)):
        if j:
            reference.predict()
        for i in np.flatnonzero(read):
            reference.update(readings[j, i], R=noise[i], H=observation[j, i : i + 1])
        filtered.append((reference.x, reference.P))
    expected, *_ = reference.rts_smoother(*map(np.array, zip(*filtered, strict=True)))
    states = smooth(
        transition=reference.F, noise=reference.Q, observation=observation, reading_noise=noise, readings=readings,
        start=start, start_covariance=start_covariance,
    )  # fmt: skip
    # Both solve the same well-conditioned system in double precision.
    np.testing.assert_allclose(states, expected, rtol=0, atol=1e-9)


def test_gnss_reveals_a_speed_sensor_that_reads_too_high():
    """0.5 % over 800 m are 4 m; positions are accurate to centimetres."""
    period, count = 0.05, 1200
    time = period * np.arange(count)
    v = np.clip(0.6 * time, 0.0, 18.0)
    distance = np.concatenate([[0.0], np.cumsum(0.5 * (v[1:] + v[:-1]) * period)])
    random = np.random.default_rng(5)
    horizontal = TRACK.plan().horizontal_at(distance) + 0.02 * random.standard_normal((count, 2))
    horizontal[1::2] = np.nan
    height = TRACK.height_at(distance) + 0.03 * random.standard_normal(count)
    height[1::2] = np.nan
    acceleration = np.gradient(v, period)[:, None] + [0.05, -0.02] + 0.05 * random.standard_normal((count, 2))
    motion = motion_of(
        period=period,
        speed=1.005 * v + 0.02 * random.standard_normal(count),
        accelerations=acceleration,
        horizontal=horizontal,
        height=height,
        trust=SensorDeviations(speed=0.02, scale=5e-3, acceleration=0.05, bias=0.1, drift=0.01, jerk=0.7, position=0.1),
        low_pass=LOW_PASS,
    )
    # A tenth of the scale error: the remainder with 0.02 m of position error over 800 m and a smoothed path.
    assert motion.distance[-1] == pytest.approx(distance[-1], rel=5e-4)
    assert motion.scale == pytest.approx(0.005, abs=5e-4)
    assert np.sqrt(np.mean((motion.speed - v) ** 2)) < 0.01
