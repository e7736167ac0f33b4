"""The calculation by hand compared with closed forms, and messages about inconsistent trains."""

import re

import numpy as np
import pytest
from wrong import change, table

from railgrip.base.units import GRAVITY
from railgrip.rolling_stock.check import findings, stops_by_hand
from railgrip.rolling_stock.modelica import class_name, class_text
from railgrip.rolling_stock.schema import train_of
from railgrip.rolling_stock.stopping import by_hand, chain_forces, full_brake_force


def bare(tables):
    """A train slowed only by constant brake forces."""
    tables["resistance"] |= {"drag_coefficient": 1e-9, "bearing_friction": 1e-9, "rolling_arm": 0}
    tables["pads"]["organic"] |= {"speed_effect": 0, "force_effect": 0}
    del tables["command"]
    return tables


def weak_behind(tables):
    """A bare train whose second car brakes half as hard."""
    bare(tables)["bogies"]["weak"] = dict(tables["bogies"]["trailer"], units=[1])
    for placed in tables["cars"][1]["bogies"]:
        placed["kind"] = "weak"
    return tables


def test_constant_force_gives_the_textbook_distance(tables):
    """With rotating masses: 2 units of 0.95·4·(p A − F) on each of 8 axles."""
    pad_force = 0.95 * 4 * (3.2e5 * 0.0324 - 1200)
    deceleration = 8 * 2 * 0.35 * pad_force * 0.25 / 0.46 / (88e3 + 8 * 120 / 0.46**2)
    train = train_of(bare(tables), "ours.toml")
    stop = by_hand(train, 30.0)
    assert stop.distance == pytest.approx(30.0**2 / (2 * deceleration), rel=1e-6)
    assert stop.deceleration == pytest.approx(deceleration, rel=1e-6)
    inertia = 120 / 0.46**2
    used = (full_brake_force(train)[0] - inertia * stop.deceleration) / (11e3 * GRAVITY)
    assert stop.adhesion == pytest.approx(np.full(8, used), rel=1e-6)


def test_an_electropneumatic_build_up_adds_its_closed_form(tables):
    """With a(t) = a (1 − e^(−(t − d)/T)) the distance grows by v (d + T) − a T²/2."""
    command = tables["command"]
    tables["brakes"]["disc"]["spring_force"] = 0
    full = by_hand(train_of(bare(tables), "ours.toml"), 30.0)
    stop = by_hand(train_of(tables | {"command": command}, "ours.toml"), 30.0)
    expected = 30.0 * (0.4 + 0.5) - full.deceleration * 0.5**2 / 2
    assert stop.distance - full.distance == pytest.approx(expected, rel=1e-3)
    assert stop.equivalent_time == pytest.approx(expected / 30.0, rel=1e-3)
    assert stop.deceleration == pytest.approx(full.deceleration, rel=1e-6)


def test_a_brake_pipe_brakes_the_rear_later(tables):
    """The front travels along 48 m at 290 m/s; the pressure behind it rises evenly to 95 % in 4 s."""
    command = {"kind": "brake_pipe", "diameter": "32 mm", "branch_volume": 0, "fill_time": "4 s", "estimated": True}
    command |= {"reservoir": "0.1 m3"}
    tables["brakes"]["disc"]["spring_force"] = 0
    full = by_hand(train_of(bare(tables), "ours.toml"), 30.0)
    train = train_of(tables | {"command": command}, "ours.toml")
    mean = sum(axle.position for axle in train.axles) / len(train.axles) / 290
    rise = 4 / 0.95
    expected = 30.0 * (mean + rise / 2) - full.deceleration * rise**2 / 24
    assert by_hand(train, 30.0).distance - full.distance == pytest.approx(expected, rel=2e-3)
    # Branches with three times the volume of the pipe halve the wave speed; drag slows the train meanwhile.
    command["branch_volume"] = f"{3 * np.pi / 4 * 0.032**2 * 24} m3"
    branched = train_of(tables | {"command": command}, "ours.toml")
    assert by_hand(branched, 30.0).distance - by_hand(train, 30.0).distance == pytest.approx(30.0 * mean, rel=5e-3)


def test_a_low_stage_adds_its_closed_form(piped):
    """With almost no build-up full braking acts down to 50 km/h, half of it below: v² over twice each deceleration."""
    piped["brakes"]["disc"]["spring_force"] = 0
    piped["command"] |= {"fill_time": "1 us"}
    piped["distributors"]["R"]["stage_time"] = "1 ms"
    command = piped["command"]
    full = by_hand(train_of(bare(piped), "ours.toml"), 30.0)
    piped["command"] = command
    for car in piped["cars"]:
        car["distributor"] = "R"
    changeover = 50 / 3.6
    expected = full.distance * (1 + (1 / 0.5 - 1) * (changeover / 30.0) ** 2)
    late = 30.0 * np.mean([axle.position for axle in train_of(piped, "ours.toml").axles]) / 290
    assert by_hand(train_of(piped, "ours.toml"), 30.0).distance - late == pytest.approx(expected, rel=1e-3)
    # A stop that starts between both speeds is in the low stage from the start.
    low = by_hand(train_of(piped, "ours.toml"), 60 / 3.6)
    assert low.deceleration == pytest.approx(0.5 * full.deceleration, rel=1e-3)


def test_a_coupler_transmits_braking_in_excess_of_a_cars_share(tables):
    """Two equal bodies, one braked twice as hard: a quarter of the sum is transmitted by the coupler."""
    train = train_of(weak_behind(tables), "ours.toml")
    force, stop = full_brake_force(train), by_hand(train, 20.0)
    front, rear = force[:4].sum(), force[4:].sum()
    assert stop.coupler_force == pytest.approx([(front - rear) / 2], rel=1e-5)


def test_two_cars_on_a_spring_overshoot_the_static_force_by_the_closed_form(tables):
    """A damped spring overshoots by exp(-π ζ/√(1 - ζ²)) after a step; undamped it reaches twice the static force."""
    (coupler,) = weak_behind(tables)["couplers"].values()
    for damping in (0.0, 3e4):
        coupler |= {"stiffness": "2 MN/m", "damping": damping, "slack": 0}
        train = train_of(tables, "ours.toml")
        stop = by_hand(train, 20.0)
        reduced = stop.car_mass.prod() / stop.car_mass.sum()
        zeta = damping / (2 * np.sqrt(2e6 * reduced))
        # The damper contributes at the peak of the force: tension is k x + c dx/dt.
        time = np.linspace(0.0, 5.0, 200001)
        own = np.sqrt(2e6 / reduced)
        swing = own * np.sqrt(1 - zeta**2)
        decay = np.exp(-zeta * own * time)
        x = 1 - decay * (np.cos(swing * time) + zeta * own / swing * np.sin(swing * time))
        force = x + 2 * zeta / own * np.gradient(x, time)
        assert chain_forces(train, stop) == pytest.approx(stop.coupler_force * force.max(), rel=1e-3)


def test_slack_lets_cars_run_into_each_other(tables):
    """From the middle of the slack a step F reaches F (1 + √(1 + k slack/F)), by the undamped energy balance."""
    (coupler,) = weak_behind(tables)["couplers"].values()
    coupler |= {"stiffness": "2 MN/m", "damping": 0, "slack": "40 mm"}
    train = train_of(tables, "ours.toml")
    stop = by_hand(train, 20.0)
    static = float(stop.coupler_force[0])
    expected = static * (1 + np.sqrt(1 + 2e6 * 0.04 / static))
    assert chain_forces(train, stop) == pytest.approx([expected], rel=1e-3)


@pytest.mark.parametrize(("changes", "key", "words"), table(__file__, "tables.toml")["inconsistent_trains"])
def test_an_inconsistency_is_reported_with_its_key(tables, changes, key, words):
    tables["bogies"]["light"] = dict(tables["bogies"]["trailer"], units=[1])
    tables["cars"][1]["bogies"][0]["kind"] = "light"
    for place, value in changes.items():
        change(tables, place, value)
    wrong = [one for one in findings(train_of(tables, "ours.toml")) if one.wrong]
    assert [one.key for one in wrong] == [key]
    assert words in wrong[0].sentence


def test_overloaded_couplers_of_a_kind_are_one_sentence(tables):
    """Six heavy cars push on a light one with equal brakes: of rigid cars the k-th coupler carries k/6 of the last."""
    tables["cars"][0] |= {"mass": "150 t", "count": 6}
    tables["couplers"]["bar"]["strength"] = "1 MN"
    forces = np.abs(next(iter(stops_by_hand(train_of(tables, "ours.toml")).values())).coupler_force)
    assert forces == pytest.approx(forces[5] * np.arange(1, 7) / 6, rel=0.1)
    tables["couplers"]["bar"]["strength"] = float(forces[2:4].mean())
    wrong = [one.sentence for one in findings(train_of(tables, "ours.toml")) if "braking alone" in one.sentence]
    name = tables["cars"][0]["name"]
    words = f"loads 3 of 6 such couplers beyond that, and the coupler behind {name}-6 by {forces[5] / 1e3:.0f} kN"
    (sentence,) = wrong
    assert words in sentence


def test_a_brake_that_requires_too_much_adhesion_is_unusual(tables):
    tables["brakes"]["disc"]["pressure_max"] = "5 bar"
    (one,) = findings(train_of(tables, "ours.toml"))
    assert not one.wrong
    assert one.key == "[bogies.trailer] brake"
    assert "LOC&PAS TSI" in one.sentence


def test_a_changeover_above_the_start_speed_and_an_idle_accelerator_are_unusual(piped):
    piped["cars"][0] |= {"distributor": "R", "accelerator": "quick"}
    piped["distributors"]["R"] |= {"speed_up": "130 km/h"}
    piped["accelerators"]["quick"]["sensing_time"] = "0.05 s"
    unusual = {one.key: one.sentence for one in findings(train_of(piped, "ours.toml")) if not one.wrong}
    assert "a stop from 120 km/h is in the low stage throughout" in unusual["[distributors.R] speed_up"]
    assert "is 0.035 bar: below 0.1 bar" in unusual["[accelerators.quick] sensing_time"]


def test_equipment_is_at_the_pipe_of_the_car_that_names_it(piped):
    """The pipe has five cells per car, with the branch at the third; cars connect to it."""
    piped["cars"][0]["distributor"] = "R"
    piped["command"]["branch_volume"] = "3 l"
    text = class_text(train_of(piped, "ours.toml"), pneumatic=True)
    assert "BrakePipe pipe(final n=10, length={4.8, 4.8, 4.8, 4.8, 4.8, 4.8, 4.8, 4.8, 4.8, 4.8}" in text
    assert "V_branch={0, 0, 0.003, 0, 0, 0, 0, 0.003, 0, 0}" in text
    assert "connect(pipe.branch[3], two_stage1.pipe);" in text
    assert "connect(pipe.branch[8], distributor[1].pipe);" in text
    assert "two_stage1.speed = body1.v;" in text
    piped["cars"][1]["accelerator"] = "quick"
    text = class_text(train_of(piped, "ours.toml"), pneumatic=True)
    assert "connect(pipe.branch[8], accelerator1.pipe);" in text
    assert "connect(two_stage1.outlet, cylinder[4].supply);" in text
    assert "connect(distributor[1].outlet, cylinder[5].supply);" in text


def test_a_name_with_quotes_stays_inside_its_string(tables):
    tables["description"] = 'so called "train" \\'
    text = class_text(train_of(tables, "ours.toml"), pneumatic=False)
    assert 'block Train_ours "so called \\"train\\" \\\\"' in text


def test_trains_of_different_names_are_classes_of_different_names(tables):
    """For all names that a file may have, with and without valves."""
    names = ["a", "a-b", "a.b", "a_b", "a_2d_b", "a__b", "a_pneumatic", "a_5f_b", "a-.b", "a.-b"]
    trains = [train_of(tables | {"name": name}, "ours.toml") for name in names]
    classes = {class_name(train, pneumatic=pneumatic) for train in trains for pneumatic in (False, True)}
    assert len(classes) == 2 * len(names)
    assert all(re.fullmatch(r"[A-Za-z_][A-Za-z0-9_]*", name) for name in classes)
