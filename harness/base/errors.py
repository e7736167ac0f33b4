"""All errors with a message for the user; the class determines the exit code."""

import errno
from dataclasses import dataclass
from math import isfinite
from typing import Final, Literal


class RailgripError(Exception):
    """An error with a message for the user, one line per problem; any other exception is a bug in this program.

    Attributes:
        exit_code: Exit code of the command line: 2 for a wrong input, 3 for a failure in spite of a valid one.
    """

    exit_code = 3


class InputError(RailgripError, ValueError):
    """The input is wrong; the message names file and key, the value found, and the value expected."""

    exit_code = 2


class UnitError(InputError):
    """A text is not a unit or not a quantity, or two units have different dimensions."""


class ScenarioError(InputError):
    """A scenario, campaign or override that cannot be run."""


class EstimationError(ScenarioError):
    """A recording or an estimation cannot be evaluated.

    A signal is missing, a grid is uneven, or a unit has the wrong dimension.
    """


class EstimateWarning(UserWarning):
    """Estimates from Python that are not to be used, where the command ends with exit code 3."""


class RecordError(InputError):
    """A result file is missing, unreadable, or was not written by railgrip."""


class EstimatorError(InputError):
    """A filter cannot be built from these shapes, names or values."""


class LoopError(InputError):
    """Tables, names or sources of a compiled loop are inconsistent."""


class FmuError(InputError):
    """An FMU file, its mapping or a parameter is invalid."""


class TranslationError(InputError):
    """The built-in compiler does not support a Modelica construct; the message names construct, file and line."""


class RewritingError(TranslationError):
    """A form of Modelica that is left as it is; the error of the text as written is shown instead."""


class ShapeError(TranslationError):
    """Arrays of these shapes cannot be combined in Modelica; the caller adds the expression and its place."""


class CompilerMissing(RailgripError):
    """No C compiler (or no OpenModelica) was found on this machine."""


class BuildFailed(RailgripError):
    """A tool failed that should have worked."""


class WriteFailed(RailgripError):
    """A result could not be written; no partial files remain, and previous files are unchanged."""


class ContractBroken(RailgripError, AssertionError):
    """A controller, estimator or sensor model violates its contract; the message names the violated part."""


class SensorsFailed(RailgripError):
    """Sensors failed to return a reading; the stop ends."""


class EstimatorFailed(RailgripError):
    """An estimator failed; the stop ends."""


class ControllerFailed(RailgripError):
    """A controller failed to decide; the stop ends."""


class FilterDiverged(RailgripError, ArithmeticError):
    """The estimate is invalid: a mean that is not finite or a covariance that is not positive definite.

    Attributes:
        why: Reason, as a sentence.
        after: Number of successful steps before it in the same call.
    """

    def __init__(self, why: str, after: int = 0) -> None:
        super().__init__(f"{why} After {after} steps." if after else why)
        self.why, self.after = why, after


Reason = Literal[
    "error", "discard", "fatal", "pending", "no_status", "ended", "not_finite", "crash", "timeout", "excess", "refused",
    "not_integrated",
]  # fmt: skip
"""Kind of failure.

An FMI status, an invalid status, a request of the FMU to end, an output that is not finite, a process that crashed,
hung or exceeded a limit, a failed instantiation, or a failed integration.
"""


@dataclass(frozen=True, slots=True, kw_only=True)
class Failure:
    """Failure of an FMU while it was running; it may end a stop.

    Attributes:
        file: Name of the FMU file.
        time: Simulated time of the failing call [s]; NaN for a prediction, which is evaluated without one.
        reason: Kind of failure.
        call: FMI function that failed, or '' if no call returned.
        variable: Affected variable, or '' if unknown.
        reached: Last time that the FMU reached [s], if it reported one after a discarded step.
        detail: Further information, a clause without full stop, or ''.
        log: Messages of the FMU, oldest first.
    """

    file: str
    time: float
    reason: Reason
    call: str = ""
    variable: str = ""
    reached: float | None = None
    detail: str = ""
    log: tuple[str, ...] = ()

    def __str__(self) -> str:
        fmi = self.call[:4] or "fmi2"
        what = {
            "error": f"{self.call} returned {fmi}Error",
            "discard": f"{self.call} returned {fmi}Discard",
            "fatal": f"{self.call} returned {fmi}Fatal",
            "pending": f"{self.call} returned {fmi}Pending, and asynchronous FMUs are not supported",
            "no_status": f"{self.call} returned a number that is no {fmi}Status",
            "ended": "the FMU requested the end of the simulation",
            "not_finite": (
                f"output '{self.variable}' is not a finite number"
                if self.variable
                else f"{self.call} returned a value that is not a finite number"
            ),
            "crash": "the FMU crashed",
            "timeout": "the FMU did not return",
            "excess": "the FMU was stopped",
            "not_integrated": "the solver could not integrate the FMU",
            "refused": f"the FMU could not be started: {self.call} gave no instance",
        }[self.reason]
        about = f" ({self.detail})" if self.detail else ""
        progress = f"; it came as far as {self.reached:.9g} s" if self.reached is not None else ""
        words = f"; it says: {self.log[-1]}" if self.log else ""
        when = f"at {self.time:.9g} s " if isfinite(self.time) else ""
        return f"{self.file}: {when}{what}{about}{progress}{words}."


class PlantFailed(RailgripError):
    """A plant failed while it was running; `failure` describes it, as a sentence for a plant in Python.

    It can be pickled.
    """

    def __init__(self, failure: Failure | str) -> None:
        super().__init__(failure)
        self.failure = failure

    def __str__(self) -> str:
        return str(self.failure)


_DISK: Final = {errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EROFS, errno.EACCES}
"""Errors of a full or protected disk, for files outside of results, built or temporary ones."""


_NO_PATHS: Final = {
    errno.ENAMETOOLONG: "is longer than a name or path may be on this system; name a shorter one",
    errno.ELOOP: "is a link that leads to itself; remove it, or name the file itself",
}
_LONGEST_NAME: Final = 60  # characters that a message shows


def for_user(problem: BaseException) -> RailgripError | None:
    """Return the error message of an exception for the user, or None for a bug in this program."""
    if isinstance(problem, RailgripError):
        return problem
    if isinstance(problem, OSError) and problem.errno in _DISK:
        return WriteFailed(f"{problem.filename or 'a file or the standard output'}: {problem.strerror}")
    if isinstance(problem, OSError) and problem.errno in _NO_PATHS:
        name = str(problem.filename or "a path")
        shown = name if len(name) <= _LONGEST_NAME else f"{name[:_LONGEST_NAME]}…"
        return InputError(f"{shown}: {_NO_PATHS[problem.errno]}")
    return None
