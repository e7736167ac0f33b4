"""A Modelica class as CasADi functions, for whoever wants its equations without an FMU."""

import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from railgrip import cache
from railgrip.fmus.native.digest import compiler_digest, digest
from railgrip.fmus.native.library import LIBRARY, sources_digest

if TYPE_CHECKING:
    import casadi as ca

GROUPS = ("states", "inputs", "parameters", "outputs")
FUNCTIONS = ("derivative", "output", "initial")


@dataclass(frozen=True, slots=True, kw_only=True)
class Variable:
    """A scalar variable at the edge of a model.

    Attributes:
        name: Modelica name, such as `slip[2]`.
        unit: Modelica unit string, empty when none is declared.
        start: Start or default value, with every parameter at its default.
        nominal: 1.0 when none is declared.
    """

    name: str
    unit: str
    start: float
    description: str
    minimum: float | None
    maximum: float | None
    nominal: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Model:
    """An explicit ordinary differential equation without events.

    Attributes:
        parameters: Those that may be set; values of dependent ones are worked into the functions.
        derivative: (t, x, u, p) → dx/dt, shapes (), (nx,), (nu,), (np,) → (nx,).
        output: (t, x, u, p) → y, the variables declared `output`, in order, shape (ny,).
        initial: (p) → x at the start, shape (nx,).
    """

    class_name: str
    states: tuple[Variable, ...]
    inputs: tuple[Variable, ...]
    parameters: tuple[Variable, ...]
    outputs: tuple[Variable, ...]
    derivative: "ca.Function"
    output: "ca.Function"
    initial: "ca.Function"


def lower(class_name: str, modelica_path: Path | None = None) -> Model:
    """Return the explicit ODE of a Modelica class.

    Args:
        class_name: Full name, such as `RailBraking.FMUs.TrainPrediction`.
        modelica_path: A `.mo` file or a library's folder; RailBraking when absent.

    Raises:
        InputError: No such file or class, or Modelica has an error.
        TranslationError: The class has events, discrete variables, nonlinear loops, or what is not translated.
    """
    library = LIBRARY if modelica_path is None else Path(modelica_path)
    if not library.exists():
        return _lowered(class_name, library)  # which says so
    # Kept once it is lowered: every process of a campaign needs it.
    key = digest([class_name, sources_digest(library), compiler_digest()])
    file = cache.find("models", key, f"{class_name}.json")
    # Also the first time what was written is read, so that every process computes with the same functions.
    return _read(file or _keep(key, _lowered(class_name, library)))


def _lowered(class_name: str, modelica_path: Path) -> Model:
    # A process that finds what it needs does without rumoca and scipy's graphs, a quarter of a second of imports.
    from railgrip.fmus.native.lowering import lowered

    return lowered(class_name, modelica_path)


def _keep(key: str, model: Model) -> Path:
    content = {
        "class_name": model.class_name,
        **{group: [asdict(v) for v in getattr(model, group)] for group in GROUPS},
        **{name: getattr(model, name).serialize() for name in FUNCTIONS},
    }
    return cache.keep("models", key, f"{model.class_name}.json", json.dumps(content).encode())


def _read(file: Path) -> Model:
    import casadi as ca

    content = json.loads(file.read_text())
    states, inputs, parameters, outputs = (tuple(Variable(**v) for v in content[group]) for group in GROUPS)
    derivative, output, initial = (ca.Function.deserialize(content[name]) for name in FUNCTIONS)
    return Model(
        class_name=content["class_name"],
        states=states,
        inputs=inputs,
        parameters=parameters,
        outputs=outputs,
        derivative=derivative,
        output=output,
        initial=initial,
    )
