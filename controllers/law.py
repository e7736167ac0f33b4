"""What control laws share: what they see, what they give, and the groups' brakes among their parameters."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass

from railgrip.controllers.brake import BRAKE, BrakeGroup
from railgrip.controllers.observation import Observation
from railgrip.controllers.sampled import Draft, Expression, Formula, Sampled

NOT_SEEN = float("nan")


@dataclass(frozen=True, slots=True, kw_only=True)
class Seen:
    """What a law sees of one group, as symbols; see `railgrip.controllers.observation.Observation`.

    Attributes:
        index: Of the group as FMI counts, 1 the leading one.
        brake: The group's data by name.
    """

    index: int
    speed: Expression
    acceleration: Expression
    slip: Expression
    adhesion: Expression
    pad_friction: Expression
    pressure: Expression
    brake: Mapping[str, Expression]

    def named(self, name: str) -> str:
        """Return the name of this group's element of an array."""
        return f"{name}[{self.index}]"


Demand = Callable[[Draft, Seen], Expression]
"""Returns the demanded pressure [Pa] of one group, keeping its states in the draft."""


def law(name: str, description: str, groups: int, demand_with: Callable[[Draft], Demand]) -> Formula:
    """Return the formula of a law that treats every group by itself.

    Args:
        name: Of the law.
        description: One line.
        groups: How many there are.
        demand_with: Asks the draft for parameters and states that all groups share, and returns what is done for one.
    """
    draft = Draft()
    numbers = range(1, groups + 1)
    speed = draft.input("speed", "m/s", "speed of the train")
    acceleration = draft.input("acceleration", "m/s2", "acceleration of the train, negative in braking")
    of_groups = {
        name: [draft.input(f"{name}[{g}]", unit, text) for g in numbers]
        for name, unit, text in (
            ("slip", "1", "slip 1 - r*omega/v of the group"),
            ("adhesion", "1", "estimated adhesion of the group, positive in braking"),
            ("pad_friction", "1", "estimated friction of the group's brake pads"),
            ("pressure", "Pa", "measured brake cylinder pressure"),
        )
    }
    demand = demand_with(draft)
    demands: list[Expression] = []
    for g in numbers:
        brake = {name: draft.parameter(f"{name}[{g}]", unit, text) for name, (unit, text) in BRAKE.items()}
        own = {name: symbols[g - 1] for name, symbols in of_groups.items()}
        demands.append(demand(draft, Seen(index=g, speed=speed, acceleration=acceleration, brake=brake, **own)))
    for g, demanded in zip(numbers, demands, strict=True):
        draft.output(f"demand[{g}]", "Pa", "demanded brake cylinder pressure", demanded)
    return draft.formula(name, description)


class Law(Sampled):
    """A control law at work on some groups.

    Attributes:
        needs: Estimates it cannot do without, of "adhesion" and "pad_friction".
    """

    needs: tuple[str, ...] = ()

    def __init__(self, formula: Formula, groups: Sequence[BrakeGroup], parameters: Mapping[str, float]) -> None:
        """Control `groups`; `parameters` are those that are not of a group, by name."""
        brakes = {f"{name}[{g}]": value for g, group in enumerate(groups, 1) for name, value in asdict(group).items()}
        super().__init__(formula, brakes | {name: float(value) for name, value in parameters.items()})
        # Where each quantity stands among the inputs, in the order of `law`.
        starts = range(2, 2 + 4 * len(groups), len(groups))
        self._slip, self._adhesion, self._pad_friction, self._pressure = (slice(s, s + len(groups)) for s in starts)

    def decide(self, observation: Observation) -> tuple[float, ...]:
        """Return the demanded pressure of each group [Pa].

        Raises:
            ValueError: The observation lacks an estimate that the law needs.
        """
        _, speed, acceleration, _, slip, _, adhesion, pad_friction, pressure, _ = observation
        given = self.given
        given[0], given[1] = speed, acceleration
        given[self._slip], given[self._pressure] = slip, pressure
        if adhesion is None or pad_friction is None:
            missing = [name for name in self.needs if getattr(observation, name) is None]
            if missing:
                raise ValueError(f"{self.formula.name}: needs an estimator of {missing[0]}; nobody provides it.")
        given[self._adhesion] = NOT_SEEN if adhesion is None else adhesion
        given[self._pad_friction] = NOT_SEEN if pad_friction is None else pad_friction
        return self.evaluate()
