"""Interface of the kinds of filters, and the data that they get."""

from dataclasses import dataclass
from typing import Any, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from railgrip.estimators.design import Gate

Vector = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FilterContext:
    """Data from which a filter is created; see `railgrip.estimators.design.FilterDesign.of`.

    Attributes:
        prediction: The model, in the form that `FilterKind.prediction` declares.
        process_noise, reading_noise: Noises of the prediction's states and outputs.
        period: Period of a step [s].
        gate: States that are frozen while an input is small, or None.
        outlier_limit: Largest innovation of each reading that is used, in standard deviations; None uses every reading.
        mean, covariance: Estimate before the first step.
    """

    prediction: Any
    process_noise: Vector
    reading_noise: Vector
    period: float
    gate: Gate | None
    outlier_limit: list[float] | None
    mean: Vector
    covariance: Vector


class FilterKind:
    """A kind of filter, in a module of `railgrip.estimators.filters` that is named like the kind in a scenario.

    Attributes:
        prediction: Form of its model: equations in CasADi, an FMU, or coupled parts of a train.
    """

    prediction: ClassVar[Literal["equations", "fmu", "parts"]] = "equations"

    @classmethod
    def start(cls, task: FilterContext) -> Any:
        """Return the filter with its first estimate, a `railgrip.simulate.loop.parts.Filter`."""
        raise NotImplementedError
