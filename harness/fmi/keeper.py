"""The process between this program and a foreign FMU: it starts the FMU's process, and kills all of its descendants.

It is started as a file in an isolated interpreter: nothing is imported from the current folder. It needs the standard
library only. The FMU's process is forked from it and has a separate session. On Linux orphaned processes are reparented
to this one, so an FMU that forks, or leaves its session, leaves no process behind.
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

_LINUX: Final = sys.platform == "linux"
_PARENT_DEATH_SIGNAL: Final = 1  # prctl(2)
_CHILD_SUBREAPER: Final = 36


def main() -> None:
    """Serve on two sockets, the line and the life line.

    The third argument has the limits, the import path and the format of the report as JSON.
    """
    line, life, options = int(sys.argv[1]), int(sys.argv[2]), json.loads(sys.argv[3])
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
        _serve(line, options)
    os.close(line)
    os.close(printer)
    output = _Output(printed, options["output"])
    ended = _supervise(server, life, wakeup, output)
    with suppress(ProcessLookupError, PermissionError):
        os.killpg(server, signal.SIGKILL)  # kills the whole session at once
    _, status, usage = os.wait4(server, 0)
    _end_the_rest()
    output.forward()
    if ended:
        with suppress(OSError):
            os.write(life, struct.pack(options["report"], status, usage.ru_maxrss, output.size))


class _Output:
    """Output of the FMU's process: forwarded to standard error, and counted.

    Attributes:
        size: Bytes so far; those beyond the limit are not forwarded.
    """

    def __init__(self, source: int, limit: int) -> None:
        self.source, self.limit, self.size = source, limit, 0

    def forward(self) -> bool:
        """Forward the available output; return whether more may come."""
        while self.size <= self.limit:
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


def _serve(line: int, options: dict[str, Any]) -> None:
    signal.set_wakeup_fd(-1)
    signal.signal(signal.SIGCHLD, signal.SIG_DFL)
    os.setsid()  # Ctrl-C does not reach the FMU; the program decides when the plant ends
    if _LINUX:
        ctypes.CDLL(None).prctl(_PARENT_DEATH_SIGNAL, int(signal.SIGKILL))
    sys.path += [folder for folder in options["path"] if folder not in sys.path]
    from railgrip.base.programs import limit_resources

    limits = options["limits"]
    allowed = {"RLIMIT_AS": limits["memory_mib"] << 20, "RLIMIT_NOFILE": limits["open_files"]}
    allowed |= {"RLIMIT_FSIZE": limits["output_mib"] << 20, "RLIMIT_CORE": 0}
    if _LINUX:  # the limit counts all processes and threads of the user, so existing ones are added
        allowed["RLIMIT_NPROC"] = limits["processes"] + _tasks()
    limit_resources(allowed)
    from railgrip.fmi.isolation import serve_on

    serve_on(line, limits["messages"])
    os._exit(0)


def _tasks() -> int:
    count = 0
    for process in Path("/proc").glob("[0-9]*"):
        with suppress(OSError):
            if process.stat().st_uid == os.getuid():
                count += len(list((process / "task").iterdir()))
    return count


def _supervise(server: int, life: int, wakeup: int, output: _Output) -> bool:
    """Wait until the FMU's process has ended or printed too much, or the program requests the end.

    Returns:
        Whether the program is still running and gets a report.
    """
    sources = [life, wakeup, output.source]
    while True:
        ready, _, _ = select.select(sources, [], [])
        if output.source in ready and not output.forward():
            sources.remove(output.source)
            if output.size > output.limit:
                return True
        with suppress(BlockingIOError):
            os.read(wakeup, 512)
        # Checked before the process is reaped: until then its number cannot be reused.
        while status := os.waitid(os.P_ALL, 0, os.WEXITED | os.WNOHANG | os.WNOWAIT):
            if status.si_pid == server:
                return True
            os.waitpid(status.si_pid, 0)
        if life in ready:
            return False


def _end_the_rest() -> None:
    # On Linux, processes that left the session have been reparented to this one.
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
            # pid (name) state parent …; a name may contain blanks and brackets.
            if int((process / "stat").read_bytes().rpartition(b")")[2].split()[1]) == os.getpid():
                children.append(int(process.name))
    return children


if __name__ == "__main__":
    main()
