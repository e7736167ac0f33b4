"""A plant that is an FMU: its life cycle from `with` over start and steps to the first failure.

A co-simulation FMU 2.0 is stepped with minimal overhead between the caller's numbers and the FMU's: vectors are in SI
and in the order of the binding, values are converted only where the FMU's units differ, and all buffers and addresses
are created once.
"""

from abc import ABC, abstractmethod
from collections.abc import Generator
from contextlib import ExitStack, contextmanager
from math import ceil, isclose, isfinite
from pathlib import Path
from typing import ClassVar, Final, Self

import numpy as np

from railgrip.base.arrays import Vector
from railgrip.base.errors import FmuError, PlantFailed
from railgrip.fmi.description import Description
from railgrip.fmi.instance import Assignment, Instance, Values, Way, assignments, unpack
from railgrip.fmi.mapping import Binding, Channel
from railgrip.fmus.native.toolchain import Struct, kernel_library

Span = tuple[float, float | None]
"""Time of an FMU at the start, and the longest time from there that it is stepped, None if that is not known [s]."""

SILENT_WARNING: Final = "the status of a call was a warning, without a message"


class SteppedPlant(ABC):
    """Base of plants that are stepped by an FMU in any process: step count, time and first failure.

    Attributes:
        sample: Number of steps since the start; −1 before `start`.
    """

    def __init__(
        self, description: Description, binding: Binding, period: float, parameters: Values, span: Span
    ) -> None:
        """Check period [s] and parameters; see `LoadedPlant`.

        The period is constant, as an FMU without canHandleVariableCommunicationStepSize requires.
        """
        if not (isfinite(period) and period > 0):
            raise FmuError(f"{description.file.name}: the communication period is a positive time, got {period} s.")
        step = description.co_simulation.fixed_step if description.co_simulation is not None else None
        if step is not None and not (round(period / step) >= 1 and isclose(period, round(period / step) * step)):
            near = max(round(period / step), 1) * step
            raise FmuError(
                f"{description.file.name}: its internal step is fixed at {step:g} s, and the communication period of "
                f"{period:g} s is not a whole multiple of it; give a multiple in [periods], such as {near:g} s."
            )
        only = description.co_simulation.only_step if description.co_simulation is not None else None
        if only is not None and not isclose(period, only, rel_tol=1e-9):
            raise FmuError(
                f"{description.file.name}: it declares one communication step, stepSize = {only:g} s with "
                f"canHandleVariableCommunicationStepSize = false, and is stepped every {period:g} s; set its period in "
                f'[periods] to "{only:g} s" (communication for a plant, controller for a controller), or export it for '
                "a variable step."
            )
        self._description = description
        self._binding = binding
        self._period, (self._begins, horizon) = period, span
        self._ends: float | None = None
        if horizon is not None:  # of the last whole step, as the FMU adds its begin and length
            last = ceil(horizon / period * (1 - 1e-12)) - 1
            self._ends = self._begins + last * period + period
        self._parameters = dict(parameters)
        self._assignments = assignments(description, parameters)
        self._stack = ExitStack()
        self._failure: PlantFailed | None = None
        self.sample = -1

    @property
    @abstractmethod
    def warnings(self) -> dict[str, int]:
        """Messages of warnings so far, each kind with its number; also after the end of `with`."""

    @property
    def file(self) -> str:
        """Name of the FMU's file."""
        return self._description.file.name

    @property
    def time(self) -> float:
        """Time of the FMU [s]."""
        return self._begins + max(self.sample, 0) * self._period


class LoadedPlant(SteppedPlant):
    """An FMU in this process.

        with CoSimulation(description, binding, period=1e-3, parameters={"mass": 84e3}) as plant:
            outputs = plant.start(inputs)
            while moving:
                outputs = plant.step(inputs)

    Vectors have the layout of `binding.inputs` and `binding.outputs`. After a failed call the instance cannot be used.
    """

    _way: ClassVar[Way] = "co-simulation"

    def __init__(
        self,
        description: Description,
        binding: Binding,
        *,
        period: float,
        parameters: Values,
        span: Span = (0.0, None),
        folder: Path | None = None,
    ) -> None:
        """Check the arguments; nothing is loaded before `with`.

        Args:
            period: Communication step [s].
            parameters: Values by FMU variable, in the FMU's units.
            span: See `Span`.
            folder: Folder of the unpacked FMU; None unpacks it for the duration of the `with`.

        Raises:
            FmuError: A parameter is wrong or the period is not positive.
        """
        super().__init__(description, binding, period, parameters, span)
        self._folder = folder
        self._instance: Instance | None = None
        self._listened: Instance | None = None
        self._ready = False  # started, not failed, not closed
        self._blank = np.full(binding.outputs.size, np.nan)

    def __enter__(self) -> Self:
        with ExitStack() as stack:
            folder = self._folder or stack.enter_context(unpack(self._description))
            instance = Instance(self._description, self._way, folder, name="plant")
            stack.callback(instance.close)
            instance.assign(self._assignments, self._begins)
            self._instance = self._listened = instance
            self._prepare(instance)
            self._stack = stack.pop_all()
        return self

    def __exit__(self, *_: object) -> None:
        self._instance = None
        self._ready = False
        self._stack.close()

    @property
    def warnings(self) -> dict[str, int]:
        """Messages of warnings so far, each kind with its number; also after the end of `with`.

        A call that returned a warning without any message counts as a message that says so.
        """
        if self._listened is None:
            return {}
        messages = self._listened.warnings()
        return messages or ({SILENT_WARNING: self._warned} if self._warned else {})

    @property
    def _warned(self) -> int:
        """Number of calls that returned a warning."""
        return 0

    def start(self, inputs: Vector) -> Vector:
        """Initialise with `inputs` applied and return the outputs at the start time.

        Raises:
            PlantFailed: The FMU cannot be initialised.
        """
        instance = self._open()
        if self.sample >= 0:
            raise RuntimeError("a plant is started once; open another one to start again")
        if np.shape(inputs) != (self._binding.inputs.size,):
            raise ValueError(f"the inputs are a vector of {self._binding.inputs.size}, got shape {np.shape(inputs)}")
        with self._remembering():
            instance.enter_initialization(self._begins, end=self._ends)
            self._send(inputs)
            self._begin(instance)
            self.sample = 0
            outputs = self._receive()
        self._ready = True
        return outputs.copy()

    @abstractmethod
    def step(self, inputs: Vector) -> Vector:
        """Hold `inputs` over one period and return the outputs at its end.

        Raises:
            PlantFailed: The FMU did not return OK, or an output is not finite.
        """

    @abstractmethod
    def _prepare(self, instance: Instance) -> None:
        """Prepare buffers that every step uses."""

    @abstractmethod
    def _send(self, inputs: Vector) -> None:
        """Set the inputs."""

    def _begin(self, instance: Instance) -> None:
        instance.exit_initialization()

    @abstractmethod
    def _receive(self) -> Vector:
        """Return the outputs, NaN for outputs that the FMU lacks."""

    def _open(self) -> Instance:
        if self._failure is not None:
            raise self._failure
        if self._instance is None:
            raise RuntimeError(f"a {type(self).__name__} is used inside 'with'")
        return self._instance

    def _not_ready(self) -> Exception:
        return self._failure or RuntimeError(f"a {type(self).__name__} is started before it is stepped, inside 'with'")

    def _not_finite(self, instance: Instance, place: int, value: float) -> PlantFailed:
        name = self._binding.outputs.elements[place]
        return PlantFailed(instance.failure("not_finite", "", self.time, variable=name, doing=f"{value}"))

    @contextmanager
    def _remembering(self) -> Generator[None]:
        # A plant that has failed is unusable; it repeats its failure from then on.
        try:
            yield
        except PlantFailed as error:
            self._failure, self._ready = error, False
            raise


_KERNEL: Final = ("railgrip.fmi", "set_step_get")


def _channel(channel: Channel, exchange: int) -> Struct:
    is_integer, size = channel.carrier != "Real", len(channel.references)
    units = dict[str, Vector]()
    if np.any(channel.gain != 1.0) or np.any(channel.shift != 0.0):
        units = {"gain": np.ascontiguousarray(channel.gain), "shift": np.ascontiguousarray(channel.shift)}
    return kernel_library(*_KERNEL).struct(
        "Channel", transfer=exchange, references=channel.references, count=size, whole=is_integer,
        positions=np.ascontiguousarray(channel.positions, dtype=np.longlong),
        buffer=np.zeros(size, dtype=np.intc if is_integer else np.float64), **units,
    )  # fmt: skip


class CoSimulation(LoadedPlant):
    """A co-simulation FMU 2.0 in this process, stepped in C.

    A loop in C calls `int set_step_get(void *plan, double time)` of `kernel/set_step_get.c` itself, and reports to
    `note_steps`.

    Attributes:
        inputs: Inputs of the next step, shape (inputs of the binding,).
        outputs: Outputs of the last step, NaN for those that the FMU lacks, shape (outputs of the binding,).
        entry: Address of `set_step_get`.
        plan: Address of its first argument.
    """

    def _prepare(self, instance: Instance) -> None:
        sending, receiving = self._binding.inputs, self._binding.outputs
        self.inputs, self.outputs = np.zeros(sending.size), self._blank.copy()
        library = kernel_library(*_KERNEL)
        to, of = (
            [_channel(each, instance.address(f"fmi2{verb}{each.carrier}")) for each in side.channels]
            for verb, side in (("Set", sending), ("Get", receiving))
        )
        self._struct = library.struct(
            "SetStepGet", fmu=instance.component, step=instance.address("fmi2DoStep"), n_senders=len(to),
            senders=library.array("Channel", to), receivers=library.array("Channel", of), n_receivers=len(of),
            n_outputs=self.outputs.size, inputs=self.inputs, outputs=self.outputs, period=self._period,
            begin=self._begins,
        )  # fmt: skip
        self._functions = library.functions
        # A call releases the interpreter's lock: a thread of the FMU may need it, and so does Ctrl-C.
        self._step, self._plan = library.functions.set_step_get, self._struct.pointer
        self.entry, self.plan = library.address("set_step_get"), self._struct.address

    @property
    def setup(self) -> tuple[Description, Binding, tuple[Assignment, ...]]:
        """Description and variables of the FMU, and the values that are set before it starts."""
        return self._description, self._binding, self._assignments

    @property
    def _warned(self) -> int:
        return int(self._struct.pointer.warnings)

    def _send(self, inputs: Vector) -> None:
        self.inputs[:] = inputs
        self._require_fine(self._functions.exchange(self._struct.pointer, self._functions.SET, 0.0))

    def _receive(self) -> Vector:
        self._require_fine(self._functions.exchange(self._struct.pointer, self._functions.GET, 0.0))
        return self.outputs

    def step(self, inputs: Vector) -> Vector:
        """Hold `inputs` over one period and return the outputs at its end.

        Raises:
            PlantFailed: The FMU did not return OK, or an output is not finite.
        """
        # Called once per simulated millisecond: each line here takes a measurable share of a stop.
        if not self._ready:
            raise self._not_ready()
        self.inputs[:] = inputs
        outcome = self._step(self._plan, self.sample * self._period)
        if outcome:
            self.note_steps(0, outcome)
        self.sample += 1
        return self.outputs.copy()

    def follow(self, inputs: Vector) -> Vector:
        """Hold each row of inputs, shape (k, nu), over one period; return the outputs, shape (k, ny).

        Raises:
            FmuError: The shape is wrong, or a value is not finite.
            PlantFailed: As `step`.
        """
        if not self._ready:
            raise self._not_ready()
        rows, width = np.ascontiguousarray(inputs, dtype=np.float64), self.inputs.size
        if rows.ndim != 2 or rows.shape[1] != width or not np.all(np.isfinite(rows)):
            found = f"shape {rows.shape}" if rows.ndim != 2 or rows.shape[1] != width else "a value that is none"
            raise FmuError(f"follow: expects rows of {width} finite inputs, got {found}.")
        library, plan, outputs = (
            kernel_library(*_KERNEL),
            self._struct.pointer,
            np.empty((len(rows), self.outputs.size)),
        )
        given, shown = library.doubles(rows), library.doubles(outputs)
        outcome = library.functions.follow(plan, len(rows), self.sample, given, width, shown)
        self.note_steps(plan.done, outcome)
        return outputs

    def note_steps(self, steps: int, outcome: int) -> None:
        """Record steps taken by a loop in C, and the last return value of `set_step_get`, 0 for success.

        Raises:
            PlantFailed: The steps ended early.
        """
        self.sample += steps
        self.sample += outcome in (self._functions.GETTING, self._functions.NOT_FINITE)  # the step itself succeeded
        self._require_fine(outcome)

    def _require_fine(self, outcome: int) -> None:
        """Raise the failure that ended a communication step early, if there was one."""
        if outcome == self._functions.FINE:
            return
        instance, plan = self._open(), self._struct.pointer
        with self._remembering():
            if outcome == self._functions.NOT_FINITE:
                raise self._not_finite(instance, plan.at, float(self.outputs[plan.at]))
            call, doing = "fmi2DoStep", ""
            if outcome != self._functions.STEPPING:
                is_setting = outcome == self._functions.SETTING
                side = self._binding.inputs if is_setting else self._binding.outputs
                call = f"fmi2{'Set' if is_setting else 'Get'}{side.channels[plan.at].carrier}"
                doing = "setting inputs" if is_setting else "reading outputs"
            instance.check(plan.status, call, self.time, doing)
