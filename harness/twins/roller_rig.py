"""The roller rig: a braked wheelset on a roller, its wheel-slide protection, and what load cells and encoders show."""

import math

import numpy as np
import xarray
from numpy.typing import NDArray

from railgrip.controllers.brake import BrakeGroup
from railgrip.controllers.observation import Observation
from railgrip.controllers.slip_based import SlipBased, SlipLevels
from railgrip.controllers.tuning import VALVE_BAND, VALVE_PULSE_MIN
from railgrip.controllers.valves import ValveLogic, ValveModel
from railgrip.scenario.seed import generator
from railgrip.trace.samples import reading_of, recording_of
from railgrip.twins.plant import defaults, parameters, plant
from railgrip.twins.rig_scenario import RigScenario

Vector = NDArray[np.float64]

PLANT = "RollerRig"
INPUTS = {"valve_command": "1", "mu0": "1"}
OUTPUTS = {
    "speed": "m/s",
    "wheelset_speed": "rad/s",
    "slip": "1",
    "adhesion": "1",
    "contact_force": "N",
    "wheelset_load": "N",
    "cylinder_pressure": "Pa",
    "pad_force": "N",
    "pad_friction": "1",
    "disc_temperature": "K",
}
_AT = {name: place for place, name in enumerate(OUTPUTS)}
READINGS = ("wheelset_speed", "speed", "pad_force", "contact_force", "wheelset_load")


def run_rig(scenario: RigScenario, seed: int | None = None) -> xarray.Dataset:
    """Return the recording of a run on the rig, from its start to the stop or the horizon.

    Beside the readings it holds `demand` [Pa], what the driver asks for, and `protecting` (0 or 1), whether the
    protection keeps the brake from giving it.

    Args:
        scenario: Of the run.
        seed: Of surface and sensors, the scenario's when None.

    Raises:
        EstimationError: The plant has no such parameter.
        PlantFailed: The plant refused a step.
    """
    drawn = scenario.seed if seed is None else seed
    steps = math.floor(scenario.horizon / scenario.period + 1e-9)
    time: Vector = np.arange(steps + 1, dtype=np.float64) * np.float64(scenario.period)
    mu0 = _friction(scenario, time, generator(drawn, "rig.surface"))
    demand = _steps(scenario.demand, time)
    protection = _Protection(scenario)
    noise = generator(drawn, "rig.sensors").standard_normal((steps + 1, len(READINGS)))
    noise *= [getattr(scenario.sensors, name) for name in READINGS]
    truth = np.empty((steps + 1, len(OUTPUTS)))
    protecting = np.zeros(steps + 1)
    inputs = np.array([0.0, mu0[0]])
    taken = [_AT[name] for name in READINGS]
    last = steps
    with plant(PLANT, inputs=INPUTS, outputs=OUTPUTS, period=scenario.period, parameters=_values(scenario)) as rig:
        truth[0] = rig.start(inputs)
        for k in range(steps + 1):
            if k > 0:
                truth[k] = rig.step(inputs)
            row = truth[k]
            if row[_AT["speed"]] <= scenario.stop_speed:
                last = k
                break
            seen = row[taken] + noise[k]
            if k % protection.every == 0:
                inputs[0] = protection.command(
                    time[k], float(seen[1]), float(seen[0]), float(row[_AT["cylinder_pressure"]]), float(demand[k])
                )
            protecting[k] = float(protection.releases and demand[k] > 0.0)
            if k < steps:
                inputs[1] = mu0[k + 1]
    kept = slice(0, last + 1)
    readings = truth[kept][:, taken] + noise[kept]
    signals = {name: (readings[:, i], OUTPUTS[name]) for i, name in enumerate(READINGS)}
    signals |= {"demand": (demand[kept], "Pa"), "protecting": (protecting[kept], "1")}
    told = {
        "w": "wheelset_speed",
        "v": "speed",
        "mu_b": "pad_friction",
        "alpha": "adhesion",
        "slip": "slip",
        "disc_temperature": "disc_temperature",
    }
    return recording_of(
        signals,
        period=scenario.period,
        truth={state: (truth[kept, _AT[name]], OUTPUTS[name]) for state, name in told.items()},
        name=scenario.name,
    )


def measured_adhesion(recording: xarray.Dataset) -> Vector:
    """Return the adhesion that the load cells show: force along the track over load."""
    return reading_of(recording, "contact_force") / reading_of(recording, "wheelset_load")


class _Protection:
    """Driver's demand, slip-based control above it, and the valves."""

    def __init__(self, scenario: RigScenario) -> None:
        values = defaults(PLANT) | _values(scenario)
        self._group = _brake(values)
        its = scenario.protection
        self.every = max(round(its.period / scenario.period), 1)
        self._law = SlipBased(
            (self._group,), SlipLevels(low=its.low, high=its.high, speed_min=its.speed_min, hold=False)
        )
        self._valves = ValveLogic(
            (self._group.pressure_max,),
            ValveModel(
                period=self.every * scenario.period,
                dead_time=0.5 * (values["dead_fill"] + values["dead_vent"]),
                fill_time=values["T_fill"],
                vent_time=values["T_vent"],
                band=VALVE_BAND,
                pulse_min=VALVE_PULSE_MIN,
            ),
        )
        self._radius = values["r_wheel"]
        self.releases = False

    def command(self, time: float, speed: float, wheel: float, pressure: float, demand: float) -> float:
        """Return the valve command for readings of speed [m/s] and wheel [rad/s], pressure and demand [Pa]."""
        slip = 1.0 - self._radius * wheel / speed if speed > 0.05 else 0.0
        wheels, slips, pressures = np.array([[wheel], [slip], [pressure]])
        observation = Observation(time, speed, 0.0, wheels, slips, False, None, None, pressures, pressures)
        allowed = self._law.decide(observation)[0]
        self.releases = allowed < self._group.pressure_max
        return self._valves.command((min(allowed, demand),), (pressure,))[0]


def _brake(values: dict[str, float]) -> BrakeGroup:
    return BrakeGroup(
        load=values["load"],
        inertia=values["J"],
        wheel_radius=values["r_wheel"],
        units=values["n_units"],
        friction_radius=values["r_friction"],
        piston_area=values["A_piston"],
        rigging=values["i_rigging"] * values["eta_rigging"],
        spring_force=values["F_spring"],
        pressure_max=values["p_max"],
    )


def _values(scenario: RigScenario) -> dict[str, float]:
    """Return the plant's parameters where the scenario sets them."""
    surface = scenario.surface
    contact = {name: getattr(surface, name) for name in ("k_A", "k_S", "A_falling", "B_falling")}
    written = parameters(PLANT, scenario.parameters, f"{scenario.name}: [parameters]")
    return contact | {"speed_start": scenario.speed_start} | written


def _friction(scenario: RigScenario, time: Vector, random: np.random.Generator) -> Vector:
    """Return the maximum friction at every instant: the points of the surface, with scatter that fades in memory.

    The scatter is a first-order Gauss-Markov process relative to the level, stationary from the first sample on.
    """
    surface = scenario.surface
    level = np.interp(time, *np.array(surface.mu0).T)
    keeps = math.exp(-scenario.period / surface.scatter_time)
    draws = random.standard_normal(time.size) * math.sqrt(1.0 - keeps**2)
    wander, value = np.empty(time.size), float(random.standard_normal())
    for k, draw in enumerate(draws):
        value = keeps * value + float(draw)
        wander[k] = value
    # Beyond three deviations friction would leave what the liquid on the roller can make of it.
    return level * (1.0 + surface.scatter * np.clip(wander, -3.0, 3.0))


def _steps(points: list[tuple[float, float]], time: Vector) -> Vector:
    """Return at every instant the value of the last point, zero before the first."""
    times, values = np.array(points).T
    place = np.searchsorted(times, time + 1e-9, side="right") - 1
    return np.where(place >= 0, values[np.maximum(place, 0)], 0.0)
