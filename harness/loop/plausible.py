"""What a plant shows, held against what was asked and against physics; the bounds and their reasons are in plausible.c.

The check is written once, in C, and called by both engines.
"""

import ctypes

import numpy as np
from numpy.typing import NDArray

from railgrip.loop.library import kernel
from railgrip.signals import Layout

_CHECKS = (
    ("", "", ""),
    ("speed", "m/s", "[start] speed asks for {expected}"),
    ("distance", "m", "it counts from the brake demand, and {expected} is wanted there"),
    ("speed", "m/s", "after the sample before a train on rails has {expected}"),
    ("distance", "m", "the integral of its speed gives {expected}"),
    ("slip", "", "a braked wheel between rolling and locked has {expected}"),
    ("adhesion", "", "the rail gives {expected}"),
)
"""Signal, unit and what was expected, in the order of the enum in plausible.h."""
_EACH = ("slip", "adhesion")


class Plausibility(ctypes.Structure):
    """The memory of the checks during one stop; as in plausible.h."""

    _fields_ = (
        *((name, ctypes.c_double) for name in ("period", "start_speed", "speed", "origin", "travel")),
        *((name, ctypes.c_double) for name in ("value", "least", "most")),
        *((name, ctypes.c_longlong) for name in ("check", "element")),
    )

    def holds(self, layout: Layout, sample: int, truth: NDArray[np.float64], inputs: NDArray[np.float64]) -> bool:
        """Return whether the truth of a sample can be; samples come in order.

        Args:
            layout: Of truth and inputs.
            sample: Its number.
            truth: Outputs of the plant then, contiguous.
            inputs: That were held until then, contiguous.
        """
        return kernel(layout).plausible(ctypes.byref(self), sample, truth.ctypes.data, inputs.ctypes.data) == 1

    def reason(self, time: float) -> str:
        """Return what was wrong at a time [s], and what was expected, in a sentence."""
        signal, unit, why = _CHECKS[self.check]
        name = f"{signal}[{self.element + 1}]" if signal in _EACH else signal
        span = f"{self.least:.6g} to {self.most:.6g}{unit and f' {unit}'}"
        value = f"{self.value:.6g}{unit and f' {unit}'}"
        return (
            f"At {time:.3f} s the plant shows {name} = {value}, but {why.format(expected=span)}; look at unit and sign "
            f"of '{signal}' in [vehicle.map], and at [vehicle.parameters]."
        )
