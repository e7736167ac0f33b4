"""Every input and output of an FMU as a signal of its own."""

from railgrip.fmi import Binding, Description, Port, bind


def bind_all(description: Description) -> Binding:
    """Bind the inputs and outputs of a description, in its units."""
    inputs, outputs = (
        [Port(name=n, unit=description.variables[n].unit or "1", size=0, needed=True) for n in description.names(side)]
        for side in ("input", "output")
    )
    return bind(description, inputs=inputs, outputs=outputs)
