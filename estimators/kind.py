"""Interface of the kinds of filters, and the data that they are given."""

from dataclasses import dataclass
from typing import Any, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from railgrip.estimators.design import Gate

Vector = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FilterContext:
    """What a filter is made for.

    Attributes:
        prediction: Its model, in the form that `FilterKind.prediction` asks for.
        process_noise, reading_noise: Of the prediction's states and outputs.
        period: Of a step [s].
        gate: Which states change only while which inputs are large.
        outlier_limit: From how many standard deviations on each reading is left out; None to use every one.
        mean, covariance: Of the first belief.
    """

    prediction: Any
    process_noise: Vector
    reading_noise: Vector
    period: float
    gate: Gate
    outlier_limit: list[float] | None
    mean: Vector
    covariance: Vector


class FilterKind:
    """A kind of filter, in a module of `railgrip.estimators.filters` whose name is the kind in a scenario.

    Attributes:
        prediction: Form of its model: equations in CasADi, an FMU, or parts of a train that are coupled.
    """

    prediction: ClassVar[Literal["equations", "fmu", "parts"]] = "equations"

    @classmethod
    def start(cls, task: FilterContext) -> Any:
        """Return the filter with its first belief, a `railgrip.simulate.loop.parts.Filter`."""
        raise NotImplementedError
