"""Plant and prediction of a stop come from the available compiler, and the result names it."""

import json
import re
from functools import cache
from pathlib import Path

import pytest
from edited_fmu import with_description

import railgrip.scenario
from railgrip.campaign.run import find_result, run
from railgrip.fmus.build import fmu
from railgrip.report.stop import read_stop
from railgrip.scenario.campaign import PlannedStop
from railgrip.scenario.load import load
from railgrip.simulate import named_models
from railgrip.simulate.run import run_stop

TRAPEZOID = Path(railgrip.scenario.__file__).parent / "library" / "trapezoid.toml"
THEIRS = "OpenModelica Compiler OpenModelica v1.27.0"


@pytest.fixture
def from_openmodelica(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Replace the FMUs of recipes by ones that declare OpenModelica as their tool."""

    @cache  # a file that is written twice contains other times, and is another file
    def relabelled(name: str) -> Path:
        tool = lambda text: re.sub(r'generationTool="[^"]*"', f'generationTool="{THEIRS}"', text)
        return with_description(fmu(name, "native"), tmp_path / f"{name}.fmu", tool)

    monkeypatch.setattr(named_models, "recipe_file", relabelled)


@pytest.mark.usefixtures("from_openmodelica")
def test_the_fmu_estimator_uses_the_compiler_of_the_plant(tmp_path, monkeypatch):
    short = [
        "limits.horizon=0.1 s",
        "estimator.kind=fmu",
        "estimator.model=TrainPredictionReduced",
        "estimator.noise=ideal",
    ]
    scenario = load(TRAPEZOID, short)
    out = tmp_path / "stop"
    run(scenario, out, run_stop)
    content = json.loads((out / "stop.json").read_text())
    assert content["versions"]["TwoPartTrain.fmu"] == THEIRS
    assert content["versions"]["TrainPredictionReduced.fmu"] == THEIRS
    assert set(content["fmus"]) == {"TwoPartTrain.fmu", "TrainPredictionReduced.fmu"}

    stop = PlannedStop(name="one", variants={}, scenario=scenario)
    monkeypatch.setattr("railgrip.campaign.run.choose", lambda compiler: "openmodelica")
    assert find_result(stop, out) is not None
    monkeypatch.setattr("railgrip.campaign.run.choose", lambda compiler: "native")
    assert find_result(stop, out) is None, "distances from OpenModelica's FMUs are not ours"


def test_fmus_of_the_built_in_compiler_are_also_named(tmp_path):
    short = ["limits.horizon=0.1 s", "estimator.kind=none", "controller.kind=full_brake"]
    run(load(TRAPEZOID, short), tmp_path, run_stop)
    versions = read_stop(tmp_path).versions
    assert (
        versions["TwoPartTrain.fmu"] == named_models.description_of(named_models.recipe_file("TwoPartTrain")).generator
    )
