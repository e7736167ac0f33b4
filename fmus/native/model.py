"""The explicit ODE of a Modelica class as CasADi functions: the result of lowering, stored in the user's cache."""

import json
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

from railgrip.base.system import Variable

if TYPE_CHECKING:
    import casadi as ca

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

        fields: dict[str, Any] = json.loads(content)
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
