"""`study benefit`: from stops to seconds, on the same draws; and what it refuses."""

import re
import tomllib
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from onboard import train_data

from railgrip.base.errors import InputError
from railgrip.report.statistics import FEWEST_DRAWS
from railgrip.rolling_stock.schema import load_train
from railgrip.scenario.load import read_toml
from railgrip.scenario.surface import Sander
from railgrip.simulate.run import run_stop
from railgrip.studies.benefit import benefit_study as module
from railgrip.studies.benefit.benefit_study import Benefit, chain_of, cost_table, gain_table, sentences_of
from railgrip.studies.benefit.chain import (
    BASE,
    BenefitChain,
    Variant,
    figures_of,
    sand_mass,
    scenario_for,
    variants_of,
    weighted_quantile,
)
from railgrip.studies.benefit.line import LIBRARY, load_study_line, measures_of
from railgrip.supervision import trains
from railgrip.supervision.model import model_of
from railgrip.trace.k_wet import k_wet

SPEED, TIME, DRY = 30.0, 1.0, 400.0
LINE = (LIBRARY / "line_leaves.toml").read_text(encoding="utf-8")
TRAM, EMU, WAGON, VT642 = (
    Path(trains.__file__).parents[1] / "scenario" / "trains" / f"{name}.toml"
    for name in ("tram", "emu387", "two_axle_wagon", "vt642")
)


@pytest.fixture(scope="module")
def commuter():
    return load_study_line(Path("commuter"))


@pytest.fixture(scope="module")
def brake():
    data = {"length": 80, "maximum_speed": SPEED, "emergency_time": TIME, "service_time": TIME}
    return model_of(train_data([(0.0, 1.2)], [(0.0, 1.0)], k_dry=0.8, **data))


def chain_with(line, brake, distances):
    """Return the chain of variants with distances of shape (variants, rails, draws)."""
    distances = np.asarray(distances, dtype=float)
    variants = [Variant(name=str(number), train=Path("t.toml"), changes={}) for number in range(len(distances))]
    return BenefitChain(
        line=line, variants=variants, speed=SPEED, models=[brake] * len(variants), dry=np.full(len(variants), DRY),
        times=np.full(len(variants), TIME), figures=dict.fromkeys(("distance", "sand", "air", "energy"), distances),
    )  # fmt: skip


def draws_of(rails, seed=1, count=FEWEST_DRAWS):
    """Return distances on the rails of a line, the last of which are more slippery, shape (rails, count)."""
    random = np.random.default_rng(seed)
    return np.stack([DRY * (1 + number * random.uniform(0.1, 0.4, count)) for number in range(rails)])


def test_a_measure_that_changes_nothing_buys_exactly_nothing(commuter, brake):
    same = draws_of(4)
    chain = chain_with(commuter, brake, [same, same])
    for values in (chain.quantile(0.95), *chain.seconds, chain.factors):
        gain = values[0] - values[1]
        assert gain[0] == 0.0
        assert chain.interval(gain) == (0.0, 0.0)
    assert gain_table(chain).texts[1]["gain, fixed blocks"] == "0.0 s [0.0, 0.0]; no difference shown"


@pytest.mark.parametrize(("count", "has_interval"), [(FEWEST_DRAWS - 1, False), (FEWEST_DRAWS, True)])
def test_too_few_draws_have_no_intervals_and_the_first_sentence_says_so(commuter, brake, count, has_interval):
    """A measure that halves what a rail adds to the dry distance; the safe factor is that of the mean on wet rails."""
    longer = draws_of(4, count=count)
    chain = chain_with(commuter, brake, [longer, (longer + DRY) / 2])
    first, *rest, remark = sentences_of(chain)
    assert "Line commuter: [speed[1]] speed is 120 km/h (33.3333 m/s), above the maximum speed of the train" in remark
    assert first.startswith(f"{100 * max(chain.beyond()):.1f} % of the stops are longer than the safe factor ")
    assert (f"{count} draws on each rail are too few" in first) != has_interval
    cells = [*gain_table(chain).texts[1].values(), *cost_table(chain).texts[1].values(), first, *rest]
    assert any("[" in cell for cell in cells) == has_interval


def test_k_wet_is_that_of_mean_distances_on_rails_that_are_not_dry(brake):
    line = load_study_line(Path("leaves"))
    stops = draws_of(2)[1:]
    chain = chain_with(line, brake, [stops])
    assert chain.k_wet[0, 0] == pytest.approx(k_wet([DRY, DRY], stops[0].tolist(), SPEED, TIME).value)
    # A single rail has no stops that are better than its mean in 95 % of cases.
    assert chain.m_nvavadh[0] == 0.0
    assert chain.factors[0, 0] == chain.k_wet[0, 0]


def test_m_nvavadh_covers_a_share_of_all_stops_and_is_one_for_all_measures(commuter, brake):
    """By hand: 68 % dry and 25 % as good; 5 % with half and 2 % with a quarter of the deceleration."""
    gone = SPEED * TIME
    by_rail = np.array([DRY, DRY, gone + 2 * (DRY - gone), gone + 4 * (DRY - gone)])
    distances = np.repeat(by_rail[:, None], 4, axis=1)
    chain = chain_with(commuter, brake, [distances, np.full_like(distances, DRY)])
    k = 0.32 / (0.25 + 2 * 0.05 + 4 * 0.02)
    assert chain.k_wet[:, 0] == pytest.approx([k, 1.0])
    # 95 % of the stops reach 0.5 and more, which is below K_wet: the weight is 0.
    assert chain.m_nvavadh[0] == 0.0
    # 90 % reach 1: the weight is that of dry rail.
    less = chain_with(commuter.model_copy(update={"cover": 0.9}), brake, [distances])
    assert less.m_nvavadh[0] == pytest.approx(1.0)
    given = commuter.national.model_validate({"M_NVAVADH": 0.5})
    fixed = chain_with(commuter.model_copy(update={"national": given}), brake, [distances])
    assert fixed.factors[0, 0] == pytest.approx(k + 0.5 * (1 - k))
    assert chain.beyond() == pytest.approx([0.07, 0.0])


def test_headway_between_knots_is_that_of_the_factor(commuter, brake):
    chain = chain_with(commuter, brake, [draws_of(4)])
    for resample in (1, 500):
        exact = [each.seconds for each in chain.headways_for(0, float(chain.factors[0, resample]))]
        # A sixteenth of the range of factors, where headway is linear in 1/factor but for other corners of the curve.
        assert chain.seconds[:, 0, resample] == pytest.approx(exact, abs=0.02)


def test_a_weighted_quantile_is_that_of_repeated_values():
    values, counts = np.array([3.0, 1.0, 2.0, 5.0]), np.array([1, 4, 2, 3])
    for share in (0.05, 0.4, 0.41, 0.6, 0.95, 1.0):
        expected = np.quantile(np.repeat(values, counts), share, method="inverted_cdf")
        assert weighted_quantile(values, counts / 10, share) == expected


def test_sand_is_the_rate_of_both_nozzles_and_less_at_a_set_density():
    time = np.linspace(0, 10, 1001)
    fixed, until = Sander(wheelset=1, rate=0.02, delay=0), Sander(wheelset=1, rate=0.02, delay=1.5, begin=2.0, end=6.0)
    assert sand_mass([fixed], time, 0 * time) == pytest.approx(2 * 0.02 * 10)
    assert sand_mass([until], time, 0 * time) == pytest.approx(2 * 0.02 * 4, rel=5e-3)  # edges of a sample of 10 ms
    variable = Sander(wheelset=3, rate=0.05, density=0.004, delay=0)
    assert sand_mass([variable], time, np.full(time.size, 10.0)) == pytest.approx(2 * 0.04 * 10)


def test_a_measure_gives_a_train_what_it_lacks_and_takes_from_it_what_it_has(tmp_path):
    line = load_study_line(Path("leaves"))
    magnetic, sand = measures_of("magnetic", line), measures_of("sand", line)
    without, own = (read_toml(variant.train) for variant in variants_of(TRAM, magnetic, "full_brake", tmp_path))
    assert all("track_brake" not in bogie for bogie in without["bogies"].values())
    assert own == read_toml(TRAM)
    without, added = variants_of(EMU, magnetic, "full_brake", tmp_path)
    assert without.train == EMU
    table = tomllib.loads(added.train.read_text(encoding="utf-8"))
    assert {bogie["track_brake"] for bogie in table["bogies"].values()} == {"benefit"} == set(table["track_brakes"])
    # The trains have their own sanders, or get some.
    assert [variant.train for variant in variants_of(EMU, sand, "full_brake", tmp_path)] == [EMU, EMU]
    assert read_toml(variants_of(TRAM, sand, "full_brake", tmp_path)[1].train)["sanders"][0]["wheelset"] == 3
    assert len(variants_of(EMU, magnetic | sand, "full_brake", tmp_path)) == 4


def test_the_figures_of_a_stop_are_those_of_its_trace(tmp_path):
    """Sand leaves the nozzles of both rails at a fixed rate from the delay of the sander on."""
    line = load_study_line(Path("leaves"))
    _, sanded = variants_of(VT642, measures_of("sand", line), "full_brake", tmp_path)
    scenario = scenario_for(sanded, line, line.rail[0], 1, 20 / 3.6)
    figures, stop = figures_of(scenario), run_stop(scenario)
    assert (figures["distance"], figures["air"]) == (stop.metrics.distance, stop.metrics.air_used)
    assert figures["energy"] == sum(stop.metrics.tread_energy) > 0
    rates = [sander.rate for sander in load_train(sanded.train).sanders]
    assert figures["sand"] == pytest.approx(2 * sum(rates) * stop.metrics.duration, rel=5e-3)
    longer = scenario.model_copy(update={"limits": scenario.limits.model_copy(update={"horizon": 1.0})})
    assert figures_of(longer)["distance"] == np.inf


HERE = SimpleNamespace(map=lambda function, cases, **_: [*map(function, cases)], notify=lambda doing: None)
"""Runs the cases of a study in this process."""


def stop_by_hand(scenario):
    """Return a stop of v²/(2 g µ), at most 1.2 m/s²; sand doubles the friction."""
    adhesion = scenario.adhesion
    mu0 = adhesion.level * (adhesion.mu0[0] if adhesion.kind == "constant" else adhesion.points[0][1])
    deceleration = min(1.2, 9.81 * mu0 * (1 if adhesion.sand is None else 2))
    return {"distance": scenario.start.speed**2 / (2 * deceleration), "sand": 0.0, "air": 1.0, "energy": 1e6}


@pytest.fixture
def few_draws(few, monkeypatch):
    monkeypatch.setattr("railgrip.studies.benefit.chain._KNOTS", 2)  # headways for two factors instead of sixteen
    monkeypatch.setattr(module, "figures_of", stop_by_hand)


def test_the_question_of_an_operator_in_one_command(few_draws, monkeypatch):
    """Leaves at .05, level 0.8 to 1.2: all variants have the same levels, and sand halves all distances."""
    study = Benefit(EMU, "sand, slip_two_state", Path("leaves"), draws=6)
    chain = chain_of(study, HERE)
    plain, sand, law, both = chain.figures["distance"]
    assert sand == pytest.approx(plain / 2)
    assert np.array_equal(plain, law)
    assert np.array_equal(sand, both)
    assert len(np.unique(plain)) == 6
    first, second, third, last = chain.seconds[:, :, 0].T
    assert np.all(second < first)
    assert np.array_equal(first, third)
    assert np.array_equal(second, last)
    monkeypatch.setattr(module, "chain_of", lambda *arguments: chain)
    page = study.page(HERE)
    assert "shortens the headway by" in page.answer
    assert [row["measure"] for row in page.tables["gains.csv"].rows] == [BASE, "sand", "slip_two_state", "all together"]
    _, *headways, _ = module.draw(chain).axes
    for system, panel in enumerate(headways):
        for bars in panel.containers:
            seconds = [one[system].parts[bars.get_label()] for one in chain.deciding]
            assert [bar.get_width() for bar in bars] == pytest.approx(seconds)


@pytest.mark.parametrize(
    ("is_lost", "stops"), [(lambda mu0: mu0 < 0.2, "2 of 2 stops"), (lambda mu0: mu0 > 0.2, "1 of 1 stops")]
)
def test_a_rail_on_which_the_train_does_not_stop_is_refused(few_draws, monkeypatch, is_lost, stops):
    monkeypatch.setattr(
        module,
        "figures_of",
        lambda scenario: stop_by_hand(scenario) | ({"distance": np.inf} if is_lost(scenario.adhesion.lowest) else {}),
    )
    with pytest.raises(InputError, match=f"does not come to a standstill in {stops} from 120 km/h on the rail"):
        chain_of(Benefit(EMU, "sand", Path("leaves"), draws=2), HERE)


@pytest.mark.parametrize(
    ("measures", "sentence"),
    [
        ("sandd", "there is no measure 'sandd'"),
        ("", "names no measure"),
        ("sand,sand", "'sand' is given twice"),
        ("slope_seeking,two_maxima", "both change [controller]"),
    ],
)
def test_wrong_measures_are_refused_with_a_sentence(measures, sentence):
    with pytest.raises(InputError, match=re.escape(sentence)):
        measures_of(measures, load_study_line(LIBRARY / "line_leaves.toml"))


def test_a_train_with_weak_brakes_has_the_time_to_stop_on_a_dry_rail(commuter, tmp_path):
    """From 120 km/h its brakes take 63 s; the friction of a dry rail would allow 14 s."""
    (base,) = variants_of(WAGON, {}, "full_brake", tmp_path)
    horizon = scenario_for(base, commuter, None, 0, 120 / 3.6).limits.horizon
    assert horizon > module.by_hand(load_train(WAGON), 120 / 3.6).duration + 20
    with pytest.raises(InputError, match=r"--measures sand: two_axle_wagon\.toml with it is wrong: .* the train has 2"):
        variants_of(WAGON, measures_of("sand", commuter), "full_brake", tmp_path)


def test_a_line_has_measures_and_files_of_its_own(tmp_path):
    """Paths are relative to the folder of the line, wherever the train is."""
    text = LINE.replace('kind = "points", polach = "leaf", over = "distance", points = [["0 m", 0.05]], scatter = 0.1, '
                        'correlation = "20 m"', 'kind = "table", polach = "leaf", file = "rail.csv"')  # fmt: skip
    text += '[measure.two]\ndescription = "two levels"\nsource = "an example"\n'
    text += 'scenario.controller.kind = "slip_two_state"\n'
    file = tmp_path / "own.toml"
    file.write_text(text, encoding="utf-8")
    (tmp_path / "rail.csv").write_text("distance,mu0\n0,0.05\n9000,0.06\n", encoding="utf-8")
    line = load_study_line(file)
    assert line.name == "own"
    measures = measures_of("two", line)
    (tmp_path / "trains").mkdir()
    base, two = variants_of(EMU, measures, "full_brake", tmp_path / "trains")
    stop = scenario_for(two, line, line.rail[0], 3, 20.0)
    assert stop.adhesion.curve.values.max() == pytest.approx(0.06)
    assert stop.controller.kind == "slip_two_state"
    other = scenario_for(replace(base, name="x"), line, line.rail[0], 3, 20.0)
    assert (other.adhesion.level, other.seed) == (stop.adhesion.level, stop.seed)
