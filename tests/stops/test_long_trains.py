"""Freight trains of many wagons: they stop, and their couplers carry what an independent chain of masses has."""

import tomllib

import pytest
from pipe_fronts import freight_row, freight_train
from sampling import sample

from railgrip.fmus.native.dae import read
from railgrip.rolling_stock.modelica import class_name, class_text
from railgrip.rolling_stock.schema import load_train, train_of

WAGONS = sample((2, 10, 20, 40), 1)
PERMISSIBLE = 240.0
"""Longitudinal compressive force that wagons with bogies and side buffers must withstand in curves [kN]: Commission
Decision 2006/861/EC (TSI WAG), 4.2.3.5."""


@pytest.fixture(scope="module", params=WAGONS)
def stop(request):
    return freight_row(request.param) | {"wagons": request.param}


def test_a_freight_train_stops_where_the_hand_calculation_says(stop):
    """The calculation has neither slip nor a pipe with friction: within the 3 % of other trains with a brake pipe."""
    assert stop["simulated"] == pytest.approx(stop["by hand"], rel=0.03)


def test_its_couplers_push_as_in_a_chain_of_masses_and_springs(stop):
    """scipy integrates the chain under the forces of the hand calculation, whose pressure front is sharp."""
    assert stop["pushes"] == pytest.approx(stop["chain"], rel=0.25)
    assert stop["pushes"] > stop["pulls"]


def test_forty_wagons_push_in_the_order_of_the_permissible_force(stop):
    """A train of 3600 t must not run in position P in practice: its force is that limit within a factor of two."""
    if stop["wagons"] == 40:
        assert PERMISSIBLE / 2 < stop["pushes"] < 2 * PERMISSIBLE
    else:
        assert stop["pushes"] < PERMISSIBLE


def test_the_last_wagon_of_a_shorter_train_has_no_coupler():
    train = train_of(tomllib.loads(freight_train(3, "three")), "three.toml")
    assert [car.coupler for car in train.cars] == ["buffers", "buffers", None]
    assert train.description == "three"


def test_a_wagon_adds_few_variables_to_those_of_the_front_end(tmp_path):
    """rumoca's time grows faster than their number. A wagon has 43 states, and had 1290 variables with Bogie and Axle.

    Twenty for each state are what remains without records that are handed on.
    """
    counts: list[int] = []
    for wagons in (1, 2):
        file = tmp_path / f"freight{wagons}.toml"
        file.write_text(freight_train(wagons, "short"), encoding="utf-8")
        train = load_train(file)
        source = tmp_path / f"Freight{wagons}.mo"
        source.write_text(class_text(train, pneumatic=True), encoding="utf-8")
        counts.append(len(read(class_name(train, pneumatic=True), source).variables))
    assert counts[1] - counts[0] < 20 * 43
