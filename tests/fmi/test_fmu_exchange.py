"""A prediction FMU equals the function in its source, in the requested order, with as few calls as possible."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from contracts.prediction import prediction_contract
from hypothesis import given
from hypothesis import strategies as st
from tiny_fmu import CURVED_OUTPUTS, K, curved, derivative, derivative_by_state, stepped, tiny, xml

from railgrip.base.errors import FilterDiverged, FmuError, PlantFailed
from railgrip.estimators.compiled import CompiledFilter
from railgrip.fmi import FmuPrediction, describe
from railgrip.fmi.exchange import column_groups

POINTS = [
    (np.array([0.3, -0.8, 0.5]), np.array([0.2, -0.1])),
    (np.array([-4.0, 2.0, 9.0]), np.array([10.0, 3.0])),
    (np.zeros(3), np.zeros(2)),
]


def opened(file: Path, states: str = "abc") -> FmuPrediction:
    return FmuPrediction(
        describe(file),
        parameters={"k": K},
        states=tuple(states),
        inputs=("u[1]", "u[2]"),
        outputs=CURVED_OUTPUTS,
    )


@pytest.fixture
def prediction(foundry: Path) -> Iterator[FmuPrediction]:
    with opened(curved(foundry)) as made:
        yield made


def jacobians(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    _, b, c = x
    return derivative_by_state(x), np.array([[1, c, b], [0, 0, 1]])


def test_it_satisfies_the_contract_of_a_prediction(prediction: FmuPrediction):
    prediction_contract(prediction, *POINTS[0])


@pytest.mark.parametrize("order", ["abc", "cab", "bca"])
@pytest.mark.parametrize("directional", [True, False])
@pytest.mark.parametrize("forgets", [True, False])
def test_values_and_jacobians_are_the_closed_form_in_any_order(foundry: Path, order: str, directional, forgets):
    """Of states and requests: OpenModelica up to 1.27.0 treats outputs as evaluated once derivatives were read."""
    places = ["abc".index(s) for s in order]
    with opened(curved(foundry, directional=directional, forgets=forgets), order) as made:
        assert made.states == tuple(order)
        for x, u in POINTS:
            f_x, h_x = jacobians(x)
            values = {"derivative": derivative(x, u)[places], "output": [x[0] + x[1] * x[2], x[2] + u[0]]}
            values |= {"derivative_jacobian": f_x[np.ix_(places, places)], "output_jacobian": h_x[:, places]}
            for name in ("derivative_jacobian", "derivative", "output", "derivative", "output_jacobian", *values):
                # Central differences lose a third of the digits: ε^(2/3) = 4e-11 of values up to 9³ here.
                tolerance = {"rtol": 1e-14} if directional or "jacobian" not in name else {"atol": 4e-8}
                np.testing.assert_allclose(getattr(made, name)(x[places], u), values[name], **tolerance)


def test_a_filter_step_repeats_no_call(foundry: Path):
    """The FMU counts how often values were set (`sent`) and read (`asked`)."""
    x, u = POINTS[0]
    with FmuPrediction(
        describe(curved(foundry)), parameters={"k": K}, states=tuple("abc"), inputs=("u[1]", "u[2]"),
        outputs=("sent", "asked"),
    ) as model:  # fmt: skip
        step = CompiledFilter(model, np.ones(3), np.ones(2), 1e-3)
        belief = step.start(x, np.ones(3))
        before = model.output(x, u)
        step.step(belief, u, np.full(2, np.nan))
        after = model.output(x, u)
    # States at the prior mean, at three stages of Runge-Kutta and at the predicted mean; inputs once; and the values
    # set by `after`: one state, one input. Derivatives at four points, outputs at one, both Jacobians once by three
    # directions each; and the values read by `after`.
    np.testing.assert_array_equal(after - before, [5 + 1 + 2, 4 + 1 + 3 + 3 + 1])


@given(st.lists(st.sets(st.integers(0, 11)), max_size=12))
def test_columns_of_a_group_share_no_row_and_each_column_is_in_one_group(rows: list[set[int]]):
    columns = 12
    groups = column_groups(tuple(tuple(sorted(row)) for row in rows), columns)
    for members in groups:
        assert all(len(row.intersection(members)) <= 1 for row in rows)
    assert sorted(column for members in groups for column in members) == sorted(set().union(*rows))


def test_a_diagonal_needs_one_directional_derivative_and_a_full_row_one_per_column():
    assert len(column_groups(tuple((i,) for i in range(9)), 9)) == 1
    assert len(column_groups((tuple(range(9)),), 9)) == 9


def test_a_point_changed_in_place_is_a_new_point(prediction: FmuPrediction):
    x, u = POINTS[0][0].copy(), POINTS[0][1]
    prediction.derivative(x, u)
    prediction.derivative_jacobian(x, u)
    x[0] = 5.0
    np.testing.assert_allclose(prediction.derivative(x, u), derivative(x, u), rtol=1e-14)
    np.testing.assert_allclose(prediction.derivative_jacobian(x, u), jacobians(x)[0], rtol=1e-14)


def test_a_derivative_that_is_not_a_number_is_named(prediction: FmuPrediction):
    with pytest.raises(PlantFailed, match=r"output 'der\(c\)' is not a finite number \(a prediction\)"):
        prediction.derivative(np.array([0.0, 0.0, 2000.0]), np.zeros(2))


def test_a_filter_names_the_derivative_of_its_fmu_that_is_not_a_number(prediction: FmuPrediction):
    step = CompiledFilter(prediction, np.ones(3), np.ones(2), 1e-3)
    belief = step.start(np.array([0.0, 0.0, 2000.0]), np.ones(3))
    with pytest.raises(FilterDiverged, match=r"output 'der\(c\)' is not a finite number \(a prediction\)"):
        step.step(belief, np.zeros(2), np.zeros(2))


def test_a_wrong_number_of_states_is_refused(prediction: FmuPrediction):
    with pytest.raises(ValueError, match="has 3 states and 2 inputs, got shapes"):
        prediction.derivative(np.zeros(4), np.zeros(2))


@pytest.mark.parametrize(
    ("claims", "states", "inputs", "sentence"),
    [
        ({}, ("mu",), ("u",), "missing: mu; unexpected: x"),
        ({}, ("x",), (), "leaves inputs undriven: u"),
        ({"indicators": 2}, ("x",), ("u",), "a prediction must be smooth, this FMU has 2 event indicators"),
        ({"output_unit": "km/h"}, ("x",), ("u",), "'y' of a prediction is in 'km/h', but must be in SI"),
    ],
)
def test_an_fmu_that_is_not_the_required_prediction_is_refused(
    foundry: Path, claims: dict[str, Any], states: tuple[str, ...], inputs: tuple[str, ...], sentence: str
):
    description = describe(tiny(foundry, description=xml(ways=("ModelExchange",), **claims)))
    with pytest.raises(FmuError, match=sentence):
        FmuPrediction(description, parameters={}, states=states, inputs=inputs, outputs=("y",))


def test_a_prediction_needs_model_exchange(foundry: Path):
    with pytest.raises(FmuError, match="this FMU offers only Co-Simulation; export it as Model Exchange"):
        opened(stepped(foundry)).__enter__()
