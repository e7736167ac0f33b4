"""The loop: a stop in C, which returns to Python whenever a part written in Python is due."""

import ctypes
import math
from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from railgrip.base.errors import ControllerFailed, EstimatorFailed, LoopError, SensorsFailed
from railgrip.controllers.observation import Observation
from railgrip.controllers.sampled import Sampled
from railgrip.estimators.compiled import StepInC
from railgrip.fmi import CoSimulation
from railgrip.fmus.native.c_library import Struct
from railgrip.fmus.native.toolchain import shared_library
from railgrip.scenario.outcome import Outcome
from railgrip.simulate.loop.library import KERNEL, every, kernel
from railgrip.simulate.loop.parts import DirectEstimator, LoopSensors, Parts, StateEstimator
from railgrip.simulate.loop.plausible import Plausibility
from railgrip.simulate.loop.sensors import BLOCK, IdealSensors, ServiceSensors, WhiteSensors
from railgrip.vehicle.signals import (
    BELIEVED,
    ESTIMATES,
    OBSERVED,
    ONLY_ESTIMATED,
    SPREAD,
    Layout,
    Role,
    length,
    places,
)
from railgrip.vehicle.slip import slip_of

Vector = NDArray[np.float64]


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

    The order of events in a sample is that of `kernel/cycle.c`. If the parts have no controller, the caller decides:

        for observation in loop.decisions():
            loop.demand(pressures)

    Attributes:
        ending: End of the stop; None before.
        struct: `Cycle` of cycle.h, with the parts that are in C.
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
        layout, sensors, estimator = parts.layout, parts.sensors, parts.estimator
        library = kernel(layout)
        self._functions = functions = library.functions
        self._plausibility = Plausibility(layout, parts.clock.period, parts.start_speed, parts.slowing)
        inputs = np.zeros(layout.inputs)
        parts.rail.write_inputs(inputs)
        truth = parts.plant.start(inputs)
        parts.rail.check_plant(truth)
        self.struct = struct = _cycle(parts, self._plausibility)
        self._cycle = struct.pointer
        self._truth, self._inputs, self._reading = (struct.view(name) for name in ("truth", "inputs", "reading"))
        self._demand = struct.view("demand")
        self._truth[:], self._inputs[:] = truth, inputs
        if np.isnan(truth[layout.output["slip"]]).any():
            struct.set(slip_radius=np.array(layout.formation.wheel_radius, dtype=np.float64))
        if isinstance(parts.plant, CoSimulation):
            _step_from_c(struct, parts.plant)
        if isinstance(sensors, ServiceSensors):
            struct.set(service=sensors.struct)
        elif isinstance(sensors, WhiteSensors):
            struct.set(read_of=sensors.places, gain=sensors.gain, bias=sensors.bias, noise=sensors.noise)
        elif isinstance(sensors, IdealSensors):
            struct.set(read_of=sensors.places)
        provides, estimate = frozenset[str](), self._advance_filter
        if isinstance(estimator, StateEstimator):
            provides = frozenset(("slip", "adhesion", "pad_friction"))
            self._squared = _filter_from_c(struct, estimator, parts)
        elif estimator is not None:
            provides, estimate = frozenset(estimator.provides), _Direct(struct, estimator, parts).step
        self._observe = _observer(struct, parts, provides)
        self._steps = {
            functions.BLOCK_DUE: self._begin_block,
            functions.PLANT_DUE: self._step_plant,
            functions.SENSORS_DUE: self._read_sensors,
            functions.ESTIMATOR_DUE: estimate,
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
            self._demand[:] = demands
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
            except SensorsFailed as failed:
                self._end(Outcome.SENSORS_FAILED, str(failed))
                return
            except EstimatorFailed as failed:
                self._end(Outcome.DIVERGED, f"{failed} At {self._time:.3f} s.")
                return
            except ControllerFailed as failed:
                self._end(Outcome.CONTROLLER_FAILED, str(failed))
                return
            except BaseException:
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
        if isinstance(sensors, WhiteSensors | ServiceSensors) and sample % (BLOCK * self._parts.clock.sensors) == 0:
            sensors.draw()
        if self._progress is not None and sample > 0:
            self._progress(float(self._truth[self._parts.layout.output["speed"].start]))

    def _step_plant(self) -> None:
        self._truth[:] = self._parts.plant.step(self._inputs)

    def _read_sensors(self) -> None:
        assert isinstance(self._parts.sensors, LoopSensors)
        self._reading[:] = self._parts.sensors.read(self._cycle.sample // self._parts.clock.sensors, self._truth)

    def _limit(self) -> None:
        limits = self._parts.limits
        assert limits is not None
        self._demand[:] = limits.limit(self._demand, self._observe())
        self._cycle.is_pascal = limits.is_pascal

    def _advance_filter(self) -> None:
        estimator = self._parts.estimator
        assert isinstance(estimator, StateEstimator)
        try:
            estimator.filter.advance()
        except ArithmeticError as diverged:
            raise EstimatorFailed(str(diverged)) from diverged
        self._squared[0] = estimator.filter.squared_innovation

    def _outcome(self, due: int) -> tuple[Outcome, str]:
        """Return outcome and reason from the return value of the cycle."""
        functions, cycle, output = self._functions, self._cycle, self._parts.layout.output
        clock, time = self._parts.clock, self._time
        speed, distance = (float(self._truth[output[name].start]) for name in ("speed", "distance"))
        if due == functions.STANDING:
            return Outcome.STANDSTILL, f"Stopped after {distance:.2f} m and {time:.3f} s."
        if due == functions.NOT_PLAUSIBLE:
            return Outcome.IMPLAUSIBLE, self._plausibility.reason(time)
        if due == functions.DIVERGED:
            return Outcome.DIVERGED, f"{self._failure_of_the_filter()} At {time:.3f} s."
        if due == functions.NO_COMMAND:
            command = tuple(self.struct.view("command").tolist())
            reason = f"The controller's command at {time:.3f} s is {command}, not {len(command)} numbers."
            return Outcome.CONTROLLER_FAILED, reason
        if due == functions.PLANT_FAILED:
            assert isinstance(self._parts.plant, CoSimulation)
            self._parts.plant.note_steps(cycle.crossed, cycle.failure)  # raises PlantFailed
        end = clock.samples * clock.period
        return Outcome.HORIZON, f"Still moving at {speed:.2f} m/s after {end:g} s and {distance:.1f} m."

    def _failure_of_the_filter(self) -> str:
        estimator = self._parts.estimator
        if self._cycle.failure == self._functions.NEGATIVE_VARIANCE or not isinstance(estimator, StateEstimator):
            return "The estimator diverged: a variance is negative or not a number."
        assert isinstance(estimator.filter, StepInC)
        return estimator.filter.failure(self._cycle.failure)

    def _end(self, outcome: Outcome, reason: str) -> Ending:
        self._finish()
        self.ending = Ending(outcome=outcome, reason=reason, samples=self._cycle.written)
        return self.ending

    def _finish(self) -> None:
        """Complete the rows that were written.

        Values derived from the estimates are computed for all rows at once: slips, and standard deviations from
        variances. Adhesion is a force, which the readings determine, over a load, which they do not: the relative error
        of the load adds to its own.
        """
        recorder, estimator = self._parts.recorder, self._parts.estimator
        recorder.written = min(self._cycle.written, len(recorder.rows))
        if not isinstance(estimator, StateEstimator):
            return
        rows, columns = recorder.rows[: recorder.written], recorder.columns
        variance = rows[:, recorder.block(SPREAD)]
        load_error = estimator.load_deviation * rows[:, columns["estimate_adhesion"]]
        rows[:, columns["estimate_adhesion_sd"]] += load_error**2
        np.sqrt(variance, out=variance)
        speed = rows[:, columns["estimate_speed"]]
        rolling = np.asarray(estimator.wheel_radius) * rows[:, columns["estimate_wheelset_speed"]]
        rows[:, columns["estimate_slip"]] = slip_of(speed, rolling)


class _Direct:
    """An estimator that returns quantities, and the arrays in which the cycle finds them."""

    def __init__(self, struct: Struct, estimator: DirectEstimator, parts: Parts) -> None:
        provided = [signal for signal in ESTIMATES if signal.name.removeprefix("estimate_") in estimator.provides]
        columns = places(provided, parts.layout.formation)
        self._step, self._observe = estimator.step, _observer(struct, parts, frozenset())
        self._estimates = {name.removeprefix("estimate_"): place for name, place in columns.items()}
        self._observed = parts.layout.places["observation"]
        self._values, self._replaced = struct.view("estimate"), struct.view("replaced")
        self._values[:], self._replaced[:] = np.nan, np.nan
        struct.set(estimates_count=length(columns), estimates_at=parts.recorder.block(provided).start)

    def step(self) -> None:
        values = self._step(self._observe())
        for name, place in self._estimates.items():
            self._values[place] = values[name]
            if name in self._observed:
                self._replaced[self._observed[name]] = values[name]


def _observer(struct: Struct, parts: Parts, provides: frozenset[str]) -> Callable[[], Observation]:
    """Return a function for the last observation of the cycle, with the estimates of each group that are provided.

    It is called at each decision of a part in Python, so constants of a stop are looked up once, here.
    """
    cycle, values, period = struct.pointer, struct.view("observation"), parts.clock.period
    constant = {"slip_is_estimated": "slip" in provides} | dict.fromkeys(ONLY_ESTIMATED - provides)
    template: list[Any] = [constant.get(name) for name in Observation._fields]
    time = Observation._fields.index("time")
    of_train, of_groups = list[tuple[int, int]](), list[tuple[int, slice]]()
    for signal in OBSERVED:
        field, place = Observation._fields.index(signal.name), parts.layout.places["observation"][signal.name]
        if signal.extent == "train":
            of_train.append((field, place.start))
        elif signal.name not in constant:
            of_groups.append((field, place))

    def observe() -> Observation:
        vector, fields = np.frombuffer(values.tobytes()), template.copy()  # read-only, because several parts read it
        fields[time] = cycle.sample * period
        for field, first in of_train:
            fields[field] = vector.item(first)
        for field, place in of_groups:
            fields[field] = vector[place]
        return Observation(*fields)

    return observe


def _cycle(parts: Parts, plausibility: Plausibility) -> Struct:
    """Return the argument of the cycle, with all parts that are always in C."""
    layout, clock, driver, recorder, law = parts.layout, parts.clock, parts.driver, parts.recorder, parts.law
    free_wheel = parts.estimator.free_wheel if isinstance(parts.estimator, StateEstimator) else None
    struct = kernel(layout).struct("Cycle", plausibility=plausibility.struct, rail=parts.rail.struct,
        driver=driver.struct if driver.has_phases else None, full=np.array(driver.full, dtype=np.float64),
        faults=parts.faults and parts.faults.struct, radius=np.array(parts.wheel_radius, dtype=np.float64),
        law=_formula(layout, parts.controller, "observation"), over=_formula(layout, parts.over, "observation"),
        most=parts.limits and parts.limits.most,
        valves=_formula(layout, parts.valves, "valve_input"),
        free_wheel=_formula(layout, free_wheel, "reference_input"),
        period=clock.period, stop_speed=parts.stop_speed, samples=clock.samples, block=BLOCK,
        sensors_every=clock.sensors, estimator_every=every(layout, clock.estimator),
        controller_every=every(layout, clock.controller),
        rows=recorder.rows, width=recorder.rows.shape[1], capacity=recorder.rows.shape[0],
        true_at=recorder.block(layout.signals["output"]).start, sent_at=recorder.block(layout.signals["input"]).start,
        read_at=recorder.block(layout.signals["reading"]).start, demand_at=recorder.at.get("demand", -1),
        driver_at=recorder.at["driver_demand"] if driver.has_phases else -1,
        traction_at=recorder.at.get("traction", -1), reference_at=recorder.at.get("reference_speed", -1),
    )  # fmt: skip
    struct.view("reference")[layout.places["reference"]["speed"]] = math.nan
    if law is not None:
        struct.set(law_state=law.values, law_of=law.places, law_count=law.places.size)
        struct.set(law_at=recorder.block(law.signals).start)
    return struct


def _formula(layout: Layout, formula: object, inputs: Role) -> Struct:
    """Return a formula for the cycle, which passes it a vector of inputs; an empty one if `formula` is not in C.

    Raises:
        LoopError: The inputs of the formula are not those of the vector, in the same order.
    """
    if not isinstance(formula, Sampled):
        return kernel(layout).struct("Formula")
    name, expected = formula.formula.name, layout.elements(inputs)
    found = tuple(quantity.name for quantity in formula.formula.inputs)
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
    """Return the address of `void call(double *state, const double *input, const double *parameter, double *output)`.

    It calls a function (state, input, parameter) → (state, output) and replaces the state by the new one.

    Raises:
        railgrip.base.errors.CompilerMissing: No C compiler was found.
    """
    generator = ca.CodeGenerator("step", {"with_header": False, "casadi_int": "int"})
    generator.add(step)
    sizes = {
        "NX": step.numel_out(0), "WORK": step.sz_w(), "INDEX": step.sz_iw(), "ARGUMENTS": step.sz_arg(),
        "RESULTS": step.sz_res(),
    }  # fmt: skip
    header = "".join(
        [
            *(f"#define {name} {value}\n" for name, value in sizes.items()),
            "#define CASADI_SYMBOL_EXPORT static\n",
            generator.dump(),
        ]
    )
    sources = {"step.h": header, "formula.c": (KERNEL / "formula.c").read_text(encoding="utf-8")}
    library = ctypes.CDLL(str(shared_library(sources, "formula")))
    return ctypes.cast(library.call, ctypes.c_void_p).value or 0


def _step_from_c(struct: Struct, plant: CoSimulation) -> None:
    interface = plant.c_interface()
    struct.set(
        cross=interface.cross, set_step_get=interface.plan, taken=interface.inputs, shown=interface.outputs,
        present=interface.present, present_count=interface.present.size,
    )  # fmt: skip


def _filter_from_c(struct: Struct, estimator: StateEstimator, parts: Parts) -> Vector:
    """Let the cycle write readings for a filter and read its estimate; return the array for the squared innovation."""
    filter_, squared = estimator.filter, np.zeros(1)
    states = [getattr(estimator, signal.name.removeprefix("estimate_")) for signal in BELIEVED]
    struct.set(
        mean=filter_.mean, covariance=filter_.covariance,
        row=filter_.covariance.strides[0] // filter_.covariance.itemsize, held=filter_.inputs, seen=filter_.readings,
        used=filter_.selection, squared=squared, seen_count=estimator.reading_places.size,
        seen_of=np.ascontiguousarray(estimator.reading_places, dtype=np.longlong),
        state_of=np.hstack(states).astype(np.longlong), radius=np.array(estimator.wheel_radius, dtype=np.float64),
        estimates_count=length(parts.layout.places["estimate"]), estimates_at=parts.recorder.block(ESTIMATES).start,
    )  # fmt: skip
    if isinstance(filter_, StepInC):
        advance, memory, squared_address = filter_.entry
        struct.set(advance=advance, memory=memory, squared=squared_address)
    return squared
