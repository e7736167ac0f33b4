"""Simulated stops with electrodynamic and eddy-current brakes, against the hand calculation and energies."""

import numpy as np
import pytest
from braked import dry
from small_train import COUPLED, dynamic_brake, one_bogie, with_constant_friction, without_command
from synthetic import MOTOR, ON_RAIL

from railgrip.base.errors import ScenarioError
from railgrip.rolling_stock.schema import load_train
from railgrip.rolling_stock.stopping import by_hand
from railgrip.scenario.outcome import Outcome
from railgrip.simulate.ideal import ideal_stop
from railgrip.simulate.run import run_stop
from railgrip.simulate.vehicle_data import VehicleData

SPEED = 100 / 3.6
RAIL = ON_RAIL | {"force": "8 kN"}


def write(folder):
    """Write a car with a motor bogie of coupled axles and a bogie with magnets; its pads have constant friction."""
    text = with_constant_friction(COUPLED.replace("NAME", "driven"))
    begin, end = text.index("\n[bogies.trailer]"), text.index("[couplers.bar]")
    bogie = text[begin:end]
    motor, magnets = (
        bogie.replace("bogies.trailer", f"bogies.{name}").replace(
            "wheel_radius", f'dynamic_brake = "{brake}"\nwheel_radius', 1
        )
        for name, brake in (("motor", "motor"), ("magnets", "rail"))
    )
    cars = text.index("\n[[cars]]", text.index("[[cars]]") + 1)
    text = text[:begin] + motor + magnets + dynamic_brake("motor", MOTOR) + dynamic_brake("rail", RAIL) + text[end:cars]
    text = text.replace('kind = "trailer"', 'kind = "motor"', 1).replace('kind = "trailer"', 'kind = "magnets"', 1)
    (folder / "train.toml").write_text(text.replace('coupler = "bar"', "", 1), encoding="utf-8")
    return folder / "train.toml"


def one_braked_bogie(file, name, brake, change=str):
    """Write a car on one bogie of coupled axles with a dynamic brake; its pads have constant friction."""
    text = with_constant_friction(one_bogie("braked").replace("coupled = false", "coupled = true"))
    text = text.replace("wheel_radius", f'dynamic_brake = "{name}"\nwheel_radius', 1)
    text = text.replace("[couplers.bar]", f"{dynamic_brake(name, brake)}\n[couplers.bar]")
    file.write_text(change(text), encoding="utf-8")
    return file


def scenario(file, mu0=0.5, **changes):
    return dry({"train": file.name}, SPEED, file.parent, mu0=mu0, **changes)


@pytest.fixture(scope="module")
def driven(tmp_path_factory):
    return write(tmp_path_factory.mktemp("driven"))


def test_a_dry_stop_has_the_distance_and_energies_of_the_hand_calculation(driven):
    """Distances within 0.5 %: the suspension, and pads that settle, are not in the hand calculation."""
    stop, hand = run_stop(scenario(driven)), by_hand(load_train(driven), SPEED)
    assert stop.outcome is Outcome.STANDSTILL, stop.reason
    assert stop.metrics.distance == pytest.approx(hand.distance, rel=5e-3)
    trace = stop.trace
    assert float(trace["dynamic_work"][-1]) == pytest.approx(hand.dynamic_work, rel=1e-2)
    taken = sum(float(trace[name][-1]) for name in ("contact_heat", "pad_heat", "resistance_work"))
    assert taken == pytest.approx(float(trace["kinetic_energy"][0]), rel=2e-3)
    assert stop.metrics.utilisation < 1.005


def test_a_sliding_axle_loses_its_dynamic_brake_and_keeps_its_friction_brake(driven):
    """From the slide on the cylinder has the whole pressure; before it, less. The motor bogie needs 0.11 or more."""
    stop = run_stop(scenario(driven, mu0=0.05))
    trace = stop.trace
    slid = int(np.argmax(trace["slip"].values[:, 0] > 0.1))
    assert slid > 0
    pressure, time = trace["cylinder_pressure"].values[:, 0], trace["time"].values
    late = time > time[slid] + 2.0
    assert pressure[late] == pytest.approx(3.2e5, rel=1e-2)
    assert pressure[slid] < 0.6 * 3.2e5
    # Only the magnets still work, down to 50 km/h.
    rate = np.diff(trace["dynamic_work"].values) / np.diff(time)
    still = late[1:] & (trace["speed"].values[1:] > 70 / 3.6)
    v = trace["speed"].values[1:][still]
    assert rate[still] == pytest.approx(8e3 * 2 * v / (v / 25 + 25 / v), rel=2e-2)


def test_the_ideal_bound_has_the_dynamic_brakes(driven):
    full = run_stop(scenario(driven))
    bound = ideal_stop(scenario(driven, controller={"kind": "ideal_bound"})).metrics.distance
    # The build-up takes 0.9 s from which the bound has 0.
    assert full.metrics.distance - 1.1 * SPEED < bound < full.metrics.distance


def test_valves_relieve_the_cylinders_too(driven):
    stop, hand = run_stop(scenario(driven, actuation={"kind": "pneumatic"})), by_hand(load_train(driven), SPEED)
    assert -0.01 * hand.distance < stop.metrics.distance - hand.distance < 0.01 * hand.distance + 0.45 * SPEED
    assert float(stop.trace["dynamic_work"][-1]) == pytest.approx(hand.dynamic_work, rel=0.05)


def test_an_estimator_that_does_not_know_the_dynamic_brakes_is_refused(driven):
    vehicle = VehicleData(scenario(driven, estimator={"kind": "decentralised"}))
    with pytest.raises(ScenarioError, match=r"\[estimator\] kind 'decentralised' assumes that pressure alone"):
        vehicle.require_known_forces()


def test_dump_valves_without_a_command_do_not_know_the_demand(tmp_path):
    """With a [command], pipe or wire bring the demand to the blending: test_demands_through_the_command.py."""
    file = one_braked_bogie(tmp_path / "direct.toml", "motor", MOTOR | {"blending": "added"}, without_command)
    demand = {"actuation": {"kind": "pneumatic"}, "demand": {"phases": [{"pressure": "1 bar"}]}}
    with pytest.raises(ScenarioError, match=r"\[demand\] with \[actuation\] kind = 'pneumatic'"):
        VehicleData(scenario(file, **demand)).require_known_forces()


def test_plausibility_allows_the_force_of_the_magnets(driven):
    assert VehicleData(scenario(driven)).slowing.constant == pytest.approx(0.02 + 8e3 / 44e3)
