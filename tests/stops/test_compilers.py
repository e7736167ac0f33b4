"""Plant and prediction of a stop come from the available compiler, and the result names it."""

import json
import re
from functools import cache
from pathlib import Path

from edited_fmu import with_description

from railgrip.campaign.run import find_result, run
from railgrip.fmus.build import fmu
from railgrip.scenario.campaign import PlannedStop
from railgrip.scenario.load import load
from railgrip.simulate import named_models
from railgrip.simulate.run import run_stop

THEIRS = "OpenModelica Compiler OpenModelica v1.27.0"


def test_the_fmu_estimator_uses_the_compiler_of_the_plant(tmp_path, monkeypatch):
    """FMUs of recipes are replaced by ones that declare OpenModelica as their tool."""

    @cache  # a file that is written twice contains other times, and is another file
    def relabelled(name: str) -> Path:
        tool = lambda text: re.sub(r'generationTool="[^"]*"', f'generationTool="{THEIRS}"', text)
        return with_description(fmu(name, "native"), tmp_path / f"{name}.fmu", tool)

    monkeypatch.setattr(named_models, "recipe_file", relabelled)
    short = [
        "limits.horizon=0.1 s",
        "estimator.kind=fmu",
        "estimator.model=TrainPredictionReduced",
        "estimator.noise=ideal",
    ]
    scenario = load(Path("trapezoid"), short)
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
