"""Checks of a plant's outputs against its inputs and against physics; `kernel/plausible.c` gives bounds and reasons.

The tolerances permit these errors in the braking distance: 0.2 % by the start speed; 0.2 % by a speed that falls faster
than adhesion, track force, running resistance and track brakes allow, in any interval of time, and 0.1 % by that bound;
0.1 %, a sample of travel and a centimetre by a distance that is not the integral of the speed. The integral of the
acceleration, which estimators and controllers read, agrees with the speed to 0.1 % of the highest speed.

For quantities that a plant may not output, the bound allows rolling resistance of 0.02 m/s2 and a drag area of 12 m2.
It does not detect a plant that brakes less than adhesion allows; `railgrip.simulate.plant_trial` runs a
foreign plant at two levels of friction before its stop.
"""

from dataclasses import dataclass
from math import inf

from railgrip.kernel import kernel
from railgrip.vehicle.signals import Layout

_ROLLING = 0.02  # m/s2; freight trains roll with some 2 N/kN, and most of it acts through the wheels
_DRAG = 7.2  # N/(m/s)2; 12 m2 of drag area, more than a blunt locomotive has, in air of 1.2 kg/m3
_DRAG_OF_LENGTH = 2e-5  # 1/m; drag along the train over its mass: 8 N/(m/s)2 for 400 m and 400 t


@dataclass(frozen=True, slots=True, kw_only=True)
class Slowing:
    """Bounds of a train's deceleration by other causes than adhesion.

    Attributes:
        lightest, heaviest: Bounds of the mass that track force acts on [kg]; the latter may be infinite.
        constant, quadratic: Maximum deceleration by running resistance and brakes on the rail itself, constant +
            quadratic v² [m/s2, 1/m]; may be infinite.
    """

    lightest: float
    heaviest: float
    constant: float
    quadratic: float

    def maximum(self, speed: float) -> float:
        """Return the maximum deceleration at a speed [m/s] without adhesion and track force [m/s2]."""
        return self.constant + self.quadratic * speed**2


UNBOUNDED = Slowing(lightest=1.0, heaviest=inf, constant=inf, quadratic=0.0)
"""Bounds of a plant that is slowed by a drive, such as a roller rig."""


def slowing_of(mass: float, *, is_known: bool, drag: float = 0.0, track_brakes: float = 0.0) -> Slowing:
    """Return the bounds for a train.

    Args:
        mass: Mass of the train [kg].
        is_known: Whether that is the plant's mass; else the bounds allow half of it and any larger mass.
        drag: Air resistance over the square of the speed [N s2/m2], used if it is higher than usual.
        track_brakes: Maximum force of brakes on the rail itself [N].
    """
    lightest = mass if is_known else 0.5 * mass
    return Slowing(
        lightest=lightest,
        heaviest=mass if is_known else inf,
        constant=_ROLLING + track_brakes / lightest,
        quadratic=max(drag, _DRAG) / mass + _DRAG_OF_LENGTH,
    )


_CHECKS = {
    "START_SPEED": ("speed", "m/s", "[start] speed requires {expected}"),
    "START_DISTANCE": ("distance", "m", "it counts from the brake demand, and {expected} is expected there"),
    "SPEED": (
        "speed",
        "m/s",
        "friction, gradient, resistance, traction and [vehicle.formation] track_brakes allow {expected}",
    ),
    "ACCELERATION": ("acceleration", "m/s2", "with both as means since the start, its speed changes by {expected}"),
    "DISTANCE": ("distance", "m", "the integral of its speed gives {expected}"),
    "SLIP": ("slip", "", "a braked wheel between rolling and locked has {expected}"),
    "ADHESION": ("adhesion", "", "the rail gives {expected}"),
}
"""Signal, unit and expectation of each check, by its name in the enum of plausible.h."""
_VECTORS = ("slip", "adhesion")
"""Signals with an element for each group or wheelset."""


class Plausibility:
    """The state of the checks during one stop.

    Attributes:
        struct: `Plausibility` of plausible.h.
    """

    def __init__(self, layout: Layout, period: float, start_speed: float, slowing: Slowing) -> None:
        """Prepare for the first sample: communication period [s], required start speed [m/s]."""
        bounds = {name: getattr(slowing, name) for name in ("lightest", "heaviest", "constant", "quadratic")}
        self._functions = kernel(layout).functions
        self.struct = kernel(layout).struct("Plausibility", period=period, start_speed=start_speed, **bounds)

    def reason(self, time: float) -> str:
        """Return a sentence on the check that failed at a time [s], with the value and the bounds."""
        failed = self.struct.pointer
        signal, unit, why = next(_CHECKS[name] for name in _CHECKS if getattr(self._functions, name) == failed.check)
        name = f"{signal}[{failed.element + 1}]" if signal in _VECTORS else signal
        span = f"{failed.lower:.6g} to {failed.upper:.6g}{unit and f' {unit}'}"
        value = f"{failed.value:.6g}{unit and f' {unit}'}"
        return (
            f"At {time:.3f} s the plant outputs {name} = {value}, but {why.format(expected=span)}; look at unit and "
            f"sign of '{signal}' in [vehicle.map], and at [vehicle.parameters]."
        )
