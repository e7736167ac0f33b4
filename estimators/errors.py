"""The two ways an estimator ends a conversation."""


class EstimatorError(ValueError):
    """The question was wrong: a shape, a name or a value that no filter can be made of."""


class FilterDiverged(ArithmeticError):
    """The belief is no longer one: a mean that is not finite or a covariance that is not positive definite.

    A filter that diverges during a stop is a result of that stop, so this is no `EstimatorError`: the loop
    catches it and says so in the outcome.

    Attributes:
        why: The sentence.
        after: Steps of the same call that went well before.
    """

    def __init__(self, why: str, after: int = 0) -> None:
        """Say why, and after how many steps if there were any."""
        super().__init__(f"{why} After {after} steps." if after else why)
        self.why, self.after = why, after
