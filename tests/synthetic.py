"""Traces and stops with known answers, for every test that needs a result without running a plant."""

from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.special import gammaincinv  # importing scipy.stats takes each process half a second

import railgrip.scenario
from railgrip.report.stop import Stop
from railgrip.scenario.adhesion import profile_of
from railgrip.scenario.outcome import Outcome
from railgrip.trace.bound import with_bound
from railgrip.trace.metrics import measure
from railgrip.trace.recorder import trace_of
from railgrip.vehicle.brake import Brake
from railgrip.vehicle.formation import Formation
from railgrip.vehicle.signals import ESTIMATES, PLANT, PLANT_INPUTS, READINGS, layout_of

LIBRARY = Path(railgrip.scenario.__file__).parent / "library"
COARSE = [f"periods.{name}=10 ms" for name in ("communication", "estimator", "controller")]

TWO_PART_TRAIN = Formation((2, 1, 1, 2), (3, 3), (0.0, 1.9, 15.625, 18.275, 32.0, 33.9))
LAYOUT = layout_of(TWO_PART_TRAIN)
FULL = np.full(4, 3.4e5)
GROUP = Brake(
    load=14500 * 9.81, inertia=209.0, wheel_radius=0.38, units=2, friction_radius=0.22, piston_area=0.0324,
    rigging=5.7, spring_force=1200.0, pressure_max=3.4e5,
)  # fmt: skip
"""A group of a single wheelset of the two-part train."""

# A train of round numbers: 6 wheelsets of 100 kN, wheels of 0.4 m.
LOAD = 1e5
RADIUS = 0.4
BRAKES = tuple(
    Brake(
        load=wheelsets * LOAD,
        inertia=1e-9,
        wheel_radius=RADIUS,
        units=wheelsets,
        friction_radius=0.25,
        piston_area=0.03,
        rigging=5.0,
        spring_force=1000.0,
        pressure_max=3e5,
    )
    for wheelsets in (2.0, 1.0, 1.0, 2.0)
)

MOTOR = {
    "kind": "electrodynamic", "force": "12 kN", "power": "200 kW", "speed_full": "10 km/h", "speed_end": "4 km/h",
    "time_constant": "0.3 s", "blending": "valve", "slide_limit": 0.1, "estimated": True,
}  # fmt: skip
"""An electrodynamic brake of a train file."""

TYPICAL = {
    "speed": 20.0, "wheelset_speed": 50.0, "pad_friction": 0.35, "group_adhesion": 0.1, "dz": 1e-3, "ddz": 1e-2,
    "d": 0.1, "bias": 0.05,
}  # fmt: skip
"""States of a braking train by the names of their arrays [SI]."""

ON_RAIL = {
    "kind": "eddy_current_rail", "force": "20 kN", "speed_peak": "90 km/h", "speed_full": "60 km/h",
    "speed_end": "50 km/h", "time_constant": "0.5 s", "estimated": True,
}  # fmt: skip
"""A linear eddy-current brake."""

POSITION_R = {
    "low_share": 0.5, "speed_up": "70 km/h", "speed_down": "50 km/h", "stage_time": "0.3 s", "estimated": True,
}  # fmt: skip
"""A distributor of a train file in position R, with two stages of pressure."""


def parabola(slip, speed, load, mu0):
    """A creep curve whose peak is known: adhesion mu0 at 5 % slip, whatever the speed."""
    return mu0 * (1 - ((slip - 0.05) / 0.95) ** 2)


def uniform_stop(speed=20.0, deceleration=1.0, period=0.01, estimates=True, end_speed=0.0, **changes):
    """The trace of uniform braking at slip 0.05; `changes` replace signals (broadcast to their shape)."""
    time = np.arange(round((speed - end_speed) / deceleration / period) + 1) * period
    v = speed - deceleration * time
    signals = {
        "distance": speed * time - deceleration * time**2 / 2,
        "speed": v,
        "acceleration": np.full_like(time, -deceleration),
        "slip": 0.05,
        "wheelset_speed": (0.95 * v / RADIUS)[:, None],
        "adhesion": deceleration / 9.81,
        "group_adhesion": deceleration / 9.81,
        "wheelset_load": LOAD,
        "cylinder_pressure": 2e5,
        "pad_friction": 0.35,
        "disc_temperature": 300.0,
        "kinetic_energy": 1e6 * v**2,
        "pad_heat": 1e6 * (speed**2 - v**2),
        "mu0": 0.12,
        "locked": 0.0,
    }
    if estimates:
        signals |= {
            "estimate_speed": v,
            "estimate_slip": 0.05,
            "estimate_adhesion": deceleration / 9.81,
            "estimate_adhesion_sd": 0.01,
            "estimate_pad_friction": 0.35,
            "estimate_pad_friction_sd": 0.01,
            "estimate_nis": 2 * gammaincinv(17 / 2, 0.5),
            "estimate_readings": 17.0,
        }
    signals |= changes
    table = (*PLANT, *PLANT_INPUTS, *READINGS, *(ESTIMATES if estimates else ()))
    blocks = {}
    for signal in table:
        values = np.asarray(signals.get(signal.name, 0.0), dtype=float)
        if values.ndim == 1 and values.shape == time.shape:
            values = values[:, None]
        blocks[signal] = np.array(np.broadcast_to(values, (len(time), TWO_PART_TRAIN.width(signal.extent))))
    return trace_of(blocks, TWO_PART_TRAIN, period)


def stop_of(scenario, deceleration=1.0, outcome=Outcome.STANDSTILL, reason="the train stands"):
    """The result of a scenario with uniform braking at the friction of the scenario."""
    period = scenario.periods.communication
    trace = uniform_stop(scenario.start.speed, deceleration, period, scenario.estimator.kind != "none")
    trace["mu0"].values[:] = profile_of(scenario, TWO_PART_TRAIN).table(trace["time"].values, trace["distance"].values)
    trace = with_bound(trace, parabola, BRAKES, scenario.limits.alpha_max)
    return Stop.of(
        scenario,
        trace,
        outcome=outcome,
        reason=reason,
        metrics=measure(trace, outcome=outcome, alpha_max=scenario.limits.alpha_max, actuation=scenario.actuation.kind),
        versions={"railgrip": "0"},
        fmus={"Plant.fmu": "0" * 64},
    )


def of_scenario(stop, scenario):
    """The stop as if it were that of another scenario."""
    return replace(stop, parsed=scenario, inputs=scenario.resolved(), digest=scenario.digest())
