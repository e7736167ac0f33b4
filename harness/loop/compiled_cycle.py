"""The compiled engine: the stop of `cycle.run` in C, to the same bits, when every party can be called from there."""

import ctypes
import math
from collections.abc import Callable
from functools import cache
from typing import Any, Protocol, runtime_checkable

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from railgrip.loop.actuation import Direct
from railgrip.loop.ending import Ending, divergence, horizon, implausibility, standstill, without_command
from railgrip.loop.library import address_of, kernel
from railgrip.loop.parties import Parties
from railgrip.loop.plausible import Plausibility
from railgrip.loop.ports import CInterface, FilterInC, PlantInC
from railgrip.loop.rail import TabulatedRail
from railgrip.loop.sensors import BLOCK, IdealSensors, ServiceSensors, WhiteSensors
from railgrip.loop.watch import NEGATIVE, StateEstimator, complete
from railgrip.signals import BELIEVED, INNOVATION, SPREAD, Layout, length, places

Vector = NDArray[np.float64]

_GOING, _STANDING, _PLANT_FAILED, _DIVERGED, _NO_COMMAND, _IMPLAUSIBLE = range(6)
_NEGATIVE_VARIANCE = -1


@runtime_checkable
class FormulaInC(Protocol):
    """A law or valve logic as `railgrip.controllers.sampled.Sampled`.

    C works on its `state` and reads its `parameters`.
    """

    state: Vector
    parameters: Vector

    @property
    def step(self) -> ca.Function:
        """(state, input, parameter) → (state, output)."""
        ...


_BELIEF = {"believed": BELIEVED, "spread": SPREAD, "innovation": INNOVATION}


class _Formula(ctypes.Structure):
    _fields_ = tuple((name, ctypes.c_void_p) for name in ("call", "state", "parameter"))


@cache
def cycle_struct(layout: Layout) -> type[ctypes.Structure]:
    """Return the struct `Cycle` of cycle.c for vectors of this layout."""
    vectors = {
        "truth": layout.outputs, "inputs": layout.inputs, "latest": layout.readings, "fresh": layout.readings,
        **{name: length(places(block, layout.formation)) for name, block in _BELIEF.items()},
        "reference": 1 + layout.formation.groups, "command": layout.formation.groups, "demand": layout.formation.groups,
        "driver_demand": layout.formation.groups,
    }  # fmt: skip

    class Cycle(ctypes.Structure):
        _fields_ = (
            *((name, ctypes.c_void_p) for name in ("cross", "set_step_get", "taken", "shown")),
            *((name, ctypes.c_void_p) for name in ("present", "slip_radius")),
            *((name, ctypes.c_void_p) for name in ("service", "read_of", "gain", "bias", "noise")),
            *((name, ctypes.c_void_p) for name in ("advance", "block", "held", "seen")),
            *((name, ctypes.c_void_p) for name in ("mean", "covariance", "squared", "used")),
            *((name, ctypes.c_void_p) for name in ("seen_of", "believed_of", "law_of", "radius")),
            *((name, _Formula) for name in ("law", "valves", "free_wheel")),
            *((name, ctypes.c_void_p) for name in ("plausibility", "rail", "driver", "full", "faults")),
            *((name, ctypes.c_double) for name in ("period", "stop_speed")),
            ("rows", ctypes.c_void_p),
            *((name, ctypes.c_double * size) for name, size in vectors.items()),
            *((name, ctypes.c_longlong) for name in ("present_count", "width", "capacity")),
            *(
                (name, ctypes.c_longlong)
                for name in ("seen_count", "sensors_every", "estimator_every", "controller_every", "row")
            ),
            *((name, ctypes.c_longlong) for name in ("true_at", "sent_at", "read_at", "believed_at", "spread_at")),
            *((name, ctypes.c_longlong) for name in ("innovation_at", "demand_at", "driver_at", "traction_at")),
            *((name, ctypes.c_longlong) for name in ("reference_at", "law_at", "law_count")),
            *(
                (name, ctypes.c_longlong)
                for name in ("any", "news", "crossed", "sample", "written", "failure", "moved")
            ),
        )

    return Cycle


def obstacle(parties: Parties) -> str | None:
    """Return which party cannot be called from C, and why; None when all can."""
    sensors, state_estimator = parties.sensors, parties.state_estimator
    controller, actuation = parties.controller, parties.actuation
    if not isinstance(parties.plant, PlantInC):
        return "the plant is not called in this process"
    if not isinstance(sensors, IdealSensors | WhiteSensors | ServiceSensors):
        return "the sensors are Python"
    if state_estimator is not None and not (
        isinstance(state_estimator, StateEstimator) and isinstance(state_estimator.filter, FilterInC)
    ):
        return "the estimator is not a compiled filter"
    if not isinstance(controller, FormulaInC):
        return "the controller is Python, not a formula"
    if not isinstance(actuation, Direct | FormulaInC):
        return "the actuation is Python, not a formula"
    # In C the vectors of both have the lengths that cycle.c gives them. A law is shown speed and acceleration, and of
    # each group slip, adhesion, pad friction, wheelset speed, and the demanded and read pressure.
    groups = parties.layout.formation.groups
    for who, formula, takes in (("controller", controller, 2 + 6 * groups), ("actuation", actuation, 2 * groups)):
        if isinstance(formula, FormulaInC) and (formula.step.numel_in(1), formula.step.numel_out(1)) != (takes, groups):
            return f"the {who} is not for {groups} groups"
    return None


def run(parties: Parties, progress: Callable[[float], None] | None = None) -> Ending:
    """Brake until the train stands, the horizon is reached, or a party fails; arguments as for `cycle.run`.

    `progress` is called after every `BLOCK` samples, which is also how long Ctrl-C waits.

    Raises:
        PlantFailed: The plant refused a step; `recorder` holds the rows before.
        TypeError: There is an `obstacle`.
    """
    if (reason := obstacle(parties)) is not None:
        raise TypeError(f"the loop in C cannot run this: {reason}")
    layout, plant, rail, sensors = parties.layout, parties.plant, parties.rail, parties.sensors
    state_estimator, clock, recorder = parties.state_estimator, parties.clock, parties.recorder
    assert isinstance(plant, PlantInC)
    inputs = np.zeros(layout.inputs)
    rail.lay(inputs)
    truth = plant.start(inputs)
    rail.meet(truth)
    parts = _Parts(parties, plant.c_interface())
    state = parts.struct
    state.truth[:], state.inputs[:] = truth.tolist(), inputs.tolist()
    cycle, address = kernel(layout).cycle, ctypes.addressof(state)
    at_speed, at_distance = layout.output["speed"].start, layout.output["distance"].start
    outcome = _GOING
    try:
        for first in range(0, clock.samples + 1, BLOCK):
            if isinstance(sensors, WhiteSensors | ServiceSensors) and first % (BLOCK * clock.sensors) == 0:
                sensors.draw()
            before = state.crossed
            outcome = cycle(address, min(first + BLOCK, clock.samples + 1))
            plant.note_steps(state.crossed - before, state.failure if outcome == _PLANT_FAILED else 0)
            if outcome != _GOING:
                break
            if progress is not None:
                progress(state.truth[at_speed])
    finally:
        recorder.written = min(state.written, len(recorder.rows))
        if isinstance(state_estimator, StateEstimator):
            complete(recorder.rows[: recorder.written], recorder, state_estimator)
    time, distance, speed = state.sample * clock.period, state.truth[at_distance], state.truth[at_speed]
    if outcome == _STANDING:
        return standstill(distance, time, state.written)
    if outcome == _IMPLAUSIBLE:
        return implausibility(parts.plausibility.reason(time), state.written)
    if outcome == _DIVERGED:
        return divergence(parts.failure(), time, state.written)
    if outcome == _NO_COMMAND:
        return without_command(tuple(state.command), time, state.written)
    return horizon(speed, distance, clock, state.written)


class _Parts:
    """The argument of the cycle in C, and everything it points to."""

    def __init__(self, parties: Parties, plant: CInterface) -> None:
        layout, sensors, state_estimator, law = parties.layout, parties.sensors, parties.state_estimator, parties.law
        rail, driver, faults, recorder = parties.rail, parties.driver, parties.faults, parties.recorder
        clock = parties.clock
        self.plausibility = Plausibility.before(clock.period, parties.start_speed, parties.slowing)
        assert isinstance(rail, TabulatedRail)
        assert isinstance(sensors, IdealSensors | WhiteSensors | ServiceSensors)
        self._keep: list[Any] = [parties, plant]
        service = ctypes.addressof(sensors.struct) if isinstance(sensors, ServiceSensors) else None
        read_of = None if isinstance(sensors, ServiceSensors) else self._places(sensors.places)
        self.struct: Any = cycle_struct(layout)(
            cross=plant.cross, set_step_get=plant.plan, taken=self._at(plant.inputs), shown=self._at(plant.outputs),
            present=self._places(plant.present), present_count=plant.present.size,
            slip_radius=None if plant.slip_radius is None else self._at(plant.slip_radius),
            service=service, read_of=read_of, radius=self._at(np.array(parties.wheel_radius)),
            rail=ctypes.addressof(rail.struct), driver=ctypes.addressof(driver.struct) if driver.has_phases else None,
            full=self._at(driver.pressure), faults=ctypes.addressof(faults.struct) if faults is not None else None,
            law=self._formula(parties.controller), valves=self._formula(parties.actuation),
            free_wheel=self._formula(None if state_estimator is None else getattr(state_estimator, "free_wheel", None)),
            plausibility=ctypes.addressof(self.plausibility), period=clock.period, stop_speed=parties.stop_speed,
            sensors_every=clock.sensors, estimator_every=clock.estimator, controller_every=clock.controller,
            rows=self._at(recorder.rows), width=recorder.rows.shape[1], capacity=recorder.rows.shape[0],
            true_at=recorder.block(layout.plant_signals).start, sent_at=recorder.block(layout.sent_signals).start,
            read_at=recorder.block(layout.reading_signals).start, demand_at=recorder.at.get("demand", -1),
            driver_at=recorder.at["driver_demand"] if driver.has_phases else -1,
            traction_at=recorder.at.get("traction", -1), reference_at=recorder.at.get("reference_speed", -1),
        )  # fmt: skip
        struct = self.struct
        struct.reference[0] = math.nan
        if law is not None:
            struct.law_of, struct.law_count = self._places(law.places), law.places.size
            struct.law_at = recorder.block(law.signals).start
        if isinstance(sensors, WhiteSensors):
            struct.gain, struct.bias, struct.noise = (
                self._at(part) for part in (sensors.gain, sensors.bias, sensors.noise)
            )
        self._filter = filter_ = state_estimator.filter if isinstance(state_estimator, StateEstimator) else None
        if isinstance(state_estimator, StateEstimator) and isinstance(filter_, FilterInC):
            struct.advance, struct.block, struct.squared = filter_.entry
            parts = filter_.inputs, filter_.readings, filter_.selection
            struct.held, struct.seen, struct.used = (self._at(part) for part in parts)
            struct.mean, struct.covariance = self._at(filter_.mean), self._at(filter_.covariance)
            struct.row = filter_.covariance.strides[0] // filter_.covariance.itemsize
            struct.seen_of, struct.seen_count = (
                self._places(state_estimator.reading_places),
                state_estimator.reading_places.size,
            )
            places = state_estimator.wheelset_speed, state_estimator.adhesion, state_estimator.pad_friction
            struct.believed_of = self._places(np.concatenate([[state_estimator.speed], *places]))
            struct.radius = self._at(np.array(state_estimator.wheel_radius))
            struct.believed_at, struct.spread_at, struct.innovation_at = (
                recorder.block(block).start for block in (BELIEVED, SPREAD, INNOVATION)
            )

    def _at(self, array: NDArray[Any]) -> int:
        self._keep.append(array)
        return array.ctypes.data

    def _places(self, places: NDArray[Any]) -> int:
        return self._at(np.ascontiguousarray(places, dtype=np.longlong))

    def failure(self) -> str:
        """Return what the number means by which the estimator failed."""
        assert isinstance(self._filter, FilterInC)
        return NEGATIVE if self.struct.failure == _NEGATIVE_VARIANCE else self._filter.failure(self.struct.failure)

    def _formula(self, formula: object) -> _Formula:
        if not isinstance(formula, FormulaInC):
            return _Formula()
        return _Formula(
            call=address_of(formula.step), state=self._at(formula.state), parameter=self._at(formula.parameters)
        )
