"""Trains made of axles, bogies, car bodies and couplers."""

import pytest

from railgrip.fmus.native.dae import read
from railgrip.fmus.native.system import System, explicit


@pytest.fixture(scope="module")
def pair(tmp_path_factory: pytest.TempPathFactory) -> tuple[System, System]:
    file = tmp_path_factory.mktemp("pair") / "Pair.mo"
    file.write_text("""
        package Pair
          block Plain
            extends RailBraking.Plants.Consist(cars=2);
          end Plain;
          block ConstantPads
            extends RailBraking.Plants.Consist(
              cars=2, redeclare block TrainPad = RailBraking.Friction.ConstantFriction);
          end ConstantPads;
        end Pair;""")
    return explicit(read("Pair.Plain", file)), explicit(read("Pair.ConstantPads", file))


def test_parameters_of_a_train_reach_every_part(pair: tuple[System, System]) -> None:
    """A parameter set in a part is independent of the train's parameter."""
    loose = [p.name for p in pair[0].variables.free if "." in p.name and not p.name.endswith("curvature_rail")]
    assert loose == [f"coupler[1].{name}" for name in ("x_small",)]


def test_the_pad_law_is_replaced_in_every_axle(pair: tuple[System, System]) -> None:
    plain, constant = ({s.name for s in system.states} for system in pair)
    assert {name for name in plain if name.endswith(".pad.mu")} == plain - constant
    assert len(plain - constant) == 8
