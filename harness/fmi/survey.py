"""Try FMUs: open and step each of a folder in a separate process, validate one, compare durations of steps."""

import ctypes
import re
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from math import isfinite
from pathlib import Path
from typing import Any, Final, cast
from zipfile import BadZipFile

import numpy as np
from fmpy.fmi2 import FMU2Slave
from fmpy.validation import validate_fmu
from numpy.typing import NDArray

from railgrip.base.arrays import Vector
from railgrip.base.errors import Failure, FmuError, PlantFailed
from railgrip.base.limits import FmuLimits
from railgrip.fmi.archive import outline
from railgrip.fmi.description import PLATFORMS, Description, describe
from railgrip.fmi.instance import Instance, unpack
from railgrip.fmi.isolation import IsolatedCoSimulation
from railgrip.fmi.mapping import Binding, Channel, side_of
from railgrip.fmi.plant import CoSimulation
from railgrip.fmus.native.toolchain import shared_library

STEPS: Final = 20
_STEP: Final = 1e-3  # s, if the FMU suggests none
_NUMBERS: Final = ("Real", "Integer", "Boolean", "Enumeration")
_LIMITS: Final = FmuLimits(patience=60.0, memory_mib=4096)
_REFUSALS: Final = {
    r"this is FMI|fmiVersion": "another version of FMI",
    r"no binary for this platform": f"no binary for {PLATFORMS[2]}",
    r"is a clock": "clocks",
    r"not an FMU|archive": "no archive of an FMU",
    r"is not valid FMI|cannot be understood|ModelStructure|in modelDescription.xml": "a description that is not valid",
    r"does not load": "a binary that does not load",
}  # fmt: skip
"""Patterns of refusals → their common reason."""
_AFTER_NAME: Final = re.compile(r"\s*(?:Version|\(|:|,|\s-\s|\bv?\d+\.\d|(?<=[a-z])\d)")


@dataclass(frozen=True, slots=True, kw_only=True)
class SurveyResult:
    """Result for one interface of an FMU.

    Attributes:
        file: Path relative to the folder.
        tool: Tool that made it, without version.
        interface: FMI version, with CS or ME if it was run.
        reason: Reason why it did not step, in a few words; '' on success.
        sentence: The same as the message for a user.
    """

    file: Path
    tool: str
    interface: str
    reason: str
    sentence: str


def survey(folder: Path) -> Iterator[SurveyResult]:
    """Open each FMU of a folder without setting parameters, step it by each of its interfaces and yield the results."""
    for file in sorted(folder.rglob("*.fmu")):
        yield from _survey_file(file, file.relative_to(folder))


def _survey_file(file: Path, name: Path) -> Iterator[SurveyResult]:
    tool, version, step = "unknown", "", ""
    try:
        first = outline(file, _LIMITS)
        tool, version, step = _tool(first.tool), first.version or "", first.step
    except (FmuError, BadZipFile, OSError, KeyError, ValueError, RuntimeError):
        pass  # `describe` reports it
    result = partial(SurveyResult, file=name, tool=tool)
    try:
        description = describe(file, _LIMITS)
    except FmuError as error:
        yield result(interface=version, reason=_reason(error), sentence=_without(file, error))
        return
    ways = {"CS": replace(description, model_exchange=None), "ME": replace(description, co_simulation=None)}
    for way, interface in ways.items():
        if interface.co_simulation is interface.model_exchange is None:
            continue
        reason = sentence = ""
        try:
            _step(interface, step)
        except FmuError as error:
            reason, sentence = _reason(error), _without(file, error)
        except PlantFailed as failed:
            reason = failed.failure.reason.replace("_", " ") if isinstance(failed.failure, Failure) else "other"
            sentence = str(failed)
        yield result(interface=f"{description.fmi}.0 {way}", reason=reason, sentence=sentence)


def _reason(error: FmuError) -> str:
    return next((words for pattern, words in _REFUSALS.items() if re.search(pattern, str(error))), "other")


def _step(description: Description, suggested: str) -> None:
    outputs = [v for v in description.variables.values() if v.causality == "output" and v.kind in _NUMBERS]
    binding = Binding(inputs=side_of(()), outputs=side_of(outputs), unused=(), parameters={})
    try:
        period = float(suggested)
    except ValueError:
        period = _STEP
    period = period if isfinite(period) and period > 0 else _STEP
    with IsolatedCoSimulation(description, binding, period=period, parameters={}, limits=_LIMITS) as plant:
        plant.start(np.zeros(0))
        for _ in range(STEPS):
            plant.step(np.zeros(0))


def _tool(generator: str) -> str:
    name = _AFTER_NAME.split(generator.strip(), maxsplit=1)[0].strip()
    if name.startswith(("OpenModelica", "OMCompiler")):
        return "OpenModelica"
    return "unknown" if name in ("", "an unnamed tool") else name


def _without(file: Path, error: FmuError) -> str:
    return str(error).replace(f"{file}: ", "")


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
    with unpack(description) as folder:
        slave: Any = FMU2Slave(
            guid=description.guid,
            unzipDirectory=str(folder),
            modelIdentifier=cast(Any, description.co_simulation).identifier,
            instanceName="fmpy",
        )
        slave.instantiate()
        slave.setupExperiment(startTime=0.0)
        slave.enterInitializationMode()
        to, start = channels_in.references.tolist(), inputs.tolist()
        slave.setReal(to, start)
        slave.exitInitializationMode()
        references = channels_out.references.tolist()
        last: list[float] = []
        begin = time.perf_counter()
        for k in range(count):
            slave.setReal(to, start)
            slave.doStep(k * period, period)
            last = slave.getReal(references)
        took = time.perf_counter() - begin
        slave.terminate()
        slave.freeInstance()
    return took, np.array(last)


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
    with unpack(description) as folder:
        fmu = Instance(description, "co-simulation", folder, name="c")
        try:
            fmu.enter_initialization()
            fmu.exit_initialization()
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
        finally:
            fmu.close()
    return took, y


def _pointer_and_size(references: NDArray[np.uint32]) -> tuple[ctypes.c_void_p, ctypes.c_size_t]:
    return ctypes.c_void_p(references.ctypes.data), ctypes.c_size_t(len(references))


def _only_real(description: Description, binding: Binding) -> tuple[Channel, Channel]:
    # The means of comparison support only Real variables without conversion, so there is one channel on each side.
    channels = (*binding.inputs.channels, *binding.outputs.channels)
    if [c.carrier for c in channels] != ["Real", "Real"] or any(np.any(c.gain != 1) for c in channels):
        raise FmuError(f"{description.file}: compared are FMUs with Real inputs and outputs in SI.")
    return channels[0], channels[1]
