"""Entry point: handles signals before slow modules are imported."""

import io
import os
import sys
from importlib import import_module

from railgrip.base.interrupted import Interrupted, listen, stop_listening


def main(arguments: list[str] | None = None, module: str = "railgrip.cli.app") -> None:
    """Run the `main` of a module; Ctrl-C and SIGTERM end it with a sentence, after files and processes are closed."""
    listen()
    _open_standard_streams()
    _write_unicode()
    try:
        import_module(module).main(arguments)
    except Interrupted as end:
        stop_listening()
        print(f"{end}; {end.kept}.", file=sys.stderr)
        sys.exit(end.code)
    finally:
        stop_listening()


def _open_standard_streams() -> None:
    # Otherwise the next file that is opened, perhaps a result, gets the number of a standard stream, and whatever an
    # FMU prints is written into it.
    for number, name, mode in ((0, "stdin", "r"), (1, "stdout", "w"), (2, "stderr", "w")):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # takes the lowest number that is free, which is this one
        if getattr(sys, name) is None:
            setattr(sys, name, open(number, mode, encoding="utf-8", closefd=False))  # noqa: SIM115 - until the end


def _write_unicode() -> None:
    # On Windows the default encoding of files and pipes has neither μ nor ≥.
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(encoding=None if stream.isatty() else "utf-8", errors="replace")


if __name__ == "__main__":
    main()
