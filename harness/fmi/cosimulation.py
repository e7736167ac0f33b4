"""Steps a co-simulation FMU 2.0 with as little as possible between the caller's numbers and the FMU's.

A vector of our inputs goes in and a vector of our outputs comes out, both in SI and in the order of the
binding; conversions are applied only where the FMU's units differ. All buffers and addresses are made once.
"""

import ctypes
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Any, Final, Literal

import numpy as np
from numpy.typing import NDArray

from railgrip.base.errors import FmuError
from railgrip.fmi.instance import Instance
from railgrip.fmi.mapping import Binding, Channel
from railgrip.fmi.plant import LoadedPlant
from railgrip.fmus.native.c_library import CLibrary

Vector = NDArray[np.float64]
Outcome = Literal["fine", "setting", "stepping", "getting", "not finite"]

KERNEL: Final = files("railgrip.fmi") / "kernel"

_SET, _STEP, _GET = 1, 2, 4
_OUTCOMES: Final[tuple[Outcome, ...]] = ("fine", "setting", "stepping", "getting", "not finite")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CInterface:
    """A communication step of a plant as C sees it.

    Attributes:
        cross: Address of `int cross(void *plan, int what, double time)`, as `kernel/set_step_get.c` has it.
        plan: Address of its first argument.
        inputs: Read by it, shape (Layout.inputs,).
        outputs: Written by it: those that the plant has.
        present: Their places among all outputs.
    """

    cross: int
    plan: int
    inputs: Vector
    outputs: Vector
    present: NDArray[np.intp]


class SetStepGet:
    """The buffers, addresses and functions of one instance's communication step.

    Attributes:
        inputs: To be written before a step, shape (binding.inputs.size,).
        outputs: Written by it, shape (number present,): the outputs that the FMU has, in the order of the binding.
        present: Places of `outputs` among all of the binding's.
    """

    def __init__(self, instance: Instance, binding: Binding, period: float) -> None:
        """Make the buffers; compile the step, once on a machine.

        Raises:
            railgrip.base.errors.CompilerMissing: There is no C compiler.
        """
        self._binding, sending, receiving = binding, binding.inputs, binding.outputs
        self.present = np.sort(np.concatenate([[], *(c.positions for c in receiving.channels)])).astype(np.intp)
        self.inputs, self.outputs = np.zeros(sending.size), np.zeros(self.present.size)
        self._keep: list[Any] = [instance]
        self._carriers = {
            "setting": tuple(channel.carrier for channel in sending.channels),
            "getting": tuple(channel.carrier for channel in receiving.channels),
        }
        library = _library()
        to, of = (library.records("Channel", len(side.channels)) for side in (sending, receiving))
        for row, channel in zip(to, sending.channels, strict=True):
            self._fill(row, channel, instance.address(f"fmi2Set{channel.carrier}"), channel.positions)
        for row, channel in zip(of, receiving.channels, strict=True):
            places = np.searchsorted(self.present, channel.positions)
            self._fill(row, channel, instance.address(f"fmi2Get{channel.carrier}"), places)
        self._struct = library.struct(
            "SetStepGet", fmu=instance.component, step=instance.address("fmi2DoStep"), senders=to, receivers=of,
            n_senders=len(to), n_receivers=len(of), n_outputs=self.outputs.size, inputs=self.inputs,
            outputs=self.outputs, period=period,
        )  # fmt: skip
        self._plan = self._struct.pointer
        self._cross = _cross()
        self._address = ctypes.c_void_p(self._struct.address)

    def _fill(self, row: np.void, channel: Channel, exchange: int, positions: NDArray[np.intp]) -> None:
        """Write a channel whose values stand at `positions` into its struct."""
        is_integer = channel.carrier != "Real"
        buffer = np.zeros(len(channel.references), dtype=np.intc if is_integer else np.float64)
        places = np.ascontiguousarray(positions, dtype=np.longlong)
        arrays = {"references": channel.references, "positions": places, "buffer": buffer}
        if np.any(channel.gain != 1.0) or np.any(channel.shift != 0.0):
            arrays |= {"gain": np.ascontiguousarray(channel.gain), "shift": np.ascontiguousarray(channel.shift)}
        self._keep += arrays.values()
        row["exchange"], row["count"], row["whole"] = exchange, buffer.size, is_integer
        for name, array in arrays.items():
            row[name] = array.ctypes.data

    @property
    def status(self) -> int:
        """fmi2Status of the call that ended the last communication step early."""
        return self._plan.status

    @property
    def worst(self) -> int:
        """Which of `outputs` was not finite."""
        return self._plan.at

    def call(self, outcome: Outcome) -> str:
        """Return the name of the FMI function that ended the last communication step early."""
        if outcome == "stepping":
            return "fmi2DoStep"
        return f"fmi2{'Set' if outcome == 'setting' else 'Get'}{self._carriers[outcome][self._plan.at]}"

    def c_interface(self) -> CInterface:
        """Return this communication step as C sees it."""
        return CInterface(
            cross=ctypes.cast(self._cross, ctypes.c_void_p).value or 0,
            plan=self._address.value or 0,
            inputs=self.inputs,
            outputs=self.outputs,
            present=self.present,
        )

    def send(self) -> Outcome:
        """Set the inputs."""
        return _OUTCOMES[self._cross(self._address, _SET, 0.0)]

    def receive(self) -> Outcome:
        """Get the outputs."""
        return _OUTCOMES[self._cross(self._address, _GET, 0.0)]

    def step(self, time: float) -> int:
        """Set the inputs, step from `time` [s] and get the outputs; return 0, or the number of the outcome."""
        return self._cross(self._address, _SET | _STEP | _GET, time)

    def follow(self, inputs: Vector, sample: int) -> tuple[Vector, int, int]:
        """Step through rows of inputs from a sample on.

        Returns:
            Rows of outputs, the number of steps that succeeded, and 0 or the number of the outcome that ended them.
        """
        library, outputs = _library(), np.empty((len(inputs), self.outputs.size))
        rows = library.doubles(inputs), inputs.shape[1], library.doubles(outputs)
        code = library.functions.follow(self._plan, len(inputs), sample, *rows)
        return outputs, self._plan.done, code


def outcome(number: int) -> Outcome:
    """Return the outcome that `SetStepGet.step` numbers."""
    return _OUTCOMES[number]


@cache
def _library() -> CLibrary:
    names = "set_step_get.c", "set_step_get.h"
    sources = {name: (KERNEL / name).read_text(encoding="utf-8") for name in names}
    return CLibrary(sources, "set_step_get", names[1:])


@cache
def _cross() -> Any:
    """Return the library's function for calls from Python.

    It keeps the interpreter lock: handing it over and back would cost as much as the rest of the call.
    """
    cross = ctypes.PyDLL(str(_library().path)).cross
    cross.argtypes, cross.restype = [ctypes.c_void_p, ctypes.c_int, ctypes.c_double], ctypes.c_int
    return cross


class CoSimulation(LoadedPlant):
    """A co-simulation FMU 2.0 in this process, stepped in C."""

    def _prepare(self, instance: Instance) -> None:
        self._set_step_get = SetStepGet(instance, self._binding, self._period)
        self._is_full = self._places.size == self._blank.size

    def _send(self, inputs: Vector) -> None:
        self._set_step_get.inputs[:] = inputs
        self._require_fine(self._set_step_get.send())

    def _receive(self) -> Vector:
        self._require_fine(self._set_step_get.receive())
        return self._set_step_get.outputs

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
        failure = set_step_get.step(self.sample * self._period)
        if failure:
            self.note_steps(0, failure)
        self.sample += 1
        return set_step_get.outputs.copy() if self._is_full else self._spread(set_step_get.outputs)

    def follow(self, inputs: Vector) -> Vector:
        """Hold each row of inputs, shape (k, nu), over one period; return the outputs that the FMU has, shape (k, ny).

        Raises:
            FmuError: The shape is another one, or a value is not a finite number.
            PlantFailed: As `step`.
        """
        if not self._ready:
            raise self._not_ready()
        rows, set_step_get = np.ascontiguousarray(inputs, dtype=np.float64), self._set_step_get
        width = set_step_get.inputs.size
        if rows.ndim != 2 or rows.shape[1] != width or not np.all(np.isfinite(rows)):
            found = f"shape {rows.shape}" if rows.ndim != 2 or rows.shape[1] != width else "a value that is none"
            raise FmuError(f"follow: wants rows of {width} finite inputs, got {found}.")
        outputs, steps, code = set_step_get.follow(rows, self.sample)
        self.note_steps(steps, code)
        return outputs

    def c_interface(self) -> CInterface:
        """Return what a loop in C steps this plant by; it then reports to `note_steps`."""
        if not self._ready:
            raise self._not_ready()
        return self._set_step_get.c_interface()

    def note_steps(self, steps: int, code: int) -> None:
        """Take note of steps done by `c_interface`, and of the number of the outcome that ended them, 0 for none.

        Raises:
            PlantFailed: They ended early.
        """
        self.sample += steps
        what = outcome(code)
        self.sample += what in ("getting", "not finite")  # the step itself succeeded
        self._require_fine(what)

    def _require_fine(self, outcome: Outcome) -> None:
        """Raise the failure that ended a communication step early, if one did."""
        if outcome == "fine":
            return
        set_step_get, instance = self._set_step_get, self._open()
        with self._remembering():
            if outcome == "not finite":
                raise self._not_finite(instance, set_step_get.worst, set_step_get.outputs[set_step_get.worst])
            doing = {"setting": "setting inputs", "getting": "reading outputs"}.get(outcome, "")
            instance.check(set_step_get.status, set_step_get.call(outcome), self.time, doing)
