"""Run a command and print the processor time that it and its child processes have used.

python tests/processor_time.py make suite kept
"""

import os
import subprocess
import sys
from collections.abc import Sequence


def main(command: Sequence[str]) -> int:
    """Run a command, print its processor time, and return its exit code; that of a signal is 128 and its number."""
    try:
        code = subprocess.run(command, check=False).returncode
    except KeyboardInterrupt:  # the command got it, too, and has written its own message
        code = 130
    spent = os.times()
    seconds = spent.children_user + spent.children_system
    print(
        f"processor time: {seconds:.0f} s (user {spent.children_user:.0f} s, system {spent.children_system:.0f} s)",
        flush=True,
    )
    return code if code >= 0 else 128 - code


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
