"""The child process of an isolated plant: it owns the FMU and answers one request at a time.

An FMU may write anything to the socket, so answers are numbers and text only: vectors of doubles, and failures as JSON.
Requests come from this program, so the request to open a plant may be pickled.
"""

import json
import os
import pickle
import socket
import struct
from contextlib import ExitStack, suppress
from dataclasses import asdict
from typing import Final, Literal

import numpy as np

from railgrip.base.errors import FmuError, PlantFailed
from railgrip.fmi.by_fmpy import loaded_plant
from railgrip.fmi.instance import limit_messages
from railgrip.fmi.plant import LoadedPlant

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
