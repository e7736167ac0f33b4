"""Steps a co-simulation FMU 2.0 with minimal overhead between the caller's numbers and the FMU's.

The input and output vectors are in SI and in the order of the binding; values are converted only where the FMU's units
differ. All buffers and addresses are created once.
"""

import ctypes
from functools import cache
from typing import Any, Final

import numpy as np

from railgrip.base.arrays import Vector
from railgrip.base.errors import FmuError
from railgrip.fmi.instance import Instance
from railgrip.fmi.mapping import Channel
from railgrip.fmi.plant import LoadedPlant
from railgrip.fmus.native.c_library import kernel_library

_KERNEL: Final = ("railgrip.fmi", "set_step_get")


@cache
def _step() -> Any:
    """Return the library's function for calls from Python.

    It releases the interpreter's lock: a thread of the FMU may need it, and so does Ctrl-C.
    """
    step = ctypes.CDLL(str(kernel_library(*_KERNEL).path)).set_step_get
    step.argtypes, step.restype = [ctypes.c_void_p, ctypes.c_double], ctypes.c_int
    return step


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
        self._keep: list[Any] = []
        library = kernel_library(*_KERNEL)
        to, of = (library.records("Channel", len(side.channels)) for side in (sending, receiving))
        for row, channel in zip(to, sending.channels, strict=True):
            self._fill(row, channel, instance.address(f"fmi2Set{channel.carrier}"))
        for row, channel in zip(of, receiving.channels, strict=True):
            self._fill(row, channel, instance.address(f"fmi2Get{channel.carrier}"))
        self._struct = library.struct(
            "SetStepGet", fmu=instance.component, step=instance.address("fmi2DoStep"), senders=to, receivers=of,
            n_senders=len(to), n_receivers=len(of), n_outputs=self.outputs.size, inputs=self.inputs,
            outputs=self.outputs, period=self._period, begin=self._begins,
        )  # fmt: skip
        self._functions = library.functions
        self._step, self._address = _step(), ctypes.c_void_p(self._struct.address)
        self.entry = ctypes.cast(self._step, ctypes.c_void_p).value or 0
        self.plan = self._struct.address

    def _fill(self, row: np.void, channel: Channel, exchange: int) -> None:
        is_integer = channel.carrier != "Real"
        buffer = np.zeros(len(channel.references), dtype=np.intc if is_integer else np.float64)
        places = np.ascontiguousarray(channel.positions, dtype=np.longlong)
        arrays = {"references": channel.references, "positions": places, "buffer": buffer}
        if np.any(channel.gain != 1.0) or np.any(channel.shift != 0.0):
            arrays |= {"gain": np.ascontiguousarray(channel.gain), "shift": np.ascontiguousarray(channel.shift)}
        self._keep += arrays.values()
        row["transfer"], row["count"], row["whole"] = exchange, buffer.size, is_integer
        for name, array in arrays.items():
            row[name] = array.ctypes.data

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
        outcome = self._step(self._address, self.sample * self._period)
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
        library, outputs, plan = (
            kernel_library(*_KERNEL),
            np.empty((len(rows), self.outputs.size)),
            self._struct.pointer,
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
