"""The brake calculation by mean values is the published one, and laws of blocks have their published numbers."""

import json
import re
import tomllib
from pathlib import Path

import numpy as np
import pytest
from deviating_train import deviating
from matplotlib.backends.backend_pdf import PdfPages
from matplotlib.text import Text
from train_stops import dry_scenario
from wrong import change, table

from railgrip.base.errors import ScenarioError
from railgrip.base.units import GRAVITY
from railgrip.rolling_stock.brakes import LAWS
from railgrip.rolling_stock.calculation import BRAKED_WEIGHT, braked_weight_percentage, mean_stop
from railgrip.rolling_stock.calculation_page import calculation_page
from railgrip.rolling_stock.check import findings
from railgrip.rolling_stock.modelica import class_text
from railgrip.rolling_stock.scatter import scatter
from railgrip.rolling_stock.schema import load_train, train_of
from railgrip.rolling_stock.stopping import by_hand, scattered_distances
from railgrip.simulate.ideal import ideal_stop
from railgrip.simulate.run import braking_distance

TRAINS = Path(__file__).parents[2] / "harness/scenario/trains"
UNIT, WAGON = TRAINS / "two_car_unit.toml", TRAINS / "eanos_wagon.toml"

PUBLISHED = {160: 1170.8, 140: 920.6, 120: 695.4, 100: 497.8}
"""Speed [km/h] → distance [m] by RailProfAC/RailwayBrakeCalculation, whose resistance here brakes at each speed."""


@pytest.fixture
def wagon():
    """The tables of the wagon with blocks."""
    return tomllib.loads(WAGON.read_text(encoding="utf-8"))


@pytest.mark.parametrize(("speed", "distance"), PUBLISHED.items())
def test_mean_values_are_those_of_the_published_calculation(speed, distance):
    """The published distances have one decimal."""
    train = load_train(UNIT)
    stop = mean_stop(train, speed / 3.6)
    assert stop.force[[0, 2]] == pytest.approx([16073, 9104], abs=1)
    assert stop.distance == pytest.approx(distance, abs=0.05)
    # A + 2/3 B v + C v²/2
    v = speed / 3.6
    # A bearing friction of 1e-9 stands for none.
    assert stop.resistance == pytest.approx(3000 + 2 / 3 * 110 * v + 7 / 2 * v**2, rel=1e-6)
    # The build-up is exponential in the file and linear in the source; the distance hardly depends on it.
    assert stop.time_steps.distance == pytest.approx(distance, rel=0.003)


def test_adhesion_energy_and_power_are_those_of_their_definitions():
    train = load_train(UNIT)
    stop = mean_stop(train, 100 / 3.6)
    assert stop.adhesion[0] == pytest.approx((stop.force[0] - 1500 * stop.deceleration) / (15e3 * GRAVITY), rel=1e-9)
    kinetic = (118e3 + 4 * 1500 + 4 * 700) * (100 / 3.6) ** 2 / 2
    braked = stop.distance - stop.speed * stop.equivalent_time
    assert stop.energy.sum() + stop.resistance * braked == pytest.approx(kinetic, rel=1e-6)
    assert stop.power == pytest.approx(stop.force * 100 / 3.6)


def test_the_steps_of_the_deceleration_give_the_distance():
    """Σ (v1² − v2²)/(2 a) over the steps; a varies by 5 %, so that its harmonic mean is 0.25 % below its mean."""
    stop = mean_stop(load_train(UNIT), 160 / 3.6, step=5 / 3.6)
    assert stop.steps[0][0] == 160 / 3.6
    assert stop.steps[-1][1] == 0
    distance = sum((upper**2 - lower**2) / (2 * a) for upper, lower, a in stop.steps)
    assert distance == pytest.approx(stop.speed**2 / (2 * stop.deceleration), rel=0.003)


def test_braked_weight_percentages_are_those_of_the_leaflet():
    """C/s − D, and nothing between the speeds of the table or outside of the range."""
    assert braked_weight_percentage(120 / 3.6, 1000, BRAKED_WEIGHT) == pytest.approx(80.033)
    assert braked_weight_percentage(130 / 3.6, 1000, BRAKED_WEIGHT) is None
    assert braked_weight_percentage(100 / 3.6, 300, BRAKED_WEIGHT) is None  # 195 %


def test_a_calculation_is_a_pdf_that_can_be_reproduced_and_json(railgrip, tmp_path):
    code, out, err = railgrip("train", "calculate", str(UNIT), "--speed", "160 km/h", "--out", "report")
    assert (code, err) == (0, "")
    assert "1170.8 m" in out
    first = (tmp_path / "report/calculation.pdf").read_bytes()
    assert first.startswith(b"%PDF")
    railgrip("train", "calculate", str(UNIT), "--speed", "160 km/h", "--out", "report")
    assert (tmp_path / "report/calculation.pdf").read_bytes() == first
    code, out, _ = railgrip("train", "calculate", str(UNIT), "--json")
    assert [round(3.6 * stop["speed"]) for stop in json.loads(out)["stops"]] == [100, 120, 140, 160]
    assert json.loads(out)["remarks"] == []
    _, out, _ = railgrip("train", "calculate", "shunting_train", "--speed", "40 km/h")
    assert "From 40 km/h the distance by time steps differs by" in out
    assert "Cells of λ are empty from 40 km/h: UIC 544-1 has no values" in out


@pytest.mark.parametrize(
    "description",
    [
        "costs $5 and $6 per km",
        r"share $\frac{1}{$ of all",
        "",
        " ".join(f"word{number}" for number in range(4000)),
        "MW" * 3000,
        "Тормозной расчёт, Πέδηση, frein, ±½ µ √2",
    ],
)
def test_a_text_is_in_the_pdf_as_it_is_written_over_all_the_sheets_that_it_takes(
    wagon, tmp_path, monkeypatch, description
):
    sheets, write = [], PdfPages.savefig
    monkeypatch.setattr(PdfPages, "savefig", lambda self, sheet: (sheets.append(sheet), write(self, sheet)))
    train = train_of(wagon | {"description": description}, tmp_path / "mine.toml")
    page = calculation_page(train, [mean_stop(train, 100 / 3.6)], origin="mine.toml", digest="")
    page.files["calculation.pdf"](tmp_path / "calculation.pdf")
    words = []
    for sheet in sheets:
        sheet.draw_without_rendering()
        texts = [text for text in sheet.findobj(Text) if text.get_text()]
        assert not any(text.get_parse_math() for text in texts)
        boxes = [text.get_window_extent() for text in texts]
        assert all(box.x0 > 0 and box.x1 < sheet.bbox.x1 and box.y0 > 0 and box.y1 < sheet.bbox.y1 for box in boxes)
        words += [text.get_text() for text in texts]
    # Heads of sheets and other cells are between its lines.
    rest = description.replace(" ", "")
    for word in words:
        rest = rest.removeprefix(word.replace(" ", ""))
    assert rest == ""


@pytest.mark.parametrize("text", ["制动计算", "חישוב בלימה", "bell \a"])
def test_a_text_that_the_pdf_cannot_show_is_refused_before_anything_is_written(wagon, tmp_path, text):
    train = train_of(wagon | {"description": text}, tmp_path / "mine.toml")
    with pytest.raises(ScenarioError, match=r"mine\.toml: calculation\.pdf cannot show .* \(U\+"):
        calculation_page(train, [mean_stop(train, 100 / 3.6)], origin="mine.toml", digest="")


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (("--speed", "80"), "names no unit"),
        (("--speed", "-80 km/h"), "at least 0.1 m/s"),
        (("--step", "0 km/h"), "at le"),
    ],
)
def test_a_speed_that_is_none_is_refused_in_a_sentence(railgrip, arguments, sentence):
    code, out, err = railgrip("train", "calculate", "tram", *arguments)
    assert (code, out) == (2, "")
    assert sentence in err


@pytest.mark.parametrize(
    ("law", "rules"),
    [
        ("cast_iron_p6", lambda k, v: 0.6 * (16 * k + 100) / (80 * k + 100) * (v + 100) / (5 * v + 100)),
        ("cast_iron_p10", lambda k, v: 0.5 * (16 * k + 100) / (52 * k + 100) * (v + 100) / (5 * v + 100)),
        ("composite_k", lambda k, v: 0.44 * (k + 20) / (4 * k + 20) * (v + 150) / (2 * v + 150)),
    ],
)
def test_laws_of_blocks_are_those_of_the_russian_rules(law, rules):
    """K is in tf there. Karwatzki's numbers are rounded from them: 61.3 kN to 62.5 kN, and 12.3 kN to 12.5 kN."""
    for kn, v in ((10.0, 100.0), (20.0, 60.0), (30.0, 20.0)):
        friction = LAWS[law].factor * LAWS[law].shape(v / 3.6, 1e3 * kn)
        assert friction == pytest.approx(rules(kn / 9.80665, v), rel=0.01)


@pytest.mark.parametrize(("law", "distance", "above"), [("cast_iron_p6", 716, 0.0), ("cast_iron_p10", 657, 0.1)])
def test_a_wagon_with_cast_iron_blocks_has_its_published_stop_and_braked_weight(wagon, law, distance, above):
    """90 t on 16 holders with 478 kN, by RailProfAC/RailwayBrakeCalculation with a mean friction of 0.12: 672.5 m.

    The k-curve is that of UIC 544-1 for P10 in two-part blocks, k = 2.137 - 0.0514 F + ..., F in kN.
    """
    wagon["blocks"]["composite"]["law"] = law
    wagon["brakes"]["block"]["rigging"] *= 478 / (4 * load_train(WAGON).bogies_in_train[0].brake.full_force / 1e3)
    stop = mean_stop(train_of(wagon, "wagon.toml"), 100 / 3.6)
    assert stop.distance == pytest.approx(distance, abs=0.5)
    assert stop.distance == pytest.approx(672.5, rel=0.07)
    holder = 478 / 16
    k = 2.137 - 0.0514 * holder + 8.32e-4 * holder**2 - 6.04e-6 * holder**3
    assert stop.braked_weight_percentage_vehicle == pytest.approx((1 + above) * k * 478 / GRAVITY / 90 * 100, rel=0.02)


def test_a_wagon_with_blocks_stops_as_by_independent_integration(wagon):
    """RailProfAC/ShuntingBrakingCurves: cylinder, rigging, 16 blocks, composite K, resistance by Strahl."""
    del wagon["command"]
    train = train_of(wagon, "wagon.toml")
    v, distance, step = 100 / 3.6, 0.0, 1e-3
    force = (3.8e5 * 0.12946 - 1500) * 5.65 * 0.83
    while v > 0:
        block = force / 16
        friction = 0.055 * (block + 200e3) / (block + 50e3) * (v + 150 / 3.6) / (v + 75 / 3.6)
        a = (force * friction + 1413 + 6.51 * v**2) / 93.6e3
        distance += v * step
        v -= a * step
    assert by_hand(train, 100 / 3.6).distance == pytest.approx(distance, rel=1e-3)


def test_the_published_stop_of_the_wagon_is_met():
    """596 m measured by Cantone and Ottati (2018) from 100 km/h, 3 % by another law of friction than theirs."""
    assert by_hand(load_train(WAGON), 100 / 3.6).distance == pytest.approx(596, rel=0.03)


def test_a_law_of_blocks_that_falls_too_low_is_refused_with_its_range(wagon):
    wagon["blocks"]["composite"]["law"] = "cast_iron_p6"
    wagon["brakes"]["block"] |= {"block_count": 1, "rigging": 2.825}
    wagon["reference"][0]["speed"] = "200 km/h"
    sentence = next(str(found) for found in findings(train_of(wagon, "wagon.toml")) if found.wrong)
    assert sentence.startswith("[blocks.composite] law: friction falls to 0.046 at 200 km/h and 112 kN on a block")


def empty_eanos(wagon):
    """The empty wagon of Cantone and Ottati (2018): 25.5 t, 15 % rotating mass, rigging of 2.4 instead of 5.65."""
    wagon["load_valves"] = {
        "lever": {"kind": "changeover", "empty_share": 2.4 / 5.65, "full_mass": "50 t", "source": "tables 5 and 7"}
    }
    wagon["cars"][0] |= {"mass": "25.5 t", "load_valve": "lever"}
    wagon["bogies"]["Y25"]["inertia"] = [0.15 * 25.5e3 / 4 * 0.46**2]
    wagon["davis"] |= {"constant": "400 N", "quadratic": "1.84 N.s2/m2"}
    return wagon


@pytest.mark.parametrize(("changes", "sentence"), table(__file__, "tables.toml")["contradictory_wagons"])
def test_contradictions_of_a_wagon_are_refused(wagon, changes, sentence):
    """A load valve is that of the empty wagon."""
    if any(key.startswith("load_valves") for key in changes):
        empty_eanos(wagon)
    for place, value in changes.items():
        change(wagon, place, value)
    with pytest.raises(ScenarioError, match=re.escape(sentence)):
        train_of(wagon, "wagon.toml")


def test_bogies_with_another_build_up_have_another_wire():
    text = class_text(load_train(UNIT), pneumatic=True)
    assert text.count("ElectropneumaticCommand wire") == 2
    assert "supply[1].pressure = p_max[1]*available[1]" in text
    assert "supply[3].pressure = p_max[3]*available[2]" in text


@pytest.mark.parametrize(("file", "speed"), [(UNIT, 100), (WAGON, 100), (TRAINS / "tram.toml", 216)])
def test_the_simulated_stop_is_that_by_hand(file, speed):
    """Slip, suspension and the settling of friction move a dry stop by less than 1 %; magnets wait for 202 km/h."""
    simulated = braking_distance(dry_scenario(file, speed / 3.6))
    assert simulated == pytest.approx(by_hand(load_train(file), speed / 3.6).distance, rel=0.01)


def test_friction_effects_of_pads_and_the_mean_over_the_distance_agree():
    """The mean of 1 + e (1 − v/v_n) over v² is 1 + e (1 − 2/3 v0/v_n)."""
    tables = tomllib.loads(UNIT.read_text(encoding="utf-8"))
    tables["pads"]["constant"] |= {"speed_effect": 0.2, "speed_nominal": "20 m/s"}
    plain, falling = mean_stop(load_train(UNIT), 30.0), mean_stop(train_of(tables, "unit.toml"), 30.0)
    ratio = np.where(np.arange(8) % 6 < 2, 1.0, 0.27 / 0.445)  # pads slide slower than the train by r/R
    assert falling.force / plain.force == pytest.approx(1 + 0.2 * (1 - 2 / 3 * 30 * ratio / 20), rel=1e-9)


def shunting_tables(position):
    """The tables of the train of RailProfAC/ShuntingBrakingCurves in a position."""
    tables = tomllib.loads((TRAINS / "shunting_train.toml").read_text(encoding="utf-8"))
    if position == "P":
        for car in tables["cars"]:
            del car["distributor"]
    return tables


def shunting(position, *, inshot=True):
    tables = shunting_tables(position)
    if not inshot:
        tables["distributors"]["G"] |= {"inshot": 0, "fill_time": 0.95 * 24}
    return train_of(tables, "shunting.toml")


@pytest.mark.parametrize(("position", "inshot", "distance"), [("P", True, 42.8), ("G", True, 76.9), ("G", False, 87.9)])
def test_positions_g_and_p_give_the_published_distances(position, inshot, distance):
    """From 25 km/h, by the source's own equations with the force of its locomotive counted once.

    The published means are 38.34 m and 64.27 m. The source gives the inshot to all cars at once, ours after the wave in
    the pipe: 0.3 m.
    """
    assert by_hand(shunting(position, inshot=inshot), 25 / 3.6).distance == pytest.approx(distance, rel=0.006)


def test_the_response_time_of_a_linear_rise_is_its_integral():
    """Inshot i at once, then linear to 95 % in T: the missing area is T (1 − i)²/(2 (0.95 − i)) after the wave."""
    stop, position = mean_stop(shunting("G"), 25 / 3.6), mean_stop(shunting("P"), 25 / 3.6)
    assert stop.equivalent_time / position.equivalent_time == pytest.approx(
        (22.667 * 0.9**2 / (2 * 0.85) + 0.2) / (3.8 / (2 * 0.95) + 0.2), rel=0.02
    )


def test_positions_are_parameters_of_the_distributors_of_the_class():
    text = class_text(shunting("G"), pneumatic=True)
    assert "T_fill={22.667, 22.667, 22.667, 22.667, 22.667, 22.667}, T_release={17, 17, 17, 17, 17, 17}" in text
    assert "inshot={0.1, 0.1, 0.1, 0.1, 0.1, 0.1}" in text


@pytest.mark.parametrize(("speed", "distance"), [(100, 421), (120, 634)])
def test_the_published_stops_of_the_empty_wagon_are_met(wagon, speed, distance):
    """Measured; RailProfAC/ShuntingBrakingCurves reports deviations of about 5 % with the same law of friction."""
    assert by_hand(train_of(empty_eanos(wagon), "wagon.toml"), speed / 3.6).distance == pytest.approx(
        distance, rel=0.06
    )


def with_load_valve(wagon, **empty):
    """Give the wagon a valve with a share of the pressure at the mass of the empty car, and all of it at 90 t."""
    wagon["load_valves"] = {"valve": {"kind": "valve", "full_mass": "90 t", "estimated": True} | empty}
    wagon["cars"][0]["load_valve"] = "valve"


def test_a_load_valve_gives_the_pressure_of_the_load(wagon):
    """Halfway between 25.5 t and 90 t it is halfway between its share and 1; beyond both it is constant."""
    with_load_valve(wagon, empty_share=0.4, empty_mass="25.5 t")
    for mass, share in (("20 t", 0.4), ("57.75 t", 0.7), ("90 t", 1.0), ("99 t", 1.0)):
        wagon["cars"][0]["mass"] = mass
        train = train_of(wagon, "wagon.toml")
        assert train.bogies_in_train[0].brake.pressure_max == pytest.approx(share * 3.8e5)
        assert f"p_max={{{share * 3.8e5:.10g}, " in class_text(train, pneumatic=False)
        # The nominal point of the law stays that of the full car.
        assert train.bogies_in_train[0].pads.force_nominal == pytest.approx(55918, abs=2)


def remarks(tables):
    return "\n".join(str(found) for found in findings(train_of(tables, "wagon.toml")))


def test_blocks_that_are_not_on_the_tread_or_share_too_much_force_are_noticed(wagon):
    assert remarks(wagon) == ""
    wagon["brakes"]["block"]["friction_radius"] = "0.25 m"
    assert "[brakes.block] friction_radius: is 0.25 m, but blocks press on the tread" in remarks(wagon)
    wagon["brakes"]["block"] |= {"friction_radius": "460 mm", "block_count": 1}
    assert "[brakes.block] block_count: gives 56 kN on a block; usual are 5 to 40 kN" in remarks(wagon)


@pytest.mark.parametrize(
    "davis",
    [
        {"constant": 1.0, "linear": 0.01, "quadratic": 0.0002},  # daN/t and km/h, as in OpenRailAssociation/osrd#9928
        {"constant": 2.2e6, "linear": 233280, "quadratic": 75582},  # 1000 times as high, as in osrd#9657
        {"constant": "1413 N", "linear": 0, "quadratic": "6.51 N"},
    ],
)
def test_a_davis_line_in_other_units_is_refused_or_announced(wagon, davis):
    wagon["davis"] |= davis
    try:
        assert "[davis]" in remarks(wagon)
    except ScenarioError as refusal:
        assert "[davis]" in str(refusal)  # noqa: PT017 (one of two outcomes)


def test_a_load_valve_keeps_the_deceleration(wagon):
    """As leezer3/OpenBVE#623 asks: with a share in proportion to the mass, and without a spring, by less than 1 %."""
    wagon["brakes"]["block"]["spring_force"] = 0
    wagon["blocks"]["composite"]["law"] = "composite_k"
    with_load_valve(wagon, empty_share=0.5, empty_mass="45 t")
    wagon["davis"] |= {"constant": 0, "quadratic": 0}
    wagon["bogies"]["Y25"]["inertia"] = ["10 kg.m2"]
    full = mean_stop(train_of(wagon, "wagon.toml"), 20.0)
    wagon["cars"][0]["mass"] = "45 t"
    empty = mean_stop(train_of(wagon, "wagon.toml"), 20.0)
    # Blocks under half of the force have more friction: (7 + 200)/(7 + 50) for (14 + 200)/(14 + 50).
    force = 3.8e5 * 0.12946 * 5.65 * 0.83 / 16e3
    gain = (force / 2 + 200) / (force / 2 + 50) / ((force + 200) / (force + 50))
    assert empty.deceleration == pytest.approx(gain * full.deceleration, rel=0.01)


def test_the_ideal_bound_of_a_wagon_with_blocks_is_its_stop_without_the_build_up():
    """On a dry rail the brakes limit; its friction is the highest that blocks have after lower forces, within 2 %."""
    wagon = load_train(WAGON)
    bound = ideal_stop(dry_scenario(WAGON, 100 / 3.6)).metrics.distance_travelled
    at_once = by_hand(wagon.model_copy(update={"command": None}), 100 / 3.6).distance
    assert bound == pytest.approx(at_once, rel=0.02)
    assert bound < at_once * 1.001


def drawn(position):
    """The train of RailProfAC/ShuntingBrakingCurves with the deviations of its source in all six vehicles.

    The force of the locomotive also acts at once, as the source has it.
    """
    tables = shunting_tables(position)
    tables["davis"]["constant"] = f"{7063 + 45580} N"
    deviations = {
        "pressure": "5 kPa",
        "efficiency": 0.02 / 0.83,
        "pad_friction": 0.025,
        "build_up": {"P": 0.33 / 4, "G": 2 / 24}[position],
    }
    tables["dispersion"] = [
        {"quantity": name, "per": "group", "kind": "normal", "deviation": each, "source": "RailProfAC"}
        for name, each in deviations.items()
    ]
    return train_of(tables, "shunting.toml")


@pytest.mark.parametrize(("position", "mean", "deviation"), [("P", 38.34, 0.471), ("G", 64.27, 0.810)])
def test_the_scatter_of_a_train_is_the_published_one(position, mean, deviation):
    """Published from 1e7 draws, with the force of the locomotive counted twice.

    600 draws have a standard error of 3 % of the deviation. Brakes of our locomotive scatter too, those of the source
    do not.
    """
    train = drawn(position)
    figures = scatter(train, 25 / 3.6, train.dispersion, draws=600, seed=1).figures
    assert figures["mean"] == pytest.approx(mean, rel=0.01)
    assert figures["standard deviation"] == pytest.approx(deviation, rel=0.1)


@pytest.mark.parametrize("name", ["vt642", "loco_coaches", "eanos_wagon", "two_car_unit", "tram"])
def test_draws_without_deviation_are_the_stop_by_hand(name):
    """Magnets, two-stage distributors, blocks and build-ups of bogies: the same equations, over draws at once."""
    train, speed = load_train(Path(name)), 60.0 if name == "tram" else 100 / 3.6
    stops = scatter(train, speed, (), draws=2, seed=1).distances
    assert stops == pytest.approx(by_hand(train, speed).distance, rel=1e-9)


@pytest.mark.parametrize("quantity", ["pad_friction", "efficiency", "pressure", "mass"])
def test_a_draw_is_a_train_with_that_datum(quantity):
    """A train whose file has the drawn value stops by hand as the draw does, without rotating masses for the mass."""
    value, unit = (1e4, "Pa") if quantity == "pressure" else (0.05, "1")
    tables = tomllib.loads(UNIT.read_text(encoding="utf-8"))
    per = "train" if quantity == "mass" else "group"
    limits = {"lowest": f"{value} {unit}", "highest": f"{value * (1 + 1e-9)} {unit}"}
    tables["dispersion"] = [{"quantity": quantity, "per": per, "kind": "uniform", "source": "test", **limits}]
    train = train_of(tables, "unit.toml")
    stops = scatter(train, 100 / 3.6, train.dispersion, draws=2, seed=1).distances
    changed = deviating(train, quantity, value)
    if quantity == "mass":
        # Rolling resistance of [davis] is that of the train of the file, and rises with the mass of a draw.
        davis = changed.davis.model_copy(update={"constant": changed.davis.constant * (1 + value)})
        changed = changed.model_copy(update={"davis": davis})
    assert stops == pytest.approx(by_hand(changed, 100 / 3.6).distance, rel=1e-6)


def test_a_build_up_that_disperses_scales_the_response_time():
    """The deceleration of developed brakes is constant here, so the distance rises by v te times the deviation."""
    train = drawn("P")
    factors = np.array([1.0, 1.1])[:, None] * np.ones((2, len(train.axles)))
    names = ("pad_friction", "efficiency", "friction_radius", "wheel_radius", "mass", "track_brake")
    nominal = {name: np.ones_like(factors) for name in names} | {"pressure": np.zeros_like(factors)}
    stops = scattered_distances(train, 100 / 3.6, {**nominal, "build_up": factors})
    # From 100 km/h the brakes are developed for most of the stop; running resistance acts at once.
    assert stops[1] - stops[0] == pytest.approx(0.1 * 100 / 3.6 * by_hand(train, 100 / 3.6).equivalent_time, rel=0.03)


def test_draws_of_trains_with_dynamic_brakes_are_refused(railgrip):
    code, out, err = railgrip("train", "calculate", "flirt", "--draws", "10")
    assert (code, out) == (2, "")
    assert "flirt: stops with drawn brakes know friction brakes" in err
    assert "--draws 1: one stop has no scatter" in railgrip("train", "calculate", "vt642", "--draws", "1")[2]


def test_the_calculation_has_the_scatter_of_its_draws(railgrip):
    arguments = ("train", "calculate", "vt642", "--speed", "100 km/h", "--draws", "20")
    result = json.loads(railgrip(*arguments, "--json")[1])
    (found,) = result["scatter"]
    assert found["draws"] == 20
    assert found["P5"] < found["P50"] < found["longest"]
    code, out, _ = railgrip(*arguments)
    assert code == 0
    assert f"{found['standard deviation']:.2f}" in out
