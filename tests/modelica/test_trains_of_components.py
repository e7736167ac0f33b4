"""Trains made of axles, bogies, car bodies and couplers."""

import pytest
from braking import DRY, Train, brake

from railgrip.fmus.native.dae import read
from railgrip.fmus.native.system import System, explicit


@pytest.mark.parametrize(
    ("km_h", "metres"), [(85, 265.2061266848434), (115, 477.3319169297286), (120, 518.6015003319706)]
)
def test_the_train_of_components_stops_where_its_equations_written_at_length_did(
    train: Train, km_h: int, metres: float
) -> None:
    """Five in ten thousand are asked for; only the order of sums differed from the flat model that was here before."""
    assert brake(train, km_h, 0.55, DRY)["distance"][-1] == pytest.approx(metres, rel=1e-9)


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


def test_what_a_train_offers_reaches_every_part(pair: tuple[System, System]) -> None:
    """A parameter of a part that may be set by itself is not bound to that of the train any more."""
    loose = [p.name for p in pair[0].variables.free if "." in p.name and not p.name.endswith("curvature_rail")]
    assert loose == [f"coupler[1].{name}" for name in ("x_small",)]


def test_the_law_of_the_pads_is_replaced_in_every_axle(pair: tuple[System, System]) -> None:
    plain, constant = ({s.name for s in system.states} for system in pair)
    assert {name for name in plain if name.endswith(".pad.mu")} == plain - constant
    assert len(plain - constant) == 8
