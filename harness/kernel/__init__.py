"""The loop's own code in C, compiled once on a machine: the cycle, and the parts of a stop that are always in C.

Modules with the tables of a scenario fill the structs of these parts.
"""

from fractions import Fraction
from functools import cache
from importlib.resources import files
from typing import Final

from railgrip.base.units import GRAVITY
from railgrip.fmus.native.toolchain import CLibrary, Struct
from railgrip.vehicle.brake import SMALL_SPEED
from railgrip.vehicle.signals import Layout

KERNEL: Final = files("railgrip.kernel")
_HEADERS: Final = ("sensors.h", "plausible.h", "driver.h", "rail.h", "faults.h", "cycle.h", "onboard.h")
_PHYSICS: Final = f"#define GRAVITY {GRAVITY}\n#define SMALL_SPEED {SMALL_SPEED}\n"
"""Constants in SI units for the C code. `kernel` omits them, because cffi accepts only integer macros."""


@cache
def kernel(layout: Layout) -> CLibrary:
    """Return the sensors, plausibility checks, driver, rail, faults and cycle in C, for vectors of this layout.

    Raises:
        railgrip.base.errors.CompilerMissing: No C compiler was found.
    """
    formation = layout.formation
    units = (name.replace(".h", ".c") for name in _HEADERS)
    name = f"cycle_{formation.groups}_{formation.wheelsets}"
    return CLibrary(headers(layout) | texts(*units), name, _HEADERS, layout.header())


def rate_of(layout: Layout, steps: Fraction | int) -> Struct:
    """Return `Rate` of sensors.h for a part whose period is a number of steps, not necessarily whole."""
    return kernel(layout).struct("Rate", steps=steps.numerator, turns=steps.denominator)


def headers(layout: Layout) -> dict[str, str]:
    """Return the text of all headers, by name, for vectors of this layout."""
    return texts("export.h", "vectors.h", "rate.h", *_HEADERS) | {"layout.h": layout.header() + _PHYSICS}


def texts(*names: str) -> dict[str, str]:
    """Return the text of kernel files, by name."""
    return {name: (KERNEL / name).read_text(encoding="utf-8") for name in names}
