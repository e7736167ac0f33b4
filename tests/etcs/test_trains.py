"""Braking models and K factors of train files: their own stops, closed forms, and plain Monte Carlo."""

import tomllib
from pathlib import Path

import numpy as np
import pytest
from deviating_train import KEYS, deviating
from scipy.stats import binom, norm
from small_train import electric_tables
from synthetic import POSITION_R

from railgrip.base.errors import InputError
from railgrip.base.registry import shelf
from railgrip.rolling_stock.dispersion import Failures, Normal
from railgrip.rolling_stock.schema import NAMED, load_train, train_of
from railgrip.rolling_stock.stopping import by_hand, full_brake_force
from railgrip.scenario.quantity import Magnitude
from railgrip.supervision.curve import braking_curve
from railgrip.supervision.dispersed import TrainBrake, speed_steps
from railgrip.supervision.k_dry import PROBABILITIES, k_factors
from railgrip.supervision.limits import BrakingCase, brake_on_line
from railgrip.supervision.line import load_line
from railgrip.supervision.national import NationalValues
from railgrip.supervision.trains import data_of, maximum_speed, model_of_train


def dispersion(quantity, per="train", deviation="5 %"):
    return Normal(quantity=quantity, per=per, source="a test", kind="normal", deviation=Magnitude(deviation))


def failures(isolated=0.0, stuck=0.0, beta=0.0):
    common = {"error_factor": 1, "source": "a test", "common_cause": {"beta": beta, "source": "a test"}}
    one = lambda probability: {"probability": probability} | common
    return Failures.model_validate({"isolated_unit": one(isolated), "stuck_valve": one(stuck)})


def brake_of(name, *of, **more):
    train = load_train(Path(name))
    speeds = more.get("speeds") or speed_steps(train, maximum_speed(train))
    return TrainBrake(train, of or data_of(train).dispersion, speeds)


def ratios_of(brake, draws):
    """Return the ratios of a brake without lost units."""
    return brake.ratios([int(np.sum(n)) for n in brake.units], np.asarray(draws))


@pytest.mark.parametrize("name", NAMED)
def test_deceleration_and_build_up_reproduce_the_stop_by_hand(name):
    """4 parts of a step of speed, and 1 cm of the time steps of the calculation by hand."""
    brake, train = brake_of(name), load_train(Path(name))
    stop = by_hand(train, maximum_speed(train))
    assert brake.distance == pytest.approx(stop.distance, abs=0.1)
    assert brake.equivalent_time == pytest.approx(stop.equivalent_time)
    # Magnets brake more the slower the train: an error of four parts, 5 cm here.
    assert brake.nominal[-1] == pytest.approx(stop.deceleration, rel=2e-3)


@pytest.mark.usefixtures("few")
def test_a_nominal_emergency_stop_on_the_curves_is_the_stop_by_hand():
    train, speed = load_train(Path("emu387")), 120 / 3.6
    model, _ = model_of_train(train, NationalValues())
    case = BrakingCase(model, NationalValues(), load_line(None))
    begin = speed * model.emergency_times[0]
    curve = braking_curve(brake_on_line(case, model.emergency), location=begin, speed=speed, foot=0.0)
    # The last step reaches up to the highest speed that ETCS supervises, 132 km/h, where pads brake less: its mean is
    # 0.5 % lower than that up to 120 km/h.
    assert 0 < float(curve.location(0.0)) - by_hand(train, speed).distance < 2.5


def test_isolated_units_alone_are_two_binomial_numbers():
    """All combinations of lost units of both kinds; a dispersion of 1e-5 that a K cannot show."""
    brake = brake_of("emu387", dispersion("mass", deviation="0.001 %"), speeds=(10.0, 0.0))
    result = k_factors(brake, failures(isolated=1e-3), seed=1, runs=2, samples=50)
    first, second = (int(np.sum(n)) for n in brake.units)
    losses = [(a, b) for a in range(8) for b in range(8)]
    k = [float(brake.ratios([first - a, second - b], np.zeros((1, 1)))[0, 0]) for a, b in losses]
    p = [binom.pmf(a, first, 1e-3) * binom.pmf(b, second, 1e-3) for a, b in losses]
    order = np.argsort(k)
    below = np.cumsum(np.array(p)[order])
    for level in range(1, 10):
        expected = np.array(k)[order][np.searchsorted(below, PROBABILITIES[level])]
        assert result.k[0][level].value == pytest.approx(expected, abs=2e-4)


@pytest.mark.parametrize("per", ["unit", "group", "train"])
def test_k_agrees_with_plain_draws(per):
    """2e5 draws, whose quantile of one in a hundred is known to 0.2 %."""
    quantity = "pressure" if per == "group" else "pad_friction"
    of = dispersion(quantity, per, "0.2 bar" if per == "group" else "10 %"), dispersion("mass", deviation="3 %")
    brake = brake_of("vt642", *of)
    result = k_factors(brake, failures(), seed=3, runs=4, samples=2000)
    draws = ratios_of(brake, np.random.default_rng(5).standard_normal((200_000, brake.dimension)))
    for output, of_output in enumerate(result.k):
        assert of_output[2].value == pytest.approx(np.quantile(draws[:, output], 0.01), rel=4e-3)


def electric_train(*, blending, force):
    """Return two cars of `railgrip new train` with a motor under each, whose forces do not depend on the speed.

    No running resistance, and pads of constant friction: closed forms have the forces of the brakes alone.
    """
    tables = electric_tables(force=force, power="10 MW", blending=blending, speed_full="1 km/h", speed_end=0)
    del tables["resistance"]
    tables["davis"] = {"constant": 0, "linear": 0, "quadratic": 0, "estimated": True}
    return train_of(tables, "electric.toml")


FASTER = 10.0, 9.999, 0.0
"""A step of speed above the fade-out of motors, whose forces are constant there."""


@pytest.mark.usefixtures("few")
@pytest.mark.parametrize("blending", ["valve", "train", "added"])
@pytest.mark.parametrize("force", ["4 kN", "9 kN"])
def test_pads_and_motors_have_the_dispersion_of_their_own_force(blending, force):
    """K = 1 − 5 % z F/(F_friction + F_motors), forces by plain arithmetic: motors at four of eight axles."""
    train, motors = electric_train(blending=blending, force=force), 4 * 1e3 * float(force.split()[0])
    friction = full_brake_force(train).sum() if blending == "added" else full_brake_force(train).sum() - motors
    assert friction > 0
    for quantity, part in (("pad_friction", friction), ("dynamic_brake", motors)):
        brake = TrainBrake(train, (dispersion(quantity),), FASTER)
        ratios = ratios_of(brake, [[-2.0], [0.0], [1.0]])[:, 1]
        assert ratios == pytest.approx(1 + 0.05 * np.array([-2.0, 0.0, 1.0]) * part / (friction + motors), rel=1e-6)


def test_dynamic_brakes_that_fail_are_a_mixture_of_two_brakes():
    """Motors alone brake without dispersion; with the probability q they are off, and pads of 5 % replace them.

    P(K < k) = q Φ((k − 1)/5 %) for k < 1, and the quantile of P has the argument P/q.
    """
    train, q = electric_train(blending="train", force="60 kN"), 0.1
    brake = TrainBrake(train, (dispersion("pad_friction"),), FASTER)
    assert brake.without is not None
    of_brake = failures()
    lost = Failures.model_validate(
        of_brake.model_dump() | {"dynamic_brake": {"probability": q, "error_factor": 1, "source": "a test"}}
    )
    result = k_factors(brake, lost, seed=1, runs=4, samples=2000)
    assert sum(state.probability for state in result.states) == pytest.approx(1.0)
    for level in (2, 3, 6, 9):
        expected = 1 + 0.05 * norm.ppf(PROBABILITIES[level] / q)
        assert result.k[1][level].value == pytest.approx(expected, abs=2e-3)
    with pytest.raises(InputError, match=r"\[failures\] has no dynamic_brake"):
        k_factors(brake, of_brake, seed=1, runs=2, samples=20)


def test_motors_that_add_their_force_and_are_off_lack_it():
    """Without them the ratio is that of the forces, since rotating masses are the same."""
    train = electric_train(blending="added", force="9 kN")
    brake = TrainBrake(train, (dispersion("mass"),), FASTER)
    friction = full_brake_force(train).sum()
    assert brake.without is not None
    ratio = ratios_of(brake.without, np.zeros((1, 1)))[0, 1]
    assert ratio == pytest.approx(friction / (friction + 36e3), rel=1e-6)


def test_a_build_up_that_deviates_changes_the_whole_stop_alone():
    change = ratios_of(brake_of("tram", dispersion("build_up")), [[0.1]])[0] - 1
    assert change[:-1] == pytest.approx(np.zeros(len(change) - 1), abs=1e-12)
    assert change[-1] < 0


def test_build_ups_of_groups_have_the_effect_of_their_mean_over_the_units():
    """Deviations of 5 % times the drawn numbers, at valves with 3, 3, 2 and 2 units."""
    together, apart = (brake_of("vt642", dispersion("build_up", per, "5 %")) for per in ("train", "group"))
    drawn = np.array([[0.4, -1.0, 2.0, 0.3]])
    mean = drawn @ np.array([0.3, 0.3, 0.2, 0.2])
    assert ratios_of(apart, drawn) == pytest.approx(ratios_of(together, mean[:, None]), rel=1e-12)


def test_like_valves_that_count_together_give_the_k_of_single_ones():
    """The train of the papers with two kinds of two valves each, and with four kinds of one."""
    train = load_train(Path("vt642"))
    data = data_of(train)
    together = TrainBrake(train, data.dispersion, (120 / 3.6, 0.0))
    tables = tomllib.loads(shelf("trains")["vt642"].read_text(encoding="utf-8"))
    tables["bogies"]["trailing"] = tables["bogies"]["motor"]
    tables["cars"][1]["bogies"][0]["kind"] = "trailing"
    tables["bogies"]["jacobs"]["valve"] = "axle"
    apart = TrainBrake(train_of(tables, "apart"), data.dispersion, (120 / 3.6, 0.0))
    assert together.units == ((3, 3), (2, 2))
    assert apart.units == ((3,), (2, 2), (3,))
    one, other = (k_factors(brake, data.failures, seed=1, runs=4, samples=500) for brake in (together, apart))
    for level in (1, 3, 5, 6):
        # Isolated units of one group or of two differ in the pressure that they have in common.
        assert one.k[0][level].value == pytest.approx(other.k[0][level].value, rel=0.01)


@pytest.mark.usefixtures("few")
def test_a_train_file_may_have_its_own_data():
    tables = tomllib.loads(shelf("trains")["tram"].read_text(encoding="utf-8"))
    tables["etcs"] = {
        "maximum_speed": "70 km/h", "brake_position": "freight P", "k_wet": 0.6, "traction_cut_off_time": "2 s",
        "service_time": "3 s", "estimated": True,
    }  # fmt: skip
    tables["dispersion"] = [
        {"quantity": "mass", "per": "train", "kind": "normal", "deviation": "1 %", "source": "weighed"}
    ]
    train = train_of(tables, "tram.toml")
    model, _ = model_of_train(train, NationalValues())
    assert 3.6 * model.maximum_speed == pytest.approx(70)
    assert (model.position, model.service_times, model.cut_off_time) == ("freight P", (3.0, 3.0), 2.0)
    assert model.k_wet is not None
    assert model.k_wet.values.tolist() == [0.6]
    assert len(data_of(train).dispersion) == 1
    # Full service braking is without the magnets.
    assert (model.service.values < 0.7 * model.emergency.values).all()
    assert data_of(train).failures == data_of(load_train(Path("vt642"))).failures


def test_two_stages_of_the_distributor_are_steps_of_the_brake():
    tables = tomllib.loads(shelf("trains")["loco_coaches"].read_text(encoding="utf-8"))
    tables["distributors"] = {"R": POSITION_R.copy()}
    for car in tables["cars"]:
        car["distributor"] = "R"
    train = train_of(tables, "loco.toml")
    speeds = speed_steps(train, 160 / 3.6)
    assert {round(3.6 * v) for v in speeds} >= {160, 70, 50, 0}
    assert len(speeds) <= 8
    brake = TrainBrake(train, (dispersion("mass"),), speeds)
    low, high = brake.nominal[0], brake.nominal[-2]
    # A stop that begins below 50 km/h has half of the pressure.
    assert 0.35 < low / high < 0.6
    assert brake.nominal[0] == pytest.approx(by_hand(train, 30 / 3.6).deceleration, rel=0.05)


@pytest.mark.parametrize(
    ("name", "quantity", "value"),
    [
        ("shunting_train", "pad_friction", 0.1),
        ("shunting_train", "pressure", 0.2e5),
        ("shunting_train", "efficiency", -0.15),
        *(("tram", quantity, 0.5e5 if quantity == "pressure" else -0.15) for quantity in KEYS),
    ],
)
def test_a_deviation_has_the_effect_of_the_changed_train(name, quantity, value):
    """The friction of a block falls with its force and its speed. Steps of the calculation by hand are 1e-4 of it."""
    train = load_train(Path(name))
    one = dispersion(quantity, deviation=f"{abs(value)} {'Pa' if quantity == 'pressure' else '1'}")
    speeds = speed_steps(train, maximum_speed(train))
    brake, changed = (TrainBrake(of, (one,), speeds) for of in (train, deviating(train, quantity, value)))
    (ratios,) = ratios_of(brake, [[np.sign(value)]])
    assert ratios[:-1] == pytest.approx(changed.nominal[:-1] / brake.nominal[:-1], rel=1e-3)
    assert abs(ratios[0] - 1) > 0.03


def test_a_train_that_does_not_stop_is_refused():
    tables = tomllib.loads(shelf("trains")["vt642"].read_text(encoding="utf-8"))
    for brake in tables["brakes"].values():
        brake["pressure_max"] = "0.1 bar"
    with pytest.raises(InputError, match="do not stop"):
        model_of_train(train_of(tables, "weak.toml"), NationalValues())
