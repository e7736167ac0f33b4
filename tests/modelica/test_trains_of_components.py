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
              cars=1, redeclare block TrainPad = RailBraking.Friction.ConstantFriction);
          end ConstantPads;
        end Pair;""")
    return explicit(read("Pair.Plain", file)), explicit(read("Pair.ConstantPads", file))


def test_parameters_of_a_train_reach_every_part(pair: tuple[System, System]) -> None:
    """A parameter set in a part is independent of the train's parameter."""
    loose = [p.name for p in pair[0].variables.free if "." in p.name and not p.name.endswith("curvature_rail")]
    assert loose == [f"coupler[1].{name}" for name in ("x_small",)]


def test_the_pad_law_is_replaced_in_every_axle(pair: tuple[System, System]) -> None:
    """In the first car, which is all that the train with constant pads has: a second one takes as long to read."""
    plain, constant = ({s.name for s in system.states if s.name.startswith(("car[1].", "cylinder"))} for system in pair)
    assert constant == {name for name in plain if not name.endswith(".pad.mu")} - {
        f"cylinder[{group}].p" for group in range(5, 9)
    }
    assert sum(name.endswith(".pad.mu") for name in plain) == 4
