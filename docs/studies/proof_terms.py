"""Equations 3, 9 and 12 to 15 of Schwarz, Posielek and Goetjes (2021) along a stop.

Their proof: with σ = ∂α/∂s and V = σ²/2, the law u = L sgn(ṡ α̇) has the sign of σ, so that V falls until adhesion is
greatest. Slip is s = 1 − rω/v, so that braking harder raises it.
"""

import math
from typing import Any

import numpy as np
import pandas as pd
import xarray
from table1_stops import stop_of

from railgrip.base.arrays import Vector
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

CURVE = ("slip", "speed", "load", "mu0")
"""States on which adhesion depends."""

NEAR = 0.99
"""Share of the greatest possible adhesion that counts as reached."""


def slopes_of(contact: Contact, slip: Vector, speed: Vector, load: Vector, mu0: Vector) -> pd.DataFrame:
    """Return derivatives of a creep curve α(s, v) by central differences.

    Columns: `by_slip`, ∂/∂s; `curvature`, ∂²/∂s²; `by_speed`, ∂/∂v [s/m]; `cross`, ∂²/∂s∂v [s/m].
    """
    ds, dv = STEPS.values()

    def alpha(along_slip: int, along_speed: int) -> Vector:
        return contact(slip + along_slip * ds, speed + along_speed * dv, load, mu0)

    return pd.DataFrame(
        {
            "by_slip": (alpha(1, 0) - alpha(-1, 0)) / (2 * ds),
            "curvature": (alpha(1, 0) - 2 * alpha(0, 0) + alpha(-1, 0)) / ds**2,
            "by_speed": (alpha(0, 1) - alpha(0, -1)) / (2 * dv),
            "cross": (alpha(1, 1) - alpha(1, -1) - alpha(-1, 1) + alpha(-1, -1)) / (4 * ds * dv),
        }
    )


def course_of(stop: Stop) -> pd.DataFrame:
    """Return the course of wheelset `WHEELSET` in a stop: states in the middle of each period, and rates over it.

    Columns:

    - `slip`, `speed`, `load`, `mu0`: states; those of `slopes_of`: derivatives of the creep curve.
    - `slip_rate`, `adhesion_rate`, `acceleration`, `slope_rate`: ṡ, α̇, v̇ and σ̇, from differences of the samples.
    - `used`: adhesion over the maximum possible.
    - `applied`: whether full pressure is demanded, else zero; missing for a law with pressures in between.
    - `gain`: g_s = ∂ṡ/∂u with the cylinder pressure as u [1/(Pa s)].
    - `lowest`, `highest`: ṡ at zero and at maximum cylinder pressure.
    - `resting`: whether the friction of the rail is constant.
    - `judged`: samples within `SLIPS` and above `SLOWEST`.
    """
    vehicle, trace = VehicleData(stop.scenario), stop.trace
    states = _states(trace)
    middle = (states + states.shift(-1))[:-1] / 2
    rates = states.diff()[1:].div(np.diff(trace["time"].values), axis=0).reset_index(drop=True)
    by_slip = slopes_of(vehicle.contact, *(states[name].to_numpy() for name in CURVE))["by_slip"]
    brake = vehicle.true.brakes[GROUP]
    assert brake is not None, "the plants of the paper show their brakes"
    lowest, highest = (rates["slip"] + change for change in _slip_rate_changes(brake, trace, middle["speed"]))
    full, command = brake.pressure_max, trace["command"].values[1:, GROUP]
    is_two_valued = bool(np.all((command < 0.01 * full) | (command > 0.99 * full)))
    return pd.concat([middle, slopes_of(vehicle.contact, *(middle[name].to_numpy() for name in CURVE))], axis=1).assign(
        slip_rate=rates["slip"],
        adhesion_rate=rates["adhesion"],
        acceleration=rates["speed"],
        slope_rate=np.diff(by_slip) / np.diff(trace["time"].values),
        used=states["adhesion"].to_numpy()[1:] / trace["peak_adhesion"].values[1:, GROUP],
        applied=(command > full / 2).astype(float) if is_two_valued else math.nan,
        gain=(highest - lowest) / full,
        lowest=lowest,
        highest=highest,
        resting=rates["mu0"] == 0.0,
        judged=(middle["slip"] > SLIPS[0]) & (middle["slip"] < SLIPS[1]) & (middle["speed"] > SLOWEST),
    )


def _states(trace: xarray.Dataset) -> pd.DataFrame:
    of_wheelset = {"load": "wheelset_load", "mu0": "mu0", "adhesion": "adhesion"}
    states = {"slip": trace["slip"].values[:, GROUP], "speed": trace["speed"].values}
    return pd.DataFrame(states | {name: trace[signal].values[:, WHEELSET] for name, signal in of_wheelset.items()})


def _slip_rate_changes(brake: Brake, trace: xarray.Dataset, speed: Any) -> tuple[Any, Any]:
    """Return by how much ṡ would differ between no pressure and the highest, all other states being equal.

    From J ω̇ = r F − T and s = 1 − rω/v: ∂ṡ/∂T = r/(J v), T = units · friction radius · pad friction · pad force.
    """
    friction, pressure = (trace[name].values[1:, GROUP] for name in ("pad_friction", "cylinder_pressure"))
    factor = brake.wheel_radius / (brake.inertia * speed) * brake.units * brake.friction_radius * friction
    now = brake.pad_force(pressure)
    return factor * (brake.pad_force(0.0) - now), factor * (brake.pad_force(brake.pressure_max) - now)


def inequalities(course: pd.DataFrame) -> pd.DataFrame:
    """Return whether each inequality of the proof holds, 1 or 0, by sample; missing if the law has no such input."""
    sigma, applied = course["by_slip"], course["applied"]
    kept, rates = sigma * course["slip_rate"], course["slip_rate"] * course["adhesion_rate"]
    obeys = (applied == (sigma > 0)).astype(float).where(applied.notna())
    falls = sigma * course["slope_rate"] < 0  # V̇ = σ σ̇
    extreme = course["highest"].where(sigma > 0, course["lowest"])
    ideal = course["curvature"] * extreme + course["cross"] * course["acceleration"]
    holds = {
        "(3) g_s < 0, as printed": course["gain"] < 0,
        "(3) g_s > 0": course["gain"] > 0,
        "(9) u has the sign of σ": obeys,
        f"(12) rest below {100 * SMALL:.0f} % of σ ṡ": (course["adhesion_rate"] - kept).abs() < SMALL * kept.abs(),
        "(13) ṡ α̇ has the sign of σ": np.sign(rates) == np.sign(sigma),
        "∂²α/∂s² < 0": course["curvature"] < 0,
        "(15) dV/dt < 0 with u of (9)": sigma * ideal < 0,
        "(15) dV/dt < 0": falls,
        "(15) dV/dt < 0 where (9) holds": np.maximum(falls, 1 - obeys),
        f"α above {100 * NEAR:.0f} % of the greatest possible": course["used"] > NEAR,
    }
    return pd.DataFrame(holds).astype(float)


def offset_of(stop: Stop) -> dict[str, float]:
    """Return where the law as printed has its equilibrium, and where adhesion is greatest, while friction is constant.

    With slip that changes at the rate ṡ, σ-bar = ṡ (∂α/∂s ṡ + ∂α/∂v v̇) is zero where ∂α/∂s = −∂α/∂v v̇/ṡ and not where
    ∂α/∂s = 0. Speed, load, friction, v̇ and |ṡ| are medians of the judged samples with constant friction.

    `peak`: slip of the greatest adhesion; `rising`, `falling`: slip of the equilibrium while slip rises and falls;
    `rate`: median |ṡ| [1/s]; `loss`: largest relative loss of adhesion at the two.
    """
    course, contact = course_of(stop), VehicleData(stop.scenario).contact
    there = course["judged"] & course["resting"]
    speed, load, mu0 = _states(stop.trace)[1:].reset_index(drop=True)[there].median()[["speed", "load", "mu0"]]
    rate, acceleration = course["slip_rate"][there].abs().median(), course["acceleration"][there].median()
    slip = np.linspace(STEPS["slip"] * 10, SLIPS[1], 20_000)
    same = np.ones(slip.size)
    slopes = slopes_of(contact, slip, speed * same, load * same, mu0 * same)
    curve = contact(slip, speed * same, load * same, mu0 * same)
    # Slopes fall through each of these values near the peak: the last slip with a larger slope, up to the inflection.
    concave = slopes["curvature"] < 0

    def slip_with(slope: float) -> float:
        return float(slip[concave & (slopes["by_slip"] > slope)][-1])

    needed = -slopes["by_speed"][int(np.argmax(curve))] * acceleration / rate
    found = {"peak": slip_with(0.0), "rising": slip_with(needed), "falling": slip_with(-needed)}
    adhesion = np.interp([found["rising"], found["falling"]], slip, curve)
    return found | {"rate": rate, "loss": float(1 - adhesion.min() / curve.max())}


def violation_rows(law: str, seed: int) -> list[dict[str, Any]]:
    """Return the number of judged samples and the share that violates each inequality, by state of the rail."""
    course = course_of(stop_of(law, seed))
    states = {"constant": course["resting"], "changing": ~course["resting"]}
    return [{"friction": word, **violations(course, course["judged"] & there)} for word, there in states.items()]


def violations(course: pd.DataFrame, judged: Any) -> dict[str, float]:
    """Return the number of samples and the share that violates each inequality, NaN if the law has no such input."""
    return {"samples": float(np.sum(judged)), **(1 - inequalities(course)[judged]).mean()}


def offset_row(law: str, seed: int) -> dict[str, float]:
    """Return `offset_of` for a stop on the identified trapezoid."""
    return offset_of(stop_of(law, seed))
