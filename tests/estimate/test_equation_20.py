"""The stationary gain of the filter with Q and R of equation (20), as stated in the report of the rig."""

import numpy as np
import pytest
from scipy.linalg import expm, solve_discrete_are

from railgrip.estimation.models import of_class
from railgrip.estimation.spec import LIBRARY, load_specification

NOISE = load_specification(LIBRARY / "rig_paper.toml").noise


def stationary(period, force):
    """Return the stationary gain, the transition matrix of a period and that of the filter error."""
    rig = of_class("RollerRigPrediction").prediction({"A_drag": 0.0})
    phi = expm(rig.derivative_jacobian(np.array([60.0, 30.0, 0.35, 0.05]), np.array([force])) * period)
    H = np.eye(2, 4)
    Q = np.diag([NOISE.process[name] for name in rig.states])
    R = np.diag([NOISE.readings[name] for name in rig.outputs])
    P = solve_discrete_are(phi.T, H.T, Q, R)
    gain = P @ H.T @ np.linalg.inv(H @ P @ H.T + R)
    return gain, phi, (np.eye(4) - gain @ H) @ phi


def test_adhesion_is_the_derivative_of_the_rollers_speed():
    gain, phi, _ = stationary(5e-3, 2e4)
    from_wheelset, from_roller = gain[3] * phi[:2, 3]
    assert from_roller == pytest.approx(0.87, abs=0.005)
    assert from_wheelset == pytest.approx(0.004, abs=0.001)


@pytest.mark.parametrize("period", [1e-3, 5e-3, 20e-3])
@pytest.mark.parametrize("force", [1e4, 4e4])
def test_pad_friction_follows_in_26_kilonewton_seconds_over_the_force(period, force):
    error = np.abs(np.linalg.eigvals(stationary(period, force)[2]))
    slowest = -period / np.log(error.max())
    assert slowest == pytest.approx(26.06e3 / force, rel=0.005)
