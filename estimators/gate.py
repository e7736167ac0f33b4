"""States that are held still while nothing can be learned about them."""

from dataclasses import dataclass

from railgrip.errors import EstimatorError


@dataclass(frozen=True, slots=True, kw_only=True)
class Gate:
    """Freezes a state while the input that makes it observable is small.

    The case it exists for: with the pads released no torque tells anything about pad friction. Its variance
    would grow without bound, and the first reading after re-application would throw the mean anywhere.

    While frozen, a state is a *consider state* of a Schmidt–Kalman filter: its derivative, process noise and
    gain are zero, so that neither its mean nor its variance moves. Its cross covariances with the other
    states stay alive: they follow the transition of the other states and their gains, and the other states'
    variances keep counting the uncertainty they inherit from it. When the gate opens, estimation goes on from
    a consistent joint covariance.

    Attributes:
        states: Names of the states to freeze.
        inputs: Names of the held inputs that decide, one for each of `states`.
        threshold: A state is frozen while its input is below this value, in the unit of the input.

    Raises:
        EstimatorError: `states` and `inputs` do not pair up, or a state is named twice.

    Source: Schmidt, Application of State-Space Methods to Navigation Problems (1966).
    """

    states: tuple[str, ...]
    inputs: tuple[str, ...]
    threshold: float

    def __post_init__(self) -> None:
        """Refuse pairs that do not pair."""
        if len(self.states) != len(self.inputs):
            raise EstimatorError(
                f"Gate: {len(self.states)} states want as many inputs, got {len(self.inputs)}; "
                "name for each state the input that opens it."
            )
        if len(set(self.states)) != len(self.states):
            raise EstimatorError(f"Gate: each state is named once, got {', '.join(self.states)}.")
