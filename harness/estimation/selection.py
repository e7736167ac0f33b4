"""A prediction that shows only some of its outputs: a filter for fewer sensors."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import casadi as ca

from railgrip.errors import EstimationError
from railgrip.estimation.run import model_of
from railgrip.estimators.prediction import CasadiPrediction


def prediction_seeing(
    model: str, outputs: Sequence[str], parameters: Mapping[str, float] | None = None
) -> CasadiPrediction:
    """Return the prediction of a class of RailBraking.FMUs that is compared with `outputs` only, in that order.

    Args:
        model: Such as `TrainPredictionReduced`.
        outputs: By name, `wheelset_speed` for all its elements.
        parameters: Where they differ from the defaults, SI.

    Raises:
        EstimationError: There is no such output or parameter.
    """
    whole = model_of(model)
    names = [variable.name for variable in whole.outputs]
    places = [i for output in outputs for i, name in enumerate(names) if output in (name, name.partition("[")[0])]
    missing = [output for output in outputs if not any(output in (n, n.partition("[")[0]) for n in names)]
    if missing:
        raise EstimationError(f"{model} has no output {', '.join(missing)}; it has {', '.join(names)}.")
    arguments = [ca.SX.sym(f"a{i}", *whole.output.size_in(i)) for i in range(whole.output.n_in())]
    selection = ca.Function("output", arguments, [ca.densify(whole.output(*arguments))[places]])
    defaults = {variable.name: variable.start for variable in whole.parameters}
    strange = [name for name in parameters or {} if name not in defaults]
    if strange:
        raise EstimationError(f"{model} has no parameter {', '.join(strange)}; it has {', '.join(defaults)}.")
    seeing = replace(whole, outputs=tuple(whole.outputs[i] for i in places), output=selection)
    return CasadiPrediction(seeing, defaults | dict(parameters or {}))
