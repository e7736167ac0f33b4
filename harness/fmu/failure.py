"""The two ways an FMU can disappoint: a wrong question before the run, and a failure during it."""

from dataclasses import dataclass
from typing import Literal

Reason = Literal[
    "error", "discard", "fatal", "pending", "no_status", "ended", "not_finite", "crash", "timeout", "refused"
]
"""What went wrong: an FMI status, a number that is none, an FMU that asked to end, a value that is no number, a process
that died or hung, or an FMU that would not be instantiated."""


class FmuError(ValueError):
    """The file, the mapping or a parameter cannot be what was meant; the message tells its author."""


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
        what = {
            "error": f"{self.call} returned fmi2Error",
            "discard": f"{self.call} returned fmi2Discard",
            "fatal": f"{self.call} returned fmi2Fatal",
            "pending": f"{self.call} returned fmi2Pending, and asynchronous FMUs are not supported",
            "no_status": f"{self.call} returned a number that is no fmi2Status",
            "ended": "the FMU asked to end the simulation",
            "not_finite": f"output '{self.variable}' is not a finite number",
            "crash": "the FMU crashed",
            "timeout": "the FMU did not return",
            "refused": f"the FMU could not be started: {self.call} gave no instance",
        }[self.reason]
        about = f" ({self.detail})" if self.detail else ""
        reached = f"; it came as far as {self.reached:.9g} s" if self.reached is not None else ""
        said = f"; it says: {self.log[-1]}" if self.log else ""
        return f"{self.file}: at {self.time:.9g} s {what}{about}{reached}{said}."


class PlantFailed(Exception):
    """An FMU failed while it ran; `failure` says how. Survives pickling between processes."""

    def __init__(self, failure: Failure) -> None:
        """Carry `failure`."""
        super().__init__(failure)
        self.failure = failure

    def __str__(self) -> str:
        """Return the sentence of the failure."""
        return str(self.failure)
