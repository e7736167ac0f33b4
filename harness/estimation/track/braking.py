"""From a recording of a run to the braking in it, with distance and track force from the train's own sensors."""

from dataclasses import dataclass

import numpy as np
import xarray
from numpy.typing import NDArray

from railgrip.errors import EstimationError
from railgrip.estimation.spec import LOW_PASS, TRUST, LowPass, Trust
from railgrip.estimation.track.motion import Motion, motion_of
from railgrip.scenario.track import CurveLaw, force_along
from railgrip.trace.samples import has_reading, period_of, readings_in, samples, with_signals
from railgrip.track.geodesy import Place, local

FILLED = 2e4
"""Cylinder pressure [Pa] above which a brake counts as applied: an empty cylinder reads 0.01 bar off or so."""


@dataclass(frozen=True, slots=True)
class Braking:
    """A braking to be estimated.

    Attributes:
        recording: From the first sample of coasting to the last, with `track_force` beside the readings.
        motion: Of the whole run.
        first: Where `recording` begins in the run.
        brake: Where braking begins in `recording`.
    """

    name: str
    recording: xarray.Dataset
    motion: Motion
    first: int
    brake: int


def braking_of(
    run: xarray.Dataset,
    mass: float,
    *,
    curve_law: CurveLaw = "bogie",
    low_pass: LowPass = LOW_PASS,
    trust: Trust = TRUST,
) -> Braking:
    """Return the braking of a run.

    Args:
        run: Readings `speed`, `acceleration_along[i]`, `latitude`, `longitude`, `height` (NaN between the samples of
            the receiver), `wheelset_speed[i]`, `cylinder_pressure[i]`, and what `driven` and `braked` want.

    Raises:
        EstimationError: A reading is missing, or nobody braked, or the train was still being driven then.
    """
    period = period_of(run)
    sensors = readings_in(run, "acceleration_along")
    if not sensors:
        raise EstimationError(f"recording '{run.attrs.get('name')}' has no acceleration_along[1]; map one or more.")
    position = samples(run, ("latitude", "longitude", "height"), ("deg", "deg", "m"))
    position[~np.isfinite(position).all(axis=1)] = np.nan  # half a position is none
    fixes = np.flatnonzero(np.isfinite(position[:, 0]))
    if fixes.size == 0:
        raise EstimationError(f"recording '{run.attrs.get('name')}': GNSS gave no position at all.")
    latitude, longitude, height = position[fixes[fixes.size // 2]].tolist()
    origin = Place(latitude=latitude, longitude=longitude, height=height)  # of the local frame
    motion = motion_of(
        period=period,
        speed=samples(run, ("speed",), ("m/s",))[:, 0],
        accelerations=samples(run, sensors, ["m/s2"] * len(sensors)),
        horizontal=local(position[:, 0], position[:, 1], position[:, 2], origin)[:, :2],
        height=position[:, 2],
        trust=trust,
        low_pass=low_pass,
    )
    slope, curvature = motion.course.slope_at(motion.distance), motion.course.curvature_at(motion.distance)
    force = force_along(slope, curvature, mass, curve_law)
    brakes = braked(run)
    if not brakes.any():
        raise EstimationError(f"recording '{run.attrs.get('name')}': nobody braked.")
    onset = int(np.argmax(brakes))
    last = int(np.flatnonzero(np.append(True, driven(run)[:onset]))[-1])  # how many samples until driving ended
    # The drive's force dies away within two seconds of the driver's letting go.
    first = last + round(2.0 / period) if last else 0
    if first >= onset:
        raise EstimationError(
            f"recording '{run.attrs.get('name')}': braking began {(onset - last) * period:.2f} s after driving; "
            "the filter knows no traction and wants 2 s of coasting before."
        )
    with_force = with_signals(run, {"track_force": (force, "N")})
    return Braking(
        name=str(run.attrs.get("name", "")),
        recording=with_force.isel(time=slice(first, None)),
        motion=motion,
        first=first,
        brake=onset - first,
    )


def driven(run: xarray.Dataset) -> NDArray[np.bool_]:
    """Return where the train is driven, shape (k,): `driving` of a train's own file, traction of a stop.

    Raises:
        EstimationError: Nobody says.
    """
    if "driver_demand" in run and not has_reading(run, "driving"):
        return run["traction"].values > 0.0 if "traction" in run else np.zeros(run.sizes["time"], dtype=bool)
    return samples(run, ("driving",), ("1",))[:, 0] > 0.5


def braked(run: xarray.Dataset) -> NDArray[np.bool_]:
    """Return where the train is braked, shape (k,): `braking` of a train's own file, the driver's demand of a stop.

    Where there is neither, a cylinder holds more than `FILLED`.
    """
    if has_reading(run, "braking"):
        return samples(run, ("braking",), ("1",))[:, 0] > 0.5
    if "driver_demand" in run:
        return np.any(run["driver_demand"].values > 0.0, axis=1)
    cylinders = readings_in(run, "cylinder_pressure")
    return np.any(samples(run, cylinders, ["Pa"] * len(cylinders)) > FILLED, axis=1)
