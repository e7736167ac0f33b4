"""A prediction may come as a Model Exchange FMU of the user."""

from pathlib import Path

import numpy as np
import pytest
from edited_fmu import replaced, short_stop, with_description
from wrong import table

from railgrip.base.errors import ScenarioError
from railgrip.fmus.build import fmu
from railgrip.scenario.load import load
from railgrip.simulate.run import run_stop


def own(folder: Path, *edits: tuple[str, str], name: str = "TrainPrediction") -> Path:
    """Write the FMU of a recipe under another name, with an edited description."""
    return with_description(fmu(name), folder / f"Mine{name}.fmu", lambda text: replaced(text, *edits))


def estimates(scenario, notify: list[str] | None = None) -> np.ndarray:
    trace = run_stop(scenario, notify=([] if notify is None else notify).append).trace
    return np.concatenate([trace[f"estimate_{name}"].values.ravel() for name in ("speed", "adhesion", "pad_friction")])


def test_a_prediction_fmu_of_a_user_estimates_like_the_recipe(tmp_path: Path):
    """Gate and start come from the train's nominal data, which equal those of the class: rounding, over 2000 steps."""
    ours = load(Path("trapezoid"), ["limits.horizon=2 s"])
    mine = short_stop(own(tmp_path))
    np.testing.assert_allclose(estimates(mine), estimates(ours), rtol=1e-9, atol=1e-9)
    assert mine.files()[0].path.name == "MineTrainPrediction.fmu"


def test_a_parameter_of_the_fmu_may_be_changed(tmp_path: Path):
    file = own(tmp_path)
    lighter = short_stop(file, "estimator.parameters.k_primary=1 MN/m")
    assert not np.allclose(estimates(lighter), estimates(short_stop(file)), rtol=1e-3)


def test_without_directional_derivatives_differences_are_used_and_reported(tmp_path: Path):
    sentences: list[str] = []
    without = own(tmp_path, ('providesDirectionalDerivative="true"', ""))
    differences = estimates(short_stop(without), sentences)
    assert sentences == [
        "[estimator]: MineTrainPrediction.fmu offers no directional derivatives; the filter takes central differences"
    ]
    # Central differences keep two thirds of the digits of a Jacobian; the filter is stable.
    np.testing.assert_allclose(differences, estimates(load(Path("trapezoid"), ["limits.horizon=2 s"])), atol=1e-5)


def test_its_code_runs_only_with_permission_of_the_scenario(tmp_path: Path):
    with pytest.raises(ScenarioError, match=r"MineTrainPrediction.fmu would run in this process; .* set trust = true"):
        short_stop(own(tmp_path), trust=False)


@pytest.mark.parametrize(("edits", "sentence"), table(__file__, "tables.toml")["wrong_predictions"])
def test_a_prediction_fmu_with_other_variables_is_refused(tmp_path: Path, edits, sentence):
    with pytest.raises(ScenarioError, match=sentence):
        run_stop(short_stop(own(tmp_path, *edits)))
