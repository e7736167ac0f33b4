"""Published laws of the friction of brake blocks on the tread, over sliding speed and block force.

Karwatzki's form of these laws is k1 (F + k2)/(F + k3) (v + k4)/(v + k5), with the force F of one block.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any, Final, Self


@dataclass(frozen=True, slots=True, kw_only=True)
class BlockLaw:
    """A law of block friction; with equal numbers above and below the lines it is a constant.

    Attributes:
        factor: Friction at infinite force and speed, k1.
        force_upper, force_lower: k2 and k3 [N].
        speed_upper, speed_lower: k4 and k5 [m/s].
        source: Publication.
    """

    factor: float
    force_upper: float
    force_lower: float
    speed_upper: float
    speed_lower: float
    source: str = ""

    def shape(self, speed: Any, force: Any) -> Any:
        """Return friction over `factor` at a sliding speed [m/s] and a force [N]; numbers or arrays."""
        of_force = (force + self.force_upper) / (force + self.force_lower)
        return of_force * (speed + self.speed_upper) / (speed + self.speed_lower)

    def for_unit(self, blocks: int) -> Self:
        """Return the law over the force of all blocks of a unit, which share it equally."""
        return replace(self, force_upper=blocks * self.force_upper, force_lower=blocks * self.force_lower)


SHAPE: Final = ("force_upper", "force_lower", "speed_upper", "speed_lower")
"""Numbers of a law that `BlockLaw.shape` uses."""


def _karwatzki(factor: float, k2: float, k3: float, k4: float, k5: float, source: str) -> BlockLaw:
    """Return a law from its published numbers: forces [kN], speeds [km/h]."""
    return BlockLaw(
        factor=factor, force_upper=1e3 * k2, force_lower=1e3 * k3, speed_upper=k4 / 3.6, speed_lower=k5 / 3.6,
        source=source,
    )  # fmt: skip


_WENDE = "Karwatzki, in Wende, Fahrdynamik des Schienenverkehrs (2003), as used by Open Rails (TrainCar.cs)"

LAWS: Final[Mapping[str, BlockLaw]] = MappingProxyType(
    {
        "cast_iron_p6": _karwatzki(0.024, 62.5, 12.5, 100, 20, _WENDE),
        "cast_iron_p10": _karwatzki(0.05, 62.5, 31.25, 100, 20, _WENDE),
        "composite_k": _karwatzki(0.055, 200, 50, 150, 75, f"{_WENDE}, and RailProfAC/ShuntingBrakingCurves"),
    }
)
"""Name in a train file → law.

There is none for LL blocks: the published model (Cantone and Ottati, 2018) has polynomials for each initial speed, and
its coefficients are not in the paper.
"""

CONSTANT: Final = BlockLaw(factor=1, force_upper=1, force_lower=1, speed_upper=1, speed_lower=1)
"""A law without an effect, for pads."""
