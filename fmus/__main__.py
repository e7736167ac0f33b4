"""The former command line of this package; `python -m` imports modules from the current folder before any other."""

import sys


def main() -> None:
    """Name the command that has taken its place, and end with exit code 2."""
    print(
        "python -m railgrip.fmus is now `railgrip build`, with --list and --check: a program does not import what "
        "lies in the current folder, as python -m does.",
        file=sys.stderr,
    )
    sys.exit(2)


if __name__ == "__main__":
    main()
