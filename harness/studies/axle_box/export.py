"""A trained estimator as an FMU."""

from dataclasses import replace

from railgrip.estimators.learned.online import Online
from railgrip.fmus.native.discrete import Discrete, sources
from railgrip.fmus.native.package import Source


def as_fmu(online: Online) -> Source:
    """Return C code and modelDescription.xml of an online estimator, for `railgrip.fmus.native.package.pack`."""
    # The states under names that no input or output has.
    states = tuple(replace(state, name=f"memory.{state.name}") for state in online.states)
    return sources(
        Discrete(
            name=online.name,
            # Whoever steps it at the rate of something slower must know: a longer step holds its inputs.
            description=f"Friction between wheel and rail from accelerations of the axle boxes, {online.rate} a second",
            period=1 / online.rate,
            states=states,
            inputs=online.inputs,
            parameters=(),
            outputs=online.outputs,
            step=online.step,
        )
    )
