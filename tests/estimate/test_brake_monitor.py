"""The monitor finds the group that lost friction, and says when stops do not distinguish the groups."""

import numpy as np
import pytest

from railgrip.recording.samples import reading_of, truth_of, with_signals
from railgrip.studies.pad_monitor.evidence import PRESSURE_OFFSET, Evidence, evidence_of
from railgrip.studies.pad_monitor.life import FIRST_SLOT, SLOT, Life, Release, live
from railgrip.studies.pad_monitor.pad_monitor_study import judge_groups, rate_bound
from railgrip.studies.pad_monitor.watch import MonitorDesign, group_names, stops_in, threshold_for, watch
from railgrip.trace.recorder import FILE_NAME, write_trace

DESIGN = MonitorDesign()


def evidence_with(health: np.ndarray, deviation: float = 0.03, drag: float = 0.0, offset: float = 0.0) -> Evidence:
    return Evidence(
        health=health, covariance=np.eye(health.size) * deviation**2, offset=np.full(health.size, offset), drag=drag
    )


def row(
    stops: int, seed: int, *, loss: float = 0.0, begin: int = 0, group: int = 2, drag: float = 0.0
) -> list[Evidence]:
    """Stops without a plant: white scatter of 3 %, train load ±5 % common to all groups, a loss from `begin`."""
    random = np.random.default_rng(seed)
    rows: list[Evidence] = []
    for k in range(stops):
        health = np.array([1.1, 0.9, 1.0, 1.05]) * (1.0 + 0.05 * random.standard_normal())
        health = health * (1.0 + 0.03 * random.standard_normal(4))
        if k >= begin:
            health[group] *= 1.0 - loss
        rows.append(evidence_with(health, drag=drag if k >= begin else 0.0))
    return rows


@pytest.fixture(scope="module")
def stops():
    """A healthy stop, and the same stop with a brake that does not release."""
    healthy = Life(stops=60, seed=3)
    sticking = Life(stops=60, seed=3, stuck=0, stuck_group=3)
    return [next(live(life, range(7, 8))) for life in (healthy, sticking)]


def test_a_brake_that_does_not_release_appears_as_drag_and_lost_friction(stops):
    healthy, sticking = (evidence_of(*stop) for stop in stops)
    # 0.8 bar leave 7.9 kN on each of three units; friction and load are known to 15 %.
    expected = 5.7 * (0.8e5 * 0.0324 - 1200.0) * 3 * 0.35 * 0.235 / 0.38 / 84e3
    assert sticking.drag - healthy.drag == pytest.approx(expected, rel=0.25)
    assert (sticking.health / healthy.health).argmin() == 3


def test_health_follows_the_true_friction_over_the_nominal_law():
    """Nominal train at nominal load: the filter finds the factor by which the plant's friction was multiplied."""
    life = Life(stops=60, seed=5)
    ratios = []
    for recording, temperature in live(life, range(4)):
        evidence = evidence_of(recording, temperature)
        true = [truth_of(recording, f"mu_b[{g + 1}]")[-200:].mean() for g in range(4)]
        ratios.append(evidence.health / np.array(true))
    spread = np.array(ratios) / np.mean(ratios, axis=1, keepdims=True)
    # The mean over groups removes the load; the remainder is the deviation of the evidence, 1.5 to 5 %.
    assert np.abs(spread - spread.mean(axis=0)).max() < 0.12


class WithoutRandomness:
    """A generator whose normal draws are 0, and whose even draws are the middle of their range."""

    def standard_normal(self, size=()):
        return np.zeros(size)

    def uniform(self, low, high, size=()):
        return np.full(size, 0.5 * (low + high))

    def random(self):
        return 1.0


@pytest.mark.parametrize("order", [(0, 1, 2, 3), (1, 0, 3, 2)])
def test_perfect_readings_have_no_bias(order, monkeypatch):
    """Neither while one group is released and another brakes again, nor by the rotating masses while coasting."""
    monkeypatch.setattr("railgrip.studies.pad_monitor.life.generator", lambda *_: WithoutRandomness())
    releases = tuple(Release(group=g, start=FIRST_SLOT + i * SLOT, duration=SLOT) for i, g in enumerate(order))
    life = Life(stops=1, seed=1, worn=0, worn_group=2, loss=0.1, releases=releases)
    evidence = evidence_of(*next(live(life)))
    # The readings are held for 40 ms, which leaves 0.4 % in the second order.
    np.testing.assert_allclose(evidence.health, [1.0, 1.0, 0.9, 1.0], atol=0.005)
    assert evidence.drag == pytest.approx(0.0, abs=2e-4)


def test_without_test_releases_the_evidence_does_not_distinguish_groups():
    recording, temperature = next(live(Life(stops=60, seed=3, releases=()), range(7, 8)))
    evidence = evidence_of(recording, temperature)
    assert evidence.deviation.min() > 0.3
    # One combination is determined nevertheless: the mean over all groups, weighted by the braking forces that stop the
    # train.
    variances, combinations = np.linalg.eigh(evidence.covariance)
    weights = combinations[:, 0] / combinations[:, 0].sum()
    assert (weights > 0.05).all()
    assert np.sqrt(variances[0]) * np.linalg.norm(weights) < 0.05
    history = watch([evidence] * 50, DESIGN)
    assert history.chart_points == 0
    assert not history.alarms


def test_a_loss_of_a_fifth_is_found_within_ten_stops_in_the_right_group():
    """Constant offsets do not change the alarms."""
    for seed in range(20):
        rows = row(80, seed, loss=0.2, begin=50)
        (alarm,) = watch(rows, DESIGN).alarms
        assert alarm.group == 2
        assert 50 <= alarm.stop < 60
        assert alarm.kind == "friction lost"
        # A mean of a few stops with 3 % scatter, relative to medians with the same scatter.
        assert alarm.loss == pytest.approx(0.2, abs=0.08)
        assert watch([evidence_with(one.health, offset=0.05) for one in rows], DESIGN).alarms == (alarm,)


@pytest.mark.parametrize("groups", [3, 6])
def test_a_train_of_other_groups_is_monitored_equally(groups):
    """White scatter of 1 %, and a group that loses a quarter."""
    random = np.random.default_rng(1)
    health = 1.0 + 0.01 * random.standard_normal((80, groups))
    health[50:, -1] *= 0.75
    history = watch([evidence_with(one) for one in health], DESIGN)
    assert history.index.shape == history.chart.shape == (80, groups)
    (alarm,) = history.alarms
    assert alarm.group == groups - 1


def test_groups_are_named_after_the_wheelsets_of_the_formation():
    assert group_names() == ["wheelsets 1 to 2", "wheelset 3", "wheelset 4", "wheelsets 5 to 6"]


def test_after_an_alarm_the_index_equals_the_new_health():
    history = watch(row(80, 5, loss=0.2, begin=50), DESIGN)
    (alarm,) = history.alarms
    level = history.index[40, 2] * 0.8
    # Ten stops with scatter of 3 % and 5 % variation of the train's load: 0.02, times two.
    assert history.index[alarm.stop + 10, 2] == pytest.approx(level, abs=0.04)


def test_a_group_with_drag_is_a_brake_that_does_not_release():
    (alarm,) = watch(row(80, 1, loss=0.2, begin=50, drag=0.05), DESIGN).alarms
    assert alarm.kind == "does not release"


def test_healthy_rows_do_not_alarm():
    """100 rows of 200 stops, 72 000 group-stops; the design allows 1e-4 at the tolerated loss, less without loss."""
    assert sum(len(watch(row(200, seed), DESIGN).alarms) for seed in range(100)) == 0


def test_the_false_alarm_rate_at_the_tolerated_loss_is_no_more_than_designed():
    """A plain cumulative sum of Gaussian steps, without the limit on a step: the formula was derived for this case."""
    scatter = 0.06  # so large that the minimum threshold is not active
    design = MonitorDesign(false_alarms=2e-3, largest_step=1.0)
    threshold = threshold_for(scatter, design)
    assert threshold > 1.6 * design.largest_step
    random = np.random.default_rng(0)
    drift, alarms, chart, count = 0.5 * (design.failed - design.tolerated) / scatter, 0, 0.0, 200_000
    for step in random.standard_normal(count) - drift:
        chart = max(chart + step, 0.0)
        if chart > threshold:
            alarms, chart = alarms + 1, 0.0
    # The number of 400 alarms is accurate to 5 %, and the formula is an approximation accurate to some 10 %.
    assert alarms / count == pytest.approx(design.false_alarms, rel=0.3)


def test_one_outlying_stop_does_not_alarm():
    rows = row(80, 4)
    rows[60] = evidence_with(np.array([1.1, 0.9, 0.1, 1.05]))
    assert not watch(rows, DESIGN).alarms


def test_the_deviation_of_the_index_is_realistic():
    """Constant health; loads and readings scatter by 5 %: the mean squared normalised error is at most 1."""
    squares = []
    for seed in range(20):
        random = np.random.default_rng(seed)
        true = np.array([1.0, 0.9, 1.1, 1.0])
        loads = 0.05 * random.standard_normal((120, 1))
        rows = [evidence_with(true + load + 0.05 * random.standard_normal(4), deviation=0.05) for load in loads]
        history = watch(rows, DESIGN)
        squares.append((((history.index[-1] - true) / history.index_sd[-1]) ** 2).mean())
    # The filter allows for a drift that these rows do not have, so its deviation is rather too large.
    assert 0.2 < np.mean(squares) < 1.1


def test_a_pressure_read_too_high_lowers_health_by_the_offset_of_the_evidence(stops):
    """The same stop with an offset of one deviation in one transducer after the other."""
    recording, temperature = stops[0]
    plain = evidence_of(recording, temperature)
    for g in range(4):
        name = f"cylinder_pressure[{g + 1}]"
        pressure = reading_of(recording, name)
        biased = pressure + PRESSURE_OFFSET * (pressure > 2e4)  # a released cylinder reads zero either way
        off = recording.copy(deep=True)
        off["reading_cylinder_pressure"][:, g] = biased
        change = evidence_of(off, temperature).health - plain.health
        # A disc that seems hotter explains 5 to 15 % of the lower friction; 3 to 5 % are due to the square of the
        # offset. The others compensate for the lower braking force attributed to one group.
        assert change[g] == pytest.approx(-plain.offset[g], rel=0.2)
        assert np.abs(np.delete(change, g)).max() < 0.3 * plain.offset[g]


def test_the_index_includes_offsets_that_do_not_average_out():
    """Constant transducer offsets, drawn for each life: the index is consistent only with the offset term."""
    offset, squares, without = 0.04, [], []
    for seed in range(40):
        random = np.random.default_rng(seed)
        true = np.array([1.0, 0.9, 1.1, 1.0]) + offset * random.standard_normal(4)
        health = [true + 0.02 * random.standard_normal(4) for _ in range(60)]
        for actual, predicted in ((squares, offset), (without, 0.0)):
            history = watch([evidence_with(h, deviation=0.02, offset=predicted) for h in health], DESIGN)
            error = history.index[-1] - np.array([1.0, 0.9, 1.1, 1.0])
            actual.append((error**2 / history.index_sd[-1] ** 2).mean())
    # 160 errors: a mean square of 1 within 3·sqrt(2/160), less because the filter allows for a drift that is absent.
    assert 0.6 < np.mean(squares) < 1.0 + 3.0 * np.sqrt(2.0 / 160.0)
    assert np.mean(without) > 2.0


def test_the_trend_is_the_slope_of_health_with_its_deviation():
    slopes = []
    for seed in range(40):
        random = np.random.default_rng(seed)
        rows = [evidence_with(np.full(4, 1.0 - 2e-3 * k) + 0.03 * random.standard_normal(4)) for k in range(60)]
        history = watch(rows, DESIGN)
        slopes.append((history.trend + 2e-3) / history.trend_sd)
    # 160 normalised errors: their mean square is 1 within 3·sqrt(2/160); the tails of Student's t with 38 degrees add 5
    # %.
    assert np.mean(np.square(slopes)) == pytest.approx(1.05, abs=0.35)


def test_without_alarms_the_bound_of_the_rate_is_the_rule_of_three():
    assert rate_bound(0, 3000) == pytest.approx(3.0 / 3000, rel=2e-3)  # ln 20 = 2.9957


def test_a_study_counts_delays_from_the_first_broken_stop():
    life = Life(stops=120, seed=0, worn=50, worn_group=2, stuck=None, stuck_group=3)
    groups = judge_groups([life], [row(120, 3, loss=0.2, begin=50)], DESIGN)
    assert groups["false_alarms"].sum() == 0
    assert groups["healthy"].sum() == (50 - 20) + 100 + 2 * 100
    assert 1 < groups["delay"][2] <= 10


def test_stops_on_disk_give_the_same_evidence(stops, tmp_path):
    recording, temperature = stops[0]
    ones = np.ones(recording.sizes["time"])
    discs = {f"disc_temperature[{g + 1}]": (ones * temperature[g], "K") for g in range(4)}
    write_trace(with_signals(recording, discs), tmp_path / recording.attrs["name"] / FILE_NAME)
    evidence, sentences = stops_in(tmp_path)
    assert [*evidence] == [recording.attrs["name"]]
    assert not sentences
    here = evidence_of(recording, temperature)
    np.testing.assert_array_equal(evidence[recording.attrs["name"]].health, here.health)
