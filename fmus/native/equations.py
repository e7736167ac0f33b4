"""A Modelica class as CasADi functions, for whoever wants its equations without an FMU."""

from pathlib import Path

from railgrip import cache
from railgrip.fmus.native.digest import compiler_digest, digest
from railgrip.fmus.native.library import LIBRARY, sources_digest
from railgrip.fmus.native.model import Model


def lower(class_name: str, modelica_path: Path | None = None) -> Model:
    """Return the explicit ODE of a Modelica class, from the user's cache once it was lowered.

    Args:
        class_name: Full name, such as `RailBraking.FMUs.TrainPrediction`.
        modelica_path: A `.mo` file or a library's folder; RailBraking when absent.

    Raises:
        InputError: No such file or class, or Modelica has an error.
        TranslationError: The class has events, discrete variables, nonlinear loops, or what is not translated.
    """
    library = LIBRARY if modelica_path is None else Path(modelica_path)
    if not library.exists():
        return _translation(class_name, library)  # which says so
    key, name = digest([class_name, sources_digest(library), compiler_digest()]), f"{class_name}.json"
    file = cache.find("models", key, name)
    if file is None:
        file = cache.keep("models", key, name, _translation(class_name, library).to_bytes())
    # Also the first time the file is read, so that every process computes with the same functions.
    return Model.from_bytes(file.read_bytes())


def _translation(class_name: str, library: Path) -> Model:
    # A process that finds what it needs does without rumoca and scipy's graphs, a quarter of a second of imports.
    from railgrip.fmus.native.dae import read
    from railgrip.fmus.native.lowering import model_of
    from railgrip.fmus.native.system import explicit

    return model_of(explicit(read(class_name, library)))
