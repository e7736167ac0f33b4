"""Which exceptions are sentences for the user, and whether they blame the question or the run."""

import errno
from dataclasses import dataclass

from railgrip.estimators.errors import EstimatorError
from railgrip.fmu.failure import FmuError, PlantFailed
from railgrip.fmus.errors import FmuError as BuildError
from railgrip.fmus.errors import WrongQuestion
from railgrip.loop.compiled import LoopError
from railgrip.record.atomic import Unwritten
from railgrip.record.error import RecordError
from railgrip.scenario.error import ScenarioError

_QUESTIONS = (ScenarioError, RecordError, FmuError, EstimatorError, LoopError, WrongQuestion)
_RUNS = (PlantFailed, BuildError, Unwritten)
_DISK = {errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EROFS, errno.EACCES}
"""What files outside of results, built or temporary ones, meet on a full or protected disk."""


@dataclass(frozen=True, slots=True)
class Sentence:
    """What to tell the user.

    Attributes:
        text: One line a problem.
        wrong_question: Whether asking differently helps; else the run failed.
    """

    text: str
    wrong_question: bool


def sentence_of(problem: BaseException) -> Sentence | None:
    """Return what an exception tells the user, or None if it is a mistake of this program."""
    if isinstance(problem, _QUESTIONS):
        return Sentence(text=str(problem), wrong_question=True)
    if isinstance(problem, _RUNS):
        return Sentence(text=str(problem), wrong_question=False)
    if isinstance(problem, OSError) and problem.errno in _DISK:
        return Sentence(text=f"{problem.filename or 'a file'}: {problem.strerror}", wrong_question=False)
    return None
