"""The laws on a minimal wheelset: a torque balance on an adhesion curve in closed form."""

import itertools
from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np
import pytest
from wheelset import GROUP, SPEED, Altered, observed, simulate, state_of

from railgrip.controllers.law import GroupLaw, Tuning
from railgrip.controllers.laws.adhesion_based import AdhesionBased
from railgrip.controllers.laws.adhesion_literal import LiteralAdhesionBased
from railgrip.controllers.laws.slip_three_state import SlipThreeState
from railgrip.controllers.laws.slip_two_state import SlipLevels, SlipTwoState
from railgrip.controllers.laws.slope_seeking import SlopeSeeking

PAPER_LEVELS = SlipTwoState.load_tuning("ideal", "read", "paper")
PEAK_SEEKING = AdhesionBased.load_tuning("ideal", "estimated", period=1e-3, adhesion_max=0.15)
PRINTED = LiteralAdhesionBased.load_tuning(
    "ideal", "estimated", period=1e-3, adhesion_max=0.15, filter_time=4.2e-3, slip_small=3e-3, adhesion_small=0.015
)
SLOPE = SlopeSeeking.load_tuning("pneumatic", "estimated", period=10e-3, pressure_lag=0.0, adhesion_max=0.15)


def peak_seeking(**changes):
    return AdhesionBased([GROUP], replace(PEAK_SEEKING, **changes))


@pytest.mark.parametrize(("peak_slip", "patience"), [(0.01, 1.0), (0.03, 1.0), (0.1, 2.0), (0.2, 4.0)])
def test_peak_seeking_finds_the_peak_wherever_it_is(peak_slip, patience):
    """At least 96 % of α* on average: the margin costs 0.1 %, hunting a few percent.

    Fixed slip levels of 10-15 % use 16 % of a peak at 1 % slip (the curve above: 2·x/(1 + x²) at x = 12.5). The climb
    to a broad peak takes longer: at 20 % the slip responds to a torque with J v/(r² dF/ds) = 0.25 s, and `rise` adds 15
    % of torque.
    """
    _, adhesion = simulate(peak_seeking(), patience + 2.0, peak_slip=peak_slip)
    assert adhesion[round(patience * 1000) :].mean() > 0.96 * 0.06


def test_peak_seeking_does_not_run_away_on_a_rail_that_improves():
    """Adhesion doubles within 2 s: α̇ > 0 whatever the slip, the term that the paper's proof neglects."""
    slip, adhesion = simulate(peak_seeking(), 4.0, peak=lambda time, group: 0.05 + 0.025 * min(max(time - 1.5, 0), 2))
    assert slip[1500:].max() < PEAK_SEEKING.slip_vent
    expected = 0.05 + 0.025 * np.clip(np.arange(1500, 4000) * 1e-3 - 1.5, 0, 2)
    assert np.mean(adhesion[1500:] / expected) > 0.93


def test_peak_seeking_survives_a_rail_that_suddenly_gets_worse():
    """Adhesion drops to a half at once: the wheel must not lock, and must find the new peak within a second."""
    slip, adhesion = simulate(peak_seeking(), 4.0, peak=lambda time, group: 0.08 if time < 2 else 0.04)
    assert slip.max() < 0.9
    assert adhesion[3000:].mean() > 0.93 * 0.04


@pytest.mark.parametrize("peak_slip", [0.003, 0.03])
def test_adhesion_stays_below_its_limit(peak_slip):
    """A rail of 0.3 with α_max 0.15; 0.005 for the pressure's lag of 20 ms.

    On the steeper curve the limit is reached at a slip so small that the wheel counts as rolling.
    """
    _, adhesion = simulate(peak_seeking(), 3.0, peak=lambda time, group: 0.3, peak_slip=peak_slip)
    assert adhesion.max() < 0.155
    assert adhesion[1500:].mean() > 0.13


@pytest.mark.parametrize("error", [0.9, 1.1])
def test_peak_seeking_tolerates_a_wrong_pad_friction(error):
    """Pad friction scatters by ±10 %, so the torque that the law assumes is wrong by up to that."""
    mistaken = Altered(peak_seeking(), lambda seen: seen._replace(pad_friction=(0.35 * error,)))
    _, adhesion = simulate(mistaken, 4.0)
    assert adhesion[1500:].mean() > 0.93 * 0.06


def test_the_literal_law_chatters_around_the_peak():
    """Bang-bang through a lag of 20 ms, derivatives filtered over 10 ms: between peak seeking and full brake.

    A locked wheel has α(1)/α* = 0.06. With a lag of a few milliseconds, which only ideal sensors allow, the law
    chatters as finely as peak seeking hunts.
    """
    slower = replace(PEAK_SEEKING, filter_time=10e-3)
    literal = LiteralAdhesionBased([GROUP], replace(PRINTED, filter_time=10e-3))
    own = AdhesionBased([GROUP], slower)
    chatter, found = simulate(literal, 4.0)[1][1500:].mean(), simulate(own, 4.0)[1][1500:].mean()
    assert 0.5 * 0.06 < chatter < found


def demands_of(tuning, slips, adhesions=(0.05, 0.05, 0.05), speed=SPEED):
    """Return the demands of the literal law at slips and adhesions one after the other."""
    law = LiteralAdhesionBased([GROUP], tuning)
    return [
        law.decide(observed(0, speed, 0, (slip,), (adhesion,), (0.35,), (0.0,)))[0]
        for slip, adhesion in zip(slips, adhesions, strict=False)
    ]


def test_each_guard_of_the_literal_law_can_be_switched_off():
    full = GROUP.pressure_max
    # If slip and adhesion do not change, the product of their rates is zero.
    assert demands_of(PRINTED, [0.05] * 2) == [full, full]
    assert demands_of(replace(PRINTED, hold=0.0), [0.05] * 2) == [0.5 * full, 0.5 * full]
    # A rolling wheel is braked fully whatever the rates.
    unguarded = replace(PRINTED, hold=0.0, slip_small=0.0, creep_small=0.0, adhesion_small=0.0)
    assert demands_of(replace(PRINTED, hold=0.0), [0.001]) == [full]
    assert demands_of(unguarded, [0.001]) == [0.5 * full]
    # Below 0.5 m/s the law does not act.
    assert demands_of(replace(PRINTED, hold=0.0), [0.05], speed=0.3) == [full]
    assert demands_of(replace(PRINTED, hold=0.0, speed_min=0.0), [0.05], speed=0.3) == [0.5 * full]


def test_the_alternative_switching_function_has_the_same_sign_outside_its_dead_zone():
    """sgn(α̇/ṡ) = sgn(ṡ α̇); while slip rests, the quotient has no value, and the last pressure is held."""
    quotient, product = replace(PRINTED, quotient=1.0), replace(PRINTED, quotient=0.0)
    rising, falling = [0.05, 0.06, 0.07], [0.07, 0.06, 0.05]
    for slips, adhesions in itertools.product((rising, falling), repeat=2):
        assert demands_of(quotient, slips, adhesions) == demands_of(product, slips, adhesions)
    assert demands_of(quotient, rising, falling)[-1] == 0.0
    assert demands_of(quotient, [0.05] * 3, rising) == [GROUP.pressure_max] * 3


def test_two_level_control_keeps_the_slip_between_its_levels():
    """10 % and 15 %; torque through a lag of 20 ms overshoots by a few percent of slip."""
    slip, _ = simulate(SlipTwoState([GROUP], PAPER_LEVELS), 4.0)
    assert 0.05 < slip[2000:].min() < 0.11
    assert 0.14 < slip[2000:].max() < 0.20


def test_hold_keeps_the_measured_pressure():
    law = SlipThreeState([GROUP], SlipThreeState.load_tuning("ideal", "read", "paper"))
    assert law.decide(observed(0, SPEED, 0, (0.12,), None, None, (1.234e5,))) == (1.234e5,)


@pytest.mark.parametrize("kind", [SlipTwoState, SlipThreeState])
def test_the_brake_is_applied_before_the_speed_is_known(kind):
    """A radar delivers its first reading some 50 ms after the demand; the brake must not wait for it."""
    law = kind([GROUP], kind.load_tuning("ideal", "read", "paper"))
    unknown = float("nan")
    assert law.decide(observed(0, unknown, 0, (unknown,), None, None, (0.0,))) == (3.4e5,)


@pytest.mark.parametrize("law", [AdhesionBased([GROUP], PEAK_SEEKING), LiteralAdhesionBased([GROUP], PRINTED)])
def test_adhesion_based_control_requires_an_estimate(law):
    with pytest.raises(ValueError, match="needs an estimator"):
        law.decide(observed(0, SPEED, 0, (0.0,), None, None, (0.0,)))


def test_below_the_lowest_speed_the_brake_is_applied():
    observation = observed(0, 0.3, -1.2, (0.9,), (0.05,), (0.35,), (0.0,))
    for law in (SlipTwoState([GROUP], PAPER_LEVELS), LiteralAdhesionBased([GROUP], PRINTED)):
        assert law.decide(observation) == (3.4e5,)
    # The limit of adhesion still holds: 0.147 of the load at the rim, through the brake equation. A locked wheel needs
    # no torque to decelerate with the train, so none is added for its inertia.
    torque = (0.15 - 0.003) * GROUP.load * 0.38
    limit = (torque / (2 * 0.35 * 0.22) / 5.7 + 1200.0) / 0.0324
    for law in (peak_seeking(), SlopeSeeking([GROUP], SLOPE)):
        assert law.decide(observation)[0] == pytest.approx(limit, rel=1e-9)


def climber(**changes):
    """With exactly known slip: the slip that counts as rolling is below every peak of these tests."""
    return SlopeSeeking([GROUP], replace(SLOPE, period=1e-3, slip_small=2e-3, creep_small=0.0, **changes))


@pytest.mark.parametrize("peak_slip", [0.005, 0.01, 0.03, 0.1, 0.2, 0.4])
def test_the_set_point_climbs_to_the_peak_wherever_it_is(peak_slip):
    """At least 85 % of α*, over a factor of 80 in slip: the curve 2x/(1 + x²) has this value at x = 0.56 and 1.8.

    From zero the set point climbs at `rise_rate`, a factor of e in 0.7 s, and overshoots until the window has forgotten
    the climb. Levels of 10 and 15 % use 8 % of the sharpest of these curves and 58 % of the broadest.
    """
    _, adhesion = simulate(climber(), 8.0, peak_slip=peak_slip)
    assert adhesion[5000:].mean() > 0.85 * 0.06


class Held:
    """Valves: they do not act on a demand within 20 kPa of the last demand that they acted on."""

    def __init__(self, law):
        self.law, self.demands = law, None

    def decide(self, observation):
        demands = self.law.decide(observation)
        last = self.demands or demands
        band = SlopeSeeking.valve_band
        self.demands = tuple(new if abs(new - old) > band else old for new, old in zip(demands, last, strict=True))
        return self.demands


@pytest.mark.parametrize("groups", [1, 2])
@pytest.mark.parametrize("peak_slip", [0.1, 0.2, 0.3])
def test_a_demand_within_the_band_of_the_valves_does_not_leave_the_slip_small(peak_slip, groups):
    """On a broad curve a wheel at 1.6 % slip uses a tenth to a half, and the missing pressure is less than the band.

    Without the integral of slip below its set point the means are 0.50, 0.16 and 0.11. The remaining difference from
    0.9 to 1 is due to the band: here 20 kPa correspond to an adhesion of 0.0105, a sixth of the total.
    """
    law = Held(SlopeSeeking([GROUP] * groups, replace(SLOPE, period=1e-2)))
    _, adhesion = simulate(law, 8.0, peak_slip=peak_slip, groups=groups)
    assert adhesion[5000:].mean() > 0.9 * 0.06


def test_a_change_of_the_rail_is_not_mistaken_for_a_slope():
    """Friction oscillates by 20 % in 0.7 s under both wheelsets, on a curve whose peak is far beyond.

    Slip rises as friction falls: for one wheelset this looks like a falling curve, so that it brakes too little. The
    difference of two wheelsets does not depend on the rail.
    """

    def swinging(time, group):
        return 0.06 * (1 + 0.2 * np.sin(2 * np.pi * time / 0.7))

    def used(groups):
        law = SlopeSeeking([GROUP] * groups, replace(SLOPE, period=1e-2))
        slips, _ = simulate(law, 8.0, peak_slip=0.3, peak=swinging, groups=groups)
        slip = slips[5000:].reshape(3000, -1)
        return (2 * 0.3 * slip / (0.3**2 + slip**2)).mean()

    assert used(2) > 0.97
    assert used(1) < used(2) - 0.05


def test_a_patch_passed_by_both_wheelsets_in_turn_is_not_mistaken_for_a_slope():
    """Friction of 0.06 with patches of 0.02, which the second wheelset reaches 0.7 s after the first.

    In the difference of both, adhesion falls by two thirds while slip rises by more: an elasticity of −0.9, which no
    curve has. If this were used, the set point would stay at 0.22 and 0.935 of the friction would be used.
    """

    def patches(time, group):
        return 0.02 if (time - 0.7 * group) % 2.1 < 0.7 else 0.06

    law = SlopeSeeking([GROUP, GROUP], replace(SLOPE, period=1e-2))
    slip = simulate(law, 8.0, peak_slip=0.3, peak=patches, groups=2)[0][5000:]
    assert (2 * 0.3 * slip / (0.3**2 + slip**2)).mean() > 0.965


@pytest.mark.parametrize(("estimate", "possible"), [(-0.009, 0.1), (0.05, 0.1), (0.35, 0.35), (1.6, 0.6)])
def test_an_impossible_pad_friction_is_limited(estimate, possible):
    """With a faulty sensor a filter may estimate it; without the limit the brake would stay released for ever."""

    def demand(pad_friction):
        return climber().decide(observed(0.0, SPEED, 0.0, (0.05,), (0.05,), (pad_friction,), (1e5,)))[0]

    assert demand(estimate) == demand(possible) > 0.0


@pytest.mark.parametrize("error", [-0.03, 0.03])
def test_a_worn_wheel_is_not_mistaken_for_a_slide(error):
    """A radius with an error of 3 % appears as 3 % of slip at once; the law measures it before the brake is applied."""
    law = climber()
    worn = Altered(law, lambda seen: seen._replace(slip=1 - (1 - seen.slip) / (1 + error)))
    used = simulate(worn, 8.0, peak_slip=0.01)[1][5000:].mean() / 0.06
    assert state_of(law, "offset[1]") == pytest.approx(1 - 1 / (1 + error), abs=1e-9)
    assert used > 0.85


@pytest.mark.parametrize("lie", ["zero", "lost", "never there", "backwards"])
def test_a_wheel_with_an_impossible_speed_follows_the_others(lie):
    """A silent sensor, or one that reads a locked wheel without braking, must not keep the brake released.

    Meanwhile the estimated friction of its pads is useless, too; the last usable estimate is 0.3.
    """
    law = SlopeSeeking([GROUP, GROUP], replace(SLOPE, period=1e-2))
    slip, adhesion = {"zero": (1.0, 0.0), "backwards": (-0.2, 0.05)}.get(lie, (0.2, 0.05))
    demands = []
    for k in range(200):
        braked = 2e5 if k else 0.0  # an offset before the brake is applied is attributed to the radius
        slips, pads = (slip if k else 0.0, 0.05), (0.6 if k else 0.3, 0.35)
        now = observed(k * 1e-2, SPEED, 0.0, slips, (adhesion, 0.06), pads, (1e5 * (k == 1), braked))
        if lie == "never there" or (lie == "lost" and k):
            now = now._replace(wheelset_speed=np.array([np.nan, now.wheelset_speed[1]]))
        demands.append(law.decide(now)[0])
    followed, carried = (
        (share * 0.06 * GROUP.load * 0.38 / (2 * 0.3 * 0.22) / 5.7 + 1200.0) / 0.0324 for share in (0.8, 1.0)
    )
    assert demands[-1] == pytest.approx(followed, rel=0.01)
    assert demands[10] != pytest.approx(followed, rel=0.1)  # not before the fault is certain
    # The valves may leave more pressure in the cylinder than the demand, but not more than the rail supports.
    for pressure, demand in ((0.97 * carried, followed), (1.03 * carried, 0.0)):
        assert law.decide(now._replace(pressure=(pressure, 2e5)))[0] == pytest.approx(demand, rel=0.01)
    again = observed(2.0, SPEED, 0.0, (0.1, 0.05), (0.05, 0.06), (0.35, 0.35), (1e5, 2e5))
    assert law.decide(again)[0] != pytest.approx(followed, rel=0.1)


def test_wheels_that_are_neither_braked_nor_turned_correct_a_wrong_radar_speed():
    """With an estimated speed 25 % too high all wheels seem to slide by 20 %; when released, they roll."""
    law = SlopeSeeking([GROUP, GROUP], replace(SLOPE, period=1e-2))
    braked = 0.9 * GROUP.pressure_max

    def decide(slip, adhesion, pressure):
        return law.decide(observed(0.0, SPEED, 0.0, (slip,) * 2, (adhesion,) * 2, (0.35,) * 2, (pressure,) * 2))

    decide(0.0, 0.0, 0.0)
    decide(0.2, 0.06, braked)
    for _ in range(200):
        decide(0.2, 0.02, 0.0)  # the rail turns the wheel: a slide
    assert state_of(law, "offset[1]") == pytest.approx(0.0, abs=1e-12)
    for _ in range(200):
        demands = decide(0.2, 0.001, 0.0)
    assert state_of(law, "offset[1]") == pytest.approx(0.2, rel=0.01)
    assert demands[0] > 0.9 * GROUP.pressure_max  # the wheel is braked again


def test_the_slip_of_a_rolling_wheel_is_averaged():
    law, random = SlopeSeeking([GROUP], replace(SLOPE, period=1e-2)), np.random.default_rng(3)
    offsets = []
    for _ in range(200):
        slip = 0.02 + 0.01 * random.standard_normal()
        law.decide(observed(0.0, SPEED, 0.0, (slip,), (0.0,), (0.35,), (0.0,)))
        offsets.append(state_of(law, "offset[1]"))
    # A mean over a second has a deviation of 0.01 √(10 ms / 2 s) = 0.0007; four of them.
    assert np.abs(np.array(offsets[100:]) - 0.02).max() < 0.003


def test_a_wheel_that_slides_with_hardly_any_adhesion_is_not_rolling():
    """On oil a wheel that slides at 40 % has an adhesion of 0.008; full brake would lock it."""
    law = climber()
    for k in range(3):
        (demand,) = law.decide(observed(k * 1e-3, SPEED, 0, (0.4,), (0.008,), (0.35,), (1e5,)))
    balance = 0.008 * GROUP.load * 0.38
    limit = ((1 + SLOPE.share_added) * balance / (2 * 0.35 * 0.22) / 5.7 + 1200.0) / 0.0324
    assert demand <= limit


def test_with_an_unknown_slope_the_usual_slip_is_sought():
    """Adhesion is noise, independent of slip: no slope is significant, so the set point stays near the usual slip."""
    law, random = climber(dither=0.0), np.random.default_rng(7)
    usual = SLOPE.slip_usual + SLOPE.creep_usual / SPEED
    for k in range(4000):
        slip = usual * np.exp(0.05 * random.standard_normal())
        adhesion = 0.06 * np.exp(0.2 * random.standard_normal())
        law.decide(observed(k * 1e-3, SPEED, 0, (slip,), (adhesion,), (0.35,), (1e5,)))
    # A bias of 0.08 raises it until the restoring rate balances the bias.
    assert 0.7 * usual < np.exp(state_of(law, "set_point")) < 1.5 * usual


def changed(tuning, **values):
    """Return a function that creates a tuning with other values."""
    return lambda: replace(tuning, **values)


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        *(
            (lambda low=low, high=high: SlipLevels(low=low, high=high, speed_min=0.5), "0 < low < high < 1")
            for low, high in ((0.1, 1.5), (0.2, 0.1), (0.0, 0.1))
        ),
        *(
            (changed(PEAK_SEEKING, **{name: -0.1}), f"AdhesionBased: {name} must be finite and .*, got -0.1 ")
            for name in ("filter_time", "rise", "dwell", "period")
        ),
        (changed(PEAK_SEEKING, filter_time=float("nan")), "filter_time must be finite and not negative, got nan s"),
        (changed(SLOPE, window=0.0), "window must be finite and positive, got 0.0 s"),
        (changed(SLOPE, gain=-1.0), "gain must be finite and not negative"),
        (changed(SLOPE, slip_most=1.5), "0 < slip_small < slip_most < 1"),
    ],
)
def test_an_invalid_tuning_is_refused(make, sentence):
    with pytest.raises(ValueError, match=sentence):
        make()


def test_a_parameter_of_a_law_may_have_any_name():
    """For example the name of an argument of `load_tuning`."""

    @dataclass(frozen=True, slots=True, kw_only=True)
    class Names(Tuning):
        actuation: Annotated[float, "1", "one"]
        slip: Annotated[float, "1", "two"]
        name: Annotated[float, "1", "three"]

    class Named(GroupLaw):
        tuning = Names

    values = {"actuation": 1.0, "slip": 2.0, "name": 3.0}
    assert Named.load_tuning("ideal", "read", **values) == Names(**values)
