"""The contact compared with tabulated Hertz ellipses, peaks of Polach's curve, and its limits."""

import casadi as ca
import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq
from scipy.special import ellipe, ellipk
from wrong import table

from railgrip.fmus.native import Model, lower

PER_CENT = 1e-2
SLIP = np.geomspace(1e-4, 1.0, 20001)
LOAD = 2 * 68.7e3
SURFACES = {
    "Dry": (1.0, 0.4, 0.55, 0.4, 0.6),
    "Wet": (0.3, 0.1, 0.30, 0.4, 0.2),
    "LowAdhesion": (0.3, 0.1, 0.06, 0.4, 0.2),
    "MalDry": (1.0, 1.0, 0.46, 0.4, 0.6),
    "MalWorst": (1.0, 1.0, 0.1, 0.1, 0.2),
    "BroadSoap": (0.05, 0.02, 0.10, 0.4, 0.15),
    "BroadLeaf": (0.04, 0.015, 0.10, 0.5, 0.10),
}
PEAKS = {
    (surface, speed): (slip, adhesion[0] if adhesion else None)
    for surface, rows in table(__file__, "peaks.toml").items()
    for speed, slip, *adhesion in rows
}


@pytest.fixture(scope="module")
def point() -> Model:
    return lower("RailBraking.FMUs.ContactPoint")


def adhesion(point: Model, surface: str, slip: np.ndarray, speed: float, load: float = LOAD) -> np.ndarray:
    k_A, k_S, mu0, A, B = SURFACES[surface]
    chosen = {"k_A": k_A, "k_S": k_S, "A_falling": A, "B_falling": B}
    p = [chosen.get(v.name, v.start) for v in point.parameters]
    assert [v.name for v in point.inputs] == ["slip", "speed", "load", "mu0"]
    u = np.vstack([slip, np.full_like(slip, speed), np.full_like(slip, load), np.full_like(slip, mu0)])
    return np.asarray(point.output(0, ca.DM(0, 1), u, p)).ravel()


@pytest.mark.parametrize(("surface", "km_h"), list(PEAKS))
def test_peaks_are_at_the_computed_slips(point: Model, surface: str, km_h: float) -> None:
    """Three per cent is required; two digits of the table correspond to 0.5 to 1 %."""
    curve = adhesion(point, surface, SLIP, km_h / 3.6)
    slip, alpha = PEAKS[surface, km_h]
    assert SLIP[curve.argmax()] == pytest.approx(slip * PER_CENT, rel=0.03)
    assert alpha is None or curve.max() == pytest.approx(alpha, rel=0.01)


def test_the_shape_beyond_the_peak(point: Model) -> None:
    """Adhesion at 10 %, 15 % and 100 % slip relative to the peak at 80 km/h, two digits."""
    for surface, shape in {
        "Dry": (0.76, 0.67, 0.56),
        "Wet": (0.98, 0.92, 0.55),
        "BroadSoap": (1.0, 0.97, 0.58),
    }.items():
        curve = adhesion(point, surface, SLIP, 80 / 3.6)
        seen = np.interp([0.10, 0.15, 1.0], SLIP, curve) / curve.max()
        assert seen == pytest.approx(shape, abs=0.0075)


def test_the_curve_is_odd_and_bounded_by_friction(point: Model) -> None:
    for surface, (_, _, mu0, _, _) in SURFACES.items():
        for speed in (1e-3, 0.1, 1.0, 22.0, 60.0):
            curve = adhesion(point, surface, SLIP[::100], speed)
            assert adhesion(point, surface, -SLIP[::100], speed) == pytest.approx(-curve, rel=1e-12)
            assert np.all((curve > 0) & (curve <= mu0 * (1 + 1e-12)))


KALKER = {
    1 / 2: 3.62, 0.6: 3.72, 0.7: 3.81, 0.8: 3.91, 0.9: 4.01, 1.0: 4.12,
    1 / 0.9: 4.22, 1 / 0.8: 4.36, 1 / 0.7: 4.54, 1 / 0.6: 4.78, 1 / 0.5: 5.10,
}  # fmt: skip
"""a/b → c11 for Poisson's ratio 0.25 (Kalker, Three-dimensional Elastic Bodies in Rolling Contact, 1990)."""


def ellipse(load: float, r: float = 0.38, r_rail: float = 0.30, E: float = 2.1e11, nu: float = 0.28):
    """Return the semi-axes along and across the track [m] by complete elliptic integrals (Johnson 1985, ch. 4.2)."""
    low, high = sorted((1 / r, 1 / r_rail))

    def curvatures(m: float) -> float:
        """Ratio of the relative curvatures of an ellipse of parameter m = 1 − (minor/major)²."""
        return (ellipe(m) / (1 - m) - ellipk(m)) / (ellipk(m) - ellipe(m))

    m = brentq(lambda m: curvatures(m) - high / low, 1e-9, 0.99)
    contact_modulus, curvature = E / (2 * (1 - nu**2)), (low + high) / 2
    major = (3 * load * ellipe(m) / (2 * np.pi * contact_modulus * curvature * (1 - m))) ** (1 / 3)
    minor = major * np.sqrt(1 - m)
    return (major, minor) if r > r_rail else (minor, major)  # the axis along the larger radius is longer


def stiffness(load: float) -> float:
    """Return G·a·b·c11 [N] for steel, with Kalker's table."""
    a, b = ellipse(load)
    return 2.1e11 / (2 * 1.28) * a * b * float(CubicSpline(list(KALKER), list(KALKER.values()))(a / b))


def test_the_reference_has_the_tabulated_ellipses() -> None:
    """Those of `Validation.HertzTable`, given to three digits."""
    for load, a, b in ((65.7e3, 5.69e-3, 4.86e-3), (69.2e3, 5.79e-3, 4.95e-3), (71.1e3, 5.85e-3, 4.99e-3)):
        assert ellipse(load) == pytest.approx((a, b), rel=1.1e-3)


def test_the_initial_slope_is_kalkers_reduced_by_the_layer(point: Model) -> None:
    """F ≈ ½(k_A + k_S)·G·a·b·c11·slip for each wheel, independent of friction.

    0.5 %: 0.2 % of Greenwood's ellipse, 0.17 % of the parabola for c11, and the table's last digit.
    """
    tiny = np.array([1e-7])
    for load in (30e3, 69.2e3, 120e3):
        for surface in ("Dry", "Wet", "LowAdhesion"):
            k_A, k_S, *_ = SURFACES[surface]
            slope = adhesion(point, surface, tiny, 20.0, load=2 * load) * load / tiny
            assert slope == pytest.approx((k_A + k_S) / 2 * stiffness(load), rel=0.005)


def test_without_friction_there_is_no_adhesion(point: Model) -> None:
    p = [v.start for v in point.parameters]
    assert float(point.output(0, ca.DM(0, 1), [0.5, 20.0, LOAD, 0.0], p)) == 0.0
