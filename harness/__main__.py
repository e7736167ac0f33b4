"""The way in: listens to signals before anything that takes time is loaded."""

import io
import sys

from railgrip.base.interrupted import Interrupted, listen, stop_listening


def main(arguments: list[str] | None = None) -> None:
    """Run the command line; Ctrl-C and SIGTERM end it with a sentence, after open files and processes are closed."""
    listen()
    _write_unicode()
    try:
        from railgrip.cli.main import main as command_line

        command_line(arguments)
    except Interrupted as end:
        stop_listening()
        print(f"{end}; what had finished is kept.", file=sys.stderr)
        sys.exit(end.code)
    finally:
        stop_listening()


def _write_unicode() -> None:
    """Set the encoding of output to files and pipes: on Windows the default has neither μ nor ≥."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(encoding=None if stream.isatty() else "utf-8", errors="replace")


if __name__ == "__main__":
    main()
