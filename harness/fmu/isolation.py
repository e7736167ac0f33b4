"""A plant or controller in a process of its own, so that a crash or an endless loop in it ends in a sentence.

An FMU is native code by whoever made it. One that this project built from its own sources is loaded into this
process; one that a user brings is not, unless the scenario says that it may be. The price is two hand-overs
between processes for each step.
"""

import os
import pickle
import signal
import socket
import subprocess
import sys
from collections.abc import Callable
from contextlib import ExitStack
from math import isfinite
from pathlib import Path
from types import TracebackType
from typing import Final, Self

import numpy as np
from numpy.typing import NDArray

from harness.fmu.child import ANSWER, FAILED, Opening, Request, receive, send
from harness.fmu.cosimulation import CoSimulation, Snapshot
from harness.fmu.description import Description
from harness.fmu.failure import Failure, FmuError, PlantFailed
from harness.fmu.instance import unpacked
from harness.fmu.mapping import Binding
from harness.fmu.parameters import Values
from harness.interrupted import deaf_children

Vector = NDArray[np.float64]

PATIENCE: Final = 10.0
"""Seconds of real time one call of a plant may last; a plant this slow would need hours for a stop anyway."""
_STARTING: Final = 120.0  # s; a new interpreter on a busy machine, with its imports


class IsolatedCoSimulation:
    """A co-simulation FMU in a child process, with the interface of `CoSimulation`."""

    def __init__(
        self,
        description: Description,
        binding: Binding,
        *,
        period: float,
        parameters: Values,
        start_time: float = 0.0,
        tolerance: float | None = None,
        patience: float = PATIENCE,
        table: str = "[vehicle]",
    ) -> None:
        """Check the question; no process is started before `with`.

        Args:
            description: Of the FMU.
            binding: Of our signals to its variables.
            period: Communication step [s].
            parameters: Values by FMU variable, in the FMU's units.
            start_time: [s].
            tolerance: Relative tolerance for the FMU's solver; None leaves it to the FMU.
            patience: Real time [s] that one call may last.
            table: Of the scenario, where it can be trusted; for sentences.

        Raises:
            FmuError: A parameter is wrong, or a time is not positive, or this system has no such processes.
        """
        if not (isfinite(patience) and patience > 0):
            raise FmuError(f"{description.file.name}: patience is a positive time, got {patience} s.")
        if os.name != "posix":
            raise FmuError(
                f"{description.file.name}: an FMU cannot have a process of its own on this system; "
                f"set trust = true under {table} to load it into this one."
            )
        CoSimulation(description, binding, period=period, parameters=parameters)  # the same questions are wrong
        self._description = description
        self._binding = binding
        self._period = period
        self._parameters = dict(parameters)
        self._start_time = start_time
        self._tolerance = tolerance
        self._patience = patience
        self._stack = ExitStack()
        self._process: subprocess.Popen[bytes] | None = None
        self._line: socket.socket | None = None
        self._spent: PlantFailed | None = None
        self._sample = -1
        self._hurry = False

    def __enter__(self) -> Self:
        """Unpack the FMU here, so that its files go even if the child does not survive; start the child."""
        with ExitStack() as stack:
            folder = stack.enter_context(unpacked(self._description))
            ours, theirs = socket.socketpair()
            stack.callback(ours.close)
            with theirs, deaf_children():
                self._process = subprocess.Popen(
                    [
                        sys.executable,
                        "-c",
                        "from harness.fmu.child import main; main()",
                        str(theirs.fileno()),
                    ],
                    pass_fds=[theirs.fileno()],
                    stdin=subprocess.DEVNULL,
                    stdout=2,  # what the FMU prints is no result
                    env={**os.environ, "PYTHONPATH": os.pathsep.join(p for p in sys.path if p)},
                )
            stack.callback(self._end)
            self._line = ours
            self._ask("open", pickle.dumps(self._opening(folder)), patience=_STARTING + self._patience)
            self._stack = stack.pop_all()
        return self

    def _opening(self, folder: Path) -> Opening:
        return Opening(
            description=self._description,
            binding=self._binding,
            period=self._period,
            parameters=self._parameters,
            start_time=self._start_time,
            tolerance=self._tolerance,
            folder=folder,
        )

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        """Let the child free the FMU, end it if it does not, and remove the files."""
        self._hurry = self._hurry or kind is not None  # whoever breaks off does not wait for a step to end
        self._stack.close()

    def _end(self) -> None:
        process, line = self._process, self._line
        self._process = self._line = None
        if process is None:
            return
        if line is not None:
            line.close()  # the child takes the end of the line for goodbye
        try:
            process.wait(timeout=0 if self._hurry or self._spent is not None else self._patience)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()

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
            PlantFailed: The FMU cannot be initialised, crashes or does not return.
        """
        values = self._values(self._ask("start", _bytes(inputs)))
        self._sample = 0
        return values

    def step(self, inputs: Vector) -> Vector:
        """Hold `inputs` over one period and return the outputs at its end.

        Raises:
            PlantFailed: The FMU did not return OK or not in time, crashed, or an output is not finite.
        """
        values = self._values(self._ask("step", _bytes(inputs)))
        self._sample += 1
        return values

    def snapshot(self) -> Snapshot:
        """Return the present state, to `restore` later; as `CoSimulation.snapshot`."""
        kept: Snapshot = pickle.loads(self._ask("snapshot", b""))
        return Snapshot(sample=kept.sample, handle=kept.handle, owner=id(self))

    def restore(self, snapshot: Snapshot) -> Vector:
        """Return to a snapshot of this plant, and return the outputs there."""
        if snapshot.owner != id(self):
            raise RuntimeError("this snapshot belongs to another plant or to one that is closed")
        values = self._values(self._ask("restore", pickle.dumps(snapshot.handle)))
        self._sample = snapshot.sample
        return values

    @staticmethod
    def _values(payload: bytes) -> Vector:
        return np.frombuffer(payload).copy()

    def _ask(self, request: Request, payload: bytes, patience: float | None = None) -> bytes:
        """Send one request to the child and return its answer.

        Raises:
            PlantFailed: The FMU failed, the child died, or it did not answer in time.
            FmuError: The child found the question wrong.
        """
        if self._spent is not None:
            raise self._spent
        line = self._line
        if line is None:
            raise RuntimeError("an IsolatedCoSimulation is used inside 'with'")
        allowed = patience or self._patience
        if line.gettimeout() != allowed:  # changing it is a call to the system, twice for each step
            line.settimeout(allowed)
        try:
            send(line, request, payload)
            kind, answer = receive(line)
        except TimeoutError:
            raise self._gone("timeout", f"within {allowed:g} s of real time, it was stopped") from None
        except OSError:  # ConnectionError and the end of the line: nobody is there any more
            raise self._gone("crash", self._last_words()) from None
        if kind == ANSWER:
            return answer
        assert kind == FAILED
        error: Exception = pickle.loads(answer)
        if isinstance(error, PlantFailed):
            self._spent = error
        raise error

    def _gone(self, reason: str, detail: str) -> PlantFailed:
        self._spent = PlantFailed(
            Failure(
                file=self._description.file.name,
                time=self.time,
                reason="timeout" if reason == "timeout" else "crash",
                detail=detail,
            )
        )
        if self._process is not None:
            self._process.kill()
        return self._spent

    def _last_words(self) -> str:
        """Say how the child ended."""
        assert self._process is not None
        try:
            code = self._process.wait(timeout=self._patience)
        except subprocess.TimeoutExpired:
            return "its process stopped answering"
        if code < 0:
            return f"its process was ended by {signal.Signals(-code).name}"
        return f"it ended its process with code {code}"


def open_plant(
    description: Description,
    binding: Binding,
    *,
    period: float,
    parameters: Values,
    trusted: bool,
    tell: Callable[[str], None],
    start_time: float = 0.0,
    tolerance: float | None = None,
    patience: float = PATIENCE,
    table: str = "[vehicle]",
) -> CoSimulation | IsolatedCoSimulation:
    """Return a plant to use in `with`: in this process when it is trusted, else in one of its own.

    Args:
        description: Of the FMU.
        binding: Of our signals to its variables.
        period: Communication step [s].
        parameters: Values by FMU variable, in the FMU's units.
        trusted: This project built it, or the scenario vouches for it.
        tell: Gets a sentence for the user when the FMU is isolated; the caller shows it once.
        start_time: [s].
        tolerance: Relative tolerance for the FMU's solver; None leaves it to the FMU.
        patience: Real time [s] that one call may last in isolation.
        table: Of the scenario, where it can be trusted; for sentences.

    Raises:
        FmuError: A parameter is wrong, or a time is not positive.
    """
    if trusted:
        return CoSimulation(
            description,
            binding,
            period=period,
            parameters=parameters,
            start_time=start_time,
            tolerance=tolerance,
        )
    tell(notice(description, table))
    return IsolatedCoSimulation(
        description,
        binding,
        period=period,
        parameters=parameters,
        start_time=start_time,
        tolerance=tolerance,
        patience=patience,
        table=table,
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
