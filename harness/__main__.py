"""The way in: listens to signals before anything that takes time is loaded."""

import sys

from railgrip.base.interrupted import Interrupted, listen, stop_listening


def main(arguments: list[str] | None = None) -> None:
    """Run the command line; Ctrl-C and SIGTERM end it with a sentence, once what was open is closed."""
    listen()
    try:
        from railgrip.cli.main import main as command_line

        command_line(arguments)
    except Interrupted as end:
        stop_listening()
        print(f"{end}; what had finished is kept.", file=sys.stderr)
        sys.exit(end.code)
    finally:
        stop_listening()


if __name__ == "__main__":
    main()
