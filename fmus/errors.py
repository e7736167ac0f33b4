"""What can go wrong on the way from Modelica to an FMU, each a sentence for the person who asked."""


class FmuError(Exception):
    """Base of every error of this room; `exit_code` is what the command line answers with."""

    exit_code = 3


class WrongQuestion(FmuError):
    """The request itself cannot be answered: an unknown recipe, a class that does not compile."""

    exit_code = 2


class Refused(WrongQuestion):
    """A Modelica construct the built-in compiler does not translate; names construct, file and line."""


class CompilerMissing(FmuError):
    """No C compiler (or no OpenModelica) on this machine."""


class BuildFailed(FmuError):
    """A tool that should have worked did not."""
