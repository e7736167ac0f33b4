"""The prediction models compared with the plant that they predict."""

import casadi as ca
import numpy as np
import pytest
from braking import DRY, FULL, WET, Train, brake

from railgrip.fmus.native import Model, lower


@pytest.fixture(scope="module", params=["TrainPrediction", "TrainPredictionReduced"])
def prediction(request: pytest.FixtureRequest) -> Model:
    return lower(f"RailBraking.Predictions.{request.param}")


def defaults(model: Model) -> list[float]:
    return [v.start for v in model.parameters]


@pytest.mark.parametrize(("surface", "mu0"), [(DRY, 0.55), (WET, 0.2)])
def test_a_prediction_with_the_true_state_has_the_true_acceleration(
    train: Train, prediction: Model, surface: dict[str, float], mu0: float
) -> None:
    """Given the plant's adhesion and pad friction, the prediction has the plant's accelerations.

    The full model knows the loads except for the dampers, whose speed the plant does not output (a few N): 1e-4. The
    reduced one uses static loads: its sum of forces is wrong by less than one per cent where adhesion differs within a
    bogie.
    """
    stop = brake(train, 80, mu0, surface, until=10.0)
    reduced = len(prediction.states) == 13
    p = defaults(prediction)
    for k in (400, 700, 950):
        x = [stop["speed"][k]]
        for name in ("wheelset_speed", "pad_friction", "group_adhesion"):
            x += list(stop[name][k])
        if not reduced:
            x += [*stop["deflection"][k], *np.zeros(6)]
        u = [*stop["cylinder_pressure"][k], 0.0]
        dx = np.asarray(prediction.derivative(0, x, u, p)).ravel()
        assert dx[0] == pytest.approx(stop["acceleration"][k], rel=1e-2 if reduced else 1e-4)
        # The plant's acceleration by central differences over 20 ms. With J of 222 kg m2 an error of 0.2 % in a torque
        # of 14 kN m gives 0.1 rad/s2; an error of 4 kN in the load of a wheelset of the trailer bogie 1 rad/s2.
        seen = (stop["wheelset_speed"][k + 1] - stop["wheelset_speed"][k - 1]) / 0.02
        assert dx[1:5] == pytest.approx(seen, abs=2.0 if reduced else 0.1)
        assert np.all(dx[5:13] == 0)


def symbols(model: Model) -> tuple[ca.SX, ca.SX, ca.SX]:
    sizes = {"x": len(model.states), "u": len(model.inputs), "p": len(model.parameters)}
    x, u, p = (ca.SX.sym(name, n) for name, n in sizes.items())
    return x, u, p


def test_the_jacobian_is_finite_at_rest_and_everywhere(prediction: Model) -> None:
    x, u, p = symbols(prediction)
    rate = prediction.derivative(0, x, u, p)
    jacobian = ca.Function("jacobian", [x, u, p], [ca.jacobian(rate, ca.vertcat(x, u))])
    for speed in (0.0, 1e-6, 1.0, 60.0):
        for share in (0.0, 0.18, 1.0):
            state = np.zeros(len(prediction.states))
            state[:13] = [speed, *[speed / 0.38] * 4, *[0.35] * 4, *[0.1] * 4]
            values = np.asarray(jacobian(state, [*(share * FULL), 0.0], defaults(prediction)))
            assert np.isfinite(values).all()


def test_a_prediction_is_smooth_everywhere(prediction: Model) -> None:
    """`lower` refuses events; the test inspects the operations for kinks that it might miss."""
    x, u, p = symbols(prediction)
    values = [prediction.derivative(0, x, u, p), prediction.output(0, x, u, p)]
    expanded = ca.Function("values", [x, u, p], values).expand()
    kinks = {ca.OP_FABS, ca.OP_SIGN, ca.OP_FMIN, ca.OP_FMAX, ca.OP_IF_ELSE_ZERO, ca.OP_LT, ca.OP_LE}
    used = {expanded.instruction_id(k) for k in range(expanded.n_instructions())}
    assert not used & kinks
