"""Distance lost along the track adds up to the difference of the distances, and arises where the brakes differ."""

import numpy as np
import pytest
import xarray

from railgrip.trace.measures import Loss, StopCourse, course_of, loss

START = 20.0
BETWEEN = 1e-3
"""Between samples 0.05 m/s apart the error of a place is (0.05 m/s)² / 8 a, 0.3 mm at 1 m/s²."""


def trace(decelerations, start=START, coasting=0.0):
    """Return the trace of a stop by steps of constant deceleration: [(until this speed, deceleration), …]."""
    time, speed, distance = [0.0], [start], [0.0]
    if coasting:
        time, speed, distance = [0.0, coasting], [start, start], [0.0, coasting * start]
    for until, deceleration in decelerations:
        for v in np.linspace(speed[-1], until, 400)[1:]:
            step = (speed[-1] - v) / deceleration
            distance.append(distance[-1] + 0.5 * (speed[-1] + v) * step)
            time.append(time[-1] + step)
            speed.append(v)
    return xarray.Dataset({"speed": ("time", speed), "distance": ("time", distance)}, coords={"time": time})


def course(*decelerations, start=START, is_standstill=True) -> StopCourse:
    return course_of(trace(decelerations, start), is_standstill=is_standstill)


def parts(lost: Loss) -> list[tuple[float, float]]:
    return list(zip(lost.sections["begin"], lost.sections["lost"], strict=True))


def test_two_uniform_stops_diverge_according_to_their_decelerations():
    """B at place x has lost x (1 − b/a): it decelerates by b, A by a."""
    a, b = 1.0, 0.8
    result = loss(course((0.0, a)), course((0.0, b)))
    assert result.total == pytest.approx(START**2 / 2 * (1 / b - 1 / a), rel=1e-9)
    np.testing.assert_allclose(result.lost, result.course.place * (1 - b / a), atol=BETWEEN)
    first = result.sections.iloc[0]
    assert (first.deceleration, first.deceleration_of_first) == pytest.approx((b, a), rel=1e-4)


def test_a_difference_arises_where_the_brakes_differ_and_nowhere_else():
    """B has half the deceleration from 15 to 10 m/s, which takes it twice A's distance: 62.5 m more, from 87.5 m."""
    result = loss(course((0.0, 1.0)), course((15.0, 1.0), (10.0, 0.5), (0.0, 1.0)))
    assert result.total == pytest.approx((15**2 - 10**2) / 2 * (1 / 0.5 - 1))
    begin, end = (20**2 - 15**2) / 2, (20**2 - 15**2) / 2 + (15**2 - 10**2) / 2 / 0.5
    outside = [value for at, value in parts(result) if at + 50 <= begin or at > end]
    assert len(outside) == 2
    assert outside == pytest.approx([0.0] * len(outside), abs=BETWEEN)


@pytest.mark.parametrize("end", [7.3, 33.0, 180.0, 3000.0])
def test_sections_add_up_to_the_difference_of_the_distances(end):
    start = np.sqrt(2 * end)
    result = loss(
        course((0.4 * start, 0.9), (0.0, 1.3), start=start), course((0.7 * start, 1.2), (0.0, 1.0), start=start)
    )
    assert result.sections["lost"].sum() == pytest.approx(result.total)
    assert result.sections["end"].iloc[-1] == pytest.approx(result.course.place[-1])
    assert list(result.sections["end"][:-1]) == list(result.sections["begin"][1:])
    assert 1 <= len(result.sections) <= 13


def test_a_faster_start_counts_until_the_speed_is_that_of_the_other_start():
    result = loss(course((0.0, 1.0)), course((0.0, 1.0), start=25.0))
    higher = (25**2 - 20**2) / 2
    assert result.total == pytest.approx(higher)
    before = result.course.place < higher
    np.testing.assert_allclose(result.lost[before], result.course.place[before])
    np.testing.assert_allclose(result.lost[~before], higher, atol=BETWEEN)


def test_a_slower_start_is_saved_before_the_first_section():
    result = loss(course((0.0, 1.0)), course((0.0, 1.0), start=15.0))
    assert (result.at_start, result.total) == pytest.approx((-(20**2 - 15**2) / 2,) * 2, abs=BETWEEN)
    assert [one for _, one in parts(result)] == pytest.approx([0.0] * len(result.sections), abs=BETWEEN)


def test_a_second_without_brakes_is_attributed_to_its_place():
    first, other = (course_of(trace([(0.0, 1.0)], coasting=time), is_standstill=True) for time in (0.0, 1.0))
    assert loss(first, other).total == pytest.approx(START)
    assert parts(loss(first, other))[0] == (0.0, pytest.approx(START, abs=BETWEEN))
    assert loss(other, first).total == pytest.approx(-START)
    assert parts(loss(other, first))[0] == (0.0, pytest.approx(-START, abs=BETWEEN))


def test_the_same_stop_loses_nothing_even_where_it_accelerates():
    speeds = [20.0, 20.0, 19.0, 19.5, 19.5, 18.0, 10.0, 0.0]
    distance = np.concatenate([[0.0], np.cumsum(speeds[1:])])
    own = xarray.Dataset({"speed": ("time", speeds), "distance": ("time", distance)}, coords={"time": range(8)})
    result = loss(course_of(own, is_standstill=True), course_of(own, is_standstill=True))
    np.testing.assert_allclose(result.lost, 0.0)


def test_without_standstill_only_speeds_reached_by_both_count():
    result = loss(course((5.0, 1.0), is_standstill=False), course((0.0, 0.5)))
    assert result.course.speed[-1] == pytest.approx(5.0, abs=0.1)
    assert result.total == pytest.approx((20**2 - 5**2) / 2 * (1 / 0.5 - 1), rel=0.01)


def test_the_last_speed_of_a_standstill_does_not_count():
    """Standstill means below a speed that is not 0, where the two need not be equal."""
    rolls, stands = course((0.05, 1.0)), course((0.02, 1.0))
    assert loss(rolls, stands).total == pytest.approx(stands.place[-1] - rolls.place[-1], abs=1e-12)
