"""The equations of a Modelica class as CasADi functions, without an FMU."""

from pathlib import Path

from railgrip.base import cache
from railgrip.fmus.native import separate_process
from railgrip.fmus.native.library import (
    LIBRARY,
    compiler_digest,
    digest,
    is_trusted,
    require_class_name,
)
from railgrip.fmus.native.model import Model
from railgrip.fmus.native.used_libraries import uses_digest


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
    from railgrip.fmus.native.lowering import model_of
    from railgrip.fmus.native.system import explicit

    return model_of(explicit(read(class_name, library))).to_bytes().decode()
