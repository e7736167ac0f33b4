"""The prediction models of estimations: of a class of the library, of a user's class, and of a train file."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, partial
from pathlib import Path
from typing import Final, Literal

import casadi as ca
import numpy as np

from railgrip.base.errors import EstimationError, InputError
from railgrip.base.names import ElementName, did_you_mean, known_names
from railgrip.base.system import Variable
from railgrip.estimators.prediction import CasadiPrediction, PredictionInC
from railgrip.fmi import Description, FmuPrediction
from railgrip.fmus.native import Model
from railgrip.fmus.native.library import LIBRARY
from railgrip.rolling_stock.check import checked_train
from railgrip.rolling_stock.modelica import nominal_data
from railgrip.scenario.file import NamedFile
from railgrip.simulate.named_models import consist_description, prediction_description, prediction_model
from railgrip.simulate.train_prediction import (
    CENTRAL,
    CentralPrediction,
    central_of,
    release_pressure,
    start_of,
    units_of_predictions,
)
from railgrip.vehicle.formation import Formation

Kind = Literal["fmu", "compiled"]
"""Form of the prediction in a filter: its FMU through FMI 2.0, or the equations of its class as C in the filter."""

READ_STATES = frozenset({"speed", "wheelset_speed"})
"""States that are measured directly; if `start` omits them they are initialised with the first reading."""

DEFAULT: Final = "library default"
"""Origin of a parameter that neither a file nor an option sets."""

OPTIONAL: Final = frozenset({"dz", "ddz", "deflection", "d", "bias"})
"""States and readings that only some predictions of trains have: those of suspensions, gradient and accelerometer."""

_OF_TRAIN: Final = {
    "m_wheelset": "Mass that each wheelset carries on the rail, including its own",
    "mu_b_nominal": "Pad friction of each group at the start",
}
"""Data of a train that the prediction has under another name, and their meaning."""

Values = Mapping[str, float]


@dataclass(frozen=True, kw_only=True, eq=False)
class PredictionModel:
    """The equations of a prediction with parameters that an estimation may set.

    Attributes:
        name: Name of the class or train in messages.
        model: Equations with all outputs, which are named as readings.
        parameters: Parameters that may be set; their start is the value that they have otherwise.
        units: Unit of each name that may be set; for a train file also of names without index, for all elements.
        origins: Origin of the values that are not defaults of a library, by name.
        optional: Names of states and readings, without index, whose noise and start may be given for nothing.
        resolve: Function from values by name to those of all parameters of `model`.
        start: Function from values by name to the mean of states at the start, by name; those of a train file.
        describe: Function that builds the FMU, if it is out of date, and returns its description.
        outputs_of_fmu: Name in the FMU of each output of `model`.
        limits: Sentences on parts of the vehicle that are in no equation.
    """

    name: str
    model: Model
    parameters: tuple[Variable, ...]
    units: Mapping[str, str]
    origins: Mapping[str, str] = field(default_factory=dict[str, str])
    optional: frozenset[str] = frozenset()
    resolve: Callable[[Values], Mapping[str, float]]
    start: Callable[[Values], dict[str, float]] = field(default=lambda _: {})
    describe: Callable[[], Description]
    outputs_of_fmu: tuple[str, ...]
    limits: tuple[str, ...] = ()

    def values(self, given: Values) -> dict[str, float]:
        """Return the value of each parameter; `given` has those that are set.

        Raises:
            EstimationError: A parameter does not exist.
        """
        strange = [name for name in given if name not in self.units]
        if strange:
            known = [variable.name for variable in self.parameters]
            raise EstimationError(
                f"{self.name} has no parameter {', '.join(strange)}; it has {known_names(known, strange[0])}"
            )
        return {v.name: given.get(v.name, given.get(ElementName.of(v.name).array, v.start)) for v in self.parameters}

    def equations(self, given: Values, outputs: Sequence[str] | None = None) -> CasadiPrediction:
        """Return the prediction as equations, which can be differentiated further and shared by threads.

        Args:
            given: Parameters that are set, SI.
            outputs: Expected readings, in that order, `wheelset_speed` for all its elements; None for all outputs.

        Raises:
            EstimationError: A parameter or output does not exist.
        """
        self.values(given)
        model = self.model if outputs is None else select_outputs(self.model, self.name, tuple(outputs))
        return CasadiPrediction(model, self.resolve(given))

    def prediction(self, given: Values, outputs: Sequence[str] | None = None, kind: Kind = "fmu") -> PredictionInC:
        """Return the prediction in a form; only one thread may use an FMU at a time.

        Other arguments and errors are those of `equations`.
        """
        equations = self.equations(given, outputs)
        if kind == "compiled":
            return equations
        of_fmu = dict(zip((v.name for v in self.model.outputs), self.outputs_of_fmu, strict=True))
        return FmuPrediction(
            self.describe(),
            parameters=self.resolve(given),
            states=equations.states,
            inputs=equations.inputs,
            outputs=[of_fmu[name] for name in equations.outputs],
            readings=equations.outputs,
        ).open()

    def release_pressure(self, given: Values, pad_force: float) -> float:
        """Return the cylinder pressure [Pa] at which the pads of every group press with a force [N] or more.

        It is NaN if the model has no data of the rigging.
        """
        groups = sum(variable.name.startswith("wheelset_speed[") for variable in self.model.states)
        values = self.values(given)
        return max(release_pressure(values, group, pad_force) for group in range(groups)) if groups else np.nan


@cache
def select_outputs(source: Model, model: str, outputs: tuple[str, ...]) -> Model:
    """Return a model with some of its outputs, in their order; `wheelset_speed` selects all its elements.

    Args:
        source: The model.
        model: Its name in messages.
        outputs: Names of outputs.

    Raises:
        EstimationError: An output does not exist.
    """
    names = [variable.name for variable in source.outputs]
    places = [i for output in outputs for i, name in enumerate(names) if output in (name, ElementName.of(name).array)]
    missing = [output for output in outputs if not any(output in (n, ElementName.of(n).array) for n in names)]
    if missing:
        raise EstimationError(f"{model} has no output {', '.join(missing)}; it has {known_names(names, missing[0])}")
    arguments = [ca.SX.sym(f"a{i}", *source.output.size_in(i)) for i in range(source.output.n_in())]
    selection = ca.Function("output", arguments, [ca.densify(source.output(*arguments))[places]])
    return replace(source, outputs=tuple(source.outputs[i] for i in places), output=selection)


def model_of(model: str) -> Model:
    """Return a class of RailBraking.Predictions as functions; cached in the process.

    Raises:
        EstimationError: The class does not exist.
    """
    classes = (LIBRARY / "Predictions" / "package.order").read_text(encoding="utf-8").split()
    if "." not in model and model not in classes:
        hint = did_you_mean(model, classes) or f"there is {', '.join(classes)}."
        raise EstimationError(f"there is no prediction '{model}'; {hint}")
    return prediction_model(model)


def units_of(model: str | Model) -> dict[str, str]:
    """Return the unit of every state, input and output of a prediction, a model or a class by its name."""
    source = model_of(model) if isinstance(model, str) else model
    return {v.name: v.unit for v in (*source.states, *source.inputs, *source.outputs)}


def of_class(name: str, library: NamedFile | None = None) -> PredictionModel:
    """Return the prediction of a class of RailBraking.Predictions, or of a user's library by its full name.

    Raises:
        EstimationError: The class does not exist in RailBraking.Predictions.
        railgrip.base.errors.InputError: The class does not exist in the user's library, or does not compile.
    """
    model = model_of(name) if library is None else prediction_model(name, library)
    return PredictionModel(
        name=name,
        model=model,
        parameters=tuple(model.parameters),
        units={variable.name: variable.unit for variable in model.parameters},
        resolve=lambda given: {variable.name: variable.start for variable in model.parameters} | dict(given),
        describe=partial(prediction_description, name, library),
        outputs_of_fmu=tuple(variable.name for variable in model.outputs),
    )


def of_train(train: NamedFile, class_name: str = CENTRAL[0], *, has_suspension: bool = True) -> PredictionModel:
    """Return the prediction of a train file, the one that the filter of a scenario with that train has.

    Args:
        train: The file.
        class_name: A class of `railgrip.simulate.train_prediction.CENTRAL`.
        has_suspension: Whether bogies of two wheelsets have a suspension; otherwise all loads are static.

    Raises:
        ScenarioError: The file is not a train.
    """
    return _of_train(train.entry, train.path, train.digest(), class_name, has_suspension)


@cache
def _of_train(entry: str, path: Path, digest: str, class_name: str, has_suspension: bool) -> PredictionModel:  # pyright: ignore[reportUnusedParameter]
    train = checked_train(path)
    if train.dynamic_groups:
        raise InputError(
            f"{path.name}: {train.name} has [dynamic_brakes] on its axles, but filters of trains know the torque of "
            "friction brakes alone and would attribute the difference to adhesion; give a model of your own, or a "
            "train file of a recording in which they were off, without dynamic_brake of [bogies]"
        )
    formation, data = Formation(tuple(map(len, train.groups))), nominal_data(train)
    if not has_suspension:  # without data of its frame a bogie is rigid
        data = {name: value for name, value in data.items() if not name.startswith("m_frame")}

    def data_with(given: Values) -> dict[str, float]:
        return {name: value for name, value in data.items() if ElementName.of(name).array not in given} | dict(given)

    def central(given: Values) -> CentralPrediction:
        return central_of(formation, data_with(given), class_name)

    def start(given: Values) -> dict[str, float]:
        names = [v.name for v in nominal.model.states if ElementName.of(v.name).array not in READ_STATES]
        return dict(zip(names, start_of(names, formation, data_with(given), np.nan).tolist(), strict=True))

    nominal = central({})
    readings = zip(nominal.model.outputs, nominal.readings, strict=True)
    limits: list[str] = []
    if train.track_brake_force:
        limits.append(
            f"{train.name} has brakes on the rail itself of up to {train.track_brake_force / 1e3:.0f} kN, which are in "
            "no equation: while they act, the filter attributes their force to gradient, adhesion and pad friction."
        )
    if train.linear_resistance:
        limits.append(
            f"{train.name} has a linear running resistance of {train.linear_resistance:g} N s/m, which is in no "
            "equation: the filter attributes it to gradient, adhesion and pad friction."
        )
    units, parameters = units_of_predictions(), _parameters_of_train(nominal.model, data)
    return PredictionModel(
        name=Path(entry).stem,
        model=replace(nominal.model, outputs=tuple(replace(output, name=name) for output, name in readings)),
        parameters=parameters,
        units=units | {variable.name: variable.unit for variable in parameters},
        origins={variable.name: f"train file {entry}" for variable in parameters if variable.name in data},
        optional=OPTIONAL,
        resolve=lambda given: central(given).parameters,
        start=start,
        describe=lambda: consist_description(nominal.source),
        outputs_of_fmu=tuple(variable.name for variable in nominal.model.outputs),
        limits=tuple(limits),
    )


def _parameters_of_train(model: Model, data: Values) -> tuple[Variable, ...]:
    """Return the data of a train that its prediction uses, then the other parameters of the prediction."""
    units = units_of_predictions()
    of_model = {ElementName.of(variable.name).array: variable.description for variable in model.parameters}
    meanings = of_model | _OF_TRAIN
    own = tuple(
        Variable(name=name, unit=units[base], description=meanings[base], start=value)
        for name, value in data.items()
        if (base := ElementName.of(name).array) in units and base in meanings
    )
    bases = {"m_group", *(ElementName.of(name).array for name in data)}
    return own + tuple(v for v in model.parameters if ElementName.of(v.name).array not in bases)
