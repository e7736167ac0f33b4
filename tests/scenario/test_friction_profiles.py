"""The friction under each wheelset is as the scenario describes, at every time and place."""

import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.signal import lfilter
from synthetic import LIBRARY, TWO_PART_TRAIN
from wrong import table

from railgrip.base.arrays import generator, markov
from railgrip.base.errors import ScenarioError
from railgrip.scenario.adhesion import profile_of
from railgrip.scenario.load import load, scenario_of
from railgrip.simulate.remarks import doubts
from railgrip.vehicle.formation import Formation

PLAIN = ["adhesion.conditioning.fraction=0"]


def profile(name, *overrides):
    # The soap curve is not calibrated: friction is that of the file, whatever the result of `make calibrate`.
    return profile_of(load(LIBRARY / f"{name}.toml", ["adhesion.polach=soap", *overrides]), TWO_PART_TRAIN)


def friction_at(found, time, distance):
    """Return the friction at each wheelset at that time."""
    return found.table(np.array([time]), np.array([distance]))[0]


def test_calibration_scales_only_its_own_profile():
    plain, scaled = (
        profile("trapezoid", *PLAIN, "adhesion.calibrated.leaf=1.25", f"adhesion.polach={shape}")
        for shape in ("soap", "leaf")
    )
    assert scaled.mu0_at == pytest.approx(1.25 * plain.mu0_at)


def test_a_trapezoid_is_high_falls_stays_low_and_rises():
    found = profile("trapezoid", *PLAIN)
    # first fall 4 s, ramp 1 s, low 4 s, period 8 s; 0.13 to 0.055
    expected = {0: 0.13, 3.999: 0.13, 4.5: 0.0925, 5: 0.055, 9: 0.055, 9.5: 0.0925, 10: 0.13, 12: 0.13, 13: 0.055}
    for time, mu0 in expected.items():
        assert friction_at(found, time, 0.0) == pytest.approx(np.full(6, mu0), abs=1e-12)


def test_a_sine_sweep_goes_from_its_first_to_its_last_frequency():
    found = profile("sine_sweep", *PLAIN)
    time = np.arange(0, 60, 1e-3)
    mu0 = found.table(time, time)[:, 0]
    assert mu0[0] == pytest.approx(0.10)
    assert mu0.min() == pytest.approx(0.07, abs=1e-6)
    assert mu0.max() == pytest.approx(0.13, abs=1e-6)
    slope = (mu0[1] - mu0[0]) / 1e-3
    # derivative of −a sin(2π f t) at 0; 1e-3: the frequency has already increased during the first sample
    assert slope == pytest.approx(-0.03 * 2 * np.pi * 0.05, rel=1e-3)
    late = time > 31
    crossings = np.flatnonzero(np.diff(np.sign(mu0[late] - 0.10)) > 0)
    assert np.diff(crossings) * 1e-3 == pytest.approx(1 / 0.4, abs=2e-3)  # two samples
    # in between, f(t) = f0 (f1/f0)^(t/T): the number of cycles until T is its integral
    within = mu0[(time > 0) & (time < 30)] - 0.10
    assert np.count_nonzero(np.diff(np.sign(within))) == int(2 * 30 * 0.35 / np.log(8))


def test_random_friction_has_the_stated_mean_deviation_and_correlation():
    found = profile(
        "random", *PLAIN, "limits.horizon=4000 s", "periods.communication=50 ms", "periods.estimator=50 ms",
        "periods.controller=50 ms", "periods.trace=50 ms",
        "controller.kind=full_brake", "adhesion.minimum=0.001", "adhesion.maximum=0.9",
    )  # fmt: skip
    values = found.table(np.arange(0, 4000, 0.05), np.zeros(80000))[:, 0]
    # 4000 independent correlation lengths: standard errors 3e-4 of the mean, 2 % of the deviation.
    assert values.mean() == pytest.approx(0.09, abs=1.5e-3)
    assert values.std() == pytest.approx(0.02, rel=0.06)
    deviation = values - values.mean()
    for lag, expected in ((10, np.exp(-1)), (20, np.exp(-2))):
        autocorrelation = np.mean(deviation[lag:] * deviation[:-lag]) / np.mean(deviation**2)
        assert autocorrelation == pytest.approx(expected, abs=0.06)


def test_random_friction_depends_on_the_seed_alone_and_is_within_its_limits():
    """Not on the horizon."""
    time = np.arange(0, 90, 1e-3)
    one, same, other = (profile("random", f"seed={seed}").table(time, time) for seed in (1, 1, 2))
    assert np.array_equal(one, same)
    assert not np.array_equal(one, other)
    assert one[:, 0].min() >= 0.03
    assert one.max() <= 0.15
    time = time[:20000]
    short, long = (profile("random", "seed=1", f"limits.horizon={h} s").table(time, time) for h in (30, 60))
    assert np.array_equal(short, one[:20000])
    assert np.array_equal(long, short)


ON_THE_RAIL = ["adhesion.over=distance", "adhesion.correlation=10 m", *PLAIN]


def test_every_wheelset_passes_the_same_place_of_the_rail_later():
    found = profile("random", *ON_THE_RAIL)
    offsets = [0, 1.9, 15.625, 18.275, 32, 33.9]
    spot = 60.0
    assert np.all(friction_at(found, 0.0, 0.0) > 0)  # the rail extends behind the start
    frictions = [friction_at(found, 0.0, spot + offset)[wheelset] for wheelset, offset in enumerate(offsets)]
    # Offsets are whole numbers of the 5 mm grid, so that no interpolation is involved.
    assert frictions == pytest.approx([frictions[0]] * 6, abs=1e-12)
    assert len(set(np.round(friction_at(found, 0.0, spot), 6))) == 6


@pytest.mark.parametrize("by", ["group", "wheelset"])
def test_conditioning_raises_minima_from_front_to_rear_and_keeps_maxima(by):
    found = profile("trapezoid", f"adhesion.conditioning.by={by}", "adhesion.conditioning.fraction=0.1")
    low, high = friction_at(found, 7.0, 0.0), friction_at(found, 2.0, 0.0)
    ahead = np.array([0, 0, 1, 2, 3, 3] if by == "group" else range(6))
    assert low == pytest.approx(0.13 - (0.13 - 0.055) * 0.9**ahead)
    assert high == pytest.approx(np.full(6, 0.13))


@given(level=st.floats(0.2, 3.0))
@settings(max_examples=4)
def test_level_scales_the_first_wheelset(level):
    base, scaled = profile("sine_sweep"), profile("sine_sweep", f"adhesion.level={level!r}")
    assert scaled.mu0_at[:, 0] == pytest.approx(level * base.mu0_at[:, 0])


def test_the_table_of_the_loop_is_read_only():
    with pytest.raises(ValueError, match="read-only"):
        profile("trapezoid").mu0_at[0, 0] = 1


def on_rail(tmp_path, **adhesion):
    """Return the scenario `trapezoid` with another table [adhesion]."""
    tables = load(LIBRARY / "trapezoid.toml").resolved() | {"adhesion": {"polach": "soap"} | adhesion}
    return scenario_of(tables, directory=tmp_path, origin="mine.toml")


def tabled(tmp_path, content, **more):
    (tmp_path / "rail.csv").write_text(content, encoding="utf-8")
    return on_rail(tmp_path, kind="table", file="rail.csv", **more)


def test_a_users_curve_may_be_over_distance_and_differ_for_each_wheelset(tmp_path):
    header = ",".join(f"mu0_{j}" for j in range(1, 7))
    rows = "distance," + header + "\n0,.1,.1,.1,.1,.1,.1\n100,.2,.3,.4,.5,.6,.7\n"
    found = profile_of(tabled(tmp_path, rows), TWO_PART_TRAIN)
    # wheelset 6 is 33.9 m behind the first
    assert friction_at(found, 0.0, 83.9)[5] == pytest.approx(0.1 + 0.6 * 0.5)
    assert friction_at(found, 0.0, 50.0)[0] == pytest.approx(0.15)


@pytest.mark.parametrize(("content", "sentence"), table(__file__, "tables.toml")["wrong_profiles"])
def test_a_wrong_table_is_refused_with_its_line(tmp_path, content, sentence):
    with pytest.raises(ScenarioError, match=re.escape(f"mine.toml: [adhesion] file rail.csv: {sentence}")):
        tabled(tmp_path, content)


@pytest.mark.parametrize(
    ("header", "factor", "percent"),
    [("distance [km],mu0 [%]", 1e-3, 100), ("distance (mm), mu0", 1e3, 1), ("distance [m],mu0 [1]", 1, 1)],
)
def test_columns_may_state_their_units(tmp_path, header, factor, percent):
    def curve(text):
        return tabled(tmp_path, text).adhesion.curve

    rows = "".join(f"{factor * place:g},{percent * mu0:g}\n" for place, mu0 in ((0, 0.1), (100, 0.2), (300, 0.05)))
    stated, plain = curve(f"{header}\n{rows}"), curve("distance,mu0\n0,0.1\n100,0.2\n300,0.05\n")
    np.testing.assert_allclose(stated.points, plain.points)
    np.testing.assert_allclose(stated.values, plain.values)
    assert stated.axis == "distance"
    for mark in ";\t":
        other = curve(f"{header}\n{rows}".replace(",", mark).replace(".", ","))
        np.testing.assert_array_equal((other.points, other.values[:, 0]), (stated.points, stated.values[:, 0]))


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        # From 80 km/h with friction of 0.1 the distance is v²/(2 mu g), 252 m, and the time v/(mu g), 22.7 s.
        ("distance,mu0\n0,.1\n0.3,.05\n", "ends at 0.3 m, but the stop takes 252 m or more; if the column has another"),
        ("distance,mu0\n0,.1\n3e5,.05\n", "has its second point at 300000 m, but the stop ends before"),
        ("time,mu0\n0,.1\n0.5,.05\n", "ends at 0.5 s, but the stop takes 22.7 s or more"),
        ("time,mu0\n0,.1\n20000,.05\n", "has its second point at 20000 s, but the stop ends before"),
        ("time [ms],mu0\n0,.1\n20,.05\n", None),
        ("distance [m],mu0\n0,.1\n0.3,.05\n", None),
        ("distance,mu0\n0,.1\n300,.05\n", None),
    ],
)
def test_an_axis_in_another_unit_is_mentioned(tmp_path, content, sentence):
    sentences = doubts(tabled(tmp_path, content))
    assert len(sentences) == (sentence is not None)
    assert sentence is None or (sentence in sentences[0] and "[adhesion] file rail.csv" in sentences[0])


def test_friction_for_another_number_of_wheelsets_is_refused(tmp_path):
    constant = ["adhesion.kind=constant", "adhesion.polach=wet"]
    two = load(LIBRARY / "plain.toml", [*constant, "adhesion.mu0=[0.1, 0.2]"])
    assert friction_at(profile_of(two, Formation((1, 1))), 0.0, 0.0).tolist() == [0.1, 0.2]
    with pytest.raises(ScenarioError, match=r"file rail.csv is for 2 wheelsets, the vehicle has 6"):
        profile_of(tabled(tmp_path, "time,mu0_1,mu0_2\n0,.1,.1\n1,.1,.1\n"), TWO_PART_TRAIN)
    short = [f"adhesion.{extent}='5 m'" for extent in ("first_fall", "low", "ramp")]
    far = load(LIBRARY / "trapezoid.toml", ["adhesion.over=distance", *short, "adhesion.period='90 m'"])
    with pytest.raises(ScenarioError, match=r"give \[vehicle.formation\] wheelset_position, how far each is behind"):
        profile_of(far, Formation((2, 1, 1, 2)))


@pytest.mark.parametrize("written", ["points", "table"])
def test_points_of_a_scenario_or_a_table_are_interpolated_linearly(tmp_path, written):
    if written == "points":
        profile = on_rail(tmp_path, kind="points", over="time", points=[["1 s", 0.2], ["3 s", 0.1]])
    else:
        profile = tabled(tmp_path, "time,mu0\n1,0.20\n3,0.10\n")
    friction = profile_of(profile, TWO_PART_TRAIN).table(np.array([0.0, 1.0, 2.0, 3.0, 9.0]), np.zeros(5))
    assert friction == pytest.approx(np.array([0.2, 0.2, 0.15, 0.1, 0.1])[:, None].repeat(6, axis=1))


def test_points_scatter_as_stated_up_to_three_deviations(tmp_path):
    made = on_rail(
        tmp_path, kind="points", over="time", points=[["0 s", 0.1]], scatter=0.05, correlation="0.05 s",
    )  # fmt: skip
    mu0 = profile_of(made, TWO_PART_TRAIN).mu0_at[:, 0]
    # 90 s with a correlation time of 0.05 s: 900 independent draws determine a deviation to 2.5 %, their mean to 1/30
    # of it.
    assert mu0.mean() == pytest.approx(0.1, abs=4 * 0.005 * np.sqrt(2 / 1800))
    assert mu0.std() == pytest.approx(0.005, rel=0.1)
    assert np.abs(mu0 / 0.1 - 1).max() <= 0.15 + 1e-12
    steps = np.diff(mu0)
    # Exact at every sample: the variance of a step of 1 ms is 2 (1 − e^(−h/T)).
    assert steps.var() == pytest.approx(2 * 0.005**2 * (1 - np.exp(-1e-3 / 0.05)), rel=0.05)


def test_each_wheelset_reaches_a_patch_of_the_rail_later(tmp_path):
    lowest = [0.1, 0.1, 0.2, 0.2, 0.2, 0.2]
    patch = {"begin": "100 m", "length": "10 m", "mu0": lowest, "edge": "1 m"}
    made = on_rail(tmp_path, kind="constant", mu0=0.28, patch=[patch])
    profile, offsets = profile_of(made, TWO_PART_TRAIN), TWO_PART_TRAIN.position
    for wheelset, low in enumerate(lowest):
        places = offsets[wheelset] + np.array([99.9, 100.5, 101.0, 105.0, 109.5, 110.1, 5000.0])
        found = profile.table(np.zeros(7), places)[:, wheelset]
        # The table's grid is 5 mm; over an edge of 1 m that is 1e-3 of 0.18.
        assert found == pytest.approx([0.28, (0.28 + low) / 2, low, low, (0.28 + low) / 2, 0.28, 0.28], abs=1e-3)


def test_a_patch_may_be_on_any_rail_over_distance(tmp_path):
    """Leaves of 8 m on a ramp, with steps at both ends; the later patch covers the earlier."""
    patches = [
        {"begin": "20 m", "length": "8 m", "mu0": 0.03},
        {"begin": "27 m", "length": "5 m", "mu0": 0.15},
    ]
    ramp = [["0 m", 0.1], ["100 m", 0.2]]
    profile = on_rail(tmp_path, kind="points", over="distance", points=ramp, patch=patches)
    places = np.array([19.9, 20.1, 26.9, 27.1, 31.9, 32.1])
    found = profile_of(profile, TWO_PART_TRAIN).table(np.zeros(6), places)[:, 0]
    assert found == pytest.approx([0.1199, 0.03, 0.03, 0.15, 0.15, 0.1321], abs=1e-5)


def test_each_purpose_has_separate_reproducible_random_numbers():
    draws = {purpose: generator(7, purpose).standard_normal(4) for purpose in ("adhesion", "sensors.wheel")}
    assert np.array_equal(draws["adhesion"], generator(7, "adhesion").standard_normal(4))
    assert not np.array_equal(draws["adhesion"], draws["sensors.wheel"])
    assert not np.array_equal(draws["adhesion"], generator(8, "adhesion").standard_normal(4))


@pytest.mark.parametrize("persistence", [0.3, 0.95, 0.9999])
def test_markov_noise_is_the_filter_of_scipy_and_keeps_unit_variance(persistence):
    """The squares of its impulse responses ρ^k and √(1 − ρ²) ρ^k sum up to 1 at every sample."""
    white = np.random.default_rng(1).standard_normal(500)
    fresh = np.append(white[0], np.sqrt(1 - persistence**2) * white[1:])
    assert np.array_equal(markov(white, persistence), lfilter([1.0], [1.0, -persistence], fresh))
    responses = np.array([markov(impulse, persistence) for impulse in np.eye(50)])
    assert np.sum(responses**2, axis=0) == pytest.approx(np.ones(50), rel=1e-12)


CHAINAGES = "distance [km],mu0\n12.350,.15\n12.450,.05\n12.850,.05\n12.950,.15\n"


def test_a_profile_that_the_stop_never_reaches_is_refused(tmp_path):
    with pytest.raises(
        ScenarioError, match=r"file rail.csv is from 12350 m to 12950 m .* the train gets no farther than"
    ):
        profile_of(tabled(tmp_path, CHAINAGES), TWO_PART_TRAIN)


@pytest.mark.parametrize(
    ("content", "origin", "places"),
    [
        (CHAINAGES, 12_300, [50, 150, 550, 650]),
        ("distance [km],mu0\n12.950,.15\n12.850,.05\n12.450,.05\n12.350,.15\n", 13_000, [50, 150, 550, 650]),
    ],
)
def test_chainages_begin_at_the_origin_and_rise_or_fall(tmp_path, content, origin, places):
    """On the chainage 12.400 km, 100 m after 12.300 km, friction is halfway between 0.15 and 0.05."""
    given = tabled(tmp_path, content, origin=origin)
    expected = np.interp([0, 100, 300, 600, 700], places, [0.15, 0.05, 0.05, 0.15])
    found = profile_of(given, TWO_PART_TRAIN)
    # The grid of 5 mm moves a place by 2.5 mm or less, where friction changes by 1e-3 a metre.
    for distance, mu0 in zip([0, 100, 300, 600, 700], expected, strict=True):
        assert friction_at(found, 0.0, distance)[0] == pytest.approx(mu0, abs=3e-6)
    assert any("begins 50 m after the brake demand" in sentence for sentence in doubts(given))


def test_an_origin_of_a_profile_over_time_is_refused(tmp_path):
    with pytest.raises(ScenarioError, match="leave origin out"):
        tabled(tmp_path, "time,mu0\n0,.1\n30,.05\n", origin=5)
