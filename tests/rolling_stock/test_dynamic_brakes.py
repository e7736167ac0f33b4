"""Electrodynamic, eddy-current and parking brakes of train files, against closed forms and numerical integrals."""

import json

import numpy as np
import pytest
from scipy.integrate import quad
from small_train import electric_tables
from synthetic import MOTOR, ON_RAIL
from wrong import REMOVED, change

from railgrip.base.errors import InputError, ScenarioError
from railgrip.base.registry import DYNAMIC_BRAKES, modules, shelf
from railgrip.estimation.models import of_train
from railgrip.rolling_stock.calculation import mean_stop, parking
from railgrip.rolling_stock.calculation_page import calculation_page
from railgrip.rolling_stock.check import findings
from railgrip.rolling_stock.dynamic_brakes.eddy_current_rail import EddyCurrentRail
from railgrip.rolling_stock.dynamic_brakes.electrodynamic import Electrodynamic
from railgrip.rolling_stock.schema import load_train, train_of
from railgrip.rolling_stock.stopping import by_hand, developed_forces, full_brake_force, response_times
from railgrip.rolling_stock.tables import plain_stop
from railgrip.scenario.file import NamedFile
from railgrip.supervision.trains import maximum_speed

DISC = ON_RAIL | {"kind": "eddy_current_axle", "force": "5 kN", "blending": "added", "slide_limit": 0.1}
SPEED = 120 / 3.6


@pytest.fixture
def electric():
    """A train with a motor bogie under each car and pads of constant friction."""
    return electric_tables()


def with_brake(tables, **keys):
    """Return the train with changed keys of its dynamic brake."""
    changed = {name: value for name, value in (tables["dynamic_brakes"]["motor"] | keys).items() if value is not None}
    return train_of(tables | {"dynamic_brakes": {"motor": changed}}, "electric")


def test_the_force_is_constant_then_that_of_constant_power_and_fades_out():
    brake = Electrodynamic.model_validate(MOTOR)
    speed = np.array([0.0, 4 / 3.6, 7 / 3.6, 10 / 3.6, 14.0, 20.0, 40.0])
    assert brake.force_at(speed) == pytest.approx([0, 0, 6e3, 12e3, 12e3, 10e3, 5e3])
    assert brake.force_at(40.0, units=4) == pytest.approx(20e3)
    limited = brake.model_copy(update={"adhesion_limit": 0.1})
    assert limited.force_at(np.array([10.0, 40.0]), 1, 1e5) == pytest.approx([10e3, 5e3])


def test_an_eddy_current_brake_has_its_maximum_at_the_critical_speed():
    """Wouterse: F/F_max = 2/(v/v1 + v1/v), so that double and half of v1 have 4/5 of the maximum."""
    brake = EddyCurrentRail.model_validate(ON_RAIL)
    assert brake.force_at(np.array([25.0, 50.0])) == pytest.approx([20e3, 16e3])
    at = np.linspace(60 / 3.6, 200 / 3.6, 20001)
    assert at[np.argmax(brake.force_at(at))] == pytest.approx(25.0, abs=0.01)


@pytest.mark.parametrize("blending", ["valve", "train"])
def test_a_blended_stop_has_the_deceleration_of_the_friction_brake(electric, blending):
    """Pads have constant friction, so that forces are exchanged one for one, whatever the speed."""
    train = with_brake(electric, blending=blending)
    with_it, without = by_hand(train, SPEED), by_hand(train, SPEED, dynamic=False)
    assert with_it.distance == pytest.approx(without.distance, rel=1e-9)
    assert with_it.equivalent_time == pytest.approx(without.equivalent_time, rel=1e-6)
    mean = mean_stop(train, SPEED)
    assert mean.distance_without_dynamic == pytest.approx(mean.distance, rel=1e-12)
    assert without.dynamic_work == 0
    assert with_it.dynamic_work > 10e6


def test_the_energies_of_both_brakes_are_the_integrals_of_their_forces(electric):
    """Developed forces over distance at constant friction: 0.5 v² F/(a v) and the electric part of it."""
    train = with_brake(electric)
    mean = mean_stop(train, SPEED)
    total = float(mean.force.sum() + mean.force_dynamic.sum())
    cap = 4 * 12e3  # four driven axles

    def electric_force(v):
        return min(cap, 4 * 200e3 / v) * min(max((v - 4 / 3.6) / (6 / 3.6), 0.0), 1.0)

    work, _ = quad(lambda v: v * electric_force(v), 0, SPEED, points=[4 / 3.6, 10 / 3.6, 200 / 12], epsabs=1)
    mean_force = 2 * work / SPEED**2
    assert mean.force_dynamic.sum() == pytest.approx(mean_force, rel=1e-3)
    braking_way = mean.distance - SPEED * mean.equivalent_time
    assert mean.energy_dynamic.sum() == pytest.approx(mean_force * braking_way, rel=1e-3)
    assert (mean.energy + mean.energy_dynamic).sum() == pytest.approx(total * braking_way)


def test_the_work_by_time_steps_is_the_integral_of_the_force_over_the_distance(electric):
    """Constant forces: pressure builds up as 1 - e^(-t/T), and the electric force behind it and a lag of its own.

    By mean values both build up in the response time of the train, which is 2.3 % more work of the electric brake.
    """
    electric["resistance"] |= {"drag_coefficient": 1e-9, "bearing_friction": 1e-9, "rolling_arm": 0}
    electric["brakes"]["disc"]["spring_force"] = 0
    train = with_brake(electric, blending="added", power="2 MW", speed_full="0.1 m/s", speed_end=0)
    time = np.linspace(0.0, 40.0, 400_001)  # from the first pressure
    pressure, lag, electric_force = 0.5, 0.3, 4 * 12e3
    first, second = (-each * np.expm1(-time / each) for each in (pressure, lag))
    share = 1 - (pressure - first - lag + second) / (pressure - lag)
    # The impulses are the integrals of both shares.
    impulse = full_brake_force(train).sum() * (time - first)
    impulse += electric_force * (time - (pressure * first - lag * second) / (pressure - lag))
    stop, mean = by_hand(train, SPEED), mean_stop(train, SPEED)
    speed = SPEED - impulse / (train.mass + stop.rotating_mass)
    work = np.trapezoid(electric_force * share * np.maximum(speed, 0), time)
    assert stop.dynamic_work == pytest.approx(work, rel=1e-3)
    assert mean.energy_dynamic.sum() == pytest.approx(1.023 * work, rel=1e-3)
    assert plain_stop(SPEED, stop)["dynamic_work"] == stop.dynamic_work


def test_across_the_train_trailers_are_relieved_too(electric):
    """20 kN of an axle are beyond the 13.25 kN of its friction brakes: only blending over the train uses them."""
    keys = {"force": "20 kN", "power": "1 MW"}
    own, common = (with_brake(electric, blending=mode, **keys) for mode in ("valve", "train"))
    at_own, at_common = (developed_forces(train, SPEED)(20.0) for train in (own, common))
    whole = developed_forces(own, SPEED, dynamic=False)(20.0).friction
    assert at_own.dynamic[:2] == pytest.approx(whole[:2])
    assert at_own.friction[2:4] == pytest.approx(whole[2:4])
    assert at_common.dynamic[:2] == pytest.approx([20e3, 20e3])
    assert at_common.friction[:2] == pytest.approx([0, 0], abs=1e-6)
    assert at_common.friction[2] == pytest.approx((whole.sum() - 4 * 20e3) / 4)
    assert at_common.friction.sum() + at_common.dynamic.sum() == pytest.approx(whole.sum())


def test_what_exceeds_the_demand_of_the_train_is_not_used(electric):
    train = with_brake(electric, blending="train", force="60 kN", power="5 MW")
    forces = developed_forces(train, SPEED)(20.0)
    assert forces.friction == pytest.approx(np.zeros(8), abs=1e-6)
    assert forces.dynamic.sum() == pytest.approx(developed_forces(train, SPEED, dynamic=False)(20.0).friction.sum())


def test_added_brakes_shorten_the_stop(electric):
    train = with_brake(electric, blending="added")
    both, friction = developed_forces(train, SPEED)(20.0), developed_forces(train, SPEED, dynamic=False)(20.0)
    assert both.friction == pytest.approx(friction.friction)
    assert both.dynamic.sum() == pytest.approx(4 * 10e3)
    mean = mean_stop(train, SPEED)
    assert mean.distance_without_dynamic > 1.1 * mean.distance
    assert mean.distance_without_dynamic == pytest.approx(mean_stop(with_brake(electric), SPEED).distance)


def test_coupled_axles_and_units_per_axle_share_the_force(electric):
    electric["bogies"]["motor"] |= {"coupled": True, "valve": "bogie", "dynamic_units": [1, 0]}
    forces = developed_forces(with_brake(electric), SPEED)(20.0)
    assert forces.dynamic == pytest.approx([10e3, 0, 0, 0, 10e3, 0, 0, 0])
    adhesion = by_hand(with_brake(electric), SPEED).adhesion
    assert adhesion[0] == pytest.approx(adhesion[1])


def test_a_brake_on_the_rail_adds_and_needs_no_adhesion(electric):
    plain = train_of({key: value for key, value in electric.items() if key != "dynamic_brakes"} | {
        "bogies": electric["bogies"] | {"motor": electric["bogies"]["trailer"]}}, "plain")  # fmt: skip
    train = train_of(electric | {"dynamic_brakes": {"motor": ON_RAIL}}, "rail")
    forces = developed_forces(train, SPEED)(25.0)
    assert forces.rail == pytest.approx([20e3, 20e3])
    assert train.track_brake_force == pytest.approx(40e3)
    assert by_hand(train, SPEED).adhesion.max() <= by_hand(plain, SPEED).adhesion.max() * (1 + 1e-6)
    assert by_hand(train, SPEED).distance < 0.95 * by_hand(plain, SPEED).distance
    assert response_times(train)[1] == pytest.approx([0.5, 0.5])


def test_a_rotating_eddy_current_brake_needs_adhesion(electric):
    train = train_of(electric | {"dynamic_brakes": {"motor": DISC}}, "disc")
    driven, plain = by_hand(train, SPEED).adhesion, by_hand(train, SPEED, dynamic=False).adhesion
    load = train.axles[0].mass * 9.81
    assert driven[0] - plain[0] == pytest.approx(5e3 / load, rel=0.05)
    assert driven[2] <= plain[2] * (1 + 1e-6)


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"dynamic_brakes.motor.speed_end": "12 km/h"},
         "dynamic_brakes.* speed_end 12 km/h and speed_full 10 km/h; speed_end must be"),
        ({"dynamic_brakes.motor.power": REMOVED}, r"dynamic_brakes.* has no 'power'"),
        ({"dynamic_brakes.motor.kind": "eddy_current_axle", "dynamic_brakes.motor.power": REMOVED},
         "dynamic_brakes.*speed_peak"),
        ({"dynamic_brakes.motor.blending": "car"}, "dynamic_brakes.* blending"),
        ({"dynamic_brakes.motor.force": "2 MN"}, "dynamic_brakes.* at most 200000 N"),
        ({"dynamic_brakes.motor.kind": "retarder"}, "dynamic_brakes.* hydrodynamic"),
        ({"bogies.motor.dynamic_brake": "motr"},
         r"names 'motr', which is not in \[dynamic_brakes\]; it has motor; .*motor"),
        ({"bogies.motor.dynamic_units": [1, 1, 1]}, "has 2 axles and 3 dynamic_units"),
        ({"bogies.motor.dynamic_units": [0, 0]}, "only zeros"),
        ({"bogies.motor.parking_units": [2]}, "parking_units needs parking_brake"),
        ({"command": REMOVED}, r"blending needs a \[command\]"),
        ({"dynamic_brakes.other": MOTOR | {"blending": "train"}, "bogies.trailer.dynamic_brake": "other"},
         "blending 'valve' and 'train'"),
        ({"bogies.trailer.brake": "other", "bogies.trailer.valve": "car", "bogies.motor.valve": "car"},
         "share a brake valve, but have different brake"),
    ],
)  # fmt: skip
def test_a_contradiction_is_refused(electric, changes, sentence):
    electric["brakes"]["other"] = electric["brakes"]["disc"] | {"pressure_max": "2 bar"}
    for place, value in changes.items():
        change(electric, place, value)
    with pytest.raises(ScenarioError, match=sentence):
        train_of(electric, "electric")


def test_a_maximum_force_that_is_never_reached_is_remarked(electric):
    remarks = [str(found) for found in findings(with_brake(electric, power="20 kW"))]
    assert any("maximum force is never available" in remark for remark in remarks)
    assert not any("never available" in str(found) for found in findings(with_brake(electric)))


def test_the_parking_brake_holds_by_force_and_by_adhesion(tables):
    """Two units of 20 kN and 0.3 on two of eight axles: 2·2·20·0.3·250/460 kN = 6.52 kN each, of 11 t."""
    tables["parking_brakes"] = {
        "spring": {"force": "20 kN", "friction": 0.3, "friction_radius": "250 mm", "estimated": True}
    }
    tables["bogies"]["parked"] = tables["bogies"]["trailer"] | {"parking_brake": "spring", "parking_units": [2, 0]}
    for car in tables["cars"]:
        car["bogies"][0]["kind"] = "parked"
    train = train_of(tables, "parked")
    axle, weight = 2 * 20e3 * 0.3 * 250 / 460, 88e3 * 9.81
    held = parking(train)
    assert held.force == pytest.approx(2 * axle)
    assert held.usable == pytest.approx(2 * axle)
    assert held.slope == pytest.approx(np.tan(np.arcsin(2 * axle / weight)))
    assert held.adhesion == pytest.approx(np.sin(np.arctan(0.04)) * weight / 2 / (11e3 * 9.81))
    assert any("[parking_brakes] force" in str(found) for found in findings(train))
    tables["parking_brakes"]["spring"]["force"] = "200 kN"
    assert parking(train_of(tables, "parked")).usable == pytest.approx(2 * 0.12 * 11e3 * 9.81)


def test_a_train_without_parking_brake_holds_nothing(train):
    held = parking(train)
    assert held.force == held.slope == 0
    assert held.adhesion == np.inf


def test_commands_have_the_stop_without_dynamic_brakes(railgrip, tmp_path):
    code, out, err = railgrip("train", "calculate", "flirt", "--json")
    assert code == 0, err
    stop = json.loads(out)["stops"][0]
    assert sum(stop["energy_dynamic"]) > 0
    assert stop["distance_without_dynamic"] > 0
    assert railgrip("train", "calculate", "flirt", "--out", "page")[0] == 0
    assert "without dynamic" in (tmp_path / "page" / "index.html").read_text(encoding="utf-8")


def test_a_filter_refuses_a_train_whose_axles_brake_electrically():
    with pytest.raises(InputError, match=r"has \[dynamic_brakes\] on its axles"):
        of_train(NamedFile(entry="flirt", path=shelf("trains")["flirt"]))


def test_the_package_has_ten_trains_and_one_of_each_brake():
    """Kinds of blocks whose law has no published train are the exception: cast iron P6."""
    trains = [load_train(path) for path in shelf("trains").values()]
    assert len(trains) >= 10
    bogies = [bogie for train in trains for bogie in train.bogies_in_train]
    dynamic = {bogie.dynamic_brake.kind for bogie in bogies if bogie.dynamic_brake}
    assert dynamic == set(modules(DYNAMIC_BRAKES))
    laws = {blocks.law for train in trains for blocks in train.blocks.values()}
    assert laws >= {"cast_iron_p10", "composite_k"}
    assert any(bogie.brake.pads for bogie in bogies)
    assert any(bogie.track_brake for bogie in bogies)
    assert any(train.parking_brakes for train in trains)


@pytest.mark.parametrize("name", sorted(shelf("trains")))
def test_a_train_of_the_package_does_not_contradict_itself_and_its_page_has_all_its_brakes(name):
    train = load_train(shelf("trains")[name])
    assert not [str(found) for found in findings(train) if found.wrong]
    page = calculation_page(train, [mean_stop(train, maximum_speed(train))], origin=name, digest="")
    values = [page.values[key] for key in ("data", "axles", "dynamic", "rail")]
    texts = {text for table in values if table for row in table.texts for text in row.values()}
    used = {bogie.kind: bogie.data for bogie in train.bogies_in_train}.values()
    names = {getattr(bogie, key) for bogie in used for key in ("brake", "dynamic_brake", "track_brake")} - {None}
    assert names <= texts
    assert ("parking brake" in texts) == any(bogie.parking_brake for bogie in used)
