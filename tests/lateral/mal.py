"""Wheelset and filter equations of Mal et al. (2020) in numpy, independent of the code under test.

The available text of the paper lacks the bodies of its equations (1) to (36). This is the same reconstruction as in the
Modelica library, from the text, Tables 1 and 3, Polach (2005) and Hussain and Mei (2009), in a second program:
agreement shows that both solve the same equations, not that these are the equations of the authors.
"""

from dataclasses import dataclass

import numpy as np

R0, LG, CONICITY = 0.5, 0.75, 0.15
MW, IW, KW, MV = 1250.0, 700.0, 5e6, 15000.0
IR, IL, KS = 134.0, 64.0, 6063260.0
N = MV * 9.81 / 2
CREEP_SMALL = 1e-7


def kappa() -> float:
    """ε·U/γ: G π a b c11/(4 N), Greenwood's ellipse and a parabola through Kalker's table."""
    young, nu, rail = 2.1e11, 0.28, 0.30
    contact_modulus = young / (2 * (1 - nu**2))
    radius = 0.5 * (0.5 * (1 / (2 * R0)) * (1 / (2 * rail)) * (1 / (2 * R0) + 1 / (2 * rail))) ** (-1 / 3)
    mean = (3 * N * radius / (4 * contact_modulus)) ** (1 / 3)
    ratio = (R0 / rail) ** (2 / 3)
    c11 = 3.1190 + ratio * (0.99604 - 0.0018374 * ratio)
    return young / (2 * (1 + nu)) * np.pi * mean**2 * c11 / (4 * N)


KAPPA = kappa()


@dataclass(frozen=True)
class Rail:
    u0: float
    A: float
    B: float


def friction(creep, v, rail):
    return rail.u0 * ((1 - rail.A) * np.exp(-rail.B * creep * v) + rail.A)


def force(creep, u):
    """Return Polach's force with k_A = k_S = 1."""
    epsilon = KAPPA * creep / u
    return 2 * N * u / np.pi * (epsilon / (1 + epsilon**2) + np.arctan(epsilon))


def wheelset(state, track, rail, rolling):
    """Return the derivative of [y, ẏ, ψ, ψ̇, v, ω_R, ω_L, θ], as reconstructed."""
    y, dy, psi, dpsi, v, w_r, w_l, theta = state
    steering = LG * dpsi / v + CONICITY * (y - track) / R0
    across = dy / v - psi
    along = (rolling * (R0 * w_r - v) / v + steering, rolling * (R0 * w_l - v) / v - steering)
    total = [np.sqrt(x**2 + across**2) + 1e-300 for x in along]
    forces = [force(creep, friction(creep, v, rail)) for creep in total]
    fx = [f * x / creep for f, x, creep in zip(forces, along, total, strict=True)]
    fy = [f * across / creep for f, creep in zip(forces, total, strict=True)]
    torsion = KS * theta
    return np.array(
        [
            dy,
            -(fy[0] + fy[1]) / MW,
            dpsi,
            (-LG * (fx[0] - fx[1]) - KW * psi) / IW,
            (fx[0] + fx[1]) / MV,
            (-torsion - R0 * fx[0]) / IR,
            (torsion - R0 * fx[1]) / IL,
            w_r - w_l,
        ]
    )


def slopes(x, y, psi, track, track_rate, v, rail):
    """Return the derivative of [ẏ, ψ̇, γ, U, F], as reconstructed, and ÿ."""
    dy, dpsi, creep, u, f = x
    across = dy / v - psi
    along = LG * dpsi / v + CONICITY * (y - track) / R0
    over = creep / (creep**2 + CREEP_SMALL**2)
    ddy = -2 * f * over / MW * across
    ddpsi = -2 * LG * f * over / IW * along - KW / IW * psi
    rate = (along * (LG * ddpsi / v + CONICITY * (dy - track_rate) / R0) + across * (ddy / v - dpsi)) * over
    u_rate = -rail.B * v * (u - rail.A * rail.u0) * rate
    f_rate = force(creep + 1e-30j * rate, u + 1e-30j * u_rate).imag / 1e-30  # exact to rounding
    return np.array([ddy, ddpsi, rate, u_rate, f_rate]), ddy
