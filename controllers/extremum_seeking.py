"""Extremum seeking of the literature: the set slip is wiggled, and goes where adhesion answers in step."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from functools import cache
from typing import Annotated, ClassVar

import casadi as ca

from railgrip.controllers.brake import BrakeGroup
from railgrip.controllers.constant_slip import slip_control
from railgrip.controllers.law import Demand, GroupObservation, Law, Tuning, law, parameters
from railgrip.controllers.sampled import Draft, Expression, Formula, choose, within


@dataclass(frozen=True, slots=True, kw_only=True)
class ExtremumSeekingTuning(Tuning):
    """Parameters of extremum seeking."""

    period: Annotated[float, "s", "between two decisions"]
    slip_start: Annotated[float, "1", "set slip to begin with"]
    slip_least: Annotated[float, "1", "least set slip"]
    slip_most: Annotated[float, "1", "largest set slip"]
    dither: Annotated[float, "1", "amplitude of the dither over the set slip"]
    frequency: Annotated[float, "Hz", "of the dither"]
    washout_time: Annotated[float, "s", "time constant of the high-pass over the adhesion"]
    climb: Annotated[float, "1/s", "relative rate of the set slip for an elasticity of 1"]
    gain: Annotated[float, "1", "share of the full pressure for a slip off by the set one"]
    integral_time: Annotated[float, "s", "after which the integral has done as much as the gain"]
    adhesion_small: Annotated[float, "1", "estimated adhesion below which there is no gradient to follow"]
    speed_min: Annotated[float, "m/s", "train speed below which the brake is applied"]

    LAW: ClassVar[str] = "ExtremumSeeking"
    POSITIVE: ClassVar[frozenset[str]] = frozenset(
        {"period", "slip_start", "slip_least", "dither", "frequency", "integral_time", "adhesion_small"}
    )

    def __post_init__(self) -> None:
        """Refuse what would run and mean nothing.

        Raises:
            ValueError: See `Tuning`; or slips are not in order, or the dither is faster than half the decisions.
        """
        Tuning.__post_init__(self)
        if not self.slip_least <= self.slip_start <= self.slip_most < 1.0:
            raise ValueError(
                "ExtremumSeeking: wanted is slip_least <= slip_start <= slip_most < 1, got "
                f"{self.slip_least}, {self.slip_start} and {self.slip_most}."
            )
        if self.dither >= 1.0:
            raise ValueError(f"ExtremumSeeking: dither is a share of the set slip, below 1, got {self.dither}.")
        if self.frequency * self.period >= 0.25:
            raise ValueError(
                f"ExtremumSeeking: frequency {self.frequency} Hz leaves less than four decisions of {self.period} s to "
                "a wave; lower it."
            )


class ExtremumSeeking(Law):
    """Perturb and observe with a sinusoidal dither, washout and demodulation; slip is held by PI control inside.

    Per group, with estimated adhesion α:

        s_set = ŝ (1 + dither·sin ωt)                    what slip control is given
        η̇ = (α − η)/washout_time                         what the dither does not change
        ŝ̇/ŝ = climb · 2/dither · (α − η)/η · sin ωt      the mean of the right side is the elasticity d ln α/d ln s

    Source: Krstić and Wang, Stability of extremum seeking feedback for general nonlinear dynamic systems, Automatica 36
    (2000) 595; for brakes Ariyur and Krstić, Real-Time Optimization by Extremum-Seeking Control (2003), ch. 7. Relative
    rates in place of absolute ones are ours: peaks lie anywhere between 0.5 % and 40 % slip.
    """

    needs = ("adhesion",)

    def __init__(self, groups: Sequence[BrakeGroup], tuning: ExtremumSeekingTuning) -> None:
        """Control `groups` with one `tuning`."""
        super().__init__(extremum_seeking(len(groups)), groups, asdict(tuning))
        starts = [quantity.name.startswith("set_slip") for quantity in self.formula.states]
        self.state[starts] = tuning.slip_start


@cache
def extremum_seeking(groups: int) -> Formula:
    """Return the formula of `ExtremumSeeking` for so many groups."""

    def demand_with(draft: Draft) -> Demand:
        tuning = parameters(draft, ExtremumSeekingTuning.meanings())
        turn = draft.state("turn", "1", "phase of the dither over a whole turn")
        onwards = turn + tuning["frequency"] * tuning["period"]
        draft.keep(turn, choose(onwards >= 1.0, onwards - 1.0, onwards))
        wave = ca.sin(2.0 * ca.pi * turn)

        def demand(draft: Draft, group: GroupObservation) -> Expression:
            slip = draft.state(group.label("set_slip"), "1", "set slip without the dither")
            steady = draft.state(group.label("steady"), "1", "adhesion that the dither does not change")
            started = draft.state(group.label("started"), "1", "1 once there is an adhesion worth following")
            ready = group.adhesion >= tuning["adhesion_small"]
            share = tuning["period"] / (tuning["washout_time"] + tuning["period"])
            follows = choose(started, steady + share * (group.adhesion - steady), group.adhesion)
            answer = (group.adhesion - follows) / follows * wave * 2.0 / tuning["dither"]
            # A step of the rail is no answer to the dither: one wave may not double the slip.
            rate = within(tuning["climb"] * answer, -tuning["frequency"], tuning["frequency"])
            moved = within(slip * (1.0 + rate * tuning["period"]), tuning["slip_least"], tuning["slip_most"])
            draft.keep(slip, choose(ready, moved, slip))
            draft.keep(steady, choose(ready, follows, steady))
            draft.keep(started, choose(ready, 1.0, 0.0))
            return slip_control(draft, group, tuning, slip * (1.0 + tuning["dither"] * wave))

        return demand

    return law("ExtremumSeeking", "Wheel-slide protection by extremum seeking", groups, demand_with)
