"""Read back wheel radius and creep curve of a plant from its outputs in a short run before the stop.

A compiler that drops a modifier leaves parameters at their defaults without an error: the FMU has the parameter, but
its contacts have another value. That value follows from relations between outputs: slip is (v - r w)/sqrt(v² +
v_small²), and adhesion that of the contact law at slip, speed, load and mu0.
"""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from railgrip.base.errors import FmuError
from railgrip.simulate.loop.parts import LoopPlant
from railgrip.trace.contact import Contact
from railgrip.vehicle.signals import CURVE, Layout

Matrix = NDArray[np.float64]

RADIUS_TOLERANCE = 1e-3
"""Relative tolerance of the radius.

A solver's slip is accurate to 1e-6 or better, and half a millimetre is the smallest wear that users set.
"""
ADHESION_TOLERANCE = 1e-3
"""Relative to mu0: the same, and the load is rounded by the square of 50 N over it.

Published creep curves differ a hundred times as much somewhere below `_SLIDING`.
"""
_SLIDING = 0.1
_WALKING = 2.0  # m/s; twenty times the speed below which slip is regularised
_LONGEST = 4.0  # s; passenger trains fill cylinders in 3 to 5 s (UIC 540), on this rail wheels slide before that
_RAIL = 0.06
_ADVICE = "the compiler lost a modifier: report it with the compiler's version, or use the other compiler."
V_SMALL = 0.1  # m/s, of a plant that does not declare it: RailBraking.Components.Wheelsets


def probe_outputs(
    plant: LoopPlant, layout: Layout, *, period: float, brake: tuple[float, ...], curve: Mapping[str, float]
) -> Matrix:
    """Return the outputs of a plant that brakes on a poor rail until its wheels slide, one row per sample.

    Args:
        plant: Plant that has not been started.
        layout: Layout of its vectors.
        period: Its communication period [s].
        brake: Full brake command of each group.
        curve: Polach's four numbers, for a plant with inputs for them.

    Raises:
        PlantFailed: The plant refused a step.
    """
    inputs = np.zeros(layout.inputs)
    inputs[layout.input["command"]], inputs[layout.input["mu0"]] = brake, _RAIL
    for signal, value in zip(CURVE, curve.values(), strict=True):
        if signal.name in layout.input:
            inputs[layout.input[signal.name]] = value
    rows = [plant.start(inputs).copy()]
    slip, speed = layout.output["slip"], layout.output["speed"].start
    for _ in range(round(_LONGEST / period)):
        rows.append(plant.step(inputs).copy())
        if np.nanmin(rows[-1][slip]) > _SLIDING or rows[-1][speed] < 0.5 * rows[0][speed]:
            break
    return np.array(rows)


def require_radius(file: str, layout: Layout, rows: Matrix, believed: tuple[float, ...], v_small: float) -> None:
    """Compare the radius of each group's contacts with the expected one [m].

    Args:
        file: Name of the FMU.
        layout: Layout of the plant's vectors.
        rows: Outputs of the plant, one row per sample.
        believed: Expected radius of each group [m].
        v_small: Speed below which slip is regularised [m/s].

    Raises:
        FmuError: A radius differs.
    """
    first = rows[0]
    v, w, slip = (first[layout.output[name]] for name in ("speed", "wheelset_speed", "slip"))
    if not np.all(w > 0.0):
        return  # at rest no speed reveals a radius; the same FMU is checked when it starts moving
    found = (v - slip * np.sqrt(v**2 + v_small**2)) / w
    for g, (here, there) in enumerate(zip(found.tolist(), believed, strict=True)):
        if abs(here / there - 1.0) > RADIUS_TOLERANCE:
            raise FmuError(
                f"{file}: the contacts of group {g + 1} have a wheel radius of {here:.6g} m by slip[{g + 1}], speed "
                f"and wheelset_speed[{g + 1}], its parameter r_wheel is {there:.6g} m; {_ADVICE}"
            )


def require_curve(
    file: str, layout: Layout, rows: Matrix, contacts: tuple[Contact, ...], curve: Mapping[str, float]
) -> None:
    """Compare the adhesion of each wheelset with that of the expected creep curve.

    Args:
        file: Name of the FMU.
        layout: Layout of the plant's vectors.
        rows: Outputs of the plant on the rail of the probe, one row per sample.
        contacts: Contact law of each group, with the expected curve.
        curve: Expected curve, by the names of the plant's parameters.

    Raises:
        FmuError: The curve differs.
    """
    group_of = np.repeat(np.arange(layout.formation.groups), layout.formation.wheelsets_per_group)
    speed = rows[:, layout.output["speed"]][:, 0]
    slip, adhesion, load = (rows[:, layout.output[name]] for name in ("slip", "adhesion", "wheelset_load"))
    for i, g in enumerate(group_of):
        rail = np.full(len(rows), _RAIL)
        expected = contacts[g](slip[:, g], speed, load[:, i], rail)
        # At walking pace the regularisation of the slip matters, and a probe from there does not reveal the curve.
        error = np.where(speed > _WALKING, np.abs(adhesion[:, i] - expected), 0.0)
        worst = int(np.argmax(error))
        if error[worst] > ADHESION_TOLERANCE * _RAIL:
            values = ", ".join(f"{name} = {value:g}" for name, value in curve.items())
            raise FmuError(
                f"{file}: adhesion[{i + 1}] is {adhesion[worst, i]:.6g} at slip {slip[worst, g]:.4g} and mu0 "
                f"{_RAIL:g}, by the creep curve of the scenario ({values}) it is {expected[worst]:.6g}; {_ADVICE}"
            )
