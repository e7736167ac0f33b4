"""Equations 3, 9 and 12 to 15 of Schwarz, Posielek and Goetjes (2021) along a stop.

Their proof: with σ = ∂α/∂s and V = σ²/2, the law u = L sgn(ṡ α̇) has the sign of σ, so that V falls until adhesion is
greatest. Slip is s = 1 − rω/v, so that braking harder raises it.
"""

from dataclasses import dataclass

import numpy as np
import xarray
from table1_stops import stop_of

from railgrip.base.arrays import Mask, Vector
from railgrip.report.stop import Stop
from railgrip.simulate.vehicle_data import VehicleData
from railgrip.trace.bound import Contact
from railgrip.vehicle.brake import Brake

GROUP, WHEELSET = 0, 0
"""The wheelset of figure 4, whose brake is strong enough for the peak; it is coupled with the second one."""

SLIPS, SLOWEST = (0.002, 0.5), 3.0
"""Range of slip [1] and minimum speed [m/s] of the samples that are judged: elsewhere the wheel rolls or locks."""

STEPS = {"slip": 1e-5, "speed": 1e-3}
"""Steps of central differences [1, m/s]: errors by rounding and curvature are below a thousandth."""

SMALL = 0.1
"""Share of the rate of adhesion up to which the neglected terms of equation 12 count as negligible."""

NEAR = 0.99
"""Share of the greatest possible adhesion that counts as reached."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Slopes:
    """Derivatives of adhesion α(s, v) at points of a stop: ∂/∂s, ∂²/∂s², ∂/∂v [s/m] and ∂²/∂s∂v [s/m]."""

    by_slip: Vector
    curvature: Vector
    by_speed: Vector
    cross: Vector


def slopes_of(contact: Contact, slip: Vector, speed: Vector, load: Vector, mu0: Vector) -> Slopes:
    """Return derivatives of a creep curve by central differences."""
    ds, dv = STEPS.values()

    def alpha(along_slip: int, along_speed: int) -> Vector:
        return contact(slip + along_slip * ds, speed + along_speed * dv, load, mu0)

    return Slopes(
        by_slip=(alpha(1, 0) - alpha(-1, 0)) / (2 * ds),
        curvature=(alpha(1, 0) - 2 * alpha(0, 0) + alpha(-1, 0)) / ds**2,
        by_speed=(alpha(0, 1) - alpha(0, -1)) / (2 * dv),
        cross=(alpha(1, 1) - alpha(1, -1) - alpha(-1, 1) + alpha(-1, -1)) / (4 * ds * dv),
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class LyapunovCourse:
    """A stop between its samples: states in the middle of each period, rates over it, and the brake in it.

    Attributes:
        slopes: Derivatives of the creep curve.
        slip_rate, adhesion_rate, acceleration, slope_rate: ṡ, α̇, v̇ and σ̇, from differences of the samples.
        used: Adhesion over the maximum possible.
        applied: Whether full pressure is demanded, else zero; None for a law with pressures in between.
        gain: g_s = ∂ṡ/∂u with the cylinder pressure as u [1/(Pa s)].
        lowest, highest: ṡ at zero and at maximum cylinder pressure.
        resting: Whether the friction of the rail is constant.
        judged: Samples within `SLIPS` and above `SLOWEST`.
    """

    slopes: Slopes
    slip_rate: Vector
    adhesion_rate: Vector
    acceleration: Vector
    slope_rate: Vector
    used: Vector
    applied: Mask | None
    gain: Vector
    lowest: Vector
    highest: Vector
    resting: Mask
    judged: Mask

    @property
    def lyapunov_rate(self) -> Vector:
        """V̇ = σ σ̇ of equation 15."""
        return self.slopes.by_slip * self.slope_rate


def course_of(stop: Stop) -> LyapunovCourse:
    """Return the course of wheelset `WHEELSET` in a stop."""
    vehicle, trace = VehicleData(stop.scenario), stop.trace
    time, command = trace["time"].values, trace["command"].values[1:, GROUP]
    speed, slip, load, mu0, adhesion = _states(trace)
    middle = [(each[1:] + each[:-1]) / 2 for each in (slip, speed, load, mu0)]
    s, v = middle[0], middle[1]
    rates = [np.diff(each) / np.diff(time) for each in (slip, adhesion, speed, mu0)]
    slope = slopes_of(vehicle.contact, slip, speed, load, mu0).by_slip
    slip_rate, adhesion_rate, acceleration, friction_rate = rates
    brake = vehicle.true.brakes[GROUP]
    assert brake is not None, "the plants of the paper show their brakes"
    lowest, highest = (slip_rate + change for change in _slip_rate_changes(brake, trace, v))
    full = brake.pressure_max
    two_valued = bool(np.all((command < 0.01 * full) | (command > 0.99 * full)))
    greatest = trace["peak_adhesion"].values[:, GROUP]
    return LyapunovCourse(
        slopes=slopes_of(vehicle.contact, *middle),
        slip_rate=slip_rate,
        adhesion_rate=adhesion_rate,
        acceleration=acceleration,
        slope_rate=np.diff(slope) / np.diff(time),
        used=(adhesion / greatest)[1:],
        applied=command > full / 2 if two_valued else None,
        gain=(highest - lowest) / full,
        lowest=lowest,
        highest=highest,
        resting=friction_rate == 0.0,
        judged=(s > SLIPS[0]) & (s < SLIPS[1]) & (v > SLOWEST),
    )


def _states(trace: xarray.Dataset) -> list[Vector]:
    of_wheelset = [trace[name].values[:, WHEELSET] for name in ("wheelset_load", "mu0", "adhesion")]
    return [trace["speed"].values, trace["slip"].values[:, GROUP], *of_wheelset]


def _slip_rate_changes(brake: Brake, trace: xarray.Dataset, speed: Vector) -> tuple[Vector, Vector]:
    """Return by how much ṡ would differ between no pressure and the highest, all other states being equal.

    From J ω̇ = r F − T and s = 1 − rω/v: ∂ṡ/∂T = r/(J v), T = units · friction radius · pad friction · pad force.
    """
    friction, pressure = (trace[name].values[1:, GROUP] for name in ("pad_friction", "cylinder_pressure"))
    factor = brake.wheel_radius / (brake.inertia * speed) * brake.units * brake.friction_radius * friction
    now = brake.pad_force(pressure)
    return factor * (brake.pad_force(0.0) - now), factor * (brake.pad_force(brake.pressure_max) - now)


def inequalities(course: LyapunovCourse) -> dict[str, Mask | None]:
    """Return whether each inequality of the proof holds, shape (samples,); None if the law has no such input."""
    at, sigma = course.slopes, course.slopes.by_slip
    kept = sigma * course.slip_rate
    obeys = None if course.applied is None else course.applied == (sigma > 0)
    ideal = at.curvature * np.where(sigma > 0, course.highest, course.lowest) + at.cross * course.acceleration
    return {
        "(3) g_s < 0, as printed": course.gain < 0,
        "(3) g_s > 0": course.gain > 0,
        "(9) u has the sign of σ": obeys,
        f"(12) rest below {100 * SMALL:.0f} % of σ ṡ": np.abs(course.adhesion_rate - kept) < SMALL * np.abs(kept),
        "(13) ṡ α̇ has the sign of σ": np.sign(course.slip_rate * course.adhesion_rate) == np.sign(sigma),
        "∂²α/∂s² < 0": at.curvature < 0,
        "(15) dV/dt < 0 with u of (9)": sigma * ideal < 0,
        "(15) dV/dt < 0": course.lyapunov_rate < 0,
        "(15) dV/dt < 0 where (9) holds": None if obeys is None else (course.lyapunov_rate < 0) | ~obeys,
        f"α above {100 * NEAR:.0f} % of the greatest possible": course.used > NEAR,
    }


def offset_of(stop: Stop) -> dict[str, float]:
    """Return where the law as printed has its equilibrium, and where adhesion is greatest, while friction is constant.

    With slip that changes at the rate ṡ, σ-bar = ṡ (∂α/∂s ṡ + ∂α/∂v v̇) is zero where ∂α/∂s = −∂α/∂v v̇/ṡ and not where
    ∂α/∂s = 0. Speed, load, friction, v̇ and |ṡ| are medians of the judged samples with constant friction.

    `peak`: slip of the greatest adhesion; `rising`, `falling`: slip of the equilibrium while slip rises and falls;
    `rate`: median |ṡ| [1/s]; `loss`: largest relative loss of adhesion at the two.
    """
    course, contact = course_of(stop), VehicleData(stop.scenario).contact
    there = course.judged & course.resting
    speed, _, load, mu0, _ = (float(np.median(each[1:][there])) for each in _states(stop.trace))
    rate, acceleration = float(np.median(np.abs(course.slip_rate[there]))), float(np.median(course.acceleration[there]))
    slip = np.linspace(STEPS["slip"] * 10, SLIPS[1], 20_000)
    same = np.ones(slip.size)
    slopes = slopes_of(contact, slip, speed * same, load * same, mu0 * same)
    curve = contact(slip, speed * same, load * same, mu0 * same)
    # Slopes fall through each of these values near the peak: the last slip with a larger slope, up to the inflection.
    concave = slopes.curvature < 0

    def slip_with(slope: float) -> float:
        return float(slip[np.flatnonzero(concave & (slopes.by_slip > slope))[-1]])

    needed = -float(slopes.by_speed[int(np.argmax(curve))]) * acceleration / rate
    found = {"peak": slip_with(0.0), "rising": slip_with(needed), "falling": slip_with(-needed)}
    adhesion = np.interp([found["rising"], found["falling"]], slip, curve)
    return found | {"rate": rate, "loss": float(1 - adhesion.min() / curve.max())}


def violation_rows(law: str, seed: int) -> list[dict[str, float | str | None]]:
    """Return the number of judged samples and the share that violates each inequality, by state of the rail."""
    course = course_of(stop_of(law, seed))
    states = {"constant": course.resting, "changing": ~course.resting}
    return [{"friction": word} | violations(course, course.judged & there) for word, there in states.items()]


def violations(course: LyapunovCourse, judged: Mask) -> dict[str, float | None]:
    """Return the number of samples and the share that violates each inequality, None if the law has no such input."""
    shares = {
        name: None if holds is None or not judged.any() else float(np.mean(~holds[judged]))
        for name, holds in inequalities(course).items()
    }
    return {"samples": float(np.sum(judged)), **shares}


def offset_row(law: str, seed: int) -> dict[str, float]:
    """Return `offset_of` for a stop on the identified trapezoid."""
    return offset_of(stop_of(law, seed))
