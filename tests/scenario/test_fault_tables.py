"""The tables [[faults]] and [truth]: their meaning and their refusals."""

import tomllib
from typing import get_args

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from kernel_calls import show
from synthetic import LIBRARY
from wrong import answered

from railgrip.base.errors import ScenarioError
from railgrip.scenario.faults import kinds_of_faults
from railgrip.scenario.file import merge
from railgrip.scenario.load import scenario_of
from railgrip.simulate.faults.site import faults_of
from railgrip.simulate.vehicle_data import VehicleData

EQUIPMENT = LIBRARY.parent / "equipment"
TABLES = kinds_of_faults()
PAIRS = [(part, kind) for kind, table in TABLES.items() for part in get_args(table.model_fields["part"].annotation)]
PARTS = {part for part, _ in PAIRS}


def scenario_with(*faults, equipment="service", **tables):
    table = tomllib.loads((LIBRARY / "plain.toml").read_text(encoding="utf-8"))
    table = merge(table, tomllib.loads((EQUIPMENT / f"{equipment}.toml").read_text(encoding="utf-8")))
    return scenario_of(merge(table, {"faults": list(faults)} | tables), directory=LIBRARY, origin="mine.toml")


def parts(scenario):
    """The effects of a scenario's faults, except those on the plant."""
    vehicle = VehicleData(scenario)
    return faults_of(scenario, vehicle.layout, vehicle.outputs)


def plant_of(scenario):
    vehicle = VehicleData(scenario)
    return vehicle.changes, vehicle.track_force.at(10.0)


units = st.sampled_from(["", "s", "bar", "m/s", "rad/s", "m", "l", "m/s**2"])
amounts = st.builds(
    lambda n, unit: f"{n} {unit}" if unit else n, st.floats(-1e3, 1e3).map(lambda n: round(n, 3)), units
)
tables = st.fixed_dictionaries(
    {"part": st.sampled_from(sorted(PARTS)), "kind": st.sampled_from(sorted(TABLES))},
    optional={
        "group": st.integers(0, 6), "wheelset": st.integers(0, 8), "begin": st.floats(0, 20), "end": st.floats(0, 80),
        "value": amounts, "pressure": amounts,
    },
)  # fmt: skip


@settings(max_examples=300)
@given(faults=st.lists(tables, min_size=1, max_size=2), equipment=st.sampled_from(["ideal", "service"]))
def test_any_table_of_faults_is_accepted_or_refused(faults, equipment):
    accepted = []

    def use():
        scenario = scenario_with(*faults, equipment=equipment)
        parts(scenario)
        plant_of(scenario)
        accepted.append(scenario)

    answered(use, ScenarioError, words="[faults[")
    for scenario in accepted:
        assert scenario_of(scenario.resolved(), directory=LIBRARY, origin="again") == scenario


def test_every_kind_has_a_valid_table():
    """With a value in the unit of the reading."""
    units = {"speed_sensor": "rad/s", "radar": "m/s", "accelerometer": "m/s**2", "transducer": "bar"}
    for part, kind in PAIRS:
        more = {"scaled": {"value": 1.1}, "missing_teeth": {"value": 2}, "slow": {"value": "50 ms"},
                "sagging": {"value": "60 l", "pressure": "5 bar"}}.get(kind, {})  # fmt: skip
        if kind in ("biased", "noisy"):
            more = {"value": f"0.1 {units.get(part, 'mm')}"}
        scenario = scenario_with({"part": part, "kind": kind, **more})
        assert (parts(scenario) is None) == (kind == "missing_teeth")


def test_without_place_a_fault_is_everywhere_and_time_is_rounded_to_the_nearest_sample():
    scenario = scenario_with({"part": "transducer", "kind": "dead", "begin": 0.57, "end": "0.5701 s"})
    layout, faults = VehicleData(scenario).layout, parts(scenario)
    assert faults.struct.pointer.reading_count == 4
    reading = np.ones(200)
    missing = {k: np.isnan(show(faults, k, reading, layout)).sum() for k in (0, 569, 570, 571)}
    assert missing == {0: 0, 569: 0, 570: 4, 571: 0}


def test_truth_equals_the_corresponding_vehicle_parameters():
    """Factors on the data of the two-part train; the gradient acts on the true mass of the train."""
    truth = scenario_with(truth={"load": 0.85, "wheel_radius": [1.03, 1, 1, 0.97], "gradient": 0.02, "efficiency": 0.9})
    parameters = {"m_wheelset": [f"{m * 0.85} kg" for m in (13400, 14100, 14500, 14500, 14100, 13400)],
                  "r_wheel": ["0.3914 m", "0.38 m", "0.38 m", "0.3686 m"], "eta_rigging": 0.95 * 0.9}  # fmt: skip
    track = {"gradient": [{"begin": "0 m", "slope": 0.02}]}
    written = scenario_with(vehicle={"parameters": parameters}, track=track)
    (one, force), (other, same_force) = plant_of(truth), plant_of(written)
    assert one == other
    assert force == pytest.approx(same_force, rel=1e-12)


def test_the_truth_does_not_change_nominal_data():
    """Controller, driver and filter keep the nominal formation."""
    truth = {"load": 0.7, "wheel_radius": 1.05, "inertia": 1.2, "pad_friction": 0.8, "efficiency": 0.9}
    truth |= {"gradient": 0.01}
    assert VehicleData(scenario_with(truth=truth)).nominal.formation == VehicleData(scenario_with()).nominal.formation
    assert plant_of(scenario_with(truth=truth))[0].keys() >= {
        "J[1]",
        "mu_b_nominal[4]",
        "mu_b_start[1]",
        "m_wheelset[6]",
    }


def test_factors_multiply_the_values_of_the_scenario():
    scenario = scenario_with(
        vehicle={"parameters": {"eta_rigging": 0.9}},
        truth={"efficiency": 0.5, "creep": {"k_A": 0.5}, "pad_friction": 2},
    )  # fmt: skip
    parameters, _ = plant_of(scenario)
    assert scenario_with(truth={"load": 1}) == scenario_with()
    assert parameters["eta_rigging"] == 0.45
    assert parameters["k_A"] == 0.5 * scenario.adhesion.polach.plant_parameters()["k_A"]
    assert parameters["mu_b_start[2]"] == 0.7


def test_isolated_units_are_parameters_of_the_plant_and_limit_the_ideal_bound():
    some = scenario_with({"part": "brake", "kind": "isolated", "group": 1, "value": 2})
    assert plant_of(some)[0] == {"n_units[1]": 1.0}
    whole = scenario_with({"part": "brake", "kind": "isolated", "group": 2})
    assert plant_of(whole)[0] == {}
    assert [brake and brake.units for brake in VehicleData(whole).true.brakes] == [3.0, None, 2.0, 3.0]
