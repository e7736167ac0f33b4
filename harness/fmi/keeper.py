"""The process between this program and a foreign FMU: starts the FMU's, and ends whatever comes of it.

It is started as a file in an isolated interpreter: nothing is imported from the current folder. It needs the
standard library only. The FMU's process is forked from it and has a session of its own. On Linux processes that
lose their parent come back to this one: an FMU that forks, or leaves its session, leaves nobody behind.
"""

import ctypes
import json
import os
import select
import signal
import struct
import sys
from contextlib import suppress
from pathlib import Path
from typing import Any, Final

REPORT: Final = struct.Struct("<iqq")
"""Wait status of the FMU's process, the most memory it had [KiB], the bytes that it printed; sent on the life line."""

_LINUX: Final = sys.platform == "linux"
_PARENT_DEATH_SIGNAL: Final = 1  # prctl(2)
_CHILD_SUBREAPER: Final = 36


def main() -> None:
    """Serve on two sockets, the line and the life line; the third argument says how, as JSON."""
    line, life, how = int(sys.argv[1]), int(sys.argv[2]), json.loads(sys.argv[3])
    if _LINUX:
        ctypes.CDLL(None).prctl(_CHILD_SUBREAPER, 1)
    wakeup, wake = os.pipe()
    os.set_blocking(wake, False)
    os.set_blocking(wakeup, False)
    printed, printer = os.pipe()
    os.set_blocking(printed, False)
    signal.set_wakeup_fd(wake)
    signal.signal(signal.SIGCHLD, lambda number, frame: None)
    server = os.fork()
    if server == 0:
        os.dup2(printer, 1)
        os.dup2(printer, 2)
        for number in (life, wakeup, wake, printed, printer):
            os.close(number)
        _serve(line, how)
    os.close(line)
    os.close(printer)
    output = _Output(printed, how["output"])
    ended = _supervise(server, life, wakeup, output)
    with suppress(ProcessLookupError, PermissionError):
        os.killpg(server, signal.SIGKILL)  # its session, at one stroke
    _, status, usage = os.wait4(server, 0)
    _end_the_rest()
    output.forward()
    if ended:
        with suppress(OSError):
            os.write(life, REPORT.pack(status, usage.ru_maxrss, output.size))


class _Output:
    """What the FMU's process prints: forwarded to standard error, and counted.

    Attributes:
        size: Bytes so far; more than allowed are not forwarded.
    """

    def __init__(self, source: int, most: int) -> None:
        self.source, self.most, self.size = source, most, 0

    def forward(self) -> bool:
        """Forward what is there; return whether more may come."""
        while self.size <= self.most:
            try:
                piece = os.read(self.source, 1 << 16)
            except BlockingIOError:
                return True
            if not piece:
                return False
            self.size += len(piece)
            with suppress(OSError):
                os.write(2, piece)
        return False


def _serve(line: int, how: dict[str, Any]) -> None:
    """Become the FMU's process."""
    signal.set_wakeup_fd(-1)
    signal.signal(signal.SIGCHLD, signal.SIG_DFL)
    os.setsid()  # Ctrl-C goes to others; the program decides what becomes of the plant
    if _LINUX:
        ctypes.CDLL(None).prctl(_PARENT_DEATH_SIGNAL, int(signal.SIGKILL))
    _limit(how["limits"])
    sys.path += [folder for folder in how["path"] if folder not in sys.path]
    from railgrip.fmi.child import serve_on

    serve_on(line, how["limits"]["messages"])
    os._exit(0)


def _limit(limits: dict[str, int]) -> None:
    import resource

    for what, limit in (
        (resource.RLIMIT_AS, limits["memory_mib"] << 20),
        (resource.RLIMIT_NOFILE, limits["open_files"]),
        (resource.RLIMIT_FSIZE, limits["output_mib"] << 20),
        # Of all the user's processes and threads, so that those there are already are added.
        *(((resource.RLIMIT_NPROC, limits["processes"] + _tasks()),) if _LINUX else ()),
        (resource.RLIMIT_CORE, 0),
    ):
        _, most = resource.getrlimit(what)
        value = limit if most == resource.RLIM_INFINITY else min(limit, most)
        with suppress(OSError, ValueError):  # a system that does not know this limit
            resource.setrlimit(what, (value, value))


def _tasks() -> int:
    """Return how many processes and threads this user has."""
    count = 0
    for process in Path("/proc").glob("[0-9]*"):
        with suppress(OSError):
            if process.stat().st_uid == os.getuid():
                count += len(list((process / "task").iterdir()))
    return count


def _supervise(server: int, life: int, wakeup: int, output: _Output) -> bool:
    """Wait until the FMU's process has ended or printed too much, or the program wants an end.

    Returns:
        Whether the program is still there and gets a report.
    """
    sources = [life, wakeup, output.source]
    while True:
        ready, _, _ = select.select(sources, [], [])
        if output.source in ready and not output.forward():
            sources.remove(output.source)
            if output.size > output.most:
                return True
        with suppress(BlockingIOError):
            os.read(wakeup, 512)
        # Looked at before it is reaped: until then nobody else can be given its number.
        while status := os.waitid(os.P_ALL, 0, os.WEXITED | os.WNOHANG | os.WNOWAIT):
            if status.si_pid == server:
                return True
            os.waitpid(status.si_pid, 0)
        if life in ready:
            return False


def _end_the_rest() -> None:
    """End what left the session; on Linux it has come back to this process."""
    with suppress(ChildProcessError):
        while True:
            for child in _children():
                with suppress(ProcessLookupError):
                    os.kill(child, signal.SIGKILL)
            os.waitpid(-1, 0)


def _children() -> list[int]:
    children: list[int] = []
    for process in Path("/proc").glob("[0-9]*") if _LINUX else ():
        with suppress(OSError):
            # pid (name) state parent …; a name may hold blanks and brackets.
            if int((process / "stat").read_bytes().rpartition(b")")[2].split()[1]) == os.getpid():
                children.append(int(process.name))
    return children


if __name__ == "__main__":
    main()
