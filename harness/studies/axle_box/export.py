"""A trained estimator as an FMU."""

from railgrip.estimators.learned.online import Edge, Online
from railgrip.fmus.native import Variable
from railgrip.fmus.native.discrete import Discrete, sources
from railgrip.fmus.native.package import Source


def as_fmu(online: Online) -> Source:
    """Return C code and modelDescription.xml of an online estimator, for `railgrip.fmus.native.package.pack`."""
    states, inputs, outputs = (
        tuple(map(_variable, edges)) for edges in (_apart(online), online.inputs, online.outputs)
    )
    return sources(
        Discrete(
            name=online.name,
            # Whoever steps it at the rate of something slower must know: a longer step holds its inputs.
            description=f"Friction between wheel and rail from accelerations of the axle boxes, {online.rate} a second",
            period=1 / online.rate,
            states=states,
            inputs=inputs,
            parameters=(),
            outputs=outputs,
            step=online.step,
        )
    )


def _apart(online: Online) -> tuple[Edge, ...]:
    """Return the states under names that no input or output has."""
    return tuple(
        Edge(name=f"memory.{edge.name}", unit=edge.unit, start=edge.start, description=edge.description)
        for edge in online.states
    )


def _variable(edge: Edge) -> Variable:
    return Variable(
        name=edge.name,
        unit=edge.unit,
        start=edge.start,
        description=edge.description,
        minimum=None,
        maximum=None,
        nominal=1.0,
    )
