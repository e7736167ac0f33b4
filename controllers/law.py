"""Common parts of control laws: symbols of the observation and of the brake data, tuning, and the law as an object."""

import inspect
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import cache
from pathlib import Path
from sys import float_info
from typing import Annotated, ClassVar

import casadi as ca

from railgrip.base.names import ElementName
from railgrip.base.system import SampledSystem
from railgrip.base.units import short
from railgrip.controllers.observation import Observation
from railgrip.controllers.parameters import SEARCHED, Parameters, SlipSource, file_of, tuned_values
from railgrip.controllers.sampled import Expression, FormulaBuilder, Sampled, Symbols, choose, require_value, within
from railgrip.vehicle.brake import BRAKE, Brake, pressure_of
from railgrip.vehicle.signals import OBSERVATION, Signal

NOT_SEEN = float("nan")
"""Input of a law for an estimate that no component provides."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Tuning(Parameters):
    """Parameters of a law: finite numbers that are not negative; the type of each states its unit and meaning.

    Parameters that are not searched have a default; the values of the others are in the law's sets. A class is named
    as its law, followed by Tuning, which messages leave out.

    Attributes:
        POSITIVE: Names of the parameters that must not be zero.
        FIXED: Names of the parameters that other tables of the scenario set.
        ORDER: Required orders of parameters and numbers, such as `low < high < 1`, some with a remark for the message
            after a semicolon.
    """

    POSITIVE: ClassVar[frozenset[str]] = frozenset({"period"})
    FIXED: ClassVar[frozenset[str]] = frozenset({"period"})
    ORDER: ClassVar[tuple[str, ...]] = ()

    def __post_init__(self) -> None:
        """Check the parameters.

        Raises:
            ValueError: A value is negative or not finite, zero where it must be positive, or not in the required order.
        """
        law_name = type(self).__name__.removesuffix("Tuning")
        for name, (unit, *_) in self.meanings().items():
            value = getattr(self, name)
            least = float_info.min if name in self.POSITIVE else 0.0
            if not (isinstance(value, int | float) and least <= value <= float_info.max):
                kind = "positive" if name in self.POSITIVE else "not negative"
                raise ValueError(f"{law_name}: {name} must be finite and {kind}, got {short(value)} {unit}.")
        for text in self.ORDER:
            order, semicolon, remark = text.partition(";")
            terms, signs = order.split()[::2], order.split()[1::2]
            values = [getattr(self, term, term) for term in terms]
            pairs = zip(map(float, values), signs, map(float, values[1:]), strict=False)
            if not all(low <= high if sign == "<=" else low < high for low, sign, high in pairs):
                found = [f"{term} = {value}" for term, value in zip(terms, values, strict=True) if term.isidentifier()]
                raise ValueError(f"{law_name}: {order} is required, got {', '.join(found)}{semicolon}{remark}.")

    @classmethod
    def units(cls) -> dict[str, str]:
        """Return the unit of each parameter that a user may change."""
        return {name: unit for name, (unit, *_) in cls.meanings().items() if name not in cls.FIXED}


@dataclass(frozen=True, slots=True, kw_only=True)
class SetSlipTuning(Tuning):
    """Parameters of a law that moves its set slip; it seeks the peak between `slip_least` and `slip_most`.

    `adhesion_small`: wheels that hardly brake carry no information on the rail.
    """

    period: Annotated[float, "s", "between two decisions"]
    slip_start: Annotated[float, "1", "set slip at the start"]
    slip_least: Annotated[float, "1", "smallest set slip"] = 0.005
    slip_most: Annotated[float, "1", "largest set slip"] = 0.3
    gain: Annotated[float, "1", "share of the full pressure for an error as large as the set slip"]
    integral_time: Annotated[float, "s", "after which the integral term equals the proportional one"]
    adhesion_small: Annotated[float, "1", "estimated adhesion below which the set slip stays"] = 0.01
    speed_min: Annotated[float, "m/s", "train speed below which the brake is applied"] = 0.5

    ORDER: ClassVar[tuple[str, ...]] = ("slip_least <= slip_start <= slip_most < 1",)


@dataclass(frozen=True, slots=True, kw_only=True)
class DitheredSlipTuning(SetSlipTuning):
    """Parameters of a law that excites its set slip by a sine, and climbs the slope of adhesion that this reveals."""

    dither: Annotated[float, "1", "amplitude of the dither over the set slip"]
    frequency: Annotated[float, "Hz", "of the dither"]
    washout_time: Annotated[float, "s", "time constant of the high-pass of the signals"]
    climb: Annotated[float, "1/s", "relative rate of the set slip for an elasticity of 1"]

    ORDER: ClassVar[tuple[str, ...]] = (*SetSlipTuning.ORDER, "dither < 1; it is a share of the set slip")


NO_PARAMETERS = Tuning()
"""Parameters of a law that has no parameters."""


@dataclass(frozen=True, slots=True, kw_only=True)
class GroupObservation:
    """Symbols of a group's observation; `railgrip.controllers.observation.Observation` has their values.

    The signals of `railgrip.vehicle.signals.OBSERVATION` are attributes by their names.

    Attributes:
        index: Number of the group as in FMI, 1 for the leading one.
        signals: Signals of the group and of the train, by name.
        brake: The group's brake data by name.
        train: Observations of all groups, leading group first; the list is complete before the first demand is formed.
    """

    index: int
    signals: Symbols
    brake: Symbols
    train: Sequence["GroupObservation"]

    def __getattr__(self, name: str) -> Expression:
        if name not in self.signals:
            raise AttributeError(f"An observation has no '{name}'; it has {', '.join(self.signals)}.")
        return self.signals[name]

    def label(self, name: str) -> str:
        """Return the name of this group's element of an array, such as `slip[2]`."""
        return f"{name}[{self.index}]"


Demands = Callable[[FormulaBuilder, Symbols, Sequence[GroupObservation]], Sequence[Expression]]
"""Returns the demanded pressure [Pa] of each group, from parameters and observations; declares states in the draft."""


def law(
    name: str,
    description: str,
    groups: int,
    demands: Demands,
    tuning: type[Tuning] = Tuning,
    observed: Sequence[Signal] = OBSERVATION,
) -> SampledSystem:
    """Return the formula of a law.

    Args:
        name: Name of the law.
        description: One line.
        groups: Number of groups.
        demands: Function for the demands of all groups.
        tuning: Type of its parameters.
        observed: Signals of the observation, the inputs of the law.
    """
    draft = FormulaBuilder()
    inputs = dict(zip((signal.name for signal in observed), draft.vector(observed, groups), strict=True))
    parameters = tuning.declare(draft)
    train: list[GroupObservation] = []
    for g in range(1, groups + 1):
        brake = {datum: draft.parameter(f"{datum}[{g}]", unit, meaning) for datum, (unit, meaning) in BRAKE.items()}
        # A signal of the train has one symbol, which all groups share.
        signals = {signal: symbols[min(g, len(symbols)) - 1] for signal, symbols in inputs.items()}
        train.append(GroupObservation(index=g, signals=signals, brake=brake, train=train))
    for g, demanded in enumerate(demands(draft, parameters, train), start=1):
        require_value(f"demand[{g}]", demanded)
        draft.output(f"demand[{g}]", "Pa", "demanded brake cylinder pressure", demanded)
    return draft.formula(name, description)


class Law(Sampled):
    """A control law with its parameters and states.

    Attributes:
        needs: Estimates that it requires: "adhesion", "pad_friction".
    """

    needs: tuple[str, ...] = ()

    def __init__(self, formula: SampledSystem, groups: Sequence[Brake], parameters: Mapping[str, float]) -> None:
        """Control `groups`; `parameters` has the values by name, except for the brake data of the groups."""
        super().__init__(formula, by_name(groups) | {name: float(value) for name, value in parameters.items()})
        names = [ElementName.of(variable.name).array for variable in formula.inputs]
        first = {name: names.index(name) for name in names}
        self._places = tuple((name, slice(start, start + names.count(name))) for name, start in first.items())

    def decide(self, observation: Observation, demand: Sequence[float] | None = None) -> tuple[float, ...]:
        """Return the demanded pressure of each group [Pa].

        Args:
            observation: Readings and estimates.
            demand: Demands of another controller [Pa], for a law with the input `demand`.

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


Ranges = Mapping[tuple[str, SlipSource], Mapping[str, tuple[float, float]]]
"""(Kind of actuation, source of the slip) → range of each searched parameter; the search uses its logarithm."""


FULL_PRESSURE = frozenset({"pressure_max", "wheel_radius"})
"""Brake data of a law that demands shares of the full pressure; slip is computed from readings with the radius."""


class GroupLaw(Law):
    """A built-in control law, declared in one module of the folder `laws`.

    Attributes:
        description: One line.
        tuning: Type of its parameters.
        ranges: Ranges in which `railgrip maintain tune-control` searches.
        brake_data: Fields of `Brake` that it uses; a foreign train has to provide only these.
        exceeds_driver: Whether it forms demands from the driver's, and may exceed them; else they are limits.
        valve_band: Half width of the band in which valves hold under this law [Pa]; None for
            `railgrip.controllers.valves.BAND`.
    """

    description: ClassVar[str]
    tuning: ClassVar[type[Tuning]] = Tuning
    ranges: ClassVar[Ranges] = {}
    brake_data: ClassVar[frozenset[str]] = frozenset(BRAKE)
    exceeds_driver: ClassVar[bool] = False
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

    @classmethod
    def demand(cls, draft: FormulaBuilder, tuning: Symbols, group: GroupObservation) -> Expression:
        """Return the demanded pressure of one group [Pa], and declare the group's states in the draft."""
        raise NotImplementedError(f"{cls.__name__} has no classmethod demand(cls, draft, tuning, group)")

    @classmethod
    def demands(cls, draft: FormulaBuilder, tuning: Symbols, train: Sequence[GroupObservation]) -> list[Expression]:
        """Return the demanded pressure of each group [Pa]; a law whose groups share states has this method instead."""
        return [cls.demand(draft, tuning, group) for group in train]

    @classmethod
    @cache
    def formula_for(cls, groups: int) -> SampledSystem:
        """Return the formula for a number of groups."""
        return law(cls.__name__, cls.description, groups, cls.demands, cls.tuning)

    @classmethod
    def load_tuning(cls, actuation: str, slip: SlipSource, name: str = SEARCHED, /, **others: float) -> Tuning:
        """Return the parameters of one of the law's sets; without a file, the defaults of `tuning`.

        Args:
            actuation: Kind of actuation, "ideal" or "pneumatic".
            slip: Whether the slip is read or estimated.
            name: Name of the set.
            others: Values that replace those of the set; names that are not parameters of this law are ignored.

        Raises:
            ValueError: The set is not for this actuation, or a value is invalid.
        """
        module = Path(inspect.getfile(cls))
        file = module.with_name(file_of(module.stem, name))
        found = tuned_values(file, name, actuation, slip) if file.exists() else {}
        return cls.tuning_with(**{**found, **others})

    @classmethod
    def tuning_with(cls, **values: float) -> Tuning:
        """Return the parameters with these values; names that are not parameters of this law are ignored.

        Raises:
            ValueError: A value is invalid.
        """
        names = cls.tuning.meanings().keys()
        return cls.tuning(**{key: value for key, value in values.items() if key in names})


class SetSlipLaw(GroupLaw):
    """A law with a state `set_slip` of each group, which it moves where adhesion is higher."""

    brake_data = FULL_PRESSURE
    needs = ("adhesion",)

    def __init__(self, groups: Sequence[Brake], tuning: SetSlipTuning) -> None:
        """Control `groups` with one `tuning`; the set slip starts at its `slip_start`."""
        super().__init__(groups, tuning)
        self.state[[quantity.name.startswith("set_slip") for quantity in self.formula.states]] = tuning.slip_start


class DitheredSlipLaw(SetSlipLaw):
    """A law whose groups add a dither to their set slip; its sine is in their parameters, as `wave`."""

    @classmethod
    def demands(cls, draft: FormulaBuilder, tuning: Symbols, train: Sequence[GroupObservation]) -> list[Expression]:
        """Return the demanded pressure of each group [Pa]."""
        turn = draft.state("turn", "1", "phase of the dither over a whole turn")
        following = turn + tuning["frequency"] * tuning["period"]
        draft.keep(turn, following - ca.floor(following))
        return super().demands(draft, {**tuning, "wave": ca.sin(2.0 * ca.pi * turn)}, train)


def by_name(groups: Sequence[Brake]) -> dict[str, float]:
    """Return the data of all groups by the names of a formula's parameters, such as `load[1]` of the first group."""
    return {f"{name}[{g}]": value for g, group in enumerate(groups, 1) for name, value in asdict(group).items()}


_PAD_FRICTION_LIMITS = 0.1, 0.6
"""Limits of pad friction, with a margin: UIC 541-3 has 0.35 to 0.45, ±20 % between lots; wet pads lose up to 30 %."""


def pressure_for(torque: Expression, pad_friction: Expression, brake: Symbols) -> Expression:
    """Return the brake cylinder pressure [Pa] at which a group's units give `torque` [N·m]; within 0 … pressure_max.

    An impossible estimate of pad friction, as after wrong readings, is limited to the possible range. A negative one
    would leave the brake off for good: without pressure no reading depends on the pads, so the estimate would not
    recover.

    Source: Schwarz, Lüdicke, Heckmann (2019), eq. (3), solved for p_c.
    """
    pad_force = torque / (brake["units"] * within(pad_friction, *_PAD_FRICTION_LIMITS) * brake["friction_radius"])
    pressure = pressure_of(pad_force, **{name: brake[name] for name in ("piston_area", "spring_force", "rigging")})
    full = brake["pressure_max"]
    # Not `within`: NaN, as before the first estimate, must give full pressure.
    return choose(pressure <= 0.0, 0.0, choose(pressure < full, pressure, full))
