"""The loop: a stop in C, which returns to Python whenever a part written in Python is due.

`structs_of` writes the parts of a stop into the structs of `kernel/cycle.h`.
"""

import ctypes
from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import casadi as ca
import numpy as np

from railgrip.base.arrays import Vector
from railgrip.base.errors import ControllerFailed, EstimatorFailed, LoopError, SensorsFailed
from railgrip.controllers.observation import Observation
from railgrip.controllers.sampled import Sampled
from railgrip.estimators.compiled import StepInC
from railgrip.fmi import CoSimulation
from railgrip.fmus.native.c_source import in_c
from railgrip.fmus.native.toolchain import FAST_BUILD, Struct, shared_library
from railgrip.kernel import kernel, rate_of, texts
from railgrip.scenario.outcome import Outcome
from railgrip.simulate.loop.interfaces import BLOCK, DirectEstimator, LoopSensors, Parts, SensorsInC, StateEstimator
from railgrip.vehicle.brake import slip_of
from railgrip.vehicle.signals import (
    DEVIATIONS,
    ESTIMATED_STATES,
    ESTIMATES,
    OBSERVATION,
    ONLY_ESTIMATED,
    Layout,
    Role,
    length,
    places,
)


@dataclass(frozen=True, slots=True, eq=False)
class Structs:
    """Structs of a stop, each named for its type in cycle.h.

    Attributes:
        filter: None without a filter.
    """

    cycle: Struct
    plant: Struct
    instruments: Struct
    filter: Struct | None
    onboard: Struct
    record: Struct


def structs_of(parts: Parts, inputs: Vector, outputs: Vector) -> Structs:
    """Return the structs of a stop; the functions of parts in Python are null pointers.

    Args:
        parts: Parts of the stop; the plant has been started.
        inputs: Inputs with which the plant has been started.
        outputs: Outputs at the start.

    Raises:
        LoopError: A law is for a different number of groups.
    """
    clock = parts.clock
    plant, instruments, filter_ = _plant(parts, inputs, outputs), _instruments(parts), _filter(parts)
    onboard, record = _onboard(parts), _record(parts)
    cycle = kernel(parts.layout).struct("Cycle", plant=plant, plausibility=parts.plausibility.struct,
        rail=parts.rail.struct, driver=parts.driver and parts.driver.struct, instruments=instruments,
        faults=parts.faults and parts.faults.struct, filter=filter_, onboard=onboard, record=record,
        period=clock.period, stop_speed=parts.stop_speed, samples=clock.samples, block=BLOCK,
    )  # fmt: skip
    return Structs(cycle, plant, instruments, filter_, onboard, record)


def _plant(parts: Parts, inputs: Vector, outputs: Vector) -> Struct:
    layout, plant = parts.layout, parts.plant
    # A plant without slip outputs leaves NaN there; the cycle then computes slip from speed and wheel speed.
    has_slip = not np.isnan(outputs[layout.output["slip"]]).any()
    radius = None if has_slip else np.array(layout.formation.wheel_radius, dtype=np.float64)
    if not isinstance(plant, CoSimulation):
        return kernel(layout).struct("Plant", inputs=inputs, outputs=outputs, slip_radius=radius)
    plant.inputs[:] = inputs
    return kernel(layout).struct("Plant", step=plant.entry, interface=plant.plan, inputs=plant.inputs,
        outputs=plant.outputs, slip_radius=radius,
    )  # fmt: skip


def _instruments(parts: Parts) -> Struct:
    fields = parts.sensors.fields if isinstance(parts.sensors, SensorsInC) else dict[str, object]()
    return kernel(parts.layout).struct("Instruments", every=parts.clock.sensors, block=BLOCK, **fields)


def _filter(parts: Parts) -> Struct | None:
    layout, estimator = parts.layout, parts.estimator
    if not isinstance(estimator, StateEstimator):
        return None
    filter_ = estimator.filter
    reference = np.zeros(length(layout.places["reference"]))
    reference[layout.places["reference"]["speed"]] = np.nan
    states = [getattr(estimator, signal.name.removeprefix("estimate_")) for signal in ESTIMATED_STATES]
    struct = kernel(layout).struct("Filter", mean=filter_.mean, covariance=filter_.covariance,
        stride=filter_.covariance.strides[0] // filter_.covariance.itemsize, inputs=filter_.inputs,
        readings=filter_.readings, selection=filter_.selection, squared_innovation=np.zeros(1), reference=reference,
        reading_at=np.ascontiguousarray(estimator.reading_places, dtype=np.longlong),
        reading_count=estimator.reading_places.size, state_at=np.hstack(states).astype(np.longlong),
        reference_speed=_formula(layout, estimator.free_wheel, "reference_input"),
        body_force=_formula(layout, estimator.body_force, "body_force_input"), track_force=estimator.track_force,
    )  # fmt: skip
    if isinstance(filter_, StepInC):
        advance, memory, squared_innovation = filter_.entry
        struct.set(advance=advance, memory=memory, squared_innovation=squared_innovation)
    return struct


def _onboard(parts: Parts) -> Struct:
    layout, clock, estimator = parts.layout, parts.clock, parts.estimator
    has_states = isinstance(estimator, StateEstimator)
    return kernel(layout).struct("Onboard", law=_formula(layout, parts.controller, "observation"),
        train_level=_formula(layout, parts.train_level, "train_input"),
        valves=_formula(layout, parts.valves, "valve_input"),
        magnets=parts.controller.visible_state("magnets") if isinstance(parts.controller, Sampled) else None,
        maximum=parts.limits and parts.limits.maximum, full=np.array(parts.full, dtype=np.float64),
        radius=np.array(estimator.wheel_radius if has_states else parts.wheel_radius, dtype=np.float64),
        has_estimator=estimator is not None and not has_states,
        estimator_rate=rate_of(layout, clock.estimator), controller_rate=rate_of(layout, clock.controller),
    )  # fmt: skip


def _record(parts: Parts) -> Struct:
    layout, recorder, law = parts.layout, parts.recorder, parts.law
    first = {role: recorder.block(layout.signals[role]).start for role in ("output", "input", "reading")}
    first |= {name: recorder.at.get(name, -1) for name in ("demand", "driver_demand", "traction")}
    struct = kernel(layout).struct("Record", rows=recorder.rows, width=recorder.rows.shape[1],
        capacity=recorder.rows.shape[0], reference=recorder.at.get("reference_speed", -1), **first,
    )  # fmt: skip
    if isinstance(parts.estimator, StateEstimator):
        struct.set(estimate=recorder.block(ESTIMATES).start, estimate_count=length(layout.places["estimate"]))
    if law is not None:
        struct.set(law_state=law.values, law_state_at=law.places, law_count=law.places.size)
        struct.set(law=recorder.block(law.signals).start)
    return struct


def _formula(layout: Layout, formula: object, inputs: Role) -> Struct:
    """Return the struct `Formula`; its function is null if `formula` is not a sampled system.

    Raises:
        LoopError: The inputs of the formula are not the elements of the vector `inputs`, in the same order.
    """
    if not isinstance(formula, Sampled):
        return kernel(layout).struct("Formula")
    name, expected = formula.formula.name, layout.elements(inputs)
    found = tuple(variable.name for variable in formula.formula.inputs)
    if len(found) != len(expected):
        groups = layout.formation.groups
        raise LoopError(f"{name}: takes {len(found)} inputs, and {len(expected)} belong to {groups} groups.")
    for place, (element, signal) in enumerate(zip(found, expected, strict=True), start=1):
        if element != signal:
            raise LoopError(f"{name}: takes {element} as input {place}, which is {signal}.")
    address = _address_of(formula.step)
    return kernel(layout).struct("Formula", call=address, state=formula.state, parameter=formula.parameters)


@cache
def _address_of(step: ca.Function) -> int:
    """Return the address of `evaluate` in formula.c for a function (state, input, parameter) → (state, output).

    Raises:
        railgrip.base.errors.CompilerMissing: No C compiler was found.
    """
    sizes, text = in_c([step])
    macros = "".join(f"#define {name} {size}\n" for name, size in {"STATES": step.numel_out(0), **sizes}.items())
    header = f"{macros}#define CASADI_SYMBOL_EXPORT static\n{text}"
    sources = {"step.h": header} | texts("formula.c", "export.h")
    library = ctypes.CDLL(str(shared_library(sources, "formula", flags=FAST_BUILD)))
    return ctypes.cast(library.evaluate, ctypes.c_void_p).value or 0


@dataclass(frozen=True, slots=True, kw_only=True)
class Ending:
    """End of a run of the loop.

    Attributes:
        outcome: Kind of end.
        reason: Reason, in one sentence.
        samples: Number of rows written.
    """

    outcome: Outcome
    reason: str
    samples: int


class Loop:
    """One stop: it ends at standstill, at the horizon, or when a part fails in a way that is a result.

    The order of events in a sample is that of `kernel/cycle.c`. A caller may decide in place of a controller in Python:

        for observation in loop.decisions():
            loop.demand(pressures)

    Attributes:
        ending: End of the stop; None before.
        structs: Structs of `kernel/cycle.h`, on which the functions in C work.
    """

    def __init__(self, parts: Parts, progress: Callable[[float], None] | None = None) -> None:
        """Start the plant.

        Args:
            parts: Parts that have not been started.
            progress: Called with the train speed [m/s] every `BLOCK` samples, which is also the delay of Ctrl-C.

        Raises:
            PlantFailed: The plant did not start.
            ScenarioError: The plant lacks outputs that the rail depends on.
            LoopError: A law is for a different number of groups.
        """
        self.ending: Ending | None = None
        self._parts, self._progress = parts, progress
        layout, estimator = parts.layout, parts.estimator
        self._functions = functions = kernel(layout).functions
        inputs = np.zeros(layout.inputs)
        parts.rail.write_inputs(inputs)
        outputs = parts.plant.start(inputs)
        parts.rail.check_plant(outputs)
        self.structs = structs = structs_of(parts, inputs, outputs)
        self._cycle, self._plant, self._onboard = (s.pointer for s in (structs.cycle, structs.plant, structs.onboard))
        self._inputs, self._outputs = structs.plant.target("inputs"), structs.plant.target("outputs")
        self._reading, self._demand = structs.instruments.view("reading"), structs.onboard.view("demand")
        provided, step_estimator = frozenset[str](), self._advance_filter
        if isinstance(estimator, StateEstimator):
            provided = frozenset(("slip", *ONLY_ESTIMATED))
        elif estimator is not None:
            provided, step_estimator = frozenset(estimator.provides), _EstimateWriter(structs, estimator, parts).step
        self._observe = _observer(structs, parts, provided)
        self._steps = {
            functions.BLOCK_DUE: self._begin_block,
            functions.PLANT_DUE: self._step_plant,
            functions.SENSORS_DUE: self._read_sensors,
            functions.ESTIMATOR_DUE: step_estimator,
            functions.LIMITS_DUE: self._limit,
        }

    def run(self) -> Ending:
        """Run the stop with the parts' controller, and return its end.

        Raises:
            PlantFailed: The plant refused a step; the recorder holds the rows up to then.
        """
        decide = self._parts.controller.decide
        for observation in self.decisions():
            try:
                demands = decide(observation)
            except ControllerFailed as failed:
                return self._end(Outcome.CONTROLLER_FAILED, str(failed))
            self._demand[:] = demands  # copied, because the cycle in C reads this memory
        assert self.ending is not None
        return self.ending

    def decisions(self) -> Generator[Observation]:
        """Run the stop; yield the observation whenever a controller in Python is due, and then expect its demand.

        Raises:
            PlantFailed: The plant refused a step; the recorder holds the rows up to then.
        """
        functions, cycle, steps, observe = self._functions, self._cycle, self._steps, self._observe
        step, controller_due = functions.cycle, functions.CONTROLLER_DUE
        while True:
            try:
                while (due := step(cycle)) in steps:
                    steps[due]()
                if due != controller_due:
                    self._end(*self._outcome(due))
                    return
            except (SensorsFailed, ControllerFailed) as failed:
                is_sensor = isinstance(failed, SensorsFailed)
                self._end(Outcome.SENSORS_FAILED if is_sensor else Outcome.CONTROLLER_FAILED, str(failed))
                return
            except EstimatorFailed as failed:
                self._end(Outcome.DIVERGED, f"{failed} At {self._time:.3f} s.")
                return
            except BaseException:
                # A failed plant and Ctrl-C, too: the rows that were written remain usable.
                self._finish()
                raise
            yield observe()

    def demand(self, demands: Sequence[float] | Vector) -> None:
        """Set the demanded brake cylinder pressure of each group [Pa] for the decision that is due."""
        self._demand[:] = demands

    @property
    def _time(self) -> float:
        return self._cycle.sample * self._parts.clock.period

    def _begin_block(self) -> None:
        sensors, sample = self._parts.sensors, self._cycle.sample
        # All noise has been used. Drawing a block at once is faster than drawing at each reading.
        if isinstance(sensors, SensorsInC) and sample % (BLOCK * self._parts.clock.sensors) == 0:
            sensors.draw()
        if self._progress is not None and sample > 0:
            self._progress(float(self._outputs[self._parts.layout.output["speed"].start]))

    def _step_plant(self) -> None:
        self._outputs[:] = self._parts.plant.step(self._inputs)

    def _read_sensors(self) -> None:
        assert isinstance(self._parts.sensors, LoopSensors)
        self._reading[:] = self._parts.sensors.read(self._cycle.sample // self._parts.clock.sensors, self._outputs)

    def _limit(self) -> None:
        limits = self._parts.limits
        assert limits is not None
        self._demand[:] = limits.limit(self._demand, self._observe())
        # Once this is set, the cycle checks the demands, and returns to Python only for those beyond the limits.
        self._onboard.is_pascal = limits.is_pascal

    def _advance_filter(self) -> None:
        estimator = self._parts.estimator
        assert isinstance(estimator, StateEstimator)
        try:
            estimator.filter.advance()
        except ArithmeticError as diverged:
            raise EstimatorFailed(str(diverged)) from diverged
        assert self.structs.filter is not None
        self.structs.filter.target("squared_innovation")[0] = estimator.filter.squared_innovation

    def _outcome(self, due: int) -> tuple[Outcome, str]:
        functions, cycle, output = self._functions, self._cycle, self._parts.layout.output
        clock, time = self._parts.clock, self._time
        speed, distance = (float(self._outputs[output[name].start]) for name in ("speed", "distance"))
        if due == functions.STANDING:
            return Outcome.STANDSTILL, f"Stopped after {distance:.2f} m and {time:.3f} s."
        if due == functions.NOT_PLAUSIBLE:
            return Outcome.IMPLAUSIBLE, self._parts.plausibility.reason(time)
        if due == functions.DIVERGED:
            return Outcome.DIVERGED, f"{self._failure_of_the_filter()} At {time:.3f} s."
        if due == functions.NO_COMMAND:
            command = tuple(self.structs.onboard.view("command").tolist())
            reason = f"The controller's command at {time:.3f} s is {command}, not {len(command)} numbers."
            return Outcome.CONTROLLER_FAILED, reason
        if due == functions.PLANT_FAILED:
            assert isinstance(self._parts.plant, CoSimulation)
            self._parts.plant.note_steps(self._plant.steps, cycle.failure)  # raises PlantFailed
        end = clock.samples * clock.period
        return Outcome.HORIZON, f"Still moving at {speed:.2f} m/s after {end:g} s and {distance:.1f} m."

    def _failure_of_the_filter(self) -> str:
        estimator = self._parts.estimator
        if self._cycle.failure == self._functions.NEGATIVE_VARIANCE:
            return "The estimator diverged: a variance is negative or not a number."
        assert isinstance(estimator, StateEstimator)
        assert isinstance(estimator.filter, StepInC)
        return estimator.filter.failure(self._cycle.failure)

    def _end(self, outcome: Outcome, reason: str) -> Ending:
        self._finish()
        self.ending = Ending(outcome=outcome, reason=reason, samples=self.structs.record.pointer.written)
        return self.ending

    def _finish(self) -> None:
        # Slips and standard deviations are computed for all rows at once, which is faster than in each sample.
        recorder, estimator = self._parts.recorder, self._parts.estimator
        recorder.written = min(self.structs.record.pointer.written, len(recorder.rows))
        if not isinstance(estimator, StateEstimator):
            return
        rows, columns = recorder.rows[: recorder.written], recorder.columns
        variance = rows[:, recorder.block(DEVIATIONS)]
        # Adhesion is force over load. The readings determine only the force, so the load adds its relative error.
        load_error = estimator.load_deviation * rows[:, columns["estimate_adhesion"]]
        rows[:, columns["estimate_adhesion_sd"]] += load_error**2  # still a variance
        np.sqrt(variance, out=variance)
        speed = rows[:, columns["estimate_speed"]]
        rim_speed = np.asarray(estimator.wheel_radius) * rows[:, columns["estimate_wheelset_speed"]]
        rows[:, columns["estimate_slip"]] = slip_of(speed, rim_speed)


class _EstimateWriter:
    """Steps an estimator that returns quantities, and writes them to the arrays in which the cycle finds them."""

    def __init__(self, structs: Structs, estimator: DirectEstimator, parts: Parts) -> None:
        provided = [signal for signal in ESTIMATES if signal.name.removeprefix("estimate_") in estimator.provides]
        columns = places(provided, parts.layout.formation)
        self._step, self._observe = estimator.step, _observer(structs, parts, frozenset())
        self._estimates = {name.removeprefix("estimate_"): place for name, place in columns.items()}
        self._observed = parts.layout.places["observation"]
        self._values, self._replacement = (structs.onboard.view(name) for name in ("estimate", "replacement"))
        self._values[:], self._replacement[:] = np.nan, np.nan
        structs.record.set(estimate=parts.recorder.block(provided).start, estimate_count=length(columns))

    def step(self) -> None:
        values = self._step(self._observe())
        for name, place in self._estimates.items():
            self._values[place] = values[name]
            if name in self._observed:
                self._replacement[self._observed[name]] = values[name]


def _observer(structs: Structs, parts: Parts, provided: frozenset[str]) -> Callable[[], Observation]:
    """Return a function that returns the last observation of the cycle; estimates that are not `provided` are None.

    It is called at each decision of a part in Python, so constants of a stop are looked up once, here.
    """
    cycle, values, period = structs.cycle.pointer, structs.onboard.view("observation"), parts.clock.period
    constants = {"slip_is_estimated": "slip" in provided} | dict.fromkeys(ONLY_ESTIMATED - provided)
    template: list[Any] = [constants.get(name) for name in Observation._fields]
    time = Observation._fields.index("time")
    scalars, vectors = list[tuple[int, int]](), list[tuple[int, slice]]()
    for signal in OBSERVATION:
        field, place = Observation._fields.index(signal.name), parts.layout.places["observation"][signal.name]
        if signal.extent == "train":
            scalars.append((field, place.start))
        elif signal.name not in constants:
            vectors.append((field, place))

    def observe() -> Observation:
        vector, fields = np.frombuffer(values.tobytes()), template.copy()  # read-only, because several parts read it
        fields[time] = cycle.sample * period
        for field, index in scalars:
            fields[field] = vector.item(index)
        for field, place in vectors:
            fields[field] = vector[place]
        return Observation(*fields)

    return observe
