"""A co-simulation FMU as the step of a filter: equal to an accurate solution of its equations, or refused."""

from contextlib import nullcontext
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm
from tiny_fmu import (
    CURVED_OUTPUTS,
    K,
    check_filter_in_c,
    curved,
    derivative,
    derivative_by_state,
    repacked,
    stepped,
    tiny,
    xml,
)  # fmt: skip

from railgrip.base.errors import EstimatorError, FmuError
from railgrip.estimators.compiled import CompiledFilter
from railgrip.fmi import FmuPrediction, SteppedFmuPrediction, describe

PERIOD = 1e-2
POINT = np.array([0.3, -0.8, 0.5]), np.array([0.2, -0.1])
NAMES = {"parameters": {"k": K}, "inputs": ("u[1]", "u[2]"), "outputs": CURVED_OUTPUTS}
IN_STEP_MODE = 1
BOTH = [(FmuPrediction, curved), (partial(SteppedFmuPrediction, period=PERIOD), stepped)]


def prediction(file: Path, states: str = "abc", period: float = PERIOD) -> SteppedFmuPrediction:
    return SteppedFmuPrediction(describe(file), period=period, states=tuple(states), **NAMES)


def step_and_jacobian(x: np.ndarray, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the states after a period and their derivatives by x, from the variational equations."""

    def slopes(_: float, y: np.ndarray) -> np.ndarray:
        return np.concatenate([derivative(y[:3], u), (derivative_by_state(y[:3]) @ y[3:].reshape(3, 3)).ravel()])

    start = np.concatenate([x, np.eye(3).ravel()])
    end = solve_ivp(slopes, (0, PERIOD), start, "DOP853", rtol=1e-13, atol=1e-14).y[:, -1]
    return end[:3], end[3:].reshape(3, 3)


@pytest.mark.parametrize("variant", [0, IN_STEP_MODE, 128 + IN_STEP_MODE])
@pytest.mark.parametrize("order", ["abc", "cab"])
def test_forward_euler_with_its_rate_is_the_accurate_step(foundry: Path, variant: int, order: str):
    """Whether states are set in initialisation mode or, also if it refuses to save them, in step mode."""
    x, u = POINT
    places = ["abc".index(name) for name in order]
    with prediction(stepped(foundry, variant), order) as model:
        stop = x[places] + PERIOD * model.derivative(x[places], u)
        # Ten steps of Runge-Kutta of 1 ms: (1e-3 s * 2/s)^5 = 3e-14 each.
        np.testing.assert_allclose(stop, step_and_jacobian(x, u)[0][places], atol=1e-12)
        np.testing.assert_allclose(model.output(x[places], u), [x[0] + x[1] * x[2], x[2] + u[0]], rtol=1e-14)
        np.testing.assert_array_equal(model.start, np.zeros(3))


@pytest.mark.parametrize("variant", [0, IN_STEP_MODE])
def test_the_jacobian_is_that_of_the_linearised_step_or_of_the_step(foundry: Path, variant: int):
    x, u = POINT
    with (
        prediction(stepped(foundry, variant)) as exact,
        prediction(stepped(foundry, variant, directional=False)) as differences,
    ):
        linearised = np.eye(3) + PERIOD * exact.derivative_jacobian(x, u)
        # The polynomial lacks (T A)^5/120 = (0.01 * 2)^5/120.
        np.testing.assert_allclose(linearised, expm(PERIOD * derivative_by_state(x)), atol=1e-10)
        of_step = np.eye(3) + PERIOD * differences.derivative_jacobian(x, u)
        # Truncation: (1e-3)^2/6 times the third derivative of a step, which is PERIOD times 6 from c^3.
        np.testing.assert_allclose(of_step, step_and_jacobian(x, u)[1], atol=1e-8)
        np.testing.assert_allclose(differences.output_jacobian(x, u), [[1, x[2], x[1]], [0, 0, 1]], atol=1e-8)
        assert exact.has_directional_derivatives
        assert not differences.has_directional_derivatives


@pytest.mark.parametrize(("kind", "build"), BOTH)
def test_a_filter_in_c_equals_the_filter_in_numpy(foundry: Path, kind, build):
    """With the FMU's own derivatives and with differences, which both filters compute equally."""
    for directional in (True, False):
        with kind(describe(build(foundry, directional=directional)), states=tuple("cab"), **NAMES) as model:
            check_filter_in_c(model, PERIOD)


def test_an_fmu_may_integrate_by_forward_euler_itself(foundry: Path):
    x, u = POINT
    with prediction(stepped(foundry, 256)) as model:
        np.testing.assert_allclose(model.derivative(x, u), derivative(x, u), rtol=1e-12)


@pytest.mark.parametrize(("kind", "build"), BOTH)
@pytest.mark.parametrize(
    ("wrong", "index", "sentence"),
    [
        (False, 0, ""),
        (True, 0, r"der\(b\) changes by .*, and by .* according to its directional derivatives or dependencies"),
        (False, 6, r"der\(c\) changes by"),
        (False, 9, r"y\[1\] changes by"),
    ],
    ids=["right", "directional derivative", "dependencies of a derivative", "dependencies of an output"],
)
def test_wrong_jacobians_of_an_fmu_are_refused(foundry: Path, tmp_path: Path, kind, build, wrong, index, sentence):
    def declared(name: str, content: bytes) -> tuple[str, bytes]:
        unknown = f'<Unknown index="{index}"'.encode()
        return name, content.replace(unknown + b"/>", unknown + b' dependencies="2"/>') if "xml" in name else content

    file = repacked(build(foundry, wrong=wrong), tmp_path / "declared.fmu", declared)
    with kind(describe(file), states=tuple("abc"), **NAMES) as model:
        for x, u in (POINT, (np.array([-4.0, 2.0, 9.0]), np.array([10.0, 3.0]))):
            with pytest.raises(FmuError, match=sentence) if sentence else nullcontext():
                model.require_true_jacobians(x, u)


def test_a_filter_has_the_period_of_its_prediction(foundry: Path):
    sentence = r"over 0.01 s, and .* period is 0.02 s; give"
    with prediction(stepped(foundry)) as model, pytest.raises(EstimatorError, match=sentence):
        CompiledFilter(model, np.ones(3), np.ones(2), 0.02)


@pytest.mark.parametrize(("kind", "build"), [*BOTH, (BOTH[1][0], partial(stepped, variant=IN_STEP_MODE))])
def test_no_files_and_no_saved_states_are_left_behind(foundry: Path, scratch: Path, kind, build):
    with kind(describe(build(foundry)), states=tuple("abc"), **NAMES) as model:
        assert len(list(scratch.iterdir())) == 1
    assert list(scratch.iterdir()) == []
    with pytest.raises(RuntimeError, match="inside 'with'"):
        model.derivative(*POINT)


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"flags": ""}, "begins every step in a saved state, and this FMU has no canGetAndSetFMUstate"),
        ({"lists_states": False}, "does not say which variables are its states"),
    ],
)
def test_an_fmu_without_states_to_set_is_refused_before_it_is_loaded(foundry: Path, changes, sentence: str):
    with pytest.raises(FmuError, match=sentence):
        prediction(stepped(foundry, **changes))


def test_an_fmu_by_model_exchange_alone_is_refused(foundry: Path):
    file = tiny(foundry, description=xml(ways=("ModelExchange",)))
    with pytest.raises(FmuError, match="offers only Model Exchange; export it as Co-Simulation, or evaluate"):
        SteppedFmuPrediction(describe(file), period=1e-3, parameters={}, states=("x",), inputs=("u",), outputs=("y",))


@pytest.mark.parametrize(
    ("variant", "sentence"),
    [
        (2, r"a parameter is 1.0 after it was set to 1.7 and its state restored"),
        (2 + IN_STEP_MODE, r"in step mode: a parameter is 1.0 after it was set to 1.7"),
        (4, "two steps from the same states differ"),
        (4 + IN_STEP_MODE, "in step mode: two steps from the same states differ"),
        (8, "two steps from the same states differ"),
        (8 + IN_STEP_MODE, "in step mode: two steps from the same states differ"),
        (16, r"its step of 0.01 s does not follow its derivatives: its own steps are longer"),
        (32, r"does not follow its derivatives: .* or it depends on time"),
        (64, r"'a' is 0 after it was set to 0.001"),
        (64 + IN_STEP_MODE, r"in step mode: 'a' is 0 after it was set to 0.001"),
        (128, r"no step can begin at an estimate. With states set in initialisation mode: .*fmi2GetFMUstate.*"
              r"With states set in step mode: .*fmi2SetReal.* Export it as Model Exchange"),
        (512, "does not follow its derivatives"),
    ],
)  # fmt: skip
def test_an_fmu_whose_steps_are_not_a_function_of_its_states_is_refused(foundry: Path, variant: int, sentence: str):
    with pytest.raises(FmuError, match=sentence):
        prediction(stepped(foundry, variant)).__enter__()


def test_a_slow_dependence_on_time_or_memory_shows_over_many_steps(foundry: Path):
    """In a step of 0.1 ms the time that passes is too short to change the derivative visibly."""
    with pytest.raises(FmuError, match="its steps depend on time, or on values besides its states"):
        prediction(stepped(foundry, 32), period=1e-4).__enter__()
