"""Trains made of axles, bogies, car bodies and couplers, against the one that is written at length."""

from pathlib import Path

import fmpy
import numpy as np
import pytest
from braking import DRY, Train, brake

from railgrip.fmus.build import build_class
from railgrip.fmus.native.dae import read
from railgrip.fmus.native.library import LIBRARY
from railgrip.fmus.native.system import System, explicit


class Built(Train):
    """A class of the library that has no recipe."""

    def __init__(self, name: str, scratch: Path) -> None:
        file = build_class(f"RailBraking.FMUs.{name}", LIBRARY, compiler="native").path
        self.description = fmpy.read_model_description(str(file))
        self.folder = fmpy.extract(str(file), unzipdir=str(scratch))
        self.variables = {v.name: v for v in self.description.modelVariables}


@pytest.fixture(scope="module")
def articulated(tmp_path_factory: pytest.TempPathFactory) -> Train:
    return Built("ArticulatedTrain", tmp_path_factory.mktemp("articulated"))


@pytest.mark.parametrize("km_h", [85, 115, 120])
def test_the_train_of_components_stops_where_the_written_one_does(train: Train, articulated: Train, km_h: int) -> None:
    """Five in ten thousand are asked for; only the order of sums differs."""
    written, built = (brake(t, km_h, 0.55, DRY) for t in (train, articulated))
    assert built["distance"][-1] == pytest.approx(written["distance"][-1], rel=1e-9)
    np.testing.assert_allclose(built["wheelset_load"], written["wheelset_load"], rtol=1e-9)


def test_its_energy_becomes_heat_and_work(articulated: Train) -> None:
    stop = brake(articulated, 85, 0.55, DRY, track_force=lambda t: 3000.0 * np.sin(t))
    total = stop["kinetic_energy"] + stop["contact_heat"] + stop["pad_heat"] + stop["resistance_work"]
    assert total / total[0] == pytest.approx(1.0, abs=1e-6)


@pytest.fixture(scope="module")
def pair(tmp_path_factory: pytest.TempPathFactory) -> tuple[System, System]:
    file = tmp_path_factory.mktemp("pair") / "Pair.mo"
    file.write_text("""
        package Pair
          block Plain
            extends RailBraking.FMUs.Consist(cars=2);
          end Plain;
          block ConstantPads
            extends RailBraking.FMUs.Consist(cars=2, redeclare block TrainPad = RailBraking.Friction.ConstantFriction);
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
