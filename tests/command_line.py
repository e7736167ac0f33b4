"""Commands of the program, run in this process, and other programs."""

import os
import subprocess
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import pytest

from railgrip.cli.app import main

NO_NETWORK = dict.fromkeys(("http_proxy", "https_proxy", "HTTP_PROXY", "HTTPS_PROXY"), "http://127.0.0.1:9")
"""Variables that send every request to a closed port."""


@dataclass(frozen=True)
class Done:
    """Exit code and output of a command."""

    code: int
    out: str
    err: str

    def refuses(self, sentence: str) -> bool:
        """Return whether the command has refused a wrong input with this sentence."""
        return self.code == 2 and sentence in self.err


def ran(command: Sequence[object], folder: Path | None = None, **variables: str) -> "subprocess.CompletedProcess[str]":
    """Run a program in a folder until it ends, with these environment variables in addition to the present ones."""
    words = [str(word) for word in command]
    return subprocess.run(
        words, cwd=folder, env=os.environ | variables, capture_output=True, encoding="utf-8", check=False,
        stdin=subprocess.DEVNULL, timeout=3600,  # ends one that hangs, also on a busy machine
    )  # fmt: skip


def exit_code(*arguments: object) -> int:
    """Run a command, or one of `tools`, until it ends, without an exception; its output is not captured here."""
    words = [str(argument) for argument in arguments]
    run = main
    if words[:1] == ["tools"]:
        from commands import main as run  # imports studies, which other commands do not need

        del words[0]
    with pytest.raises(SystemExit) as end:
        run(words)
    return int(end.value.code or 0)


def done(capture: pytest.CaptureFixture[str], *arguments: object) -> Done:
    """Run a command until it ends, without a traceback."""
    capture.readouterr()
    code = exit_code(*arguments)
    out, err = capture.readouterr()
    assert "Traceback" not in err
    return Done(code, out, err)
