"""Common parts of control laws: observations, demands, and the brake data of the groups as parameters."""

import inspect
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import cache
from itertools import groupby
from math import isfinite
from operator import itemgetter
from pathlib import Path
from typing import ClassVar

from railgrip.controllers import tuned
from railgrip.controllers.brake import by_name
from railgrip.controllers.observation import Observation
from railgrip.controllers.parameters import Parameters
from railgrip.controllers.sampled import Expression, Formula, FormulaBuilder, Sampled
from railgrip.vehicle.brake import BRAKE, Brake
from railgrip.vehicle.signals import OBSERVED, Signal

NOT_SEEN = float("nan")


@dataclass(frozen=True, slots=True, kw_only=True)
class Tuning(Parameters):
    """Parameters of a law: finite numbers that are not negative; the type of each states its unit and meaning.

    Parameters that are not searched have a default; the values of the others are in the law's sets.

    Attributes:
        LAW: Name of the law in messages.
        POSITIVE: Names of the parameters that must not be zero.
        FIXED: Names of the parameters that other tables of the scenario set.
    """

    LAW: ClassVar[str] = ""
    POSITIVE: ClassVar[frozenset[str]] = frozenset({"period"})
    FIXED: ClassVar[frozenset[str]] = frozenset({"period"})

    def __post_init__(self) -> None:
        """Check the parameters.

        Raises:
            ValueError: A value is negative or not finite, or zero where it must be positive.
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
    """Symbols of a group's observation; `railgrip.controllers.observation.Observation` has their values.

    The signals of `railgrip.vehicle.signals.OBSERVED` are attributes by their names.

    Attributes:
        index: Number of the group as in FMI, 1 for the leading one.
        signals: Signals of the group and of the train, by name.
        brake: The group's brake data by name.
        train: Observations of all groups, leading group first; complete when the demands are formed.
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
    """Return the formula of a law that forms the demand of one group at a time.

    Args:
        name: Name of the law.
        description: One line.
        groups: Number of groups.
        demand_with: Function that declares in the draft the parameters and states that all groups share, and returns
            a function for the demand of one group.
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
    """A control law with its parameters and states.

    Attributes:
        needs: Estimates that it requires: "adhesion", "pad_friction".
    """

    needs: tuple[str, ...] = ()

    def __init__(self, formula: Formula, groups: Sequence[Brake], parameters: Mapping[str, float]) -> None:
        """Control `groups`; `parameters` has the values by name, except for the brake data of the groups."""
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


Ranges = Mapping[tuple[str, tuned.SlipSource], Mapping[str, tuple[float, float]]]
"""(Kind of actuation, source of the slip) → range of each searched parameter, on a logarithmic scale."""


FULL_PRESSURE = frozenset({"pressure_max", "wheel_radius"})
"""Brake data of a law that demands only zero or full pressure, or shares of it; every law needs the radius for slip."""


class GroupLaw(Law):
    """A built-in control law, declared in one module of the folder `laws`.

    Attributes:
        description: One line.
        tuning: Type of its parameters.
        ranges: Ranges in which `railgrip maintain tune-control` searches.
        brake_data: Fields of `Brake` that it uses; a foreign train has to provide only these.
        valve_band: Half width of the band in which valves hold under this law [Pa]; None for that of `ValveLogic`.
    """

    description: ClassVar[str]
    tuning: ClassVar[type[Tuning]] = Tuning
    ranges: ClassVar[Ranges] = {}
    brake_data: ClassVar[frozenset[str]] = frozenset(BRAKE)
    valve_band: ClassVar[float | None] = None

    def __init__(self, groups: Sequence[Brake], tuning: Tuning = NO_PARAMETERS) -> None:
        """Control all `groups` with the same `tuning`; their positions are not known."""
        unknown = {f"position[{g}]": NOT_SEEN for g in range(1, len(groups) + 1)}
        super().__init__(self.formula_for(len(groups)), groups, asdict(tuning) | unknown)

    def place(self, positions: Sequence[float]) -> None:
        """Set the distance of each group behind the leading wheelset [m], if the law uses it."""
        of_group = {f"position[{g}]": position for g, position in enumerate(positions, start=1)}
        for i, quantity in enumerate(self.formula.parameters):
            self.parameters[i] = of_group.get(quantity.name, self.parameters[i])

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
            actuation: Kind of actuation, "ideal" or "pneumatic".
            slip: Whether the slip is read or estimated.
            name: Name of the set.
            others: Values that replace those of the set; names that are not parameters of this law are ignored.

        Raises:
            ValueError: The set is not for this actuation, or a value is invalid.
        """
        module = Path(inspect.getfile(cls))
        file = module.with_name(tuned.file_of(module.stem, name))
        found = tuned.values(file, name, actuation, slip) if file.exists() else {}
        names = cls.tuning.meanings().keys()
        return cls.tuning(**{key: value for key, value in {**found, **others}.items() if key in names})
