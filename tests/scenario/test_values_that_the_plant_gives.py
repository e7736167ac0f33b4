"""Values that both scenario and plant contain: they default to the plant's, and a contradiction is refused."""

import pytest
from synthetic import LIBRARY

from railgrip.api import Scenario
from railgrip.base.errors import ScenarioError
from railgrip.base.units import GRAVITY
from railgrip.scenario.load import load
from railgrip.simulate.vehicle_data import VehicleData

DOWNHILL = "track.gradient=[{begin=0, slope=-0.02}]"
CLASS_OF_PYTHON = (
    "vehicle={plant='mine:Train', formation={wheelsets_per_group=[1, 1], wheelset_load=['60 kN', '60 kN'], "
    "brakes={p_max='3 bar', n_units=2, r_friction=0.2, r_wheel=0.4, J=100, A_piston=0.03, i_rigging=6, "
    "eta_rigging=0.9, F_spring=0}}}"
)


def vehicle(*overrides, name="plain"):
    return VehicleData(load(LIBRARY / f"{name}.toml", overrides))


@pytest.mark.parametrize(
    ("overrides", "mass"),
    [
        ((), 84e3),  # VT 642 in the field test: 2 (13.4 + 14.1 + 14.5) t
        (("truth.load=0.85",), 0.85 * 84e3),
        (('vehicle.parameters."m_wheelset[1]"=15 t',), 85.6e3),
        (("track.train_mass=90 t",), 90e3),
        ((CLASS_OF_PYTHON,), 120e3 / GRAVITY),
        ((CLASS_OF_PYTHON.replace("wheelset_load=['60 kN', '60 kN'], ", ""), "track.train_mass=12 t"), 12e3),
    ],
    ids=["plant", "truth", "parameter", "given", "wheelset_load", "unknown plant"],
)
def test_a_gradient_acts_on_the_mass_of_the_vehicle(overrides, mass):
    """The force on a slope of 2 % is m g sin(arctan 0.02)."""
    one = vehicle(DOWNHILL, *overrides)
    assert one.mass == pytest.approx(mass)
    assert one.track_force.at(10.0) == pytest.approx(mass * GRAVITY * 0.02 / (1 + 0.02**2) ** 0.5)


def test_track_brakes_are_those_of_the_train_file():
    """Each magnet of the tram attracts with 55 kN at a friction of 0.2: 44 kN in all for two at each of two bogies."""

    def tram(**formation):
        return VehicleData(Scenario.load("plain").with_plant({"train": "tram", "formation": formation}))

    with pytest.raises(ScenarioError, match=r"track_brakes is 1000 N, but the train file has 44000 N; leave it out"):
        _ = tram(track_brakes="1 kN").slowing
    assert tram().slowing == tram(track_brakes="44 kN").slowing
