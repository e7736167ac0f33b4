"""A plant or controller in a process of its own, so that a crash or an endless loop in it ends in a sentence.

An FMU is native code by whoever made it. One that this project built from its own sources is loaded into this
process; one that a user brings is not, unless the scenario says that it may be. The price is two hand-overs
between processes for each step.
"""

import json
import os
import pickle
import signal
import socket
import subprocess
import sys
from collections.abc import Callable, Generator
from contextlib import ExitStack, contextmanager, suppress
from contextvars import ContextVar
from dataclasses import dataclass
from pathlib import Path
from secrets import token_hex
from time import perf_counter
from types import TracebackType
from typing import Final, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import TypeAdapter, ValidationError

from railgrip.base.errors import Failure, FmuError, PlantFailed, Reason
from railgrip.base.interrupted import ignore_sigint
from railgrip.base.limits import FMU_LIMITS, MIB, FmuLimits
from railgrip.fmi.by_fmpy import loaded_plant
from railgrip.fmi.child import ANSWER, FAILED, REFUSED, TALKATIVE, UNREACHABLE, Request, receive, send
from railgrip.fmi.description import Description
from railgrip.fmi.instance import unpack
from railgrip.fmi.keeper import REPORT
from railgrip.fmi.mapping import Binding
from railgrip.fmi.parameters import Values
from railgrip.fmi.plant import LoadedPlant, SteppedPlant

Vector = NDArray[np.float64]

KEEPER: Final = Path(__file__).with_name("keeper.py")
_FAILURE: Final = TypeAdapter(Failure)
_READY: Final = 120.0  # s; a new interpreter on a busy machine, with its imports: nothing of the FMU runs yet
_SHORTEST: Final = 1e-3  # s; a timeout of 0 would not wait at all
_GOODBYE: Final = 2.0  # s for processes to go once they are killed
_TOKEN: Final = "RAILGRIP_ISOLATED"
"""Environment variable by which a process is known as started by an FMU, whatever it did to be nobody's child."""


@dataclass(slots=True)
class _Account:
    """Use of the budget by the FMUs of one run.

    Attributes:
        seconds: Real time of their calls [s].
        printed: Their output [bytes].
    """

    seconds: float = 0.0
    printed: int = 0


_SHARED: Final = ContextVar[_Account | None]("account of the run", default=None)


@contextmanager
def shared_budget() -> Generator[None]:
    """Let the FMUs that are opened within share one budget of time and output, as a stop and its trial runs do."""
    token = _SHARED.set(_SHARED.get() or _Account())
    try:
        yield
    finally:
        _SHARED.reset(token)


class IsolatedCoSimulation(SteppedPlant):
    """An FMU in a child process, with the interface of a `LoadedPlant`."""

    def __init__(
        self,
        description: Description,
        binding: Binding,
        *,
        period: float,
        parameters: Values,
        begin: float = 0.0,
        limits: FmuLimits = FMU_LIMITS,
        table: str = "[vehicle]",
        notify: Callable[[str], None] = lambda sentence: None,
    ) -> None:
        """Check the question; no process is started before `with`.

        Args:
            begin: Time of the FMU at the start [s].
            notify: Gets a sentence for the user when the FMU crashes as it is terminated or freed.
            table: Of the scenario, where it can be trusted; for sentences.

        Raises:
            FmuError: A parameter is wrong, or a time is not positive, or this system has no such processes.
        """
        if os.name != "posix":
            raise FmuError(
                f"{description.file.name}: an FMU cannot have a process of its own on this system; "
                f"set trust = true under {table} to load it into this one."
            )
        super().__init__(description, binding, period, parameters, begin)
        self._limits = limits
        self._patience = limits.patience
        self._account = _SHARED.get() or _Account()
        self._notify = notify
        self._process: subprocess.Popen[bytes] | None = None
        self._line: socket.socket | None = None
        self._life: socket.socket | None = None
        self._token = token_hex(8)
        self._hurry = False

    def __enter__(self) -> Self:
        """Unpack the FMU here, so that its files go even if the child does not survive; start the child."""
        with ExitStack() as stack:
            folder = stack.enter_context(unpack(self._description))
            ours, theirs = socket.socketpair()
            stack.callback(ours.close)
            life, its_life = socket.socketpair()
            stack.callback(life.close)
            with theirs, its_life, ignore_sigint():
                # Isolated, -I: neither the current folder nor PYTHONPATH decides what is imported.
                self._process = subprocess.Popen(
                    [sys.executable, "-I", str(KEEPER), str(theirs.fileno()), str(its_life.fileno()), self._how()],
                    pass_fds=[theirs.fileno(), its_life.fileno()],
                    stdin=subprocess.DEVNULL,
                    stdout=2,  # what the FMU prints is no result
                    start_new_session=True,
                    env={**os.environ, "OPENBLAS_NUM_THREADS": "1", _TOKEN: self._token},
                )
            self._line, self._life = ours, life
            stack.callback(self._end)
            self._receive(_READY)
            options = {"period": self._period, "parameters": self._parameters, "begin": self._begins, "folder": folder}
            self._ask("open", pickle.dumps((self._description, self._binding, options)))
            self._stack = stack.pop_all()
        return self

    def _how(self) -> str:
        """Return limits, and where to import from: after Python's own folders this program's, never the current one."""
        path = [folder for folder in sys.path if Path(folder).is_absolute() and Path(folder) != Path.cwd()]
        output = max(self._limits.output_mib * MIB - self._account.printed, 0)
        how = {"path": [*path, str(Path(__file__).parents[2])], "limits": self._limits.model_dump(), "output": output}
        return json.dumps(how)

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        """Let the child free the FMU, end it if it does not, and remove the files."""
        self._hurry = self._hurry or kind is not None  # whoever breaks off does not wait for a step to end
        self._stack.close()

    def _end(self) -> None:
        process, line, life = self._process, self._line, self._life
        self._process = self._line = self._life = None
        if process is None or line is None or life is None:
            return
        line.close()  # the child takes the end of the line for goodbye
        if not self._hurry and self._failure is None:
            with suppress(subprocess.TimeoutExpired):
                process.wait(timeout=self._patience)
            self._report_bad_end(process, life)
        life.close()  # and its keeper the end of this one for the order to end everything
        try:
            process.wait(timeout=_GOODBYE)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
        if process.returncode:  # whoever killed the keeper may have left something behind
            _sweep(self._token)

    def _report_bad_end(self, process: subprocess.Popen[bytes], life: socket.socket) -> None:
        """Tell the user when the FMU could not be terminated and freed; results are not touched by that."""
        words = f"it did not return within {self._patience:g} s"
        if process.poll() is not None:
            report = self._report_on(life)
            if report is None or report[0] == 0:
                return
            _, words = self._how_it_ended(*report)
        name = self._description.file.name
        self._notify(f"{name}: when it was terminated and freed after the last step, {words}; the results stand.")

    def start(self, inputs: Vector) -> Vector:
        """Initialise with `inputs` applied and return the outputs at the start time.

        Raises:
            PlantFailed: The FMU cannot be initialised, crashes or does not return.
        """
        values = self._values(self._ask("start", _bytes(inputs)))
        self.sample = 0
        return values

    def step(self, inputs: Vector) -> Vector:
        """Hold `inputs` over one period and return the outputs at its end.

        Raises:
            PlantFailed: The FMU did not return OK or not in time, crashed, or an output is not finite.
        """
        values = self._values(self._ask("step", _bytes(inputs)))
        self.sample += 1
        return values

    def _values(self, payload: bytes) -> Vector:
        if len(payload) != 8 * self._binding.outputs.size:
            raise self._nonsense()
        return np.frombuffer(payload).copy()

    def _ask(self, request: Request, payload: bytes) -> bytes:
        """Send one request to the child and return its answer.

        Raises:
            PlantFailed: The FMU failed, the child died, or it did not answer in time.
            FmuError: The child found the question wrong.
        """
        if self._failure is not None:
            raise self._failure
        line = self._line
        if line is None:
            raise RuntimeError("an IsolatedCoSimulation is used inside 'with'")
        with suppress(OSError):  # nobody is there any more: what was last said may still be read
            send(line, request, payload)
        return self._receive(self._patience)

    def _receive(self, timeout: float) -> bytes:
        line = self._line
        assert line is not None
        left = self._limits.budget - self._account.seconds
        timeout, since = min(timeout, max(left, _SHORTEST)), perf_counter()
        if line.gettimeout() != timeout:  # changing it is a call to the system, twice for each step
            line.settimeout(timeout)
        try:
            kind, answer = receive(line)
        except TimeoutError:
            if timeout >= left:
                words = f"its calls took longer than {_limit('budget', self._limits.budget, 's')}"
                raise self._fail("excess", words) from None
            raise self._fail("timeout", f"within {timeout:g} s of real time, it was stopped") from None
        except OSError:  # ConnectionError and the end of the line
            raise self._fail(*self._last_words()) from None
        except ValueError:
            raise self._nonsense() from None
        self._account.seconds += perf_counter() - since
        if kind == ANSWER:
            return answer
        if kind == REFUSED:
            raise FmuError(answer.decode(errors="replace"))
        try:
            self._failure = PlantFailed(_FAILURE.validate_json(answer if kind == FAILED else b""))
        except ValidationError:
            raise self._nonsense() from None
        raise self._failure

    def _nonsense(self) -> PlantFailed:
        return self._fail("crash", "its process answered nonsense")

    def _fail(self, reason: Reason, detail: str) -> PlantFailed:
        name = self._description.file.name
        self._failure = PlantFailed(Failure(file=name, time=self.time, reason=reason, detail=detail))
        self._end()
        return self._failure

    def _last_words(self) -> tuple[Reason, str]:
        """Return how the FMU's process ended."""
        assert self._life is not None
        report = self._report_on(self._life)
        return self._how_it_ended(*report) if report else ("crash", "its process is gone, and the one that watched it")

    def _report_on(self, life: socket.socket) -> tuple[int, int] | None:
        """Return wait status and maximum memory [KiB] of the ended process of the FMU; None without a report."""
        report = _report_on(life)
        if report is None:
            return None
        status, most, printed = report
        self._account.printed += printed
        return status, most

    def _how_it_ended(self, status: int, most: int) -> tuple[Reason, str]:
        """Return the reason and the sentence for the end of the FMU's process."""
        limits, code = self._limits, os.waitstatus_to_exitcode(status)
        if self._account.printed > limits.output_mib * MIB:
            return "excess", f"it printed more than {_limit('output_mib', limits.output_mib)}"
        if code == TALKATIVE:
            return "excess", f"it logged more than {_limit('messages', limits.messages)}"
        if code == UNREACHABLE:
            return "crash", "it closed the descriptor by which its process answers"
        if code >= 0:
            return "crash", f"it ended its process with code {code}"
        name = signal.Signals(-code).name if -code in {each.value for each in signal.Signals} else f"signal {-code}"
        sentence = f"its process was ended by {name}"
        if most < limits.memory_mib / 2 * 1024:
            return "crash", sentence
        size = f"{most / 1024:.0f} MiB; memory_mib under [limits.fmu] is {limits.memory_mib}"
        return "crash", f"{sentence} when it had {size}"


def _report_on(life: socket.socket) -> tuple[int, int, int] | None:
    """Return what the keeper reports, once the FMU's process has ended; None when it does not."""
    life.settimeout(_GOODBYE)
    report = b""
    with suppress(OSError):
        report = life.recv(REPORT.size)
    return REPORT.unpack(report) if len(report) == REPORT.size else None


def _limit(key: str, value: float, unit: str = "") -> str:
    return f"allowed; {key} under [limits.fmu] is {value:.12g}{unit and f' {unit}'}"


def _sweep(token: str) -> None:
    """End every process that an FMU left behind, known by its environment; on Linux only."""
    mark = f"{_TOKEN}={token}".encode()
    for process in Path("/proc").glob("[0-9]*"):
        with suppress(OSError):
            if mark in (process / "environ").read_bytes().split(b"\0"):
                os.kill(int(process.name), signal.SIGKILL)


def open_plant(
    description: Description,
    binding: Binding,
    *,
    period: float,
    parameters: Values,
    trusted: bool,
    notify: Callable[[str], None],
    begin: float = 0.0,
    limits: FmuLimits = FMU_LIMITS,
    table: str = "[vehicle]",
) -> LoadedPlant | IsolatedCoSimulation:
    """Return a plant to use in `with`: in this process when it is trusted, else in one of its own.

    Args:
        begin: Time of the FMU at the start [s].
        trusted: This project built it, or the scenario vouches for it.
        notify: Gets a sentence for the user when the FMU is isolated; the caller shows it once.
        table: Of the scenario, where it can be trusted; for sentences.

    Raises:
        FmuError: A parameter is wrong, or a time is not positive.
    """
    if description.blemishes:
        notify(f"{description.file.name}: {description.blemishes}; it runs all the same.")
    if trusted:
        return loaded_plant(description)(description, binding, period=period, parameters=parameters, begin=begin)
    notify(notice(description, table))
    return IsolatedCoSimulation(
        description,
        binding,
        period=period,
        parameters=parameters,
        begin=begin,
        limits=limits,
        table=table,
        notify=notify,
    )


def notice(description: Description, table: str) -> str:
    """Return the sentence that tells a user why their FMU runs slower than it could, and the table to change that."""
    return (
        f"{description.file.name} comes from outside and runs in a process of its own, so that a "
        f"crash in it cannot take the stop along; set trust = true under {table} to load it into this one, "
        "which is faster."
    )


def _bytes(inputs: Vector) -> bytes:
    return np.ascontiguousarray(inputs, dtype=np.float64).tobytes()
