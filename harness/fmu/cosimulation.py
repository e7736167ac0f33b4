"""Steps a co-simulation FMU with as little as possible between the caller's numbers and the FMU's.

A vector of our inputs goes in and a vector of our outputs comes out, both in SI and in the order of the
binding; conversions are applied only where the FMU's units differ. All buffers and addresses are made once.
"""

import ctypes
from collections.abc import Generator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from math import isfinite
from pathlib import Path
from types import TracebackType
from typing import Protocol, Self, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from railgrip.errors import FmuError, PlantFailed
from railgrip.fmu.description import Description
from railgrip.fmu.instance import Instance, unpacked
from railgrip.fmu.mapping import Binding, Side
from railgrip.fmu.parameters import Values, assignments
from railgrip.fmu.set_step_get import Outcome, SetStepGet, outcome
from railgrip.loop.compiled import Calls
from railgrip.loop.ports import Edge

Vector = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Snapshot:
    """The state of a plant at one sample, to return to; valid while that plant is open."""

    sample: int
    handle: int
    owner: int


@runtime_checkable
class Plant(Protocol):
    """A plant on a grid of equal periods, used inside `with`."""

    def start(self, inputs: Vector) -> Vector:
        """Initialise with `inputs` applied and return the outputs at the start time."""
        ...

    def step(self, inputs: Vector) -> Vector:
        """Hold `inputs` over one period and return the outputs at its end."""
        ...


class CoSimulation:
    """A co-simulation FMU in this process.

        with CoSimulation(description, binding, period=1e-3, parameters={"mass": 84e3}) as plant:
            outputs = plant.start(inputs)
            while moving:
                outputs = plant.step(inputs)

    Vectors are those of `binding.inputs` and `binding.outputs`. Once a call has failed the instance is spent.
    """

    def __init__(
        self,
        description: Description,
        binding: Binding,
        *,
        period: float,
        parameters: Values,
        start_time: float = 0.0,
        tolerance: float | None = None,
        folder: Path | None = None,
    ) -> None:
        """Check the question; nothing is loaded before `with`.

        Args:
            description: Of the FMU.
            binding: Of our signals to its variables.
            period: Communication step [s].
            parameters: Values by FMU variable, in the FMU's units.
            start_time: [s].
            tolerance: Relative tolerance for the FMU's solver; None leaves it to the FMU.
            folder: Where the FMU is unpacked already; None unpacks it for the time of the `with`.

        Raises:
            FmuError: A parameter is wrong or the period is not positive.
        """
        if not (isfinite(period) and period > 0):
            raise FmuError(f"{description.file.name}: the communication period is a positive time, got {period} s.")
        self._description = description
        self._binding = binding
        self._period = period
        self._start_time = start_time
        self._tolerance = tolerance
        self._assignments = assignments(description, parameters)
        self._folder = folder
        self._stack = ExitStack()
        self._instance: Instance | None = None
        self._spent: PlantFailed | None = None
        self._sample = -1
        self._ready = False  # started, not failed, not closed
        self._snapshots: list[int] = []

    def __enter__(self) -> Self:
        """Unpack, load, instantiate and set the parameters."""
        with ExitStack() as stack:
            folder = self._folder or stack.enter_context(unpacked(self._description))
            instance = Instance(self._description, "co-simulation", folder, name="plant")
            stack.callback(instance.close)
            instance.assign(self._assignments, self._start_time)
            self._instance = instance
            self._prepare(instance)
            self._stack = stack.pop_all()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        """Free everything, whatever happened."""
        if self._instance is not None and self._spent is None:
            for handle in self._snapshots:
                self._instance.call("fmi2FreeFMUstate", ctypes.byref(ctypes.c_void_p(handle)), time=self.time)
        self._instance = None
        self._ready = False
        self._stack.close()

    def _prepare(self, instance: Instance) -> None:
        """Make what every step needs."""
        self._set_step_get = set_step_get = SetStepGet(instance, self._binding, self._period)
        size = self._binding.outputs.size
        self._present = set_step_get.present if set_step_get.present.size < size else None
        self._blank = np.full(size, np.nan)

    @property
    def sample(self) -> int:
        """Number of steps since the start; −1 before `start`."""
        return self._sample

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self._start_time + max(self._sample, 0) * self._period

    def start(self, inputs: Vector) -> Vector:
        """Initialise with `inputs` applied and return the outputs at the start time.

        Raises:
            PlantFailed: The FMU cannot be initialised.
        """
        instance = self._open()
        if self._sample >= 0:
            raise RuntimeError("a plant is started once; open another one to start again")
        if np.shape(inputs) != (self._binding.inputs.size,):
            raise ValueError(f"the inputs are a vector of {self._binding.inputs.size}, got shape {np.shape(inputs)}")
        with self._remembering():
            instance.enter_initialization(self._start_time, self._tolerance)
            self._send(inputs)
            instance.exit_initialization(self._start_time)
            self._sample = 0
            values = self._receive()
        self._ready = True
        return values

    def step(self, inputs: Vector) -> Vector:
        """Hold `inputs` over one period and return the outputs at its end.

        Raises:
            PlantFailed: The FMU did not return OK, or an output is not finite.
        """
        # Once per simulated millisecond: each line here is a measurable part of a stop.
        if not self._ready:
            raise self._not_ready()
        set_step_get = self._set_step_get
        set_step_get.inputs[:] = inputs
        failure = set_step_get.step(self._start_time + self._sample * self._period)
        if failure:
            self.crossed(0, failure)
        self._sample += 1
        return set_step_get.outputs.copy() if self._present is None else self._spread()

    def edge(self) -> Edge:
        """Return what a loop in C steps this plant by; it then reports to `crossed`."""
        if not self._ready:
            raise self._not_ready()
        return self._set_step_get.edge(self._start_time)

    def crossed(self, steps: int, code: int) -> None:
        """Take note of steps done by `edge`, and of the number of the outcome that ended them, 0 for none.

        Raises:
            PlantFailed: They ended early.
        """
        self._sample += steps
        if code:
            what = outcome(code)
            self._sample += what in ("getting", "not finite")  # the step itself succeeded
            self._fail_step(what)

    def calls(self) -> Calls:
        """Return what a loop in C needs to step this plant; it then reports to `stepped`.

        Raises:
            FmuError: A signal is absent, no real number, or in another unit.
        """
        instance = self._open()
        if not self._ready:
            raise self._not_ready()
        return Calls(
            set_real=instance.address("fmi2SetReal").value or 0,
            do_step=instance.address("fmi2DoStep").value or 0,
            get_real=instance.address("fmi2GetReal").value or 0,
            component=instance.component,
            inputs=self._binding.inputs.elements,
            outputs=self._binding.outputs.elements,
            input_references=_plain(self._binding.inputs, self._description.file.name),
            output_references=_plain(self._binding.outputs, self._description.file.name),
            start=self._start_time,
            period=self._period,
            sample=self._sample,
            looks_back=self._set_step_get.looks_back,
        )

    def stepped(self, steps: int, status: int, call: str, outputs: Vector) -> None:
        """Take note of steps that a loop in C did.

        Args:
            steps: That were completed.
            status: Of the last call; when `call` is "not finite", the number of the output.
            call: The call that ended the loop early, empty when none did.
            outputs: The last ones.

        Raises:
            PlantFailed: The loop ended early.
        """
        self._sample += steps
        if call == "not finite":
            self._sample += 1
            instance = self._open()
            name = self._binding.outputs.elements[status]
            failure = instance.failure("not_finite", "", self.time, variable=name, doing=f"{outputs[status]}")
            self._spent, self._ready = PlantFailed(failure), False
            raise self._spent
        if call:
            self._fail(call, status, self.time, "")

    def snapshot(self) -> Snapshot:
        """Return the present state, to `restore` later.

        Raises:
            FmuError: The FMU cannot save its state.
            PlantFailed: It failed to.
        """
        instance = self._open()
        interface = self._description.co_simulation
        if interface is None or not interface.can_save_state:
            raise FmuError(
                f"{self._description.file}: cannot return to an earlier sample, the FMU does not offer "
                "canGetAndSetFMUstate; replay the stop from its start instead."
            )
        handle = ctypes.c_void_p(None)
        with self._remembering():
            instance.call("fmi2GetFMUstate", ctypes.byref(handle), time=self.time, doing="saving its state")
        self._snapshots.append(handle.value or 0)
        self._set_step_get.keep_past()
        return Snapshot(sample=self._sample, handle=handle.value or 0, owner=id(self))

    def restore(self, snapshot: Snapshot) -> Vector:
        """Return to a snapshot of this plant, and return the outputs there."""
        instance = self._open()
        if snapshot.owner != id(self) or snapshot.handle not in self._snapshots:
            raise RuntimeError("this snapshot belongs to another plant or to one that is closed")
        state = ctypes.c_void_p(snapshot.handle)
        with self._remembering():
            instance.call("fmi2SetFMUstate", state, time=self.time, doing="returning to a saved state")
            self._sample = snapshot.sample
            return self._receive()

    def _open(self) -> Instance:
        if self._spent is not None:
            raise self._spent
        if self._instance is None:
            raise RuntimeError("a CoSimulation is used inside 'with'")
        return self._instance

    def _not_ready(self) -> Exception:
        return self._spent or RuntimeError("a CoSimulation is started before it is stepped, inside 'with'")

    def _send(self, inputs: Vector) -> None:
        self._set_step_get.inputs[:] = inputs
        failure = self._set_step_get.send()
        if failure != "fine":
            self._fail_step(failure)

    def _receive(self) -> Vector:
        failure = self._set_step_get.receive()
        if failure != "fine":
            self._fail_step(failure)
        return self._spread()

    def _spread(self) -> Vector:
        """Return the vector of all signals, NaN where the FMU has none."""
        if self._present is None:
            return self._set_step_get.outputs.copy()
        everything = self._blank.copy()
        everything[self._present] = self._set_step_get.outputs
        return everything

    def _fail_step(self, outcome: Outcome) -> None:
        """Raise the failure that ended a communication step early."""
        set_step_get = self._set_step_get
        if outcome == "not finite":
            self._not_finite(set_step_get.outputs[set_step_get.worst])
        doing = {"setting": "setting inputs", "getting": "reading outputs"}.get(outcome, "")
        self._fail(set_step_get.call(outcome), set_step_get.status, self.time, doing)

    def _fail(self, call: str, status: int, time: float, doing: str) -> None:
        """Raise the failure behind a bad status."""
        with self._remembering():
            self._open().check(status, call, time, doing)

    @contextmanager
    def _remembering(self) -> Generator[None]:
        """Keep a failure that passes: the plant is spent and repeats it from then on."""
        try:
            yield
        except PlantFailed as failed:
            self._spent, self._ready = failed, False
            raise

    def _not_finite(self, value: float) -> None:
        name = self._binding.outputs.elements[self._set_step_get.present[self._set_step_get.worst]]
        failure = self._open().failure("not_finite", "", self.time, variable=name, doing=f"{value}")
        with self._remembering():
            raise PlantFailed(failure)


def _plain(side: Side, file: str) -> NDArray[np.uint32]:
    """Return the value references of a side in the order of its vector."""
    if [c.carrier for c in side.channels] != ["Real"] or side.absent:
        raise FmuError(f"{file}: a loop in C wants signals that are all there and all real numbers.")
    channel = side.channels[0]
    if np.any(channel.gain != 1.0) or np.any(channel.shift != 0.0):
        raise FmuError(f"{file}: a loop in C wants signals in our units; {', '.join(channel.variables)} are converted.")
    references = np.empty(side.size, dtype=np.uint32)
    references[channel.positions] = channel.references
    return references
