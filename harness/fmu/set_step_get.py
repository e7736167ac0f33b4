"""What crosses the boundary of a co-simulation FMU in a communication step, as one call to C.

Through ctypes every call costs a microsecond, and so does every array operation around it; a step takes four calls and
a dozen such operations, more than the physics of a train behind them.
"""

import ctypes
from functools import cache
from importlib.resources import files
from typing import Any, Final, Literal

import numpy as np
from numpy.typing import NDArray

from railgrip.fmu.instance import Instance
from railgrip.fmu.mapping import Binding, Channel
from railgrip.fmus.native.toolchain import shared_library
from railgrip.loop.ports import CInterface

Vector = NDArray[np.float64]
Outcome = Literal["fine", "setting", "stepping", "getting", "not finite"]

KERNEL: Final = files("railgrip.fmu") / "kernel" / "set_step_get.c"

_SET, _STEP, _GET = 1, 2, 4
_OUTCOMES: Final[tuple[Outcome, ...]] = ("fine", "setting", "stepping", "getting", "not finite")


class _Channel(ctypes.Structure):
    _fields_ = (
        *((name, ctypes.c_void_p) for name in ("exchange", "references", "positions", "gain", "shift", "buffer")),
        *((name, ctypes.c_longlong) for name in ("count", "whole")),
    )


class _SetStepGet(ctypes.Structure):
    _fields_ = (
        *((name, ctypes.c_void_p) for name in ("fmu", "step", "senders", "receivers")),
        *((name, ctypes.c_longlong) for name in ("n_senders", "n_receivers", "n_outputs")),
        *((name, ctypes.c_void_p) for name in ("inputs", "outputs")),
        ("period", ctypes.c_double),
        *((name, ctypes.c_longlong) for name in ("status", "at")),
    )


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
            railgrip.errors.CompilerMissing: There is no C compiler.
        """
        self._binding, sending, receiving = binding, binding.inputs, binding.outputs
        self.present = np.sort(np.concatenate([[], *(c.positions for c in receiving.channels)])).astype(np.intp)
        self.inputs, self.outputs = np.zeros(sending.size), np.zeros(self.present.size)
        self._keep: list[Any] = [instance]
        self._carriers = {
            "setting": tuple(channel.carrier for channel in sending.channels),
            "getting": tuple(channel.carrier for channel in receiving.channels),
        }
        senders = [self._channel(instance, "Set", c, c.positions) for c in sending.channels]
        receivers = [
            self._channel(instance, "Get", c, np.searchsorted(self.present, c.positions)) for c in receiving.channels
        ]
        to, of = (_Channel * len(senders))(*senders), (_Channel * len(receivers))(*receivers)
        self._keep += [to, of]
        self._plan = _SetStepGet(
            fmu=instance.component, step=instance.address("fmi2DoStep"),
            senders=ctypes.addressof(to), receivers=ctypes.addressof(of),
            n_senders=len(senders), n_receivers=len(receivers), n_outputs=self.outputs.size,
            inputs=self.inputs.ctypes.data, outputs=self.outputs.ctypes.data, period=period,
        )  # fmt: skip
        self._cross = _library().cross
        self._address = ctypes.c_void_p(ctypes.addressof(self._plan))

    def _channel(self, instance: Instance, verb: str, channel: Channel, positions: NDArray[np.intp]) -> _Channel:
        whole = channel.carrier != "Real"
        buffer = np.zeros(len(channel.references), dtype=np.intc if whole else np.float64)
        places = np.ascontiguousarray(positions, dtype=np.longlong)
        has_conversion = bool(np.any(channel.gain != 1.0) or np.any(channel.shift != 0.0))
        gain, shift = (np.ascontiguousarray(factor) for factor in (channel.gain, channel.shift))
        self._keep += [buffer, places, gain, shift, channel.references]
        return _Channel(
            exchange=instance.address(f"fmi2{verb}{channel.carrier}"),
            references=channel.references.ctypes.data,
            positions=places.ctypes.data,
            gain=gain.ctypes.data if has_conversion else None,
            shift=shift.ctypes.data if has_conversion else None,
            buffer=buffer.ctypes.data,
            count=buffer.size,
            whole=whole,
        )

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

    def c_interface(self, sample: int) -> CInterface:
        """Return this communication step as C sees it, of a plant that is at a sample."""
        return CInterface(
            cross=ctypes.cast(self._cross, ctypes.c_void_p).value or 0,
            plan=self._address.value or 0,
            inputs=self.inputs,
            outputs=self.outputs,
            present=self.present,
            input_names=self._binding.inputs.elements,
            output_names=tuple(self._binding.outputs.elements[place] for place in self.present),
            period=self._plan.period,
            sample=sample,
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


def outcome(number: int) -> Outcome:
    """Return the outcome that `SetStepGet.step` numbers."""
    return _OUTCOMES[number]


@cache
def _library() -> ctypes.CDLL:
    path = shared_library({"set_step_get.c": KERNEL.read_text(encoding="utf-8")}, "set_step_get")
    # The interpreter lock is kept: handing it over and back would cost as much as the rest of the call.
    library = ctypes.PyDLL(str(path))
    library.cross.argtypes = [ctypes.c_void_p, ctypes.c_int, ctypes.c_double]
    library.cross.restype = ctypes.c_int
    return library
