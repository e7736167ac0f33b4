"""A law uses only the brake data that it declares; of a foreign train only these are required, in one message."""

import math
from dataclasses import fields, replace

import numpy as np
import pytest

from railgrip.base import registry
from railgrip.base.errors import ScenarioError
from railgrip.controllers.law import GroupLaw
from railgrip.testing import formations, observations
from railgrip.vehicle.brake import Brake
from railgrip.vehicle.formation import Formation
from railgrip.vehicle.parameters import VehicleParameters

LAWS = sorted(registry.modules(registry.LAWS))
KNOWN = {"m_wheelset[1]": 2e4, "m_wheelset[2]": 2e4, "p_max": 3.4e5, "r_wheel": 0.46}


def demands(law: type[GroupLaw], brakes: tuple[Brake, ...], formation: Formation) -> np.ndarray:
    own = law(brakes, law.load_tuning("ideal", "estimated", period=0.01, adhesion_max=0.15, pressure_lag=0.0))
    seen = [one for one in observations(formation, estimated=True) if math.isfinite(one.speed)]
    return np.array([own.decide(one) for one in seen])


@pytest.mark.parametrize("name", LAWS)
def test_a_law_uses_only_the_brake_data_that_it_declares(name):
    """Data that nobody gives are NaN, which would propagate to any result that uses them."""
    law = registry.part(registry.LAWS, name, GroupLaw)
    unused = {field.name for field in fields(Brake)} - law.brake_data
    for formation in formations():
        without = tuple(replace(brake, **dict.fromkeys(unused, math.nan)) for brake in formation.brakes)
        expected = demands(law, formation.brakes, formation)
        assert np.isfinite(expected).all()
        np.testing.assert_array_equal(demands(law, without, formation), expected)


def test_all_missing_data_are_in_one_message_with_their_keys():
    with pytest.raises(ScenarioError) as lacking:
        _ = VehicleParameters(Formation((1, 1)), {"r_wheel": 0.46}).formation
    message = str(lacking.value)
    assert message.startswith("[vehicle.formation] lacks wheelset_load (static force of each wheelset on the rail [N])")
    keys = ("p_max", "n_units", "r_friction", "J", "A_piston", "F_spring", "i_rigging", "eta_rigging")
    assert all(f"{key} (" in message for key in keys)
    assert "r_wheel" not in message


def test_data_that_no_part_uses_may_be_missing():
    required = frozenset({"pressure_max", "wheel_radius"})
    formation = VehicleParameters(Formation((1, 1)), KNOWN, required=required).formation
    assert formation.pressure_max.tolist() == [3.4e5, 3.4e5]
    assert math.isnan(formation.brakes[0].inertia)
    with pytest.raises(ScenarioError, match=r"brakes = \{ n_units \(number of brake units\), r_friction "):
        _ = VehicleParameters(Formation((1, 1)), KNOWN).formation
    with pytest.raises(ScenarioError, match=r"lacks brakes = \{ p_max \(highest brake cylinder pressure \[Pa\]\) \}"):
        _ = VehicleParameters(
            Formation((1, 1)), {k: v for k, v in KNOWN.items() if k != "p_max"}, required=required
        ).formation
