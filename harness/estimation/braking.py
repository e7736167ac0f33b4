"""The braking phase of a recorded run, with the track force from the train's own sensors."""

from dataclasses import dataclass

import numpy as np
import xarray
from numpy.typing import NDArray

from railgrip.base.errors import EstimationError
from railgrip.estimation.motion import Motion, motion_of
from railgrip.estimation.spec import CourseTable
from railgrip.recording.samples import has_reading, period_of, readings_in, samples, with_signals
from railgrip.scenario.track import force_along
from railgrip.scenario.track_geometry import Place, local

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
    slope, curvature = (np.interp(motion.distance, track.distance, of) for of in (track.slope, track.curvature))
    force = force_along(slope, curvature, course.mass, course.curve_law)
    brakes, period = brake_mask(run), period_of(run)
    if not brakes.any():
        raise EstimationError(f"{who}: the train did not brake.")
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
