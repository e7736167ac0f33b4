"""Common parts of control laws: observations, demands, and the brake data of the groups as parameters."""

import inspect
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, fields
from functools import cache
from itertools import groupby
from math import isfinite
from operator import itemgetter
from pathlib import Path
from typing import Any, ClassVar, Literal, get_type_hints

from railgrip.controllers import tuned
from railgrip.controllers.brake import by_name
from railgrip.controllers.observation import Observation
from railgrip.controllers.sampled import Expression, Formula, FormulaBuilder, Sampled
from railgrip.vehicle.brake import BRAKE, Brake
from railgrip.vehicle.signals import OBSERVED, Signal

NOT_SEEN = float("nan")


@dataclass(frozen=True, slots=True, kw_only=True)
class Tuning:
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
    @cache
    def meanings(cls) -> Mapping[str, tuple[Any, ...]]:
        """Return the unit, the meaning and, if there is one, the largest value of each parameter, by name."""
        types = get_type_hints(cls, include_extras=True)
        return {field.name: types[field.name].__metadata__ for field in fields(cls)}

    @classmethod
    def units(cls) -> dict[str, str]:
        """Return the unit of each parameter that a user may change."""
        return {name: unit for name, (unit, *_) in cls.meanings().items() if name not in cls.FIXED}


NO_PARAMETERS = Tuning()
"""Parameters of a law that has no parameters."""


@dataclass(frozen=True, slots=True, kw_only=True)
class GroupObservation:
    """Symbols of a group's observation; `railgrip.controllers.observation.Observation` has their values.

    The signals of `railgrip.vehicle.signals.OBSERVED` are attributes by their names.

    Attributes:
        index: Number of the group as in FMI, 1 for the leading one.
        signals: Signals of the group and of the train, by name.
        brake: The group's data by name.
        train: Observations of every group, this one among them, lead to trail; complete once the demands are formed.
    """

    index: int
    signals: Mapping[str, Expression]
    brake: Mapping[str, Expression]
    train: Sequence["GroupObservation"]

    def __getattr__(self, name: str) -> Expression:
        """Return a signal."""
        if name not in self.signals:
            raise AttributeError(f"An observation has no '{name}'; it has {', '.join(self.signals)}.")
        return self.signals[name]

    def label(self, name: str) -> str:
        """Return the name of this group's element of an array."""
        return f"{name}[{self.index}]"


Demand = Callable[[FormulaBuilder, GroupObservation], Expression]
"""Returns the demanded pressure [Pa] of one group, keeping its states in the draft."""


def law(
    name: str,
    description: str,
    groups: int,
    demand_with: Callable[[FormulaBuilder], Demand],
    observed: Sequence[Signal] = OBSERVED,
) -> Formula:
    """Return the formula of a law that treats every group by itself.

    Args:
        name: Name of the law.
        description: One line.
        groups: Number of groups.
        demand_with: Declares the parameters and states that all groups share in the draft, and returns the demand of
            one group.
        observed: Signals of the observation, the inputs of the law.
    """
    draft = FormulaBuilder()
    inputs = dict(zip((signal.name for signal in observed), draft.vector(observed, groups), strict=True))
    demand = demand_with(draft)
    train: list[GroupObservation] = []
    for g in range(groups):
        brake = {name: draft.parameter(f"{name}[{g + 1}]", unit, text) for name, (unit, text) in BRAKE.items()}
        signals = {name: symbols[min(g, len(symbols) - 1)] for name, symbols in inputs.items()}
        train.append(GroupObservation(index=g + 1, signals=signals, brake=brake, train=train))
    demands = [demand(draft, group) for group in train]
    for g, demanded in enumerate(demands, start=1):
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
        elements = enumerate(quantity.name.partition("[")[0] for quantity in formula.inputs)
        numbers = {name: [i for i, _ in of_name] for name, of_name in groupby(elements, key=itemgetter(1))}
        self._places = tuple((name, slice(places[0], places[-1] + 1)) for name, places in numbers.items())

    def decide(self, observation: Observation, demand: Sequence[float] | None = None) -> tuple[float, ...]:
        """Return the demanded pressure of each group [Pa].

        Raises:
            ValueError: The observation lacks an estimate that the law needs.
        """
        missing = [name for name in self.needs if getattr(observation, name) is None]
        if missing:
            raise ValueError(f"{self.formula.name}: needs an estimator of {missing[0]}; no component provides it.")
        for name, place in self._places:
            values = demand if name == "demand" else getattr(observation, name)
            self.inputs[place] = NOT_SEEN if values is None else values
        return self.evaluate()


@dataclass(frozen=True, slots=True, kw_only=True)
class TypeTestEntry:
    """How a law takes part in the type test.

    Attributes:
        description: One line.
        role: A baseline is what an entrant has to beat.
        slip: Whether it is given an estimator or readings alone.
        tuning: Name of its set.
    """

    description: str
    role: Literal["baseline", "entrant"]
    slip: tuned.SlipSource
    tuning: str = tuned.SEARCHED


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
        entries: In the type test, by the name there.
        brake_data: What it uses of the data of a `Brake`; of a train from outside no more has to be given.
        valve_band: Half width of the band in which valves hold under this law [Pa]; None for that of `ValveLogic`.
    """

    description: ClassVar[str]
    tuning: ClassVar[type[Tuning]] = Tuning
    ranges: ClassVar[Ranges] = {}
    entries: ClassVar[Mapping[str, TypeTestEntry]] = {}
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
            symbols = {name: draft.parameter(name, *meaning) for name, meaning in cls.tuning.meanings().items()}
            return cls.demand_with(draft, symbols)

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
