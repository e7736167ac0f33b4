"""The recording that an estimation makes of a user's file."""

from pathlib import Path

from harness.estimate.error import EstimationError
from harness.estimate.recorded.read import Taken, recorded
from harness.estimate.run import model_of, units_of
from harness.estimate.spec import Specification


def taken_for(specification: Specification, path: Path) -> Taken:
    """Return the recording in `path`, read by the [data] of an estimation, and what had to be mended.

    Raises:
        EstimationError: The estimation has no [data], or the file cannot be used; in a sentence.
    """
    if specification.data is None:
        raise EstimationError(
            f"{specification.name}: has no [data], which says what the columns of {path.name} are; see "
            "harness/estimate/recorded/table.py for an example."
        )
    model = model_of(specification.model.class_)
    return recorded(
        path,
        specification.data,
        units_of(specification.model.class_),
        [variable.name for variable in model.inputs],
        [variable.name for variable in model.outputs],
    )
