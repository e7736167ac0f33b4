"""Common parts of control laws: observations, demands, and the brake data of the groups as parameters."""

import inspect
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import cache
from math import isfinite
from pathlib import Path
from typing import ClassVar

from railgrip.controllers import tuned
from railgrip.controllers.brake import by_name
from railgrip.controllers.observation import Observation
from railgrip.controllers.parameters import Parameters
from railgrip.controllers.sampled import Expression, Formula, FormulaBuilder, Sampled
from railgrip.vehicle.brake import BRAKE, Brake

NOT_SEEN = float("nan")


@dataclass(frozen=True, slots=True, kw_only=True)
class Tuning(Parameters):
    """Parameters of a law: finite numbers that are not negative, each with its unit and meaning in its type.

    A parameter that is not searched has its value as default here; the others are in the law's sets.

    Attributes:
        LAW: Name of the law in a sentence.
        POSITIVE: Names of those that must not be zero, either.
        FIXED: Names of those that the scenario sets by other tables.
    """

    LAW: ClassVar[str] = ""
    POSITIVE: ClassVar[frozenset[str]] = frozenset({"period"})
    FIXED: ClassVar[frozenset[str]] = frozenset({"period"})

    def __post_init__(self) -> None:
        """Refuse what would run and mean nothing.

        Raises:
            ValueError: A value is negative or not a finite number, or zero where it must not be.
        """
        for name, (unit, *_) in self.meanings().items():
            value = getattr(self, name)
            if not (isfinite(value) and value >= 0.0) or (name in self.POSITIVE and value == 0.0):
                kind = "positive" if name in self.POSITIVE else "not negative"
                raise ValueError(f"{self.LAW}: {name} must be finite and {kind}, got {value} {unit}.")

    @classmethod
    def units(cls) -> dict[str, str]:
        """Return the unit of each parameter that a user may change."""
        return {name: unit for name, (unit, *_) in cls.meanings().items() if name not in cls.FIXED}


NO_PARAMETERS = Tuning()
"""Parameters of a law that has no parameters."""


@dataclass(frozen=True, slots=True, kw_only=True)
class GroupObservation:
    """What a law sees of one group, as symbols; see `railgrip.controllers.observation.Observation`.

    Attributes:
        index: Of the group as FMI counts, 1 the leading one.
        brake: The group's data by name.
        train: Observations of every group, this one among them, lead to trail; complete once the demands are formed.
    """

    index: int
    speed: Expression
    acceleration: Expression
    slip: Expression
    adhesion: Expression
    pad_friction: Expression
    wheelset_speed: Expression
    driver_demand: Expression
    pressure: Expression
    brake: Mapping[str, Expression]
    train: Sequence["GroupObservation"]

    def label(self, name: str) -> str:
        """Return the name of this group's element of an array."""
        return f"{name}[{self.index}]"


Demand = Callable[[FormulaBuilder, GroupObservation], Expression]
"""Returns the demanded pressure [Pa] of one group, keeping its states in the draft."""


OF_GROUPS = (
    ("slip", "1", "slip 1 - r*omega/v of the group"),
    ("adhesion", "1", "estimated adhesion of the group, positive in braking"),
    ("pad_friction", "1", "estimated friction of the group's brake pads"),
    ("wheelset_speed", "rad/s", "rotational speed of the group's wheelsets"),
    ("driver_demand", "Pa", "brake cylinder pressure that the driver asks for"),
    ("pressure", "Pa", "measured brake cylinder pressure"),
)
"""Inputs of a law that each group has, in their order behind speed and acceleration: name, unit and meaning."""


def law(name: str, description: str, groups: int, demand_with: Callable[[FormulaBuilder], Demand]) -> Formula:
    """Return the formula of a law that treats every group by itself.

    Args:
        name: Of the law.
        description: One line.
        groups: Number of groups.
        demand_with: Declares the parameters and states that all groups share in the draft, and returns the demand of
            one group.
    """
    draft = FormulaBuilder()
    numbers = range(1, groups + 1)
    speed = draft.input("speed", "m/s", "speed of the train")
    acceleration = draft.input("acceleration", "m/s2", "acceleration of the train, negative in braking")
    of_groups = {name: [draft.input(f"{name}[{g}]", unit, text) for g in numbers] for name, unit, text in OF_GROUPS}
    demand = demand_with(draft)
    train: list[GroupObservation] = []
    for g in numbers:
        brake = {name: draft.parameter(f"{name}[{g}]", unit, text) for name, (unit, text) in BRAKE.items()}
        signals = {name: symbols[g - 1] for name, symbols in of_groups.items()}
        train.append(
            GroupObservation(index=g, speed=speed, acceleration=acceleration, brake=brake, train=train, **signals)
        )
    demands = [demand(draft, group) for group in train]
    for g, demanded in zip(numbers, demands, strict=True):
        draft.output(f"demand[{g}]", "Pa", "demanded brake cylinder pressure", demanded)
    return draft.formula(name, description)


class Law(Sampled):
    """A control law at work on some groups.

    Attributes:
        needs: Estimates it cannot do without, of "adhesion" and "pad_friction".
    """

    needs: tuple[str, ...] = ()

    def __init__(self, formula: Formula, groups: Sequence[Brake], parameters: Mapping[str, float]) -> None:
        """Control `groups`; `parameters` are those that are not of a group, by name."""
        super().__init__(formula, by_name(groups) | {name: float(value) for name, value in parameters.items()})
        self._count = len(groups)

    def decide(self, observation: Observation) -> tuple[float, ...]:
        """Return the demanded pressure of each group [Pa].

        Raises:
            ValueError: The observation lacks an estimate that the law needs.
        """
        _, speed, acceleration, wheels, slip, _, adhesion, pad_friction, pressure, driver_demand = observation
        if adhesion is None or pad_friction is None:
            missing = [name for name in self.needs if getattr(observation, name) is None]
            if missing:
                raise ValueError(f"{self.formula.name}: needs an estimator of {missing[0]}; no component provides it.")
        inputs = self.inputs
        inputs[0], inputs[1] = speed, acceleration
        rows = inputs[2:].reshape(len(OF_GROUPS), self._count)  # a view, in the order of `OF_GROUPS`
        rows[0], rows[3], rows[4], rows[5] = slip, wheels, driver_demand, pressure
        rows[1] = NOT_SEEN if adhesion is None else adhesion
        rows[2] = NOT_SEEN if pad_friction is None else pad_friction
        return self.evaluate()


Ranges = Mapping[tuple[str, tuned.SlipSource], Mapping[str, tuple[float, float]]]
"""Kind of actuation and how the law knows the slip → where each parameter is searched, on a logarithmic scale."""


FULL_PRESSURE = frozenset({"pressure_max", "wheel_radius"})
"""What a law uses of a brake that knows only all of it and none; the radius, for slip, is that of every law."""


class GroupLaw(Law):
    """A control law of this project for single groups: all that is said of it, in one module of the folder `laws`.

    Attributes:
        description: One line.
        tuning: Type of its parameters.
        ranges: Where `railgrip maintain tune-control` searches.
        brake_data: What it uses of the data of a `Brake`; of a train from outside no more has to be given.
        valve_band: Half width of the band in which valves hold under this law [Pa]; None for that of `ValveLogic`.
    """

    description: ClassVar[str]
    tuning: ClassVar[type[Tuning]] = Tuning
    ranges: ClassVar[Ranges] = {}
    brake_data: ClassVar[frozenset[str]] = frozenset(BRAKE)
    valve_band: ClassVar[float | None] = None

    def __init__(self, groups: Sequence[Brake], tuning: Tuning = NO_PARAMETERS) -> None:
        """Control `groups` with one `tuning`."""
        super().__init__(self.formula_for(len(groups)), groups, asdict(tuning))

    @staticmethod
    def demand_with(draft: FormulaBuilder, tuning: Mapping[str, Expression]) -> Demand:
        """Declare states that all groups share in the draft, and return the demand of one group; see `law`."""
        raise NotImplementedError

    @classmethod
    @cache
    def formula_for(cls, groups: int) -> Formula:
        """Return the formula for a number of groups."""

        def demand_with(draft: FormulaBuilder) -> Demand:
            return cls.demand_with(draft, cls.tuning.declare(draft))

        return law(cls.__name__, cls.description, groups, demand_with)

    @classmethod
    def load_tuning(cls, actuation: str, slip: tuned.SlipSource, name: str = tuned.SEARCHED, **others: float) -> Tuning:
        """Return the parameters of one of the law's sets; without a file they are those of its type.

        Args:
            actuation: Kind of it.
            slip: How the law knows the slip.
            name: Of the set.
            others: Values in place of those of the set; names that are not parameters of this law are ignored.

        Raises:
            ValueError: The set is not for this actuation, or a value means nothing.
        """
        module = Path(inspect.getfile(cls))
        file = module.with_name(tuned.file_of(module.stem, name))
        found = tuned.values(file, name, actuation, slip) if file.exists() else {}
        names = cls.tuning.meanings().keys()
        return cls.tuning(**{key: value for key, value in {**found, **others}.items() if key in names})
