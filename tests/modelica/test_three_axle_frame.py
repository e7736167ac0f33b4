"""A bogie frame has two degrees of freedom: three deflections of its suspension cannot drift apart.

The pattern +1, -2, +1 of the deflections has no restoring force. It is the second difference of the rail's heights
under the wheelsets at any time, whatever the frame does.
"""

from pathlib import Path

import numpy as np
import pytest
import rumoca

from railgrip.base.registry import shelf
from railgrip.rolling_stock.schema import load_train
from railgrip.scenario.track_geometry import spectrum

LIBRARY = Path(__file__).parents[2] / "modelica"
BEHIND = np.array([9.6, 11.85, 14.1])
"""Distances of the wheelsets of the second bogie behind the first wheelset of the train [m]."""

SPEED = 85 / 3.6

RAIL = "RailBraking.Tracks.UnevenRail rail(n=3, behind={9.6, 11.85, 14.1}); equation rail.v = 85/3.6;"

FRAME = f"""model Frame
  RailBraking.Components.BogieFrame frame(n=3, m_wheelset=fill(19000, 3), m_unsprung=fill(3000, 3), m_frame=9000,
    I_frame=20000, h_frame=0.75, h_rod=0.6, wheelbase=4.5, r_wheel=0.625, k=3e6, c=4e4);
  output Real dz[3];
  {RAIL}
  frame.rail_height = rail.height; frame.rail_rate = rail.rate; frame.rail_acceleration = rail.acceleration;
  frame.F = 0; frame.a = 0; frame.torque = 0; dz = frame.dz;
end Frame;"""
"""The frame of the library with the second bogie of `loco_coaches` at constant speed."""


def deflections_of(source):
    """Return time and deflections of a model over 5 s."""
    name = source.split()[1]
    model = rumoca.Session(roots=[str(LIBRARY)]).loads(source, model=name, filename=f"{name}.mo")
    result = model.simulate((0, 5), dt=0.01, config=rumoca.SimConfig(solver="rk-like", rtol=1e-8, atol=1e-10))
    return np.asarray(result.time), np.stack([np.asarray(result[f"dz[{i}]"]) for i in (1, 2, 3)])


def waves():
    """Return amplitudes, wavenumbers and phases of the rail: 16 lines of the published spectrum in progression."""
    step = 100.0 ** (1 / 16)
    wavenumber = 2 * np.pi / 125 * step ** (np.arange(16) + 0.5)
    density = spectrum("erri-high", "vertical", wavenumber / (2 * np.pi)) / (2 * np.pi)
    golden = (np.sqrt(5) - 1) / 2
    return (
        np.sqrt(2 * density * wavenumber * (step**0.5 - step**-0.5)),
        wavenumber,
        2 * np.pi * np.mod(np.arange(1, 17) * golden, 1),
    )


def second_difference(of_wheelsets):
    first, second, third = of_wheelsets
    return first - 2 * second + third


def test_the_dimensions_are_those_of_the_train():
    bogie = load_train(shelf("trains")["loco_coaches"]).bogies["locomotive"]
    assert (bogie.stiffness, bogie.damping, bogie.frame_mass, bogie.frame_inertia) == (3e6, 4e4, 9e3, 2e4)


def test_deflections_of_three_wheelsets_follow_the_second_difference_of_the_rail():
    amplitude, wavenumber, phase = waves()
    time, deflections = deflections_of(FRAME)
    x = SPEED * time - BEHIND[:, None]
    height = np.sum(amplitude[:, None, None] * np.cos(wavenumber[:, None, None] * x + phase[:, None, None]), axis=0)
    expected = second_difference(height)
    assert np.ptp(expected) > 1e-3
    # The constants of the library have nine digits, of phases up to 60 rad: 1e-7 of a height of millimetres.
    assert second_difference(deflections) == pytest.approx(expected, abs=1e-8)
