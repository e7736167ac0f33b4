"""Steps FMUs through FMPy: Co-Simulation by FMI 3.0, and Model Exchange by FMI 2.0 or 3.0, integrated by CVODE."""

from abc import abstractmethod
from collections.abc import Callable
from functools import partial
from importlib import import_module
from math import isclose
from types import SimpleNamespace
from typing import Any, ClassVar, Final

import numpy as np
from fmpy.fmi1 import FMICallException

from railgrip.base.arrays import Vector
from railgrip.base.errors import FmuError, PlantFailed
from railgrip.fmi.description import Description
from railgrip.fmi.instance import Instance, Way, start_values
from railgrip.fmi.mapping import Channel
from railgrip.fmi.plant import CoSimulation, LoadedPlant

TOLERANCE: Final = 1e-6
"""Relative error of a step of CVODE, as in the built-in plants; the absolute error is that times nominal values."""
_MAX_STEPS: Final = 5000  # of CVODE between two communication points
_DISCARD: Final = 2  # status of FMI
_SAME_INSTANT: Final = 1e-9  # of a period
_MAX_EVENTS: Final = 100  # at one instant; far more than any model needs


class _Block:
    """The variables of a channel for one call of FMPy, with all elements of FMI 3.0 arrays."""

    def __init__(self, channel: Channel, description: Description) -> None:
        variables = {v.reference: v for v in description.variables.values() if v.carrier == channel.carrier}
        self.references: list[int] = [int(r) for r in np.unique(channel.references)]
        starts = [start_values(description, variables[r]) for r in self.references]
        first = dict(zip(self.references, np.cumsum([0, *map(len, starts)]), strict=False))
        self.places = np.array([first[int(r)] for r in channel.references], dtype=np.intp) + channel.elements
        self.values = np.array([float(value) for array in starts for value in array])
        self.channel = channel
        self._as_type: Callable[[float], object] | None = None
        if not channel.carrier.startswith(("Real", "Float")):
            self._as_type = bool if channel.carrier == "Boolean" else int

    def plain(self) -> list[Any]:
        """Return the values as the FMU's type."""
        if self._as_type is None:
            return self.values.tolist()
        return [self._as_type(value) for value in np.rint(self.values).tolist()]


class _FmpyPlant(LoadedPlant):
    """Common base of the plants that are stepped through FMPy."""

    def _prepare(self, instance: Instance) -> None:
        self._senders, self._receivers = (
            [_Block(channel, self._description) for channel in side.channels]
            for side in (self._binding.inputs, self._binding.outputs)
        )

    def _send(self, inputs: Vector) -> None:
        with self._open().calling(self.time, "setting inputs") as fmu:
            for block in self._senders:
                channel = block.channel
                block.values[block.places] = inputs[channel.positions] * channel.gain + channel.shift
                getattr(fmu, f"set{channel.carrier}")(block.references, block.plain())

    def _receive(self) -> Vector:
        instance, outputs = self._open(), self._blank.copy()
        with instance.calling(self.time, "reading outputs") as fmu:
            for block in self._receivers:
                channel, size = block.channel, block.values.size
                sizes = () if size == len(block.references) else (size,)  # FMI 2.0 has no arrays
                values = np.array(getattr(fmu, f"get{channel.carrier}")(block.references, *sizes), dtype=np.float64)
                outputs[channel.positions] = values[block.places] * channel.gain + channel.shift
        for block in self._receivers:
            bad = block.channel.positions[~np.isfinite(outputs[block.channel.positions])]
            if bad.size:
                raise self._not_finite(instance, int(bad[0]), float(outputs[bad[0]]))
        return outputs

    def step(self, inputs: Vector) -> Vector:
        """Hold `inputs` over one period and return the outputs at its end.

        Raises:
            PlantFailed: The FMU did not return OK, requested the end or could not be integrated, or an output is not
                finite.
        """
        if not self._ready:
            raise self._not_ready()
        with self._remembering():
            self._advance(self._open(), inputs)
            self.sample += 1
            return self._receive()

    @abstractmethod
    def _advance(self, instance: Instance, inputs: Vector) -> None:
        """Hold the inputs over one period."""


class SlaveOfFmi3(_FmpyPlant):
    """A co-simulation FMU 3.0 in this process, without event mode and early return: it handles events inside a step."""

    def _advance(self, instance: Instance, inputs: Vector) -> None:
        self._send(inputs)
        with instance.calling(self.time) as fmu:
            _, ended, early, reached = fmu.doStep(self.time, self._period)
        if ended:
            raise PlantFailed(instance.failure("ended", "fmi3DoStep", self.time))
        if early and not isclose(reached, self.time + self._period):
            doing = f"it returned early, at {reached:.9g} s, which it was not allowed to"
            raise PlantFailed(instance.failure("not_integrated", "fmi3DoStep", self.time, doing=doing))


class IntegratedModel(_FmpyPlant):
    """A Model Exchange FMU in this process, integrated by CVODE, with state, time and step events.

    A change of the inputs is an event: they are set in event mode, and CVODE restarts.
    """

    _way: ClassVar[Way] = "model exchange"

    def _begin(self, instance: Instance) -> None:
        super()._begin(instance)
        self._sent: Vector | None = None
        self._next_event = instance.settle(self._begins)
        self._solver = _solver(instance, self._period, self._begins)

    def _advance(self, instance: Instance, inputs: Vector) -> None:
        time, end = self.time, self._begins + (self.sample + 1) * self._period
        interface = self._description.model_exchange
        if self._sent is None or not np.array_equal(self._sent, inputs):
            self._sent = inputs.copy()
            self._event(instance, time, inputs)
        events = 0
        while True:
            if self._next_event is not None and self._next_event - time <= _SAME_INSTANT * self._period:
                # The solver cannot take a step of no length.
                time, events = max(time, self._next_event), events + 1
                if events > _MAX_EVENTS:
                    doing = f"it sets its next event at the present time again, {events} times"
                    raise PlantFailed(instance.failure("not_integrated", "", time, doing=doing))
                with instance.calling(time, "at an event") as fmu:
                    fmu.setTime(time)
                self._event(instance, time)
                continue
            if time >= end or isclose(time, end):
                return
            before, until = time, end if self._next_event is None else min(end, self._next_event)
            with instance.calling(time) as fmu:
                is_event, time = self._integrate(instance, time, until)
                fmu.setTime(time)
                if interface is not None and interface.completed_steps:
                    is_step_event, ended = fmu.completedIntegratorStep()
                    is_event = is_event or is_step_event
                    if ended:
                        raise PlantFailed(instance.failure("ended", "", time))
            events = events if time - before <= _SAME_INSTANT * self._period else 0
            if is_event:
                self._event(instance, time)

    def _integrate(self, instance: Instance, time: float, until: float) -> tuple[bool, float]:
        self._solver.failure = None
        try:
            is_event, _, time = self._solver.step(time, until)
        except RuntimeError as error:
            if self._solver.failure is not None:
                raise self._solver.failure from error
            raise PlantFailed(instance.failure("not_integrated", "", time, doing=str(error))) from error
        return is_event, time

    def _event(self, instance: Instance, time: float, inputs: Vector | None = None) -> None:
        with instance.calling(time, "at an event") as fmu:
            fmu.enterEventMode()
            if inputs is not None:
                self._send(inputs)
            self._next_event = instance.settle(time)
            self._solver.reset(time)


def loaded_plant(description: Description) -> type[CoSimulation | SlaveOfFmi3 | IntegratedModel]:
    """Return the class that steps an FMU in this process; Co-Simulation is preferred if the FMU offers both."""
    if description.co_simulation is None:
        return IntegratedModel
    return CoSimulation if description.fmi == 2 else SlaveOfFmi3


def _solver(instance: Instance, period: float, begin: float) -> Any:
    # FMPy includes CVODE for some platforms only, and loads it with this module.
    try:
        sundials: Any = import_module("fmpy.sundials")
    except (OSError, AttributeError) as error:
        raise FmuError(
            f"{instance.description.file}: Model Exchange is integrated by CVODE, which FMPy does not have for this "
            f"platform ({error}); export the FMU as Co-Simulation."
        ) from error

    class Solver(sundials.CVodeSolver):
        """CVODE, which stops when an FMI function fails or returns NaN.

        FMPy's callbacks would continue with the last values; CVODE treats an event indicator of NaN as unchanged in
        sign.
        """

        failure: FMICallException | PlantFailed | None = None

        def __init__(self, **arguments: Any) -> None:
            super().__init__(**arguments)
            # SUNDIALS would also print each error that is raised as an exception here.
            sundials.sundials_core.SUNContext_ClearErrHandlers(self.sunctx)
            sundials.SUNContext_PushErrHandler(self.sunctx, self.ehfun_, None)

        def f(self, time: float, states: Any, derivatives: Any, data: Any) -> int:
            call = "fmi2GetDerivatives" if is_fmi_2 else "fmi3GetContinuousStateDerivatives"
            values = sundials.NV_DATA_S(derivatives), self.nx
            return self._guarded(partial(super().f, time, states, derivatives, data), time, call, *values)

        def g(self, time: float, states: Any, indicators: Any, data: Any) -> int:
            call = f"fmi{description.fmi}GetEventIndicators"
            return self._guarded(partial(super().g, time, states, indicators, data), time, call, indicators, self.nz)

        def _guarded(self, function: Callable[[], int], time: float, call: str, pointer: Any, size: int) -> int:
            # CVODE's codes: 0 success, positive recoverable (the step is too long), negative fatal.
            try:
                status = function()
            except FMICallException as error:
                self.failure = error
                return 1 if error.status == _DISCARD else -1
            bad = np.flatnonzero(~np.isfinite(np.ctypeslib.as_array(pointer, (size,)))) if size else np.array([])
            if bad.size:
                doing = f"number {bad[0] + 1} of {size}"
                self.failure = PlantFailed(instance.failure("not_finite", call, time, doing=doing))
                return 1
            return status

    fmu, description = instance.fmpy, instance.description

    is_fmi_2 = description.fmi == 2
    with instance.calling(begin, "starting the solver"):
        return Solver(
            nx=len(description.states) if is_fmi_2 else fmu.getNumberOfContinuousStates(),
            nz=description.event_indicators if is_fmi_2 else fmu.getNumberOfEventIndicators(),
            get_x=fmu.getContinuousStates,
            set_x=fmu.setContinuousStates,
            get_dx=fmu.getDerivatives if is_fmi_2 else fmu.getContinuousStateDerivatives,
            get_z=fmu.getEventIndicators,
            get_nominals=partial(_read_nominals, fmu),
            set_time=fmu.setTime,
            # Inputs are held, and set at events only.
            input=SimpleNamespace(apply=lambda time: None),
            startTime=begin,
            # Search for state events once or more often in each period.
            maxStep=period,
            relativeTolerance=TOLERANCE,
            maxNumSteps=_MAX_STEPS,
        )


def _read_nominals(fmu: Any, pointer: Any, size: int) -> None:
    fmu.getNominalsOfContinuousStates(pointer, size)
    values = np.ctypeslib.as_array(pointer, (size,))
    values[~(np.isfinite(values) & (values > 0))] = 1.0
