"""The explicit ODE of a Modelica class as CasADi functions, without an FMU; results are stored in the user's cache.

CasADi and the front end are imported where they are needed: with a cached result this saves a quarter of a second.
"""

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from railgrip.base import cache
from railgrip.base.errors import TranslationError
from railgrip.base.system import Variable
from railgrip.base.tables import JsonObject
from railgrip.fmus.native import separate_process
from railgrip.fmus.native.library import (
    LIBRARY,
    compiler_digest,
    digest,
    is_trusted,
    require_class_name,
    uses_digest,
)

if TYPE_CHECKING:
    import casadi as ca

    from railgrip.fmus.native.arrays import SX
    from railgrip.fmus.native.system import System
    from railgrip.fmus.native.variables import Scalar

GROUPS = ("states", "inputs", "parameters", "outputs")
FUNCTIONS = ("derivative", "output", "initial")


@dataclass(frozen=True, slots=True, kw_only=True)
class Model:
    """An explicit ordinary differential equation without events.

    Attributes:
        parameters: Parameters that may be set; dependent ones are substituted in the functions.
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

    @classmethod
    def from_bytes(cls, content: bytes) -> "Model":
        """Return the model that `to_bytes` wrote."""
        import casadi as ca

        fields: JsonObject = json.loads(content)
        fields.update({group: tuple(Variable(**v) for v in fields[group]) for group in GROUPS})
        fields.update({name: ca.Function.deserialize(fields[name]) for name in FUNCTIONS})
        return cls(**fields)

    def to_bytes(self) -> bytes:
        """Return the model as JSON, with its functions as serialised by CasADi."""
        content = {
            "class_name": self.class_name,
            **{group: [asdict(v) for v in getattr(self, group)] for group in GROUPS},
            **{name: getattr(self, name).serialize() for name in FUNCTIONS},
        }
        return json.dumps(content).encode()


def lower(class_name: str, modelica_path: Path | None = None) -> Model:
    """Return the explicit ODE of a Modelica class, from the user's cache if it has been lowered before.

    Args:
        class_name: Full name, such as `RailBraking.Predictions.TrainPrediction`.
        modelica_path: A `.mo` file or a library's folder; RailBraking when absent.

    Raises:
        InputError: The file or class is missing, or Modelica has an error.
        TranslationError: The class has events, discrete variables, nonlinear loops, or another unsupported form.
    """
    require_class_name(class_name)
    library = LIBRARY if modelica_path is None else Path(modelica_path)
    if not library.exists():
        lower_here(class_name, library)  # raises the error for a missing file, before anything reads it
    key, name = digest([class_name, uses_digest(library, (), class_name), compiler_digest()]), f"{class_name}.json"
    file = cache.find("models", key, name)
    if file is None:
        with cache.one_maker("models", key, class_name.rpartition(".")[2]):
            file = cache.find("models", key, name)
            if file is None:
                if is_trusted(library):
                    text = lower_here(class_name, library)
                else:
                    text = separate_process.call("lower", class_name, library)
                file = cache.keep("models", key, name, text.encode())
    # The file is read even if it has just been written, so that every process computes with the same functions.
    return Model.from_bytes(file.read_bytes())


def lower_here(class_name: str, library: Path) -> str:
    """Return the text of `Model.to_bytes` for a class, translated in this process; errors are those of `lower`."""
    # Imported here: with a cached result the imports of rumoca and scipy's graphs, a quarter of a second, are avoided.
    from railgrip.fmus.native.dae import read
    from railgrip.fmus.native.system import explicit

    return model_of(explicit(read(class_name, library))).to_bytes().decode()


def model_of(system: "System") -> Model:
    """Return a system as a plain differential equation.

    Raises:
        TranslationError: It has events, discrete variables or nonlinear loops.
    """
    import casadi as ca

    from railgrip.fmus.native.system import column
    from railgrip.fmus.native.variables import vector

    unsupported = {
        "relations that cause events (write noEvent(...) or smooth(...))": system.relation.numel(),
        "discrete variables": system.d.numel(),
        "time events": system.instants.numel() + len(system.clocks),
        "nonlinear algebraic loops": len(system.loops.guesses) + len(system.start_loops.guesses),
    }
    parts = [f"{count} {what}" for what, count in unsupported.items() if count]
    if parts:
        raise TranslationError(f"{system.class_name} is not a plain differential equation: it has {', '.join(parts)}.")
    v = system.variables
    free = vector(v.free)
    arguments = [system.time, system.x, system.u, free]
    # In one column, because each substitution has a fixed cost.
    values = column([system.derivative, output_values(system), system.start])
    if v.dependent:
        values = ca.substitute(values, vector(v.dependent), column(v.dependent_values))
    nx, ny = len(system.states), len(output_scalars(system))
    names = ["t", "x", "u", "p"]
    return Model(
        class_name=system.class_name,
        states=_variables(system.states),
        inputs=_variables(v.inputs),
        parameters=_variables(v.free),
        outputs=_variables(output_scalars(system)),
        derivative=ca.Function("derivative", arguments, [values[:nx]], names, ["dx"]),
        output=ca.Function("output", arguments, [values[nx : nx + ny]], names, ["y"]),
        initial=ca.Function("initial", [free], [values[nx + ny :]], ["p"], ["x"]),
    )


def output_scalars(system: "System") -> "list[Scalar]":
    """Return the variables declared `output`, in declaration order."""
    every = [s for scalars in system.variables.of_id.values() for s in scalars]
    return [s for s in every if s.causality == "output"]


def output_values(system: "System") -> "SX":
    """Return the expressions of `output_scalars`."""
    from railgrip.fmus.native.system import column

    expressions = {s.name: s.symbol for s in [*system.states, *system.variables.discretes]}
    expressions |= {s.name: system.algebraic[i] for i, s in enumerate(system.algebraics)}
    return column([expressions[s.name] for s in output_scalars(system)])


def _variables(scalars: "Sequence[Scalar]") -> tuple[Variable, ...]:
    return tuple(
        Variable(
            name=s.name,
            unit=s.attributes.get("unit") or "",
            start=s.start,
            description=s.attributes.get("description") or "",
            minimum=s.bounds.get("minimum"),
            maximum=s.bounds.get("maximum"),
            nominal=s.bounds.get("nominal") or 1.0,
        )
        for s in scalars
    )
