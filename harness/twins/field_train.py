"""The train of the field test: driven along a laid track, braked, and measured.

The plant is `TwoPartTrainPneumatic`; its valves fill and stay open, there is no wheel-slide protection. It has no
drive: traction is a force on the body beside that of the track, so that while driving the wheelsets roll freely.
The train is a point for gradient and curve, at its middle, where the GNSS antenna is. Groups are counted from the
leading end in either direction; the two motor bogies are alike.
"""

import math
from dataclasses import dataclass

import numpy as np
import xarray
from numpy.typing import NDArray

from railgrip.errors import EstimationError
from railgrip.scenario.seed import generator
from railgrip.scenario.track import force_along
from railgrip.trace.samples import recording_of
from railgrip.track.laid import Plan
from railgrip.twins.field_scenario import Case, FieldScenario, Patch, SensorTable
from railgrip.twins.plant import parameters, plant

Vector = NDArray[np.float64]

PLANT = "TwoPartTrainPneumatic"
GROUPS, WHEELSETS, ACCELEROMETERS = 4, 6, 4
INPUTS = {"valve_command": ("1", GROUPS), "mu0": ("1", WHEELSETS), "track_force": "N"}
OUTPUTS = {
    "distance": "m",
    "speed": "m/s",
    "acceleration": "m/s2",
    "wheelset_speed": ("rad/s", GROUPS),
    "group_adhesion": ("1", GROUPS),
    "slip": ("1", GROUPS),
    "pad_friction": ("1", GROUPS),
    "cylinder_pressure": ("Pa", GROUPS),
}
_AT: dict[str, slice] = {}
for _name, _told in OUTPUTS.items():
    _from = sum(place.stop - place.start for place in _AT.values())
    _AT[_name] = slice(_from, _from + (1 if isinstance(_told, str) else _told[1]))

WHEELSET_AHEAD = (16.95, 15.05, 1.325, -1.325, -15.05, -16.95)
"""Of the middle of the train [m]: pivots 16 m apart, wheelbases 1.9 and 2.65 m (table 3 of the paper)."""

STOPPED = 0.3
"""Speed that counts as the end of a run [m/s]: below it the prediction, which brakes on and on, would go backwards."""

LONGEST = 300.0
"""A run that has not stopped by then [s] will not."""


def run_case(scenario: FieldScenario, name: str, seed: int | None = None) -> xarray.Dataset:
    """Return the recording of one case, from rest to the stop.

    Readings: `speed` (optical), `wheelset_speed[i]`, `cylinder_pressure[i]`, `acceleration_along[i]` of four sensors,
    which feel g sin β too, `latitude`, `longitude` [deg] and `height` [m] by GNSS, NaN between its samples, and
    `driving` and `braking` (0 or 1), what the driver asked for. Truth: states of the prediction, `distance`, `slip[i]`,
    `acceleration`, `place` on the track [m], `slope` and `curvature` in the direction of travel, and `track_force`.

    Args:
        scenario: The field test.
        name: Of the case.
        seed: Of the sensors, the scenario's when None.

    Raises:
        EstimationError: No such case, the train leaves its track or never stops, or the plant lacks a parameter.
        PlantFailed: The plant refused a step.
    """
    return measured(scenario, driven(scenario, name), seed)


@dataclass(frozen=True, slots=True, kw_only=True)
class Driven:
    """One case as it was, before anybody measured it.

    Attributes:
        case: Name.
        truth: Outputs of the plant at every sample, shape (k, outputs).
        did: Track force [N], driving and braking, shape (k, 3).
    """

    case: str
    truth: Vector
    did: Vector


def driven(scenario: FieldScenario, name: str) -> Driven:
    """Return a case driven once, for sensors of any seed.

    Raises:
        EstimationError: See `run_case`.
        PlantFailed: The plant refused a step.
    """
    case = scenario.case(name)
    track = scenario.track.laid()
    driver = _Driver(scenario, case)
    way = 1.0 if case.direction == "fw" else -1.0
    each = round(scenario.period / scenario.step)
    truth: list[Vector] = []
    did: list[tuple[float, float, float]] = []
    inputs = np.zeros(GROUPS + WHEELSETS + 1)
    inputs[GROUPS:-1] = scenario.surface.mu0
    inputs[-1] = float(force_along(way * track.slope(case.start), 0.0, scenario.train.mass)) + scenario.train.traction
    values = _values(scenario, case)
    with plant(PLANT, inputs=INPUTS, outputs=OUTPUTS, period=scenario.step, parameters=values) as train:
        row = train.start(inputs)
        for k in range(math.ceil(LONGEST / scenario.step)):
            travelled, speed = float(row[0]), float(row[1])
            place = case.start + way * travelled
            if not 0.0 <= place <= track.length:
                raise EstimationError(
                    f"{scenario.name}: case {name} leaves its track at {place:.0f} m; move its start or lay more."
                )
            slope, bend = way * float(track.slope(place)), float(track.curvature(place))
            resistance = float(force_along(slope, bend, scenario.train.mass, scenario.track.curve_law))
            driver.look(k * scenario.step, travelled, speed)
            if k % each == 0:
                truth.append(row)
                did.append((resistance, float(driver.drives), float(driver.brakes)))
            if driver.brakes and speed <= STOPPED:
                break
            inputs[:GROUPS] = 1.0 if driver.brakes else -1.0
            inputs[GROUPS:-1] = driver.friction(travelled)
            inputs[-1] = resistance + driver.traction
            row = train.step(inputs)
        else:
            raise EstimationError(f"{scenario.name}: case {name} did not stop within {LONGEST:g} s.")
    return Driven(case=name, truth=np.array(truth), did=np.array(did))


class _Driver:
    """Drives, coasts, drives up to a little more than the speed of the test, coasts down to it, and brakes."""

    def __init__(self, scenario: FieldScenario, case: Case) -> None:
        self._train, self._case, self._step = scenario.train, case, scenario.step
        self._dry = np.full(WHEELSETS, scenario.surface.mu0)
        self._reached = False
        self._braked_at = math.inf
        self.drives = self.brakes = False
        self.traction = 0.0

    def look(self, time: float, travelled: float, speed: float) -> None:
        """Decide for a step that begins at `time` [s], `travelled` [m], at `speed` [m/s]."""
        train = self._train
        self._reached = self._reached or speed >= self._case.speed + train.margin
        self.drives = not self._reached and (time < train.first_drive or time >= train.second_drive)
        wanted = min(train.traction, train.power / max(speed, 1.0)) if self.drives else 0.0
        change = train.traction_rate * self._step
        self.traction += min(max(wanted - self.traction, -change), change)
        if not self.brakes and self._reached and speed <= self._case.speed:
            self.brakes, self._braked_at = True, travelled

    def friction(self, travelled: float) -> Vector:
        """Return the maximum friction at each wheelset, shape (6,)."""
        patch = self._case.patch
        if patch is None or not self.brakes:
            return self._dry
        into = travelled + np.array(WHEELSET_AHEAD) - (self._braked_at + WHEELSET_AHEAD[0] + patch.after)
        found = np.where(np.arange(WHEELSETS) < 2, patch.mu0, patch.cleaned)
        return self._dry + (found - self._dry) * _within(patch, into)


def _within(patch: Patch, into: Vector) -> Vector:
    """Return 1 inside a patch, 0 outside, straight between over its edges."""
    return np.clip(np.minimum(into, patch.length - into) / patch.edge, 0.0, 1.0)


def measured(scenario: FieldScenario, run: Driven, seed: int | None = None) -> xarray.Dataset:
    """Return the recording of a run by sensors of a seed, the scenario's when None; see `run_case`."""
    name, truth, did = run.case, run.truth, run.did
    case, sensors = scenario.case(name), scenario.sensors
    way = 1.0 if case.direction == "fw" else -1.0
    track = scenario.track.laid()
    distance, speed, acceleration = (truth[:, i] for i in range(3))
    place = case.start + way * distance
    slope, curvature = way * track.slope(place), way * track.curvature(place)
    count = len(truth)
    random = generator(scenario.seed if seed is None else seed, f"field.{name}")
    felt = acceleration + 9.81 * slope / np.sqrt(1.0 + slope**2)
    signals: dict[str, tuple[Vector, str]] = {
        "speed": (
            speed * (1.0 + sensors.speed_scale * random.standard_normal())
            + sensors.speed * random.standard_normal(count),
            "m/s",
        ),
        "driving": (did[:, 1], "1"),
        "braking": (did[:, 2], "1"),
    }
    for output, sd, unit in (
        ("wheelset_speed", sensors.wheelset_speed, "rad/s"),
        ("cylinder_pressure", sensors.pressure, "Pa"),
    ):
        noisy = truth[:, _AT[output]] + sd * random.standard_normal((count, GROUPS))
        signals |= {f"{output}[{i + 1}]": (noisy[:, i], unit) for i in range(GROUPS)}
    for i in range(ACCELEROMETERS):
        bias = sensors.acceleration_bias * random.standard_normal()
        noise = sensors.acceleration * random.standard_normal(count)
        signals[f"acceleration_along[{i + 1}]"] = (felt + bias + noise, "m/s2")
    signals |= _gnss(sensors, track.plan(), place, scenario.period, random)
    told: dict[str, tuple[Vector, str]] = {
        "v": (speed, "m/s"),
        "distance": (distance, "m"),
        "acceleration": (acceleration, "m/s2"),
        "place": (place, "m"),
        "slope": (slope, "1"),
        "curvature": (curvature, "m-1"),
        "track_force": (did[:, 0], "N"),
    }
    for state, output, unit in (
        ("w", "wheelset_speed", "rad/s"),
        ("mu_b", "pad_friction", "1"),
        ("alpha", "group_adhesion", "1"),
        ("slip", "slip", "1"),
    ):
        told |= {f"{state}[{i + 1}]": (truth[:, _AT[output]][:, i], unit) for i in range(GROUPS)}
    return recording_of(signals, period=scenario.period, truth=told, name=f"{scenario.name} {name}")


def _gnss(
    sensors: SensorTable, plan: Plan, place: Vector, period: float, random: np.random.Generator
) -> dict[str, tuple[Vector, str]]:
    """Return latitude, longitude and height as the receiver gives them, NaN where it gives none."""
    each = round(sensors.gnss_every / period)
    at = np.arange(0, place.size, each)
    exact = plan.positions(place[at])
    keeps = math.exp(-sensors.gnss_every / sensors.gnss_wander_time)
    wander = np.empty((at.size, 3))
    wander[0] = random.standard_normal(3)
    for j in range(1, at.size):
        wander[j] = keeps * wander[j - 1] + math.sqrt(1.0 - keeps**2) * random.standard_normal(3)
    horizontal, high = sensors.gnss_horizontal_wander, sensors.gnss_height_wander
    error = wander * [horizontal, horizontal, high]
    white = [sensors.gnss_horizontal, sensors.gnss_horizontal, sensors.gnss_height]
    error += random.standard_normal((at.size, 3)) * white
    # A tenth of a metre in degrees: radii of the sphere are within 0.4 % of the ellipsoid's.
    metre = math.degrees(1.0 / 6.371e6)
    seen = np.full((place.size, 3), np.nan)
    seen[at] = exact + error * np.column_stack(
        [np.full(at.size, metre), metre / np.cos(np.radians(exact[:, 0])), np.ones(at.size)]
    )
    return {
        "latitude": (seen[:, 0], "deg"),
        "longitude": (seen[:, 1], "deg"),
        "height": (seen[:, 2], "m"),
    }


def _values(scenario: FieldScenario, case: Case) -> dict[str, float]:
    surface = scenario.surface
    contact = {name: getattr(surface, name) for name in ("k_A", "k_S", "A_falling", "B_falling")}
    written = parameters(PLANT, scenario.train.parameters, f"{scenario.name}: [train] parameters")
    return contact | {"speed_start": 0.0, "T_fill": scenario.train.fill_time[case.brake]} | written
