"""One instance of an FMU: loaded, instantiated, and freed in any case.

FMPy unpacks, loads and declares the functions of the shared library; after that they are called directly, because
FMPy's wrapper around each call costs more than the physics behind it.

Values of parameters are checked against the FMU's declarations before any of them is set. They are in the unit that the
FMU declares for the variable, as in every FMI tool; a parameter that the harness itself sets in SI goes through
`Binding.translate` first.
"""

import atexit
import ctypes
import math
import os
import re
import sys
import tempfile
import zipfile
import zlib
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from itertools import chain
from pathlib import Path
from threading import Lock
from typing import Any, Final, Literal, cast

import fmpy
from fmpy.fmi1 import _FMU, FMICallException  # pyright: ignore[reportPrivateUsage] - base of the classes below
from fmpy.fmi2 import (
    FMU2Model,
    FMU2Slave,
    fmi2CallbackAllocateMemoryTYPE,
    fmi2CallbackFreeMemoryTYPE,
    fmi2CallbackFunctions,
    fmi2CallbackLoggerTYPE,
)
from fmpy.fmi3 import FMU3Model, FMU3Slave

from railgrip.base.errors import Failure, FmuError, PlantFailed, Reason
from railgrip.base.files import scratch
from railgrip.base.interrupted import end_if_stuck
from railgrip.fmi.archive import DESCRIPTION, digest, extract
from railgrip.fmi.description import PLATFORMS, Description, FmuVariable, Interface
from railgrip.fmus.native.toolchain import kernel_library

Scalar = float | int | bool | str
_ROUNDING = 1e-14
"""Relative error of a number that two units were multiplied into: a few times the machine epsilon of 2.2e-16."""
Values = Mapping[str, object]
"""Name → number, boolean, string, or a (nested) list of them for an array `name[i]` or `name[i,j]`."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Assignment:
    """Checked values of one FMI type, for one call; arrays of FMI 3.0 are complete."""

    carrier: str
    references: tuple[int, ...]
    values: tuple[Scalar, ...]


def assignments(description: Description, values: Values) -> tuple[Assignment, ...]:
    """Check parameter values and sort them by FMI type.

    Raises:
        FmuError: The FMU lacks a name, a variable cannot be set, or a value has the wrong type or is out of bounds.
    """
    by_type: dict[str, dict[int, list[Scalar]]] = {}
    for name, value in (pair for each in values.items() for pair in _flat(*each)):
        variable = description.variable(name, "parameters")
        if not variable.settable or variable.causality == "input":
            raise FmuError(
                f"parameters: '{name}' of {description.file.name} cannot be set, it is "
                f"{'an input' if variable.causality == 'input' else 'calculated or constant'}; "
                f"leave it out. Its parameters: {_some(description)}."
            )
        scalar = _check(variable, value, description.file.name)
        arrays = by_type.setdefault(variable.carrier, {})
        if variable.reference not in arrays:
            arrays[variable.reference] = start_values(description, variable)
        arrays[variable.reference][variable.element] = scalar
    return tuple(
        Assignment(carrier=carrier, references=tuple(arrays), values=tuple(chain.from_iterable(arrays.values())))
        for carrier, arrays in by_type.items()
    )


def start_values(description: Description, variable: FmuVariable) -> list[Scalar]:
    """Return the start values of all elements of a variable's array, zeros for missing ones; one value for a scalar."""
    plain: dict[str, Callable[[str], Scalar]] = {
        "Real": float, "Boolean": lambda text: text in ("true", "1"), "String": str, "Binary": str,
    }  # fmt: skip
    number = plain.get(variable.kind, lambda text: int(float(text)))
    values = [number("0")] * variable.elements
    for element in description.variables.values():
        is_in_it = element.reference == variable.reference and element.carrier == variable.carrier
        if is_in_it and element.start_text is not None:
            values[element.element] = number(element.start_text.strip())
    return values


def _flat(name: str, value: object, at: tuple[int, ...] = ()) -> Iterator[tuple[str, object]]:
    if isinstance(value, Sequence) and not isinstance(value, str):
        for i, inside in enumerate(cast(Sequence[object], value), start=1):
            yield from _flat(name, inside, (*at, i))
    else:
        yield f"{name}[{','.join(map(str, at))}]" if at else name, value


def _check(variable: FmuVariable, value: object, file: str) -> Scalar:
    who = f"parameters: '{variable.name}' of {file}"
    type_, name = {"String": (str, "a text"), "Boolean": (bool, "true or false")}.get(variable.kind, (None, ""))
    if type_ is not None:
        if not isinstance(value, type_):
            raise FmuError(f"{who} is {name}, got {value!r}.")
        return value
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise FmuError(f"{who} is a number, got {value!r}.")
    if not math.isfinite(value):
        raise FmuError(f"{who} is a finite number, got {value!r}.")
    if variable.kind != "Real" and value != int(value):
        raise FmuError(f"{who} is a whole number, got {value!r}.")
    unit = f" {variable.unit}" if variable.unit not in ("", "1") else ""
    # A value that was converted may miss a bound that it has to meet by its last digits.
    for bound in (variable.minimum, variable.maximum):
        if bound is not None and math.isclose(value, bound, rel_tol=_ROUNDING, abs_tol=0.0):
            value = bound
    if variable.minimum is not None and value < variable.minimum:
        raise FmuError(f"{who} is at least {variable.minimum:g}{unit}, got {value:g}{unit}.")
    if variable.maximum is not None and value > variable.maximum:
        raise FmuError(f"{who} is at most {variable.maximum:g}{unit}, got {value:g}{unit}.")
    return float(value) if variable.kind == "Real" else int(value)


def _some(description: Description) -> str:
    names = description.names("parameter")
    return ", ".join(names[:12]) + (", …" if len(names) > 12 else "")


Way = Literal["co-simulation", "model exchange"]


class _LoadedInPlace(_FMU):
    # FMPy changes to the folder of a library while it loads it, in all threads of the process. The loader needs no such
    # folder: dependencies of a library at an absolute path are found by its own search path, on Windows in its folder.

    def __init__(self, *, libraryPath: str, **names: str) -> None:
        defaults = {"fmiCallLogger": None, "requireFunctions": True, "component": None, "callbacks": None}
        vars(self).update(names, **defaults, _functions={}, dll=ctypes.CDLL(libraryPath))
        self._loadFunctions()


_CLASSES: Final = {
    (fmi, way): type(base.__name__, (base, _LoadedInPlace), {})
    for fmi, way, base in (
        (2, "co-simulation", FMU2Slave), (2, "model exchange", FMU2Model),
        (3, "co-simulation", FMU3Slave), (3, "model exchange", FMU3Model),
    )
}  # fmt: skip
"""Class of FMPy by FMI version and interface."""

OK_OR_WARNING: Final = (0, 1)
"""Status after which results are valid; a number that FMI does not define is an error."""
_REASONS: Final[dict[int, Reason]] = {2: "discard", 3: "error", 4: "fatal", 5: "pending"}
_STATUS_NAMES: Final = ("info", "warning", "discard", "error", "fatal", "pending")
_LAST_SUCCESSFUL_TIME: Final = 2  # fmi2StatusKind
_TERMINATED: Final = 3  # fmi2StatusKind
_LAST: Final = 50  # messages that log.h keeps
_MAX_ITERATIONS: Final = 100  # of an event; far more than any model needs

_KERNEL: Final = ("railgrip.fmi", "log")
_REFERENCE: Final = re.compile(r"#([rRiIbBsS])(\d+)#|##")
_KINDS_OF_REFERENCE: Final = {
    "r": ("Real",), "i": ("Integer", "Enumeration"), "b": ("Boolean",), "s": ("String",)
}  # fmt: skip


def limit_messages(most: int, code: int) -> None:
    """End this process with an exit code when its FMUs have logged more than `most` messages."""
    kernel_library(*_KERNEL).functions.limit_messages(most, code)


_foreign: list[str] = []


@contextmanager
def foreign_code(file: str) -> Generator[None]:
    """Let a sentence name an FMU whose code, loaded into this process, ends the process or does not return."""
    _foreign.append(file)
    _announce_end()
    try:
        with end_if_stuck(" or ".join(_foreign)):
            yield
    finally:
        _foreign.remove(file)
        _announce_end()


def _announce_end() -> None:
    what = "crashed, or ended the program, into which trust = true loads it; correct the FMU.\n"
    text = f"{' or '.join(_foreign)} {what}" if _foreign else ""
    kernel_library(*_KERNEL).functions.announce_end(text.encode())


@atexit.register
def _end_regularly() -> None:
    if _foreign:  # of a bench that is still open
        _foreign.clear()
        _announce_end()


def _callbacks(environment: int) -> fmi2CallbackFunctions:
    callbacks = fmi2CallbackFunctions()
    callbacks.logger = fmi2CallbackLoggerTYPE(kernel_library(*_KERNEL).functions.address_of_logger())
    # The C functions themselves: wrapped in Python, each allocation of the FMU would enter the interpreter.
    callbacks.allocateMemory = fmi2CallbackAllocateMemoryTYPE(_address(fmpy.calloc))
    callbacks.freeMemory = fmi2CallbackFreeMemoryTYPE(_address(fmpy.free))
    callbacks.componentEnvironment = environment
    return callbacks


def _address(function: Any) -> int:
    return ctypes.cast(function, ctypes.c_void_p).value or 0


@contextmanager
def unpack(description: Description) -> Generator[Path]:
    """Yield a temporary folder with the FMU's files, removed at the end.

    Raises:
        FmuError: The file has changed since it was described, or cannot be unpacked.
    """
    here = f"binaries/{PLATFORMS[description.fmi]}/"
    with scratch("fmu") as folder:
        try:
            if digest(description.file) != description.digest:
                raise FmuError(f"{description.file}: the FMU changed while it was being read; try again.")
            kept = (here, "resources/")
            extract(description.file, folder, lambda name: name.startswith(kept) or name == DESCRIPTION)
        except FmuError:
            raise
        except (OSError, ValueError, RuntimeError, zipfile.BadZipFile, zlib.error) as error:
            raise FmuError(f"{description.file}: the FMU cannot be unpacked: {error}") from error
        yield folder


_SOLVER_LINES: Final = re.compile(rb"^LOG_SOLVER .*\n(?:\|.*\n)*", re.MULTILINE)


_STANDARD_OUTPUT: Final = Lock()


@contextmanager
def _without_solver_lines(description: Description) -> Generator[None]:
    # OpenModelica FMUs print a dozen lines with printf whatever logging is set (fmu_read_flags.c of its FMI export),
    # some versions in fmi2Instantiate, some at initialisation. All other output is passed on.
    if "OpenModelica" not in description.generator:
        yield
        return
    libc = ctypes.CDLL("msvcrt" if sys.platform == "win32" else None)
    # Two threads that redirect it at a time could restore each other's file.
    with _STANDARD_OUTPUT, tempfile.TemporaryFile() as file:
        sys.stdout.flush()
        libc.fflush(None)
        before = os.dup(1)
        os.dup2(file.fileno(), 1)
        try:
            yield
        finally:
            libc.fflush(None)
            os.dup2(before, 1)
            os.close(before)
            file.seek(0)
            os.write(1, _SOLVER_LINES.sub(b"", file.read()))


class Instance:
    """A running FMU, the only object of this package with hidden state.

    After fmi2Error only freeing is legal, after fmi2Fatal no call at all (FMI 2.0.4, §2.1.3); `close` complies.
    """

    def __init__(self, description: Description, way: Way, folder: Path, *, name: str) -> None:
        """Load and instantiate the FMU.

        Args:
            folder: Folder of the unpacked FMU.
            name: Name of the instance, used in its messages.

        Raises:
            FmuError: The FMU does not offer this interface, or its library does not load here.
            PlantFailed: The FMU could not be instantiated.
        """
        self.description = description
        interface = _interface(description, way)
        try:
            binaries = folder / "binaries" / PLATFORMS[description.fmi]
            instance: Any = _CLASSES[description.fmi, way](
                guid=description.guid,
                unzipDirectory=str(folder),
                modelIdentifier=interface.identifier,
                instanceName=name,
                libraryPath=str(binaries.absolute() / f"{interface.identifier}{fmpy.sharedLibraryExtension}"),
            )
        except Exception as error:  # OSError of the loader; of FMPy AttributeError for a missing function, and others
            raise FmuError(
                f"{description.file}: its binary does not load on this machine: {error}. "
                f"Export the FMU again for this platform, with all functions of FMI {description.fmi}.0."
            ) from error
        self._library: Any = instance.dll
        self._log = kernel_library(*_KERNEL).struct("Log")
        self._functions = kernel_library(*_KERNEL).functions
        self._functions.open_log(self._log.pointer)
        self.fmpy = instance
        self._running = False
        self._defect: Reason | None = None
        self._saved: list[ctypes.c_void_p] = []
        self.component = 0
        try:
            self._instantiate(way)
        except BaseException:  # an open log would be written to after its memory is freed
            self.close()
            raise

    def _instantiate(self, way: Way) -> None:
        description, instance = self.description, self.fmpy
        with _without_solver_lines(description), suppress(Exception):  # FMPy raises bare Exception if it fails
            if description.fmi == 2:
                instance.instantiate(callbacks=_callbacks(self._log.address), loggingOn=True)
            else:
                instance.instantiate(logMessage=self._hear, loggingOn=True)
            self.component = cast(int, instance.component)
        if not self.component:
            interface = _interface(description, way)
            kind = "CoSimulation" if way == "co-simulation" else "ModelExchange"
            call = "fmi2Instantiate" if description.fmi == 2 else f"fmi3Instantiate{kind}"
            needs = f"it needs {description.generator or 'its tool'} on this machine" if interface.needs_tool else ""
            raise PlantFailed(self.failure("refused", call, 0.0, doing=needs))
        with suppress(FMICallException):  # an FMU without such logging still works
            categories = [c for c in description.log_categories if c in _PROBLEMS]
            instance.setDebugLogging(bool(categories), categories)

    def _hear(self, _: object, status: int, category: bytes, message: bytes) -> None:
        # FMI 3.0 is stepped through FMPy, which releases the interpreter's lock in each call.
        self._functions.record(self._log.pointer, status, message or b"")

    def warnings(self) -> dict[str, int]:
        """Return the messages of warnings and worse so far, each kind with its number; also after `close`.

        Messages that differ only in numbers are of one kind, whose first message is returned.
        """
        log = self._log.pointer
        counts = {self._text(log.kinds[k]): int(log.kinds[k].count) for k in range(log.n_kinds)}
        return counts | ({"further messages": int(log.others)} if log.others else {})

    def _text(self, message: Any) -> str:
        """Return the text of a message, with the names of variables for their references (FMI 2.0.4, §2.1.5)."""
        text = bytes(self._log.bytes_of(message.text)).split(b"\0")[0].decode("utf-8", errors="replace")
        # One line, and no control codes of a terminal.
        text = "".join(c if c.isprintable() else " " for c in text).strip()
        return _REFERENCE.sub(self._name, text)

    def _name(self, reference: re.Match[str]) -> str:
        kind, number = reference[1], reference[2]
        if kind is None:
            return "#"
        kinds = _KINDS_OF_REFERENCE[kind.lower()]
        names = (v.name for v in self.description.variables.values() if v.kind in kinds and v.reference == int(number))
        return next(names, reference[0])

    def address(self, name: str) -> int:
        """Return the address of an FMI function, for a caller in C."""
        return _address(getattr(self._library, name))

    def call(self, name: str, *arguments: Any, time: float, doing: str = "") -> None:
        """Call an FMI function of this instance, outside the stepping loop.

        Raises:
            PlantFailed: The status is neither OK nor a warning.
        """
        self.check(getattr(self._library, name)(self.component, *arguments), name, time, doing)

    def check(self, status: int, name: str, time: float, doing: str = "") -> None:
        """Check a status: OK and warnings pass.

        Raises:
            PlantFailed: The status is another one.
        """
        if status in OK_OR_WARNING:
            return
        reason = _REASONS.get(status, "no_status")
        if reason == "no_status":
            doing = f"{status}{doing and f', {doing}'}"
        failure = self.failure(reason, name, time, doing=doing)
        if reason == "discard" and name == "fmi2DoStep":
            failure = self._discard(failure)
        self._defect = None if reason == "discard" else reason
        raise PlantFailed(failure)

    @contextmanager
    def calling(self, time: float, doing: str = "") -> Generator[Any]:
        """Yield FMPy's interface of this instance, for calls of FMI functions.

        Raises:
            PlantFailed: The status of a call is neither OK nor a warning.
        """
        try:
            yield self.fmpy
        except FMICallException as error:
            self.check(error.status, error.function, time, doing)

    def failure(self, reason: Reason, call: str, time: float, *, variable: str = "", doing: str = "") -> Failure:
        """Return a failure of this FMU with the messages that it logged."""
        log = self._log.pointer
        messages = [log.last[n % _LAST] for n in range(max(log.heard - _LAST, 0), log.heard)]
        worst = [f"{_STATUS_NAMES[min(max(m.status, 0), 5)]}: {self._text(m)}" for m in messages if m.status != 0]
        file, log_ = self.description.file.name, tuple(worst)
        return Failure(file=file, time=time, reason=reason, call=call, variable=variable, detail=doing, log=log_)

    def _discard(self, failure: Failure) -> Failure:
        termination, last_time = ctypes.c_int(0), ctypes.c_double(0.0)
        knows_end = self._library.fmi2GetBooleanStatus(self.component, _TERMINATED, ctypes.byref(termination))
        knows_time = self._library.fmi2GetRealStatus(self.component, _LAST_SUCCESSFUL_TIME, ctypes.byref(last_time))
        return replace(
            failure,
            reason="ended" if knows_end in OK_OR_WARNING and termination.value else "discard",
            reached=last_time.value if knows_time in OK_OR_WARNING else None,
        )

    def assign(self, assignments: tuple[Assignment, ...], time: float) -> None:
        """Set checked parameter values."""
        with self.calling(time, "setting parameters") as fmu:
            for a in assignments:
                getattr(fmu, f"set{a.carrier}")(a.references, a.values)

    def enter_initialization(
        self, begin: float = 0.0, tolerance: float | None = None, end: float | None = None
    ) -> None:
        """Set up the experiment and enter initialisation mode at time `begin` [s].

        Args:
            begin: Time of the start.
            tolerance: Relative error that a slave of FMI 2.0 allows its solver; None leaves it to the slave.
            end: Time of the FMU [s] after which it is not stepped; None if it is not known.
        """
        with _without_solver_lines(self.description), self.calling(begin) as fmu:
            if self.description.fmi == 2:
                fmu.setupExperiment(tolerance=tolerance, startTime=begin, stopTime=end)
                fmu.enterInitializationMode()
            else:
                fmu.enterInitializationMode(startTime=begin, stopTime=end)

    def exit_initialization(self) -> None:
        """Leave initialisation mode."""
        with self.calling(0.0) as fmu:
            fmu.exitInitializationMode()
        self._running = True

    def save_state(self, time: float) -> ctypes.c_void_p:
        """Return the state of the whole FMU, valid until `close`, by fmi2GetFMUstate.

        Raises:
            PlantFailed: The FMU cannot save it.
        """
        state = ctypes.c_void_p()
        self.call("fmi2GetFMUstate", ctypes.byref(state), time=time, doing="saving its state")
        self._saved.append(state)
        return state

    def settle(self, time: float) -> float | None:
        """Iterate an event of Model Exchange, enter continuous time and return the time of the next time event, or
        None.

        Raises:
            PlantFailed: The FMU requests the end, does not converge, or sets its next event in the past or at NaN.
        """
        with self.calling(time, "at an event") as fmu:
            update = fmu.newDiscreteStates if self.description.fmi == 2 else fmu.updateDiscreteStates
            for _ in range(_MAX_ITERATIONS):
                goes_on, ended, _, _, is_defined, next_time = update()
                if ended:
                    raise PlantFailed(self.failure("ended", "", time))
                if not goes_on:
                    if is_defined and not next_time >= time:
                        doing = f"it sets its next event at {next_time:g} s"
                        raise PlantFailed(self.failure("not_integrated", "", time, doing=doing))
                    fmu.enterContinuousTimeMode()
                    return next_time if is_defined else None
        raise PlantFailed(self.failure("not_integrated", "", time, doing="its events never settle"))

    def close(self) -> None:
        """Terminate, free and unload, as far as the last status allows; may be called twice."""
        try:
            self._close()
        finally:
            self._functions.close_log(self._log.pointer)

    def _close(self) -> None:
        if self._defect == "fatal":
            # No function of this FMU may be called any more; its library stays loaded until the process ends.
            self.component = 0
            return
        if self.component:
            component, self.component = self.component, 0
            prefix = f"fmi{self.description.fmi}"
            if self._running and self._defect is None:
                getattr(self._library, f"{prefix}Terminate")(component)
            while self._saved:
                self._library.fmi2FreeFMUstate(component, ctypes.byref(self._saved.pop()))
            getattr(self._library, f"{prefix}FreeInstance")(component)
        if self._library is not None:
            fmpy.freeLibrary(self._library._handle)
            self._library = None


_PROBLEMS: Final = ("logStatusWarning", "logStatusDiscard", "logStatusError", "logStatusFatal", "logStatusPending")
"""Standard log categories (FMI 2.0.4, §2.2.4) that are worth the cost of logging."""


def _interface(description: Description, way: Way) -> Interface:
    interface = description.co_simulation if way == "co-simulation" else description.model_exchange
    if interface is None:
        other = "Model Exchange" if way == "co-simulation" else "Co-Simulation"
        kind = "Co-Simulation" if way == "co-simulation" else "Model Exchange"
        role = "a plant is stepped" if way == "co-simulation" else "a prediction is evaluated"
        raise FmuError(f"{description.file}: {role} through {kind}, this FMU offers only {other}; export it as {kind}.")
    return interface
