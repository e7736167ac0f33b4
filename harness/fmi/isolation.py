"""Run a plant or controller in a separate process, so that a crash or an endless loop in it ends in an error message.

An FMU is native code by an unknown author. One that was built here from Modelica sources is loaded into this process; a
user's FMU is not, unless the scenario declares trust. Isolation costs two context switches for each step.

The child process owns the FMU and answers one request at a time (`serve`). An FMU may write anything to the socket, so
answers are numbers and text only: vectors of doubles, and failures as JSON. Requests come from this program, so the
request to open a plant may be pickled.
"""

import json
import os
import pickle
import signal
import socket
import struct
import subprocess
import sys
from collections.abc import Callable, Generator
from contextlib import ExitStack, contextmanager, suppress
from contextvars import ContextVar
from dataclasses import asdict, dataclass
from pathlib import Path
from secrets import token_hex
from time import perf_counter
from typing import Final, Literal, Self

import numpy as np
from pydantic import TypeAdapter, ValidationError

from railgrip.base.arrays import Vector
from railgrip.base.errors import Failure, FmuError, PlantFailed, Reason
from railgrip.base.interrupted import ignore_sigint
from railgrip.base.limits import FMU_LIMITS, MIB, FmuLimits
from railgrip.fmi.by_fmpy import loaded_plant
from railgrip.fmi.description import Description
from railgrip.fmi.instance import Values, limit_messages, unpack
from railgrip.fmi.mapping import Binding
from railgrip.fmi.plant import LoadedPlant, Span, SteppedPlant

Request = Literal["open", "start", "step", "warnings"]
_CODES: Final[dict[Request, int]] = {"open": 1, "start": 2, "step": 3, "warnings": 4}
_REQUESTS: Final = {code: request for request, code in _CODES.items()}
ANSWER: Final = 0
FAILED: Final = 255
REFUSED: Final = 254
TALKATIVE: Final = 251
UNREACHABLE: Final = 252
"""Exit codes of the FMU's process."""
_MAX_MESSAGE: Final = 1 << 24  # bytes of a message
_HEAD: Final = struct.Struct("<BI")
_CHUNK: Final = 1 << 16  # bytes; a step's vectors fit a hundred times over


def send(line: socket.socket, kind: Request | int, payload: bytes) -> None:
    """Send one message."""
    code = kind if isinstance(kind, int) else _CODES[kind]
    line.sendall(_HEAD.pack(code, len(payload)) + payload)


def receive(line: socket.socket) -> tuple[int, bytes]:
    """Return the next message; the two ends take turns, so at most one message is in transit.

    Raises:
        ConnectionError: The other end closed the line.
        ValueError: The bytes are not a message.
        TimeoutError: The line has a timeout and no message came.
    """
    buffer = b""
    size = _HEAD.size
    while len(buffer) < size:
        more = line.recv(_CHUNK)
        if not more:
            raise ConnectionError("the other end of the line is gone")
        buffer += more
        if len(buffer) >= _HEAD.size:
            size = _HEAD.size + _HEAD.unpack_from(buffer)[1]
        if max(size, len(buffer)) > _MAX_MESSAGE:
            raise ValueError("no message is that long")
    if len(buffer) != size:
        raise ValueError("more than a message")
    return _HEAD.unpack_from(buffer)[0], buffer[_HEAD.size :]


def serve(line: socket.socket) -> None:
    """Answer requests until the line is closed; then free the FMU."""
    with ExitStack() as stack:
        plant: LoadedPlant | None = None
        while True:
            try:
                code, payload = receive(line)
            except ConnectionError:
                return
            try:
                request = _REQUESTS[code]
                if request == "open":
                    description, binding, options = pickle.loads(payload)
                    plant = stack.enter_context(loaded_plant(description)(description, binding, **options))
                    answer = b""
                elif plant is None:
                    raise RuntimeError("the first request opens the plant")
                elif request == "warnings":
                    answer = json.dumps(plant.warnings).encode()
                else:
                    answer = getattr(plant, request)(np.frombuffer(payload)).tobytes()
            # Any exception is sent to the parent, which raises it in the caller.
            except PlantFailed as failed:
                failure = failed.failure
                assert not isinstance(failure, str)  # plain text comes from plants in Python only
                send(line, FAILED, json.dumps(asdict(failure)).encode())
            except FmuError as error:
                send(line, REFUSED, str(error).encode())
            except Exception as error:
                send(line, REFUSED, f"{type(error).__name__}: {error}".encode())
            else:
                send(line, ANSWER, answer)


def serve_on(number: int, messages: int) -> None:
    """Report that this process is ready, and serve on the socket of a file descriptor.

    An FMU that logs more messages than allowed ends the process with `TALKATIVE`, one that closes the socket with
    `UNREACHABLE`.
    """
    limit_messages(messages, TALKATIVE)
    # The parent may have exited before the answer, which then has no receiver.
    try:
        with socket.socket(fileno=number) as line, suppress(ConnectionError):
            send(line, ANSWER, b"")
            serve(line)
    except OSError:
        os._exit(UNREACHABLE)


_REPORT: Final = struct.Struct("<iqq")
"""Wait status of the FMU's process, its maximum memory [KiB], the bytes that it printed; sent on the life line."""
KEEPER: Final = Path(__file__).with_name("keeper.py")
_WARNINGS: Final = TypeAdapter(dict[str, int])
_FAILURE: Final = TypeAdapter(Failure)
_READY: Final = 120.0  # s; start of an interpreter with its imports on a busy machine, before any code of the FMU runs
_SHORTEST: Final = 1e-3  # s; a timeout of 0 would not wait at all
_GOODBYE: Final = 2.0  # s for processes to end once they are killed
_TOKEN: Final = "RAILGRIP_ISOLATED"
"""Environment variable that identifies processes started by an FMU, even after they have detached from their parent."""


@dataclass(slots=True)
class _Account:
    """Share of the budget that the FMUs of one run have used.

    Attributes:
        seconds: Wall-clock time of their calls [s].
        printed: Their output [bytes].
    """

    seconds: float = 0.0
    printed: int = 0


_SHARED: Final = ContextVar[_Account | None]("account of the run", default=None)


@contextmanager
def shared_budget() -> Generator[None]:
    """Let the FMUs opened in the block share one budget of time and output, as a stop and its trial runs do."""
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
        span: Span = (0.0, None),
        limits: FmuLimits = FMU_LIMITS,
        table: str = "[vehicle]",
        notify: Callable[[str], None] = lambda sentence: None,
    ) -> None:
        """Check the arguments; no process is started before `with`.

        Args:
            span: See `Span`.
            notify: Called with a sentence for the user if the FMU crashes while it is terminated or freed.
            table: Table of the scenario with the key `trust`; for messages.

        Raises:
            FmuError: A parameter is wrong, a time is not positive, or the system does not support isolation.
        """
        if os.name != "posix":
            raise FmuError(
                f"{description.file.name}: an FMU cannot run in a separate process on this system; "
                f"set trust = true under {table} to load it into this one."
            )
        super().__init__(description, binding, period, parameters, span)
        self._span = span
        self._limits = limits
        self._patience = limits.patience
        self._account = _SHARED.get() or _Account()
        self._notify = notify
        self._process: subprocess.Popen[bytes] | None = None
        self._line: socket.socket | None = None
        self._life: socket.socket | None = None
        self._token = token_hex(8)
        self._hurry = False
        self._is_dead = False
        self._warnings: dict[str, int] = {}

    def __enter__(self) -> Self:
        # The FMU is unpacked in this process, so that its files are removed even if the child crashes.
        with ExitStack() as stack:
            folder = stack.enter_context(unpack(self._description))
            ours, theirs = socket.socketpair()
            stack.callback(ours.close)
            life, its_life = socket.socketpair()
            stack.callback(life.close)
            with theirs, its_life, ignore_sigint():
                # Isolated, -I: neither the current folder nor PYTHONPATH affects imports.
                self._process = subprocess.Popen(
                    [sys.executable, "-I", str(KEEPER), str(theirs.fileno()), str(its_life.fileno()), self._options()],
                    pass_fds=[theirs.fileno(), its_life.fileno()],
                    stdin=subprocess.DEVNULL,
                    stdout=2,  # output of the FMU must not mix with results
                    start_new_session=True,
                    env={**os.environ, "OPENBLAS_NUM_THREADS": "1", _TOKEN: self._token},
                )
            self._line, self._life = ours, life
            stack.callback(self._end)
            self._receive(_READY)
            options = {"period": self._period, "parameters": self._parameters, "span": self._span, "folder": folder}
            self._ask("open", pickle.dumps((self._description, self._binding, options)))
            self._stack = stack.pop_all()
        return self

    def _options(self) -> str:
        # The path has this program's folder after Python's, and never the current folder.
        path = [folder for folder in sys.path if Path(folder).is_absolute() and Path(folder) != Path.cwd()]
        output = max(self._limits.output_mib * MIB - self._account.printed, 0)
        path.append(str(Path(__file__).parents[2]))
        options = {"path": path, "limits": self._limits.model_dump(), "output": output, "report": _REPORT.format}
        return json.dumps(options)

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        """Let the child free the FMU, kill it if it does not, and remove the files."""
        self._hurry = self._hurry or kind is not None  # on an error, do not wait for a step to end
        self._stack.close()

    @property
    def warnings(self) -> dict[str, int]:
        """Messages of warnings so far, each kind with its number; none if the FMU crashed or did not return."""
        if self._line is not None and not self._hurry and not self._is_dead:
            with suppress(PlantFailed, FmuError, ValidationError, OSError):
                send(self._line, "warnings", b"")
                self._warnings = _WARNINGS.validate_json(self._receive(self._patience))
        return self._warnings

    def _end(self) -> None:
        self._warnings = self.warnings
        process, line, life = self._process, self._line, self._life
        self._process = self._line = self._life = None
        if process is None or line is None or life is None:
            return
        line.close()  # the child frees the FMU and exits when the line closes
        if not self._hurry and self._failure is None:
            with suppress(subprocess.TimeoutExpired):
                process.wait(timeout=self._patience)
            self._report_bad_end(process, life)
        life.close()  # the keeper kills the remaining processes when this line closes
        try:
            process.wait(timeout=_GOODBYE)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
        if process.returncode:  # a keeper that was killed may have left processes behind
            _sweep(self._token)

    def _report_bad_end(self, process: subprocess.Popen[bytes], life: socket.socket) -> None:
        # Results are complete by then, so a bad end does not affect them.
        words = f"it did not return within {self._patience:g} s"
        if process.poll() is not None:
            report = self._report_on(life)
            if report is None or report[0] == 0:
                return
            _, words = self._describe_end(*report)
        name = self._description.file.name
        self._notify(f"{name}: when it was terminated and freed after the last step, {words}; the results are valid.")

    def start(self, inputs: Vector) -> Vector:
        """Initialise with `inputs` applied and return the outputs at the start time.

        Raises:
            PlantFailed: The FMU cannot be initialised, crashes or does not return.
        """
        return self._exchange("start", inputs)

    def step(self, inputs: Vector) -> Vector:
        """Hold `inputs` over one period and return the outputs at its end.

        Raises:
            PlantFailed: The FMU did not return OK or not in time, crashed, or an output is not finite.
        """
        return self._exchange("step", inputs)

    def _exchange(self, request: Request, inputs: Vector) -> Vector:
        answer = self._ask(request, np.ascontiguousarray(inputs, dtype=np.float64).tobytes())
        if len(answer) != 8 * self._binding.outputs.size:
            raise self._invalid_answer()
        self.sample += 1
        return np.frombuffer(answer).copy()

    def _ask(self, request: Request, payload: bytes) -> bytes:
        if self._failure is not None:
            raise self._failure
        line = self._line
        if line is None:
            raise RuntimeError("an IsolatedCoSimulation is used inside 'with'")
        with suppress(OSError):  # if the child has exited, its last message may still be read
            send(line, request, payload)
        return self._receive(self._patience)

    def _receive(self, timeout: float) -> bytes:
        line = self._line
        assert line is not None
        left = self._limits.budget - self._account.seconds
        timeout, since = min(timeout, max(left, _SHORTEST)), perf_counter()
        if line.gettimeout() != timeout:  # setting it is a system call, twice per step
            line.settimeout(timeout)
        try:
            kind, answer = receive(line)
        except TimeoutError:
            if timeout >= left:
                words = f"its calls took longer than {_limit('budget', self._limits.budget, 's')}"
                raise self._fail("excess", words) from None
            raise self._fail("timeout", f"within {timeout:g} s of real time, it was stopped") from None
        except OSError:  # ConnectionError and the end of the line
            raise self._fail(*self._reason_of_end()) from None
        except ValueError:
            raise self._invalid_answer() from None
        self._account.seconds += perf_counter() - since
        if kind == ANSWER:
            return answer
        if kind == REFUSED:
            raise FmuError(answer.decode(errors="replace"))
        try:
            self._failure = PlantFailed(_FAILURE.validate_json(answer if kind == FAILED else b""))
        except ValidationError:
            raise self._invalid_answer() from None
        raise self._failure

    def _invalid_answer(self) -> PlantFailed:
        return self._fail("crash", "its process answered nonsense")

    def _fail(self, reason: Reason, detail: str) -> PlantFailed:
        name = self._description.file.name
        self._is_dead = True
        self._failure = PlantFailed(Failure(file=name, time=self.time, reason=reason, detail=detail))
        self._end()
        return self._failure

    def _reason_of_end(self) -> tuple[Reason, str]:
        assert self._life is not None
        report = self._report_on(self._life)
        return self._describe_end(*report) if report else ("crash", "its process is gone, and the one that watched it")

    def _report_on(self, life: socket.socket) -> tuple[int, int] | None:
        life.settimeout(_GOODBYE)
        report = b""
        with suppress(OSError):
            report = life.recv(_REPORT.size)
        if len(report) != _REPORT.size:
            return None
        status, memory_kib, printed = _REPORT.unpack(report)
        self._account.printed += printed
        return status, memory_kib

    def _describe_end(self, status: int, memory_kib: int) -> tuple[Reason, str]:
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
        if memory_kib < limits.memory_mib / 2 * 1024:
            return "crash", sentence
        size = f"{memory_kib / 1024:.0f} MiB; memory_mib under [limits.fmu] is {limits.memory_mib}"
        return "crash", f"{sentence} when it had {size}"


def _limit(key: str, value: float, unit: str = "") -> str:
    return f"allowed; {key} under [limits.fmu] is {value:.12g}{unit and f' {unit}'}"


def _sweep(token: str) -> None:
    # Processes are identified by their environment, which only Linux reveals.
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
    span: Span = (0.0, None),
    limits: FmuLimits = FMU_LIMITS,
    table: str = "[vehicle]",
) -> LoadedPlant | IsolatedCoSimulation:
    """Return a plant to use in `with`: in this process if it is trusted, else in a separate one.

    Args:
        span: See `Span`.
        trusted: Whether it was built here, or the scenario declares trust. An FMU that can be instantiated only once in
            a process runs in a separate one all the same: a stop follows its trial runs, and other stops.
        notify: Called with a sentence for the user if the FMU is isolated; the caller displays it once.
        table: Table of the scenario with the key `trust`; for messages.

    Raises:
        FmuError: A parameter is wrong, or a time is not positive.
    """
    if description.blemishes:
        notify(f"{description.file.name}: {description.blemishes}; it runs all the same.")
    interface = description.co_simulation or description.model_exchange
    is_once = interface is not None and interface.once and os.name == "posix"
    if trusted and not is_once:
        return loaded_plant(description)(description, binding, period=period, parameters=parameters, span=span)
    name = description.file.name
    notify(
        f"{name} can be instantiated only once in a process, and runs in a separate one in spite of "
        f"trust = true under {table}."
        if trusted
        else f"{name} is foreign and runs in a separate process, so that a crash in it does not end the "
        f"stop; set trust = true under {table} to load it into this one, which is faster."
    )
    return IsolatedCoSimulation(
        description, binding, period=period, parameters=parameters, span=span, limits=limits, table=table,
        notify=notify,
    )  # fmt: skip
