"""The choice of the loop; apart from `assemble`, so that a command line can offer it without loading the parties."""

from enum import StrEnum


class Engine(StrEnum):
    """What steps the parties of a stop; the stop is the same."""

    AUTO = "auto"
    """C where every party allows it, else Python."""
    PYTHON = "python"
    COMPILED = "compiled"
