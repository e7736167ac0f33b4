"""The recording that an estimation makes of a user's file."""

from pathlib import Path

from railgrip.errors import EstimationError
from railgrip.estimation.recorded.read import Taken, recorded
from railgrip.estimation.run import model_of, units_of
from railgrip.estimation.spec import Specification


def taken_for(specification: Specification, path: Path) -> Taken:
    """Return the recording in `path`, read by the [data] of an estimation, and what had to be mended.

    Raises:
        EstimationError: The estimation has no [data], or the file cannot be used; in a sentence.
    """
    if specification.data is None:
        raise EstimationError(
            f"{specification.name}: has no [data], which says what the columns of {path.name} are; see "
            "harness/estimation/recorded/table.py for an example."
        )
    model = model_of(specification.model.class_)
    units = units_of(specification.model.class_)
    inputs = [variable.name for variable in model.inputs]
    outputs = [variable.name for variable in model.outputs]
    if specification.course is not None:
        from railgrip.estimation.course import ALWAYS, MADE, units_of_run

        of_run = units_of_run(list(specification.data.columns))
        units = {name: unit for name, unit in units.items() if name != MADE} | of_run
        inputs = [name for name in inputs if name != MADE] + [name for name in of_run if name in ALWAYS]
        outputs += [name for name in of_run if name not in ALWAYS]
    return recorded(path, specification.data, units, inputs, outputs)
