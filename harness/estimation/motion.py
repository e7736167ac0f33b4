"""Motion of a train and course of its track, from an optical speed sensor, accelerometers and GNSS.

The motion comes from one Rauch–Tung–Striebel smoother over the states

    s' = v,  v' = a,  a' = jerk,  b' = drift,  k' = 0

with the readings

    speed sensor      v + k v      k is its scale error; the product takes v from the reading
    accelerometers    a + b        mean of all; b is their bias and g sin β, which look like acceleration
    GNSS              s            length of the smoothed path plus the distance of a position ahead of it

GNSS requires a path over distance, and the path requires a distance: the first pass is without GNSS, the second with
it.

The course follows equations (6) and (8) of Schwarz, Lüdicke and Heckmann: κ = Δφ/Δs, tan β = Δz/Δs. Its low-pass is
over distance: north, east and height become smoothing splines, weighted by the distance between two samples, so that a
metre has the same weight at 5 and at 100 km/h. Away from its ends such a spline keeps 1/(1 + (L/l)⁴) of a wave of
length l, half of a wave of the cut-off length L.

The braking phase of a run has the track force that follows from its course.
"""

from dataclasses import dataclass

import numpy as np
import xarray
from numpy.typing import ArrayLike, NDArray
from scipy.interpolate import make_smoothing_spline

from railgrip.base.errors import EstimationError
from railgrip.estimation.spec import CourseTable, LowPass, SensorDeviations
from railgrip.estimators.belief import Array
from railgrip.recording.samples import has_reading, period_of, readings_in, samples, with_signals
from railgrip.scenario.track import force_along
from railgrip.scenario.track_geometry import Place, local

GRID = 1.0
"""Spacing of a course [m]; positions that are closer are averaged."""

FEWEST = 5
"""Minimum number of points for a smoothing spline."""


@dataclass(frozen=True, slots=True)
class ReconstructedTrack:
    """The reconstructed track, on an even grid of distance.

    Attributes:
        distance: Distances, shape (k,) [m].
        horizontal: North and east, shape (k, 2) [m].
        height: Height, shape (k,) [m].
        heading: φ, continuous, clockwise from north [rad].
        curvature: κ [1/m], positive to the right in the direction of travel.
        slope: tan β, positive uphill in the direction of travel.
    """

    distance: Array
    horizontal: Array
    height: Array
    heading: Array
    curvature: Array
    slope: Array

    def length_to(self, distance: ArrayLike) -> Array:
        """Return the length of the reconstructed path up to measured distances [m]."""
        steps = np.linalg.norm(np.diff(self.horizontal, axis=0), axis=1)
        return np.interp(np.asarray(distance), self.distance, np.concatenate([[0.0], np.cumsum(steps)]))

    def ahead(self, distance: Array, horizontal: Array) -> Array:
        """Return the lead of positions over their distance, along the path [m], shape (k,)."""
        heading = np.interp(distance, self.distance, self.heading)
        north, east = (np.interp(distance, self.distance, column) for column in self.horizontal.T)
        return (horizontal[:, 0] - north) * np.cos(heading) + (horizontal[:, 1] - east) * np.sin(heading)


def course_of(distance: Array, horizontal: Array, height: Array, low_pass: LowPass) -> ReconstructedTrack:
    """Return the course of a track from positions along it.

    Args:
        distance: Distance travelled at each position, never decreasing, shape (k,) [m].
        horizontal: North and east of each position, shape (k, 2) [m].
        height: Height of each position, shape (k,) [m].

    Raises:
        EstimationError: The positions span less than the base of the differences and five metres.
    """
    reach = float(distance[-1] - distance[0])
    if reach < max(low_pass.base, FEWEST * GRID):
        raise EstimationError(
            f"course: positions over {reach:.1f} m do not determine curvature over {low_pass.base:g} m; "
            "take a longer recording."
        )
    at, positions = _means_by_metre(distance, np.column_stack([horizontal, height]))
    # Each point represents half of the distance to either neighbour.
    weight = np.gradient(at)
    plan, rise = ((wavelength / (2.0 * np.pi)) ** 4 for wavelength in (low_pass.plan, low_pass.height))
    north, east = (make_smoothing_spline(at, positions[:, c], w=weight, lam=plan) for c in (0, 1))
    up = make_smoothing_spline(at, positions[:, 2], w=weight, lam=rise)
    grid = np.arange(at[0], at[-1], GRID)
    half = 0.5 * low_pass.base
    # At the ends the base is shortened, not shifted.
    behind, before = np.maximum(grid - half, at[0]), np.minimum(grid + half, at[-1])

    def heading(s: Array) -> Array:
        return np.unwrap(np.arctan2(east(s, nu=1), north(s, nu=1)))

    turn = (heading(before) - heading(behind) + np.pi) % (2.0 * np.pi) - np.pi
    return ReconstructedTrack(
        distance=grid,
        horizontal=np.column_stack([north(grid), east(grid)]),
        height=up(grid),
        heading=heading(grid),
        curvature=turn / (before - behind),
        slope=(up(before) - up(behind)) / (before - behind),
    )


def _means_by_metre(distance: Array, values: Array) -> tuple[Array, Array]:
    cell = np.floor((distance - distance[0]) / GRID).astype(int)
    _, which, count = np.unique(cell, return_inverse=True, return_counts=True)
    at = np.bincount(which, distance) / count
    return at, np.column_stack([np.bincount(which, column) / count for column in values.T])


@dataclass(frozen=True, slots=True)
class Motion:
    """Motion of a train at every sample.

    Attributes:
        distance: Distance since the first sample [m], never decreasing, shape (k,).
        speed: Speed [m/s], shape (k,).
        scale: Scale error of the speed sensor.
        course: Course of the track, over `distance`.
    """

    distance: Array
    speed: Array
    scale: float
    course: ReconstructedTrack


def motion_of(
    *,
    period: float,
    speed: Array,
    accelerations: Array,
    horizontal: Array,
    height: Array,
    trust: SensorDeviations,
    low_pass: LowPass,
) -> Motion:
    """Return motion and course from readings on one even grid.

    Args:
        period: Period of the grid [s].
        speed: Reading of the optical sensor, shape (k,) [m/s].
        accelerations: Readings of all accelerometers along the vehicle, shape (k, sensors) [m/s2].
        horizontal: North and east by GNSS, NaN without a position, shape (k, 2) [m].
        height: Height by GNSS, NaN without a position, shape (k,) [m].

    Raises:
        EstimationError: The train hardly moved.
    """
    fixes = np.flatnonzero(np.isfinite(height))
    mean_acceleration = np.mean(accelerations, axis=1)
    nothing = np.full(speed.size, np.nan)
    first = _pass(period, speed, mean_acceleration, nothing, trust)
    rough = np.maximum.accumulate(first[:, 0])
    path = course_of(rough[fixes], horizontal[fixes], height[fixes], low_pass)
    along = nothing.copy()
    along[fixes] = path.length_to(rough[fixes]) + path.ahead(rough[fixes], horizontal[fixes])
    # The path begins at the first fix, the distance at the first sample.
    along -= np.nan_to_num(along[fixes[0]]) - rough[fixes[0]]
    second = _pass(period, speed, mean_acceleration, along, trust)
    distance = np.maximum.accumulate(second[:, 0] - second[0, 0])
    return Motion(
        distance=distance,
        speed=second[:, 1],
        scale=float(second[-1, 4]),
        course=course_of(distance[fixes], horizontal[fixes], height[fixes], low_pass),
    )


def _pass(period: float, speed: Array, acceleration: Array, along: Array, trust: SensorDeviations) -> Array:
    T = period
    F = np.eye(5)
    F[0, 1] = F[1, 2] = T
    F[0, 2] = 0.5 * T**2
    # White jerk, integrated exactly over a period.
    jerk = trust.jerk**2 * np.array(
        [[T**5 / 20, T**4 / 8, T**3 / 6], [T**4 / 8, T**3 / 3, T**2 / 2], [T**3 / 6, T**2 / 2, T]]
    )
    Q = np.zeros((5, 5))
    Q[:3, :3] = jerk
    Q[3, 3] = trust.drift**2 * T
    # A lower bound: with a constant state the covariance of the smoother is singular except for rounding.
    Q[4, 4] = (1e-6) ** 2 * T
    observation = np.zeros((speed.size, 3, 5))
    observation[:, 0, 1], observation[:, 0, 4] = 1.0, np.nan_to_num(speed)
    observation[:, 1, 2] = observation[:, 1, 3] = 1.0
    observation[:, 2, 0] = 1.0
    # The covariance is not returned: the receiver's error is correlated, but the smoother assumes white noise.
    return smooth(
        transition=F,
        noise=Q,
        observation=observation,
        reading_noise=np.array([trust.speed, trust.acceleration, trust.position]) ** 2,
        readings=np.column_stack([speed, acceleration, along]),
        start=np.array([0.0, float(speed[np.isfinite(speed)][0]), 0.0, 0.0, 0.0]),
        # The distance at the first sample is zero by definition, here within a millimetre.
        start_covariance=np.diag([1e-3, 1.0, 1.0, trust.bias, trust.scale]) ** 2,
    )


def smooth(
    *,
    transition: Array,
    noise: Array,
    observation: Array,
    reading_noise: Array,
    readings: Array,
    start: Array,
    start_covariance: Array,
) -> Array:
    """Return the means of the states of x[j+1] = F x[j] + q, y[j] = H[j] x[j] + r given all readings, shape (k, n).

    The Rauch–Tung–Striebel smoother.

    Args:
        transition: F, shape (n, n).
        noise: Covariance of q, shape (n, n).
        observation: H at every instant, shape (k, m, n).
        reading_noise: Variances of independent r, shape (m,).
        readings: y, shape (k, m); NaN where missing.
        start: Mean at the first instant before its readings, shape (n,).
        start_covariance: Its covariance, shape (n, n), positive definite.

    Source: Särkkä, Bayesian Filtering and Smoothing (2013), theorems 4.2 and 8.2.
    """
    count, n = len(readings), start.size
    mean, covariance = np.empty((count, n)), np.empty((count, n, n))
    expected_mean, expected = np.empty((count, n)), np.empty((count, n, n))
    m, covariance_now = start, start_covariance
    for j in range(count):
        if j > 0:
            m, covariance_now = transition @ m, transition @ covariance_now @ transition.T + noise
        expected_mean[j], expected[j] = m, covariance_now
        there = np.isfinite(readings[j])
        if there.any():
            H, R = observation[j][there], np.diag(reading_noise[there])
            gain = np.linalg.solve(H @ covariance_now @ H.T + R, H @ covariance_now).T
            remainder = np.eye(n) - gain @ H
            m = m + gain @ (readings[j][there] - H @ m)
            covariance_now = remainder @ covariance_now @ remainder.T + gain @ R @ gain.T
        mean[j], covariance[j] = m, covariance_now
    for j in range(count - 2, -1, -1):
        G = np.linalg.solve(expected[j + 1], transition @ covariance[j]).T
        mean[j] = mean[j] + G @ (mean[j + 1] - expected_mean[j + 1])
        update = covariance[j] + G @ (covariance[j + 1] - expected[j + 1]) @ G.T
        covariance[j] = 0.5 * (update + update.T)
    return mean


FILLED = 2e4
"""Cylinder pressure [Pa] above which a brake counts as applied; an empty cylinder reads about 0.01 bar."""

COASTING = 2.0
"""Time after driving in which the force of the drive decays [s]."""


@dataclass(frozen=True, slots=True)
class Braking:
    """A braking phase for an estimation.

    Attributes:
        recording: Samples from the first one of coasting to the last, with `track_force` in addition to the readings.
        motion: Motion of the whole run.
        brake: Sample of `recording` at which braking begins.
    """

    recording: xarray.Dataset
    motion: Motion
    brake: int


def braking_of(run: xarray.Dataset, course: CourseTable) -> Braking:
    """Return the braking phase of a run.

    Args:
        run: Readings `speed`, `acceleration_along[i]`, `latitude`, `longitude`, `height` (NaN between the samples of
            the receiver), `wheelset_speed[i]`, `cylinder_pressure[i]`, and the signals of `traction_mask` and
            `brake_mask`.

    Raises:
        EstimationError: A reading is missing, the train did not brake, or it was driven until it braked.
    """
    who = f"recording '{run.attrs.get('name')}'"
    motion = _motion(run, course, who)
    track = motion.course
    of_track = force_along(track.slope, track.curvature, course.mass, course.curve_law)
    behind = course.wheelset_position or (0.0,)
    force = np.mean([np.interp(motion.distance - each, track.distance, of_track) for each in behind], axis=0)
    brakes, period = brake_mask(run), period_of(run)
    if not brakes.any():
        raise EstimationError(
            f"{who}: the train did not brake: no cylinder fills, and braking is never 1; check the unit of "
            "cylinder_pressure, or give the signal braking"
        )
    onset = int(np.argmax(brakes))
    last = int(np.flatnonzero(np.append(True, traction_mask(run)[:onset]))[-1])  # number of samples until driving ended
    first = last + round(COASTING / period) if last else 0
    if first >= onset:
        raise EstimationError(
            f"{who}: braking began {(onset - last) * period:.2f} s after driving; "
            f"the filter does not model traction and needs {COASTING:g} s of coasting before."
        )
    with_force = with_signals(run, {"track_force": (force, "N")})
    return Braking(recording=with_force.isel(time=slice(first, None)), motion=motion, brake=onset - first)


def _motion(run: xarray.Dataset, course: CourseTable, who: str) -> Motion:
    sensors = readings_in(run, "acceleration_along")
    if not sensors:
        raise EstimationError(f"{who} has no acceleration_along[1]; map one or more.")
    position = samples(run, ("latitude", "longitude", "height"), ("deg", "deg", "m"))
    position[~np.isfinite(position).all(axis=1)] = np.nan  # an incomplete position is not usable
    fixes = np.flatnonzero(np.isfinite(position[:, 0]))
    if fixes.size == 0:
        raise EstimationError(f"{who}: GNSS gave no position at all.")
    latitude, longitude, height = position[fixes[fixes.size // 2]].tolist()
    origin = Place(latitude=latitude, longitude=longitude, height=height)  # origin of the local frame
    return motion_of(
        period=period_of(run),
        speed=samples(run, ("speed",), ("m/s",))[:, 0],
        accelerations=samples(run, sensors, ["m/s2"] * len(sensors)),
        horizontal=local(position[:, 0], position[:, 1], position[:, 2], origin)[:, :2],
        height=position[:, 2],
        trust=course.trust,
        low_pass=course.low_pass,
    )


def traction_mask(run: xarray.Dataset) -> NDArray[np.bool_]:
    """Return a mask of the samples with driving, shape (k,): from `driving` of a user's file or the traction of a stop.

    Raises:
        EstimationError: The recording has neither signal.
    """
    if "driver_demand" in run and not has_reading(run, "driving"):
        return run["traction"].values > 0.0 if "traction" in run else np.zeros(run.sizes["time"], dtype=bool)
    return samples(run, ("driving",), ("1",))[:, 0] > 0.5


def brake_mask(run: xarray.Dataset) -> NDArray[np.bool_]:
    """Return a mask of the samples with braking, shape (k,): from `braking` of a user's file or the demand of a stop.

    Without either signal, the samples at which a cylinder pressure exceeds `FILLED`.
    """
    if has_reading(run, "braking"):
        return samples(run, ("braking",), ("1",))[:, 0] > 0.5
    if "driver_demand" in run:
        return np.any(run["driver_demand"].values > 0.0, axis=1)
    cylinders = readings_in(run, "cylinder_pressure")
    return np.any(samples(run, cylinders, ["Pa"] * len(cylinders)) > FILLED, axis=1)
