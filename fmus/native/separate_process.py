"""Translation of a user's classes in a separate process, with limits of time and memory.

rumoca crashes if expressions are nested deeper than its stack allows, and a few characters of Modelica can declare more
variables than fit into memory. In a separate process such a class results in an error message. Classes of this project
are translated in the caller's process.
"""

import json
import os
import shlex
import signal
import subprocess
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any, Final, NoReturn

from railgrip.base.errors import InputError, TranslationError
from railgrip.base.programs import limit_resources
from railgrip.base.tables import JsonObject

_TASKS: Final = {"translate": "railgrip.fmus.build", "lower": "railgrip.fmus.native.equations"}
"""Task → module whose function TASK_here the process calls; arguments and result are JSON."""

_WAY_OUT: Final = (
    "The class may be valid Modelica that the built-in compiler does not translate. OpenModelica may build it:\n"
    "  railgrip build --compiler openmodelica {options} {class_name}\n"
    "docs/how_to/install.md#openmodelica says where to get it; with omc on the PATH railgrip uses it by itself."
)


@dataclass(frozen=True, slots=True, kw_only=True)
class TranslationLimits:
    """Limits of one translation.

    Attributes:
        seconds: Time [s]; the largest train of this project's tests takes ten.
        memory_mib: Address space [MiB].
    """

    seconds: int = 300
    memory_mib: int = 4096


LIMITS = TranslationLimits()

_KILLED: Final = [-getattr(signal, name) for name in ("SIGXCPU", "SIGKILL") if hasattr(signal, name)]
"""Exit codes of a process that the system ended at a limit of time or memory; Windows has no such signals."""


def call(task: str, class_name: str, library: Path, **arguments: Any) -> Any:
    """Return the result of a task for a class of a library, computed in a separate process.

    Raises:
        InputError: The class cannot be translated, or not within the limits.
    """
    request = {
        "task": task,
        "class_name": class_name,
        "library": str(library),
        "limits": [LIMITS.seconds, LIMITS.memory_mib],
    }
    # Nothing is imported from the current folder, not even if the caller is `python script.py`.
    path = [folder for folder in sys.path if Path(folder).is_absolute() and Path(folder) != Path.cwd()]
    start = f"import sys; sys.path[:] = {path!r}; from {__name__} import main; main()"
    try:
        done = subprocess.run(
            [sys.executable, "-I", "-c", start],
            input=json.dumps(request | {"arguments": arguments}).encode(),
            env=os.environ,  # not the environment of C, in which `dae` hides the user's cache folder from rumoca
            capture_output=True,
            check=False,
            timeout=LIMITS.seconds,
            start_new_session=True,  # Ctrl-C interrupts only this process, which then ends the other
        )
    except subprocess.TimeoutExpired:
        answer = _refuse(f"{class_name} takes more than {LIMITS.seconds} s to translate; make it smaller.")
    else:
        message = done.stderr.decode(errors="replace")
        if done.returncode:
            problem = _process_failure(done.returncode, message)
            answer = _refuse(f"{class_name} {problem}; make it smaller.")
        else:
            sys.stderr.write(message)  # warnings
            answer = json.loads(done.stdout)
    return result_of(answer, task, class_name, library, arguments.get("others", ()))


def result_of(answer: JsonObject, task: str, class_name: str, library: Path, others: Sequence[str] = ()) -> Any:
    """Return the result in an answer of the process; arguments are those of `call`.

    Raises:
        TranslationError: The answer is a refusal of a class that another compiler may build to an FMU, with how.
        InputError: It is any other refusal.
    """
    if "refusal" not in answer:
        return answer["result"]
    if answer["kind"] != "TranslationError":
        raise InputError(answer["refusal"])
    libraries = [Path(one) for one in (str(library), *others)]
    here = [one.relative_to(Path.cwd()) if one.is_relative_to(Path.cwd()) else one for one in libraries]
    options = " ".join(f"--library {shlex.quote(str(one))}" for one in here)
    way_out = "\n" + _WAY_OUT.format(options=options, class_name=class_name) if task == "translate" else ""
    raise TranslationError(answer["refusal"] + way_out)


def _refuse(sentence: str) -> JsonObject:
    return {"kind": "TranslationError", "refusal": sentence}


def _process_failure(code: int, message: str) -> str:
    if code in _KILLED:
        return f"takes more than {LIMITS.seconds} s to translate, or too much memory"
    if "memory" in message:  # Rust aborts, C++ throws bad_alloc: both messages contain it
        return f"takes more than {LIMITS.memory_mib} MiB to translate"
    end = signal.Signals(-code).name if code < 0 else f"exit code {code}"
    return (
        "has an expression that is too long, or an expression or packages that are nested too deeply: its compiler "
        f"ended with {end}"
    )


def main() -> None:
    """Answer the request on standard input on standard output; all other output goes to standard error."""
    request = json.load(sys.stdin)
    answers = os.dup(1)
    os.dup2(2, 1)
    seconds, memory_mib = request["limits"]
    # Of time in addition to the caller's timeout, so that this process ends even if its caller has ended.
    limit_resources({"RLIMIT_CPU": seconds, "RLIMIT_AS": memory_mib << 20, "RLIMIT_CORE": 0})
    answer = _answer(request["task"], request["class_name"], Path(request["library"]), request["arguments"])
    with os.fdopen(answers, "w", encoding="utf-8") as stream:
        json.dump(answer, stream)
    sys.stderr.flush()
    os._exit(0)  # without freeing millions of objects one by one


def _answer(task: str, class_name: str, library: Path, arguments: JsonObject) -> JsonObject:
    function: Callable[..., Any] = getattr(import_module(_TASKS[task]), f"{task}_here")
    try:
        return {"result": function(class_name, library, **arguments)}
    except InputError as error:
        kind = "TranslationError" if isinstance(error, TranslationError) else "InputError"
        return {"kind": kind, "refusal": str(error)}
    except MemoryError:
        _exit_with("out of memory")
    except RecursionError:
        problem = "an expression that is too long or nested too deeply, or a function that calls itself"
        return _refuse(f"{class_name} has {problem}.")
    except BaseException as error:  # the panic of a Rust extension is not an Exception
        if not isinstance(error, Exception) and type(error).__name__ != "PanicException":
            raise
        if "bad_alloc" in str(error):
            _exit_with("out of memory")
        last_line = f"{type(error).__name__}: {error}".strip().splitlines()[-1]
        return _refuse(f"{class_name}: the built-in compiler fails on this class ({last_line}); simplify it.")


def _exit_with(message: str) -> NoReturn:
    os.write(2, message.encode())
    os._exit(1)
