"""An independent solver for a brake pipe: MUSCL with the limiter of van Leer, HLL fluxes, three-stage Runge-Kutta."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

ATMOSPHERE, DENSITY = 1.01325e5, 1.2041
SOUND = float(np.sqrt(ATMOSPHERE / DENSITY))
LENGTHS = np.array([19.5, *[26.4] * 10])
FULL, FILL_TIME, RELAY = 3.8e5, 4.0, 0.05

Vector = NDArray[np.float64]


def nozzle(conductance: float, pressure: Vector) -> Vector:
    """Return the free air that flows through an orifice of ISO 6358, b = 1/2, into the atmosphere."""
    high = pressure + ATMOSPHERE
    subsonic = 2 * np.sqrt(ATMOSPHERE * np.maximum(pressure, 0))
    return conductance * np.where(high > 2 * ATMOSPHERE, high, subsonic)


@dataclass(frozen=True, kw_only=True)
class Pipe:
    """A pipe of 32 mm through a locomotive and ten coaches, vented at the front by an emergency brake valve."""

    cells: int
    branch: float = 0.0
    vent: float = 0.0
    diameter: float = 0.032
    friction: float = 0.03
    valve_volume: float = 1e-3
    valve: float = 8e-7
    rate_open: float = 7e4
    sensing: float = 0.3
    closing: float = 2.5e5

    def front(self) -> float:
        """Return the speed at which 5 % of the highest cylinder pressure travels from the first vehicle to the last."""
        begin, middle = self.begin(), np.cumsum(LENGTHS) - LENGTHS / 2
        return float((middle[-1] - middle[0]) / (begin[-1] - begin[0]))

    def begin(self, until: float = 1.6) -> Vector:
        """Return when the cylinders of each vehicle reach 5 % of their highest pressure."""
        dx = np.repeat(LENGTHS / self.cells, self.cells)
        step = 0.4 * dx.min() / (SOUND + 110)
        n = dx.size
        absolute = np.full(n, 5e5 + ATMOSPHERE)
        # Pressure and momentum in the pipe, pressure at the valve, in the cylinders and behind the sensing chokes.
        state = [absolute, np.zeros(n), np.array([5e5]), np.zeros(LENGTHS.size), np.full(LENGTHS.size, 5e5)]
        venting, ready = np.zeros(LENGTHS.size, dtype=bool), np.ones(LENGTHS.size, dtype=bool)
        site = np.arange(LENGTHS.size) * self.cells + self.cells // 2
        begin = np.full(LENGTHS.size, np.nan)
        for number in range(int(until / step)):
            old = state
            for share in (1, 1 / 4, 2 / 3):
                rates = self._rates(state, dx, site, venting)
                state = [(1 - share) * a + share * (b + step * c) for a, b, c in zip(old, state, rates, strict=True)]
            pressure = state[0][site] - ATMOSPHERE
            ready = np.where(ready, pressure > self.closing, pressure > 4.5e5)
            venting = ready & (venting | (state[4] - pressure > self.sensing * self.rate_open))
            level = 0.05 * FULL
            crossed = np.isnan(begin) & (state[3] >= level)
            share = (level - old[3][crossed]) / (state[3][crossed] - old[3][crossed])
            begin[crossed] = (number + share) * step
        return begin

    def _rates(self, state: list[Vector], dx: Vector, site: Vector, venting: Vector) -> list[Vector]:
        absolute, momentum, valve, cylinder, sensed = state
        area = np.pi / 4 * self.diameter**2
        (p_left, p_right), (m_left, m_right) = (_faces(one, dx) for one in (absolute, momentum))
        mass, force = _hll(p_right[:-1], m_right[:-1], p_left[1:], m_left[1:])
        # At the valve the wave that leaves the pipe conserves u - c ln P; the other end is a wall.
        end = valve[0] + ATMOSPHERE
        speed = m_left[0] * SOUND**2 / p_left[0] + SOUND * np.log(end / p_left[0])
        out = speed * end / SOUND**2
        wall = p_right[-1] * np.exp(m_right[-1] * SOUND / p_right[-1])
        mass, force = np.concatenate([[out], mass, [0]]), np.concatenate([[out * speed + end], force, [wall]])
        pressure = absolute[site] - ATMOSPHERE
        vented, volume = np.zeros(dx.size), np.zeros(dx.size)
        vented[site], volume[site] = np.where(venting, nozzle(self.vent, pressure), 0) * DENSITY, self.branch
        p_rate = SOUND**2 * (-area * np.diff(mass) - vented) / (area * dx + volume)
        inflow = np.maximum(volume / SOUND**2 * p_rate + vented, 0)
        speed = momentum * SOUND**2 / absolute
        drag = self.friction / (2 * self.diameter) * np.abs(momentum) + inflow / (area * dx)
        m_rate = -np.diff(force) / dx - drag * speed
        valve_rate = ATMOSPHERE / self.valve_volume * (-out * area / DENSITY - nozzle(self.valve, valve))
        target = FULL * np.clip((5e5 - pressure - 1e4) / 1.4e5, 0, 1)
        follow = (target - cylinder) / RELAY
        return [
            p_rate,
            m_rate,
            valve_rate,
            np.minimum(follow, 0.95 * FULL / FILL_TIME),
            (pressure - sensed) / self.sensing,
        ]


def _faces(values: Vector, dx: Vector) -> tuple[Vector, Vector]:
    """Return values at both faces of each cell, with van Leer's limiter."""
    between = np.diff(values) / ((dx[1:] + dx[:-1]) / 2)
    a, b = np.concatenate([between[:1], between]), np.concatenate([between, between[-1:]])
    same = a * b > 0
    slope = np.where(same, 2 * a * b / np.where(same, a + b, 1), 0)
    return values - slope * dx / 2, values + slope * dx / 2


def _hll(p_left: Vector, m_left: Vector, p_right: Vector, m_right: Vector) -> tuple[Vector, Vector]:
    """Return the fluxes of mass and momentum between two states of isothermal air."""
    u_left, u_right = m_left * SOUND**2 / p_left, m_right * SOUND**2 / p_right
    slow, fast = np.minimum(u_left, u_right) - SOUND, np.maximum(u_left, u_right) + SOUND
    force_left, force_right = m_left * u_left + p_left, m_right * u_right + p_right
    density = (p_right - p_left) / SOUND**2
    mass = (fast * m_left - slow * m_right + slow * fast * density) / (fast - slow)
    force = (fast * force_left - slow * force_right + slow * fast * (m_right - m_left)) / (fast - slow)
    return mass, force
