"""How a recording or an estimation is refused."""

from railgrip.scenario.error import ScenarioError


class EstimationError(ScenarioError):
    """A question that no estimate answers: a signal that is missing, an uneven grid, a unit that does not fit.

    It is a `ScenarioError`, so the command line ends with its sentence.
    """
