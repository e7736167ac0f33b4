"""Equations (17) and (18) of Schwarz and Keck (2020) for the wagon prediction, corrected and as printed."""

import numpy as np
import pytest

from railgrip.estimation.models import of_class
from railgrip.estimation.results import observe
from railgrip.estimation.spec import LIBRARY, load_specification
from railgrip.estimators.observability import observability, readings_and_rates
from railgrip.recording.samples import recording_of

G = 9.81
M, J, R_WHEEL, R_FRICTION, UNITS, H, A = 40e3, 130.0, 0.46, 0.25, 2.0, 1.5, 9.0
DRAG = 1.2 / 2 * 0.9 * 10
CORRECTED = {"adhesion_share": 1.0, "resistance_transfer": -1.0, "adhesion_transfer": 1.0}
PRINTED = {"adhesion_share": 0.5, "resistance_transfer": 1.0, "adhesion_transfer": 0.0}
X = np.array([48.0, 47.0, 21.0, 0.33, 0.36, 0.07])
SCALE = np.array([50.0, 50.0, 20.0, 0.35, 0.35, 0.1])


def inverse(z, u, variant):
    """Return the states from readings and their first derivatives.

    As printed, with the paper's signs reversed: alpha = -2 f_sub/(m g), and the loads of (11) without 2 h mu/a. As
    corrected: alpha = -f_sub/(m g), and loads that shift by -h m der(v)/a.
    """
    pull = u[2] - DRAG * z[2] ** 2
    f_sub = M * z[5] - pull  # (18)
    alpha = -f_sub / (variant["adhesion_share"] * M * G)
    shift = H / A * pull if variant is PRINTED else -H / A * M * z[5]
    loads = M * G / 2 + shift, M * G / 2 - shift
    pads = [
        (R_WHEEL * alpha * load + torque - J * rate) / (UNITS * R_FRICTION * force)
        for load, torque, rate, force in zip(loads, u[3:], z[3:5], u[:2], strict=True)
    ]
    return np.array([*z[:3], *pads, alpha])


@pytest.mark.parametrize("variant", [CORRECTED, PRINTED], ids=["corrected", "printed"])
def test_the_closed_form_inverts_readings_and_rates(variant):
    wagon = of_class("WagonPrediction").equations(variant)
    u = np.array([2e4, 1.5e4, -800.0, -50.0, -60.0])
    z, _ = readings_and_rates(wagon, 1, X, u)
    # Differences of torques of 1e4 N.m lose three of sixteen digits.
    assert inverse(z, u, variant) == pytest.approx(X, rel=1e-12)


@pytest.mark.parametrize("variant", [CORRECTED, PRINTED], ids=["corrected", "printed"])
@pytest.mark.parametrize(
    ("forces", "lost"),
    [
        ((2e4, 1.5e4), ()),
        ((0.0, 1.5e4), ("pad_friction[1]",)),
        ((2e4, 0.0), ("pad_friction[2]",)),
        ((0.0, 0.0), ("pad_friction[1]", "pad_friction[2]")),
    ],
)
def test_only_pads_without_force_are_undetermined(variant, forces, lost):
    wagon = of_class("WagonPrediction").equations(variant)
    information = observability(wagon, X, np.array([*forces, -800.0, 0.0, 0.0]), SCALE)
    assert (information.complete, information.rank, information.undetermined) == (not lost, 6 - len(lost), lost)
    assert lost or information.order == 1


def test_a_relaxing_pad_without_force_is_also_undetermined():
    """Equation (9) gives friction separate dynamics on which no reading depends."""
    wagon = of_class("WagonPrediction").equations(CORRECTED | {"mu_b_relaxes": 1.0})
    information = observability(wagon, X, np.array([0.0, 1.5e4, 0.0, 0.0, 0.0]), SCALE)
    assert information.undetermined == ("pad_friction[1]",)


def test_windows_without_pad_force_do_not_determine_pad_friction():
    samples, period = 300, 0.01
    force = np.where(np.arange(samples) < 150, 50.0, 2e4)  # noise of 50 N and offset of a load cell
    steady = {"w": (60.0, "rad/s"), "v": (30.0, "m/s"), "mu_b": (0.35, "1"), "alpha": (0.08, "1")}
    recording = recording_of(
        {
            "pad_force": (force, "N"),
            "wheelset_speed": (np.full(samples, 60.0), "rad/s"),
            "speed": (np.full(samples, 30.0), "m/s"),
        },
        period=period,
        truth={state: (np.full(samples, value), unit) for state, (value, unit) in steady.items()},
    )
    points, windows = observe(load_specification(LIBRARY / "rig_own.toml"), recording)
    windows = windows.set_index(time="time")
    coasting = windows.where(windows["time"] < 0.9, drop=True)
    braking = windows.where(windows["time"] >= 1.5, drop=True)
    assert np.all(coasting["singular"].sel(state="pad_friction") == 0.0)
    assert np.all(np.isinf(coasting["deviation"].sel(state="pad_friction")))
    assert np.all(braking["deviation"].sel(state="pad_friction") < 0.01)
    assert np.all(np.isfinite(windows["deviation"].sel(state="group_adhesion")))
    assert [information.rank for _, _, information in points] == [4, 3]
