"""Try an FMU: validate it, and compare durations of its steps."""

import ctypes
import time
from collections.abc import Callable, Generator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Final

import numpy as np
from fmpy.validation import validate_fmu
from numpy.typing import NDArray

from railgrip.base.arrays import Vector
from railgrip.base.errors import FmuError
from railgrip.fmi.description import Description
from railgrip.fmi.instance import Instance, unpack
from railgrip.fmi.mapping import Binding, Channel
from railgrip.fmi.plant import CoSimulation
from railgrip.fmus.native.toolchain import shared_library

C_LOOP: Final = """
#include <stddef.h>
typedef int Exchange(void *, const unsigned *, size_t, double *);
typedef int Step(void *, double, double, int);
int steps(Exchange *set, Step *step, Exchange *get, void *fmu, const unsigned *to, size_t inputs, double *u,
          const unsigned *from, size_t outputs, double *y, double period, int count) {
    for (int k = 0; k < count; k++) {
        int status = set(fmu, to, inputs, u);
        if (status < 2) status = step(fmu, k * period, period, 1);
        if (status < 2) status = get(fmu, from, outputs, y);
        if (status != 0 && status != 1) return status;
    }
    return 0;
}
"""


def validation_problems(file: Path) -> list[str]:
    """Return the violations of the FMI standard that FMPy finds in an FMU."""
    return [str(problem) for problem in validate_fmu(str(file))]


def seconds_of_railgrip(
    description: Description, binding: Binding, inputs: Vector, *, period: float, count: int
) -> tuple[float, Vector]:
    """Return the time [s] of `count` steps through `CoSimulation`, and the last outputs."""
    with CoSimulation(description, binding, period=period, parameters={}) as plant:
        last = plant.start(inputs)
        step = plant.step
        begin = time.perf_counter()
        for _ in range(count):
            last = step(inputs)
        return time.perf_counter() - begin, last


def seconds_of_fmpy(
    description: Description, binding: Binding, inputs: Vector, *, period: float, count: int
) -> tuple[float, Vector]:
    """Return the time [s] of `count` steps through FMPy's FMU2Slave, and the last outputs."""
    channels_in, channels_out = _only_real(description, binding)
    to, start, references = channels_in.references.tolist(), inputs.tolist(), channels_out.references.tolist()
    with _started(description, to, start) as fmu:
        slave, last = fmu.fmpy, list[float]()
        begin = time.perf_counter()
        for k in range(count):
            slave.setReal(to, start)
            slave.doStep(k * period, period)
            last = slave.getReal(references)
        return time.perf_counter() - begin, np.array(last)


def seconds_in_c(
    description: Description, binding: Binding, inputs: Vector, *, period: float, count: int
) -> tuple[float, Vector]:
    """Return the processor time [s] of `count` steps in a loop in C, and the last outputs.

    Args:
        binding: Binding with Real variables only.
        inputs: Inputs, held constant.
    """
    channels_in, channels_out = _only_real(description, binding)
    library = ctypes.CDLL(str(shared_library({"steps.c": C_LOOP}, "steps", flags=("-fvisibility=default",))))
    u, y = inputs.astype(float), np.zeros(len(channels_out.references))
    with _started(description, channels_in.references.tolist(), u.tolist()) as fmu:
        arguments = [
            *(ctypes.c_void_p(fmu.address(name)) for name in ("fmi2SetReal", "fmi2DoStep", "fmi2GetReal")),
            ctypes.c_void_p(fmu.component),
            *_pointer_and_size(channels_in.references),
            ctypes.c_void_p(u.ctypes.data),
            *_pointer_and_size(channels_out.references),
            ctypes.c_void_p(y.ctypes.data),
            ctypes.c_double(period),
            ctypes.c_int(count),
        ]
        steps: Callable[..., int] = library.steps
        begin = time.process_time()
        status = steps(*arguments)
        took = time.process_time() - begin
        fmu.check(status, "fmi2DoStep", count * period)
    return took, y


@contextmanager
def _started(description: Description, references: list[int], inputs: list[float]) -> Generator[Instance]:
    with unpack(description) as folder, closing(Instance(description, "co-simulation", folder, name="trial")) as fmu:
        fmu.enter_initialization()
        with fmu.calling(0.0, "setting inputs") as slave:
            slave.setReal(references, inputs)
        fmu.exit_initialization()
        yield fmu


def _pointer_and_size(references: NDArray[np.uint32]) -> tuple[ctypes.c_void_p, ctypes.c_size_t]:
    return ctypes.c_void_p(references.ctypes.data), ctypes.c_size_t(len(references))


def _only_real(description: Description, binding: Binding) -> tuple[Channel, Channel]:
    # The means of comparison support only Real variables without conversion, so there is one channel on each side.
    channels = (*binding.inputs.channels, *binding.outputs.channels)
    if [c.carrier for c in channels] != ["Real", "Real"] or any(np.any(c.gain != 1) for c in channels):
        raise FmuError(f"{description.file}: compared are FMUs with Real inputs and outputs in SI.")
    return channels[0], channels[1]
