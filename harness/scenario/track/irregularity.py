"""Track irregularities drawn from published power spectral densities.

Spectra are one-sided over the wavenumber Ω [rad/m]. A realisation is a sum of cosines with random phases,
r(s) = Σ √(2 S_f(f) Δf) cos(2π f s + θ) with S_f(f) = 2π S_Ω(2π f).

Sources: ERRI B176 RP1 (German spectra of low and high disturbance); Federal Railroad Administration, FRA/ORD-77/22
and Garg and Dukkipati, Dynamics of Railway Vehicle Systems (1984), for the classes 4 to 6.
"""

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

Vector = NDArray[np.float64]
Kind = Literal["alignment", "vertical", "cross_level", "gauge"]
KINDS: Final[tuple[Kind, ...]] = ("alignment", "vertical", "cross_level", "gauge")

HALF_GAUGE: Final = 0.75
"""Half the distance of the contacts [m], ERRI's b."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Band:
    """Spatial frequencies of a realisation, 1/m: wavelengths from 1/highest to 1/lowest."""

    lowest: float
    highest: float
    lines: int

    @property
    def spacing(self) -> float:
        """Distance of the spectral lines, 1/m; a realisation repeats after 1/spacing."""
        return (self.highest - self.lowest) / self.lines

    @property
    def frequencies(self) -> Vector:
        """Centres of the spectral lines, 1/m, shape (lines,)."""
        return np.asarray(self.lowest + (np.arange(self.lines) + 0.5) * self.spacing, dtype=np.float64)


RIDE: Final = Band(lowest=0.008, highest=0.8, lines=1600)
"""Wavelengths from 1.25 to 125 m: 0.06 to 21 Hz at 60 mph, and no repetition within 2 km."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Fra:
    """American track class after FRA/AAR.

    Attributes:
        a_vertical, a_lateral: Roughness, m²·rad/m.
        omega_s: Corner of cross level and gauge, rad/m.
    """

    a_vertical: float
    a_lateral: float
    omega_s: float

    def density(self, kind: Kind, omega: Vector) -> Vector:
        """Return S_Ω, m²/(rad/m), at wavenumbers in rad/m."""
        k, corner = 0.25, 0.8245
        fall = corner**2 / (omega**2 + corner**2)
        if kind == "alignment":
            return k * self.a_lateral * fall / omega**2
        if kind == "vertical":
            return k * self.a_vertical * fall / omega**2
        return 4 * k * self.a_vertical * fall / (omega**2 + self.omega_s**2)


@dataclass(frozen=True, slots=True, kw_only=True)
class Erri:
    """German track after ERRI B176.

    Attributes:
        a_lateral, a_vertical, a_gauge: Roughness, m²·rad/m.
    """

    a_lateral: float
    a_vertical: float
    a_gauge: float

    def density(self, kind: Kind, omega: Vector) -> Vector:
        """Return S_Ω, m²/(rad/m), at wavenumbers in rad/m; cross level as a height over both rails."""
        corner, long, short = 0.8246, 0.0206, 0.4380
        common = corner**2 / ((omega**2 + long**2) * (omega**2 + corner**2))
        if kind == "alignment":
            return self.a_lateral * common
        if kind == "vertical":
            return self.a_vertical * common
        high_pass = omega**2 / (omega**2 + short**2)
        if kind == "gauge":
            return self.a_gauge * common * high_pass
        angle = self.a_vertical / HALF_GAUGE**2 * common * high_pass
        return angle * (2 * HALF_GAUGE) ** 2


CM2: Final = 1e-4
TRACKS: Final[Mapping[str, Fra | Erri]] = {
    "fra-4": Fra(a_vertical=0.5376 * CM2, a_lateral=0.3027 * CM2, omega_s=1.1312),
    "fra-5": Fra(a_vertical=0.2095 * CM2, a_lateral=0.0762 * CM2, omega_s=0.8209),
    "fra-6": Fra(a_vertical=0.0339 * CM2, a_lateral=0.0339 * CM2, omega_s=0.4380),
    "erri-low": Erri(a_lateral=2.119e-7, a_vertical=4.032e-7, a_gauge=5.32e-8),
    "erri-high": Erri(a_lateral=6.125e-7, a_vertical=1.080e-6, a_gauge=1.032e-7),
}


def spectrum(track: str, kind: Kind, frequencies: Vector) -> Vector:
    """Return S_f, m²/(1/m), at spatial frequencies in 1/m."""
    return 2 * np.pi * TRACKS[track].density(kind, 2 * np.pi * frequencies)


def rms(track: str, kind: Kind, band: Band) -> float:
    """Return the root mean square, m, within a band."""
    return float(np.sqrt(np.sum(spectrum(track, kind, band.frequencies)) * band.spacing))


@dataclass(frozen=True, slots=True)
class Irregularity:
    """One realisation of a track, by kind: irregularity [m] over the position [m], within its grid."""

    curves: Mapping[Kind, CubicSpline]

    def at(self, kind: Kind, position: Vector) -> Vector:
        """Return the irregularity, m, at positions along the track, m."""
        return np.asarray(self.curves[kind](position), dtype=np.float64)


def realise(
    track: str, length: float, generator: np.random.Generator, band: Band = RIDE, kinds: Collection[Kind] = KINDS
) -> Irregularity:
    """Draw the irregularities of a stretch of track from position 0 to `length`, m."""
    # Eight points on the shortest wave: the error of the cubic interpolation is then below 0.2 %.
    grid = np.arange(0.0, length + 1.0, 1 / (8 * band.highest))
    frequencies = band.frequencies
    curves: dict[Kind, CubicSpline] = {}
    for kind in kinds:
        amplitude = np.sqrt(2 * spectrum(track, kind, frequencies) * band.spacing)
        phase = generator.uniform(0, 2 * np.pi, band.lines)
        curves[kind] = CubicSpline(grid, _sum_of_cosines(grid, frequencies, amplitude, phase))
    return Irregularity(curves)


def _sum_of_cosines(position: Vector, frequencies: Vector, amplitude: Vector, phase: Vector) -> Vector:
    out = np.zeros(position.size)
    for part in np.array_split(np.arange(position.size), max(1, position.size // 500)):
        turns = np.outer(position[part], frequencies)
        out[part] = np.cos(2 * np.pi * turns + phase) @ amplitude
    return out
