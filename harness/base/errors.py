"""Every sentence to a user is one of these; the class says whether asking differently helps."""

import errno
from dataclasses import dataclass
from typing import Final, Literal


class RailgripError(Exception):
    """What ends in a sentence for the user, one line a problem; anything else is a mistake of this program.

    Attributes:
        exit_code: What the command line answers with: 2 for a wrong question, 3 for what failed in spite of a good one.
    """

    exit_code = 3


class InputError(RailgripError, ValueError):
    """The input is wrong; the text names the file and key, what was wanted and found."""

    exit_code = 2


class UnitError(InputError):
    """A text that is no unit or no quantity, or two units of different dimensions."""


class ScenarioError(InputError):
    """A scenario, campaign or override that cannot be run."""


class EstimationError(ScenarioError):
    """A recording or an estimation that gives no estimate: a signal is missing, a grid uneven, a unit does not fit."""


class RecordError(InputError):
    """A result file that is missing, unreadable or not one of ours."""


class EstimatorError(InputError):
    """A shape, a name or a value that no filter can be made of."""


class LoopError(InputError):
    """Tables, names or sources of a compiled loop that do not fit each other."""


class FmuError(InputError):
    """An FMU file, its mapping or a parameter cannot be what was meant."""


class TranslationError(InputError):
    """A Modelica construct the built-in compiler does not translate; names construct, file and line."""


class CompilerMissing(RailgripError):
    """No C compiler (or no OpenModelica) on this machine."""


class BuildFailed(RailgripError):
    """A tool that should have worked did not."""


class Unwritten(RailgripError):
    """A result could not be written; nothing of it was left, and what was there before is untouched."""


class ContractBroken(RailgripError, AssertionError):
    """A controller, estimator or sensor model does not keep its contract; the text says which part of it."""


class SensorsFailed(RailgripError):
    """Sensors gave no reading; the stop ends with that."""


class EstimatorFailed(RailgripError):
    """An estimator could not go on; the stop ends with that."""


class ControllerFailed(RailgripError):
    """A controller could not decide; the stop ends with that."""


class FilterDiverged(RailgripError, ArithmeticError):
    """The belief is no longer one: a mean that is not finite or a covariance that is not positive definite.

    Attributes:
        why: The sentence.
        after: Steps of the same call that went well before.
    """

    def __init__(self, why: str, after: int = 0) -> None:
        """Say why, and after how many steps if there were any."""
        super().__init__(f"{why} After {after} steps." if after else why)
        self.why, self.after = why, after


Reason = Literal[
    "error", "discard", "fatal", "pending", "no_status", "ended", "not_finite", "crash", "timeout", "excess", "refused",
    "not_integrated",
]  # fmt: skip
"""What went wrong: an FMI status, a number that is none, an FMU that requested the end, a value that is no number, a
process that died, hung or took too much, an FMU that would not be instantiated, or could not be integrated."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Failure:
    """How and when an FMU failed while it ran; a stop can end with one.

    Attributes:
        file: Name of the FMU file.
        time: Simulated time of the failing call [s].
        reason: The kind of failure.
        call: FMI function that failed, or '' when none returned.
        variable: Variable concerned, or '' when unknown.
        reached: Last time the FMU itself reached [s], when it said so after a discarded step.
        detail: More about it, a clause without full stop, or ''.
        log: What the FMU said, oldest first.
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
        """Return the sentence for the user."""
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
        return f"{self.file}: at {self.time:.9g} s {what}{about}{progress}{words}."


class PlantFailed(RailgripError):
    """A plant failed while it ran; `failure` says how, in words if it is in Python. Survives pickling."""

    def __init__(self, failure: Failure | str) -> None:
        """Carry `failure`."""
        super().__init__(failure)
        self.failure = failure

    def __str__(self) -> str:
        """Return the sentence of the failure."""
        return str(self.failure)


_DISK: Final = {errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EROFS, errno.EACCES}
"""What files outside of results, built or temporary ones, meet on a full or protected disk."""


def for_user(problem: BaseException) -> RailgripError | None:
    """Return the message of an exception for the user, or None if it is a mistake of this program."""
    if isinstance(problem, RailgripError):
        return problem
    if isinstance(problem, OSError) and problem.errno in _DISK:
        return Unwritten(f"{problem.filename or 'a file or the standard output'}: {problem.strerror}")
    return None
