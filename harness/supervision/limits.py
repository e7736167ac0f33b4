"""Supervision limits: locations at which speed and distance monitoring warns or brakes, over speed (§3.13.4 to .9)."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from math import inf
from typing import cast

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import brentq

from railgrip.base.arrays import Vector
from railgrip.base.errors import InputError
from railgrip.supervision import fixed
from railgrip.supervision.curve import BrakingCurve, Deceleration, Steps, braking_curve, combine
from railgrip.supervision.line import Line, Target
from railgrip.supervision.model import BrakingModel, highest_on_low_adhesion, safe_deceleration
from railgrip.supervision.national import NationalValues

Limits = Mapping[str, Vector]
"""Limit → location over speed [m]."""


@dataclass(frozen=True, eq=False)
class BrakingCase:
    """A train on a line under national values.

    Its decelerations do not depend on the target. A headway has hundreds of targets, so they are calculated once.
    """

    model: BrakingModel
    national: NationalValues
    line: Line

    @property
    def ceiling(self) -> float:
        """Permitted speed V_MRSP [m/s], at most that of the train (§3.13.7.2)."""
        return min(self.model.maximum_speed, self.line.speed or inf)

    @cached_property
    def safe(self) -> Deceleration:
        """A_safe(V, d) of the emergency brake (§3.13.6.2)."""
        return Deceleration.of(
            lambda a, most, gradient: np.minimum(a, most) + gradient,
            [safe_deceleration(self.model, self.national)],
            [highest_deceleration(self), gradient_deceleration(self)],
        )

    @cached_property
    def expected(self) -> Deceleration:
        """A_expected(V, d) of the service brake (§3.13.6.3)."""
        return brake_on_line(self, self.model.service)


def lowest_gradient(line: Line, length: float) -> Steps:
    """Return the lowest gradient under a train over the location of its front end, positive uphill (§3.13.4.2)."""
    rows = [(-inf, 0.0), *((section.begin, section.slope) for section in line.gradient)]
    begins, slopes = (np.array(column) for column in zip(*rows, strict=True))
    ends = begins[1:] + length
    fronts = np.unique(np.concatenate([begins, ends]))
    # The sections under the train are adjacent: from that of its rear to that of its front.
    under = np.stack(
        [np.searchsorted(ends, fronts, side="right"), np.searchsorted(begins, fronts, side="right")], axis=1
    )
    return Steps(fronts, np.minimum.reduceat(np.append(slopes, inf), under.ravel())[::2])


def gradient_deceleration(case: BrakingCase) -> Steps:
    """Return A_gradient(d) [m/s2] over the location of the front end, negative downhill (§3.13.4)."""
    known = case.model.rotating

    def deceleration(slope: Vector) -> Vector:
        usual = np.where(slope > 0, fixed.ROTATING_MOST, fixed.ROTATING_LEAST)
        return fixed.GRAVITY * slope / (1 + (usual if known is None else known) / 100)

    return combine(deceleration, lowest_gradient(case.line, case.model.length))


def emergency_curve(case: BrakingCase, target: Target) -> BrakingCurve:
    """Return the EBD of a target (§3.13.8.3).

    Through zero speed at an SvL; otherwise through the ceiling EBI at the target, and down to the target speed.

    Raises:
        InputError: The brake does not slow the train down on a gradient.
    """
    above = float(fixed.ceiling_margin("EBI", target.speed)) if target.speed else 0.0
    return _curve(case, "EBD", case.safe, target, target.at, target.speed + above)


def highest_deceleration(case: BrakingCase) -> Steps:
    """Return A_MAXREDADH over location: on reported low adhesion until the whole train has left it (§3.13.5.3)."""
    cap = highest_on_low_adhesion(case.model, case.national)
    rows = [(-inf, inf)]
    for stretch in case.line.low_adhesion:
        if rows[-1][0] >= stretch.begin:  # the train still has its rear on the stretch before
            rows.pop()
        else:
            rows.append((stretch.begin, cap))
        rows.append((stretch.end + case.model.length, inf))
    return Steps.of(rows)


def service_curve(case: BrakingCase, target: Target) -> BrakingCurve:
    """Return the SBD of an EoA (§3.13.8.4).

    Raises:
        InputError: The brake does not slow the train down on a gradient.
    """
    return _curve(case, "SBD", case.expected, target, target.at, target.speed)


def brake_on_line(case: BrakingCase, brake: Steps) -> Deceleration:
    """Return the deceleration by a brake and the gradient: A_expected(V, d) for A_brake_service(V) (§3.13.6.3.1.3)."""
    return Deceleration.of(np.add, [brake], [gradient_deceleration(case)])


def guidance_curve(case: BrakingCase, target: Target, foot: float) -> BrakingCurve:
    """Return the GUI of a target (§3.13.8.5), which has the target speed at the location `foot` [m].

    Raises:
        InputError: The train has no A_brake_normal_service(V), or does not slow down on a gradient.
    """
    if case.model.normal_service is None:
        raise InputError(
            f"{case.model.name}: lacks normal_service, which guidance curves need; give it, or Q_NVGUIPERM = false"
        )
    deceleration = Deceleration.of(
        lambda a, up, down, slope, gradient: a + gradient - np.where(slope > 0, up, down) * slope,
        [case.model.normal_service, *case.model.kn],
        [lowest_gradient(case.line, case.model.length), gradient_deceleration(case)],
    )
    return _curve(case, "GUI", deceleration, target, foot, target.speed)


def _curve(
    case: BrakingCase, name: str, deceleration: Deceleration, target: Target, location: float, speed: float
) -> BrakingCurve:
    try:
        return braking_curve(deceleration, location=location, speed=speed, foot=target.speed)
    except InputError as problem:
        raise InputError(f"{case.model.name}, {name} of {target.name}: {problem}") from None


@dataclass(frozen=True, slots=True, kw_only=True)
class Times:
    """The times of §3.13.6 and §3.13.9.3 for a target [s].

    Attributes:
        build_up: T_be.
        service: T_bs.
        before_brake: T_bs1 = T_bs2, without feedback of the service brake.
        traction: T_traction.
        rest: T_berem.
        indication: T_indication.
    """

    build_up: float
    service: float
    before_brake: float
    traction: float
    rest: float
    indication: float


def times_of(case: BrakingCase, target_speed: float) -> Times:
    """Return the times for a target speed [m/s]: §3.13.6.2.2.3, .6.3.2.4, .9.3.2.3, .9.3.2.6, .9.3.3.3 and .9.3.6.2."""
    model, national = case.model, case.national
    moving = int(target_speed > 0)
    build_up = model.emergency_times[moving] * (national.M_NVKTINT if model.is_converted else 1.0)
    service = model.service_times[moving]
    before_brake = service if model.has_service_brake and national.Q_NVSBTSMPERM else 0.0
    traction = model.cut_off_time
    if model.cuts_off:
        traction = max(traction - (fixed.WARNING_TIME + before_brake), 0.0)
    return Times(
        build_up=build_up,
        service=service,
        before_brake=before_brake,
        traction=traction,
        rest=max(build_up - traction, 0.0),
        indication=max(0.8 * service, fixed.INDICATION_LEAST) + fixed.DRIVER_TIME,
    )


def limits_of(case: BrakingCase, target: Target, speed: ArrayLike, acceleration: float = 0.0) -> Limits:
    """Return the braking curve and the supervision limits of a target over the estimated speed (§3.13.9.3).

    Args:
        case: Train, line and national values.
        target: An EoA has SBD, SBI1, W, P and I; others have EBD, EBI, SBI2, W, P and I. GUI comes with both where
            guidance curves are permitted.
        speed: V_est, at least the target speed [m/s].
        acceleration: A_est, at the moment of the calculation [m/s2].

    Raises:
        InputError: The brake does not slow the train down on a gradient, or the train lacks what guidance needs.
    """
    v = np.asarray(speed, dtype=np.float64)
    times = times_of(case, target.speed)
    limits: dict[str, Vector] = {}
    if target.kind == "EoA":
        curve = service_curve(case, target)
        limits["SBD"] = curve.location(v)
        sbi = limits["SBI1"] = limits["SBD"] - v * times.before_brake
        foot = target.at
    else:
        curve = emergency_curve(case, target)
        limits["EBD"] = curve.location(v)
        limits["EBI"] = intervention(case, curve, target, v, times, acceleration)
        sbi = limits["SBI2"] = limits["EBI"] - v * times.before_brake
        foot = target.at if target.kind == "SvL" else _permitted_foot(case, curve, target, times)
    limits["W"] = sbi - v * fixed.WARNING_TIME
    limits["P"] = sbi - v * fixed.DRIVER_TIME
    if case.national.Q_NVGUIPERM:
        limits["GUI"] = guidance_curve(case, target, foot).location(v)
        limits["P"] = np.minimum(limits["P"], limits["GUI"])
    limits["I"] = limits["P"] - v * times.indication
    return limits


def intervention(
    case: BrakingCase, curve: BrakingCurve, target: Target, speed: ArrayLike, times: Times, acceleration: float = 0.0
) -> Vector:
    """Return the location of the EBI from an EBD, over the estimated speed [m] (§3.13.9.3.2)."""
    v = np.asarray(speed, dtype=np.float64)
    v_delta0 = 0.0 if case.national.Q_NVINHSMICPERM else fixed.under_reading(v)
    v_delta1 = max(acceleration, 0.0) * times.traction
    v_delta2 = min(max(acceleration, 0.0), fixed.TRACTION_MOST) * times.rest
    before = np.maximum(v + v_delta0 + v_delta1, target.speed)
    distance = np.maximum(v + v_delta0 + v_delta1 / 2, target.speed) * times.traction
    distance = distance + (before + v_delta2 / 2) * times.rest
    return curve.location(before + v_delta2) - distance


def _permitted_foot(case: BrakingCase, curve: BrakingCurve, target: Target, times: Times) -> float:
    """Return the location of the permitted speed for the target speed, the foot of the GUI (§3.13.9.3.5.9, .10)."""
    ebi = float(intervention(case, curve, target, target.speed, times))
    return ebi - target.speed * (fixed.DRIVER_TIME + times.before_brake)


def trip_location(case: BrakingCase) -> float:
    """Return d_tripEOA of level 2: the EoA and the largest confidence interval expected there [m] (§3.13.9.4.8.2)."""
    eoa, balise = case.line.only("EoA").at, case.line.balise
    assert balise is not None  # a line with a calculated release speed has it
    return eoa + 2 * case.national.Q_NVLOCACC + 10.0 + 0.1 * (eoa - balise)


def release_speed(case: BrakingCase) -> float | None:
    """Return the release speed [m/s], which no permitted speed exceeds; None without one (§3.13.9.4).

    A calculated one is exact where §3.13.9.4.8.2 accepts an error of 1 km/h.
    """
    match case.line.release:
        case "none":
            return None
        case "given":
            speed = case.line.release_speed
        case "national":
            speed = case.national.V_NVREL
        case "calculated":
            speed = _calculated_release(case)
    # §3.13.9.4.9: no permitted speed on the way to the trip location is exceeded.
    end = case.line.only("EoA").at if case.line.balise is None else trip_location(case)
    before = [target.speed for target in case.line.target if target.kind == "MRSP" and target.at <= end]
    return min(speed or 0.0, case.ceiling, *before) or None


def _release_targets(case: BrakingCase) -> list[Target]:
    """Return the SvL and, for a calculated release speed, the targets between trip location and SvL (§3.13.9.4.6)."""
    svl = case.line.only("SvL")
    if case.line.release != "calculated":
        return [svl]
    trip = trip_location(case)
    return [svl, *(target for target in case.line.target if target.speed and trip < target.at <= svl.at)]


def _calculated_release(case: BrakingCase) -> float:
    """Return the lowest of the speeds whose EBI is at the trip location, as without traction cut-off (§3.13.9.4.8)."""
    trip, speeds = trip_location(case), []
    for target in _release_targets(case):
        curve, times = emergency_curve(case, target), times_of(case, target.speed)
        whole = max(times.build_up, case.model.cut_off_time)

        def ahead(speed: float, curve: BrakingCurve = curve, whole: float = whole) -> float:
            v = speed + (0.0 if case.national.Q_NVINHSMICPERM else float(fixed.under_reading(speed)))
            return float(curve.location(v)) - v * whole - trip

        if ahead(target.speed) <= 0 or ahead(case.ceiling) >= 0:
            speeds.append(target.speed if ahead(target.speed) <= 0 else case.ceiling)
        else:
            speeds.append(cast(float, brentq(ahead, target.speed, case.ceiling, xtol=1e-9)))
    return min(speeds)


def release_start(case: BrakingCase, speed: float) -> float:
    """Return the start of release speed monitoring: the first SBI for a release speed [m] (§3.13.9.4.6, .7)."""
    starts = [limits_of(case, case.line.only("EoA"), speed)["SBI1"]]
    starts += [limits_of(case, target, speed)["SBI2"] for target in _release_targets(case)]
    return float(min(starts))
