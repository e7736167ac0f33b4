"""The other end of an isolated plant: owns the FMU, answers one request at a time, ends with its parent.

`main` is started in a new interpreter by `harness.fmu.isolation`, with its end of a socket pair as argument.
"""

import ctypes
import pickle
import signal
import socket
import struct
import sys
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Final, Literal

import numpy as np

from harness.fmu.cosimulation import CoSimulation, Snapshot
from harness.fmu.description import Description
from harness.fmu.mapping import Binding
from harness.fmu.parameters import Values

Request = Literal["open", "start", "step", "snapshot", "restore"]
_CODES: Final[dict[Request, int]] = {"open": 1, "start": 2, "step": 3, "snapshot": 4, "restore": 5}
_REQUESTS: Final = {code: request for request, code in _CODES.items()}
ANSWER: Final = 0
FAILED: Final = 255
_HEAD: Final = struct.Struct("<BI")
_CHUNK: Final = 1 << 16  # bytes; a step's vectors fit a hundred times over


@dataclass(frozen=True, slots=True, kw_only=True)
class Opening:
    """Everything a child needs to open a plant."""

    description: Description
    binding: Binding
    period: float
    parameters: Values
    start_time: float
    tolerance: float | None
    folder: Path


def send(line: socket.socket, kind: Request | int, payload: bytes) -> None:
    """Send one message."""
    code = kind if isinstance(kind, int) else _CODES[kind]
    line.sendall(_HEAD.pack(code, len(payload)) + payload)


def receive(line: socket.socket) -> tuple[int, bytes]:
    """Return the next message; the two ends take turns, so there is never more than one on the line.

    Raises:
        ConnectionError: The other end is gone.
        TimeoutError: The line has a timeout and nothing came.
    """
    got = b""
    wanted = _HEAD.size
    while len(got) < wanted:
        more = line.recv(_CHUNK)
        if not more:
            raise ConnectionError("the other end of the line is gone")
        got += more
        if len(got) >= _HEAD.size:
            wanted = _HEAD.size + _HEAD.unpack_from(got)[1]
    return _HEAD.unpack_from(got)[0], got[_HEAD.size :]


def serve(line: socket.socket) -> None:
    """Answer requests until the line ends; then free the FMU."""
    with ExitStack() as stack:
        plant: CoSimulation | None = None
        snapshots: dict[int, Snapshot] = {}
        while True:
            try:
                code, payload = receive(line)
            except ConnectionError:
                return
            try:
                request = _REQUESTS[code]
                if request == "open":
                    plant = stack.enter_context(_plant(pickle.loads(payload)))
                    answer = b""
                elif plant is None:
                    raise RuntimeError("the first request opens the plant")
                elif request == "snapshot":
                    kept = plant.snapshot()
                    snapshots[kept.handle] = kept
                    answer = pickle.dumps(kept)
                elif request == "restore":
                    answer = plant.restore(snapshots[pickle.loads(payload)]).tobytes()
                elif request == "start":
                    answer = plant.start(np.frombuffer(payload)).tobytes()
                else:
                    answer = plant.step(np.frombuffer(payload)).tobytes()
            except Exception as error:
                # Whatever it is belongs to the parent, which raises it where the question was asked.
                send(line, FAILED, pickle.dumps(error))
            else:
                send(line, ANSWER, answer)


def _plant(opening: Opening) -> CoSimulation:
    return CoSimulation(
        opening.description,
        opening.binding,
        period=opening.period,
        parameters=opening.parameters,
        start_time=opening.start_time,
        tolerance=opening.tolerance,
        folder=opening.folder,
    )


def _end_with_parent() -> None:
    """Ask Linux to end this process when its parent dies, even while the FMU loops."""
    if sys.platform == "linux":
        set_parent_death_signal = 1  # PR_SET_PDEATHSIG, prctl(2)
        ctypes.CDLL(None).prctl(set_parent_death_signal, int(signal.SIGKILL))


def main() -> None:
    """Serve on the file descriptor named on the command line."""
    # Ctrl-C goes to the whole group; the parent decides what becomes of the plant.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    _end_with_parent()
    # Whoever asked may be gone before the answer; then nobody wants it.
    with socket.socket(fileno=int(sys.argv[1])) as line, suppress(ConnectionError):
        serve(line)
