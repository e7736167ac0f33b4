"""Steps a co-simulation FMU with as little as possible between the caller's numbers and the FMU's.

A vector of our inputs goes in and a vector of our outputs comes out, both in SI and in the order of the
binding; conversions are applied only where the FMU's units differ. All buffers and addresses are made once.
"""

import ctypes
from collections.abc import Callable, Generator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from math import isfinite
from pathlib import Path
from types import TracebackType
from typing import Protocol, Self, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from harness.fmu.description import Description
from harness.fmu.failure import FmuError, PlantFailed
from harness.fmu.instance import OK_OR_WARNING, Instance, unpacked
from harness.fmu.mapping import Binding, Channel, Side
from harness.fmu.parameters import Values, assignments
from harness.loop.compiled import Calls

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
        self._looks_back = 1  # fmi2True: no state before the current time will ever be restored

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
        """Make the buffers, addresses and functions of the hot path."""
        pointer, size = ctypes.c_void_p, ctypes.c_size_t
        self._component = ctypes.c_void_p(instance.component)
        self._do_step = instance.function("fmi2DoStep", pointer, ctypes.c_double, ctypes.c_double, ctypes.c_int)
        inputs, outputs = self._binding.inputs, self._binding.outputs
        present = np.sort(np.concatenate([[], *(c.positions for c in outputs.channels)])).astype(np.intp)
        self._values = np.zeros(present.size)
        # A sum is finite exactly when all of y is, in one pass: so far scaled down, finite values cannot
        # overflow, and numbers of any physical size stay normal.
        self._total = np.full(present.size, 2.0**-512).dot
        self._present = present if present.size < outputs.size else None
        self._blank = np.full(outputs.size, np.nan)
        carriers = {c.carrier for c in (*inputs.channels, *outputs.channels)}
        setters = {c: instance.function(f"fmi2Set{c}", pointer, pointer, size, pointer) for c in sorted(carriers)}
        getters = {c: instance.function(f"fmi2Get{c}", pointer, pointer, size, pointer) for c in sorted(carriers)}
        self._senders = tuple(_Sender(c, setters[c.carrier], self._component, inputs.size) for c in inputs.channels)
        self._receivers = tuple(
            _Receiver(c, np.searchsorted(present, c.positions), getters[c.carrier], self._component, self._values)
            for c in outputs.channels
        )

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
            self._send(instance, inputs)
            instance.exit_initialization(self._start_time)
            self._sample = 0
            values = self._receive(instance)
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
        period = self._period
        time = self._start_time + self._sample * period
        for sender in self._senders:
            if sender.send(inputs) > OK_OR_WARNING:
                self._fail(f"fmi2Set{sender.carrier}", sender.status, time, "setting inputs")
        status = self._do_step(self._component, time, period, self._looks_back)
        if status > OK_OR_WARNING:
            self._fail("fmi2DoStep", status, time, "")
        self._sample += 1
        for receiver in self._receivers:
            if receiver.receive() > OK_OR_WARNING:
                self._fail(f"fmi2Get{receiver.carrier}", receiver.status, self.time, "reading outputs")
        values = self._values.copy()
        if not isfinite(self._total(values)):
            self._not_finite(values)
        return values if self._present is None else self._spread(values)

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
            looks_back=bool(self._looks_back),
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
        self._looks_back = 0
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
            return self._receive(instance)

    def _open(self) -> Instance:
        if self._spent is not None:
            raise self._spent
        if self._instance is None:
            raise RuntimeError("a CoSimulation is used inside 'with'")
        return self._instance

    def _not_ready(self) -> Exception:
        return self._spent or RuntimeError("a CoSimulation is started before it is stepped, inside 'with'")

    def _send(self, instance: Instance, inputs: Vector) -> None:
        for sender in self._senders:
            instance.check(sender.send(inputs), f"fmi2Set{sender.carrier}", self.time, "setting inputs")

    def _receive(self, instance: Instance) -> Vector:
        for receiver in self._receivers:
            instance.check(receiver.receive(), f"fmi2Get{receiver.carrier}", self.time, "reading outputs")
        values = self._values.copy()
        if not isfinite(self._total(values)):
            self._not_finite(values)
        return self._spread(values)

    def _spread(self, values: Vector) -> Vector:
        """Return the vector of all signals, NaN where the FMU has none."""
        if self._present is None:
            return values
        everything = self._blank.copy()
        everything[self._present] = values
        return everything

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

    def _not_finite(self, values: Vector) -> None:
        instance = self._open()
        worst = int(np.flatnonzero(~np.isfinite(values))[0])
        name = self._binding.outputs.elements[worst if self._present is None else self._present[worst]]
        failure = instance.failure("not_finite", "", self.time, variable=name, doing=f"{values[worst]}")
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


class _Sender:
    """Puts the values of one channel into the FMU."""

    __slots__ = (
        "_address",
        "_buffer",
        "_component",
        "_convert",
        "_count",
        "_gain",
        "_keep",
        "_positions",
        "_set",
        "_shift",
        "_whole",
        "carrier",
        "status",
    )

    def __init__(self, channel: Channel, setter: Callable[..., int], component: ctypes.c_void_p, size: int) -> None:
        n = len(channel.references)
        self.carrier = channel.carrier
        self.status = 0
        self._set = setter
        self._component = component
        self._count = n
        self._buffer = np.zeros(n)
        self._whole = np.zeros(n, dtype=np.int32) if channel.carrier != "Real" else None
        carried = self._buffer if self._whole is None else self._whole
        self._keep = channel.references
        self._address = (
            ctypes.c_void_p(channel.references.ctypes.data),
            ctypes.c_void_p(carried.ctypes.data),
        )
        every = n == size and bool(np.all(channel.positions == np.arange(size)))
        self._positions = None if every else channel.positions
        self._convert = bool(np.any(channel.gain != 1.0) or np.any(channel.shift != 0.0))
        self._gain = channel.gain
        self._shift = channel.shift

    def send(self, inputs: Vector) -> int:
        buffer = self._buffer
        buffer[:] = inputs if self._positions is None else inputs[self._positions]
        if self._convert:
            buffer *= self._gain
            buffer += self._shift
        if self._whole is not None:
            # Nearest: 0.9999999 is a one that was computed.
            self._whole[:] = np.rint(buffer)
        references, values = self._address
        self.status = self._set(self._component, references, self._count, values)
        return self.status


class _Receiver:
    """Takes the values of one channel out of the FMU, into the vector of all outputs."""

    __slots__ = (
        "_buffer",
        "_component",
        "_convert",
        "_count",
        "_direct",
        "_gain",
        "_get",
        "_keep",
        "_positions",
        "_references",
        "_shift",
        "_values",
        "_where",
        "carrier",
        "status",
    )

    def __init__(
        self,
        channel: Channel,
        positions: NDArray[np.intp],
        getter: Callable[..., int],
        component: ctypes.c_void_p,
        values: Vector,
    ) -> None:
        n = len(channel.references)
        self.carrier = channel.carrier
        self.status = 0
        self._get = getter
        self._component = component
        self._count = n
        self._values = values
        self._positions = positions
        first = int(positions[0])
        adjacent = bool(np.all(positions == np.arange(first, first + n)))
        # Reals that lie side by side are written by the FMU straight into their place.
        self._direct = adjacent and channel.carrier == "Real"
        own = np.zeros(n) if channel.carrier == "Real" else np.zeros(n, dtype=np.int32)
        self._buffer = values[first : first + n] if self._direct else own
        self._keep = channel.references
        self._references = ctypes.c_void_p(channel.references.ctypes.data)
        self._where = ctypes.c_void_p(self._buffer.ctypes.data)
        self._convert = bool(np.any(channel.gain != 1.0) or np.any(channel.shift != 0.0))
        self._gain = channel.gain
        self._shift = channel.shift

    def receive(self) -> int:
        self.status = status = self._get(self._component, self._references, self._count, self._where)
        if self._direct:
            if self._convert:
                self._buffer *= self._gain
                self._buffer += self._shift
        else:
            taken = self._buffer
            self._values[self._positions] = taken * self._gain + self._shift if self._convert else taken
        return status
