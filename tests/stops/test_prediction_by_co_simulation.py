"""A filter whose prediction FMU integrates itself estimates like one that integrates the prediction.

Papers 000 and 001 cite the former, by Brembeck et al. (2014).
"""

import os
import re
import signal
import subprocess
import sys
import zipfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from edited_fmu import replaced, short_stop, with_description, with_own_prediction
from sampling import sample
from table_1 import table_1_scenario
from waiting import LONGEST, until

from railgrip.base.errors import FmuError, ScenarioError
from railgrip.fmi import describe
from railgrip.fmus.native import package
from railgrip.report.stop import Stop
from railgrip.scenario.load import load
from railgrip.scenario.outcome import Outcome
from railgrip.simulate.named_models import prediction_description
from railgrip.simulate.run import run_stop

STEPPED = "estimator.interface=co_simulation"
ESTIMATES = ("estimate_speed", "estimate_adhesion", "estimate_slip", "estimate_pad_friction")


def largest_difference(one: Stop, other: Stop) -> float:
    return max(float(np.nanmax(np.abs(one.trace[name].values - other.trace[name].values))) for name in ESTIMATES)


@pytest.mark.parametrize(
    "stop", sample(["trapezoid-ideal", "sine_sweep-ideal", "random-ideal", "trapezoid-service"], 2)
)
def test_estimates_and_distances_of_table_1_are_those_by_model_exchange(stop: str):
    """Over a whole stop. In a step of 1 ms RK4 and the solver of the FMU differ by rounding; 1e-6 is what papers need.

    The distance follows from the estimates through a continuous law; 1 mm is a thousandth of what a figure shows.
    """
    by_model_exchange = table_1_scenario(f"{stop}-adhesion_based")
    stepped = by_model_exchange.revised({"estimator": {"interface": "co_simulation"}})
    stops = [run_stop(scenario) for scenario in (by_model_exchange, stepped)]
    assert largest_difference(*stops) < 1e-6
    assert stops[1].metrics.distance == pytest.approx(stops[0].metrics.distance, abs=1e-3)


def own(folder: Path, *edits: tuple[str, str]) -> Path:
    """Write the FMU of TrainPrediction for Co-Simulation alone, with an edited description."""

    def stepped_only(text: str) -> str:
        stepped, count = re.subn(r"  <ModelExchange .*?</ModelExchange>\n", "", text, flags=re.DOTALL)
        assert count == 1
        return replaced(stepped, *edits)

    source = prediction_description("TrainPrediction", None, "me_cs").file
    file = with_description(source, folder / "Mine.fmu", stepped_only)
    assert describe(file).model_exchange is None
    return file


@pytest.mark.parametrize(("edits", "tolerance"), [((), 1e-6), ((('providesDirectionalDerivative="true"', ""),), 1e-4)])
def test_a_prediction_of_a_user_may_integrate_itself(tmp_path: Path, edits, tolerance: float):
    """Differences give the Jacobian of the step, which tests/fmi/test_stepped_prediction.py compares with that of its
    variational equations.

    Directional derivatives are those of its start: the load of a wheelset, by which adhesion acts on its speed, changes
    by 2e-4 of itself in a millisecond, and so do gains at the beginning of a stop.
    """
    sentences: list[str] = []
    mine = run_stop(short_stop(own(tmp_path, *edits), STEPPED), notify=sentences.append)
    ours = run_stop(load(Path("trapezoid"), ["limits.horizon=2 s"]))
    assert largest_difference(mine, ours) < tolerance
    missing = "[estimator]: Mine.fmu offers no directional derivatives; the filter takes central differences"
    assert sentences == ([missing] if edits else [])


def test_a_prediction_for_co_simulation_alone_needs_the_key(tmp_path: Path):
    with pytest.raises(ScenarioError, match=r"Mine\.fmu offers only Co-Simulation; set interface = 'co_simulation'"):
        run_stop(short_stop(own(tmp_path)))


HOSTILE = """
    static int steps = 0;
    const char *hostile = getenv("HOSTILE");
    if (hostile && ++steps > 2000) {
        fclose(fopen(getenv("HOSTILE_MARK"), "w"));
        if (*hostile == 'n') { s->v[X + 2] = NAN; return fmi2OK; }
        if (*hostile == 's') *(volatile int *)0 = 1;
        if (*hostile == 'a') abort();
        if (*hostile == 'x') exit(0);
        while (*hostile == 'l');
        return (fmi2Status)(*hostile - '0');
    }
"""
"""Statements of fmi2DoStep, which is called some ten times before the stop, and 26 times in each period."""


@pytest.fixture(scope="module")
def source() -> package.Source:
    with zipfile.ZipFile(prediction_description("TrainPrediction", None, "me_cs").file) as archive:
        names = [name.removeprefix("sources/") for name in archive.namelist() if name.startswith("sources/")]
        files = {name: archive.read(f"sources/{name}").decode() for name in names}
        xml = archive.read("modelDescription.xml").decode()
    return package.Source.of("RailBraking_Predictions_TrainPrediction", files, xml)


def test_a_prediction_by_fmi_3_is_refused_by_either_interface(source: package.Source, tmp_path: Path):
    """By the key of Model Exchange, too, which would propose the other interface."""
    file = package.pack(package.as_fmi_3(source), tmp_path / "Mine.fmu")
    for changes in ([], [STEPPED]):
        with pytest.raises(FmuError, match=r"by FMI 2\.0, this is FMI 3\.0; export it as FMI 2\.0"):
            run_stop(short_stop(file, *changes))


@pytest.fixture(scope="module")
def hostile(source: package.Source, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A scenario whose prediction misbehaves as the environment variable HOSTILE says."""
    before, name = "    (void)no_set_state;\n", "cosimulation.c"
    text = "#include <stdio.h>\n#include <stdlib.h>\n" + replaced(source.files[name], (before, before + HOSTILE))
    changed = replace(source, files=source.files | {name: text})
    return with_own_prediction(package.pack(changed, tmp_path_factory.mktemp("hostile") / "Mine.fmu"))


@pytest.mark.parametrize(
    ("behaviour", "sentence"),
    [
        ("2", "Mine.fmu: fmi2DoStep returned fmi2Discard (evaluating the prediction)"),
        ("3", "Mine.fmu: fmi2DoStep returned fmi2Error (evaluating the prediction)."),
        ("4", "Mine.fmu: fmi2DoStep returned fmi2Fatal (evaluating the prediction)."),
        ("5", "Mine.fmu: fmi2DoStep returned fmi2Pending, and asynchronous FMUs are not supported"),
        ("7", "Mine.fmu: fmi2DoStep returned a number that is no fmi2Status (7, evaluating the prediction)."),
        ("n", "Mine.fmu: output 'der(w[2])' is not a finite number (a prediction)."),
    ],
)
def test_a_step_that_fails_ends_the_stop_as_diverged(hostile: Path, monkeypatch, behaviour: str, sentence: str):
    monkeypatch.setenv("HOSTILE", behaviour)
    monkeypatch.setenv("HOSTILE_MARK", os.devnull)
    stop = run_stop(load(hostile, [STEPPED]))
    assert stop.outcome is Outcome.DIVERGED
    assert stop.reason.startswith(sentence)
    assert 0.05 < stop.metrics.duration < 3.0


@pytest.mark.skipif(sys.platform != "linux", reason="needs POSIX signals")
@pytest.mark.parametrize(
    ("behaviour", "code", "sentence"),
    [
        ("s", -signal.SIGSEGV, "Mine.fmu crashed, or ended the program, into which trust = true loads it"),
        ("a", -signal.SIGABRT, "Mine.fmu crashed, or ended the program"),
        ("x", 3, "Mine.fmu crashed, or ended the program"),
        ("l", 128 + signal.SIGINT, "Interrupted: Mine.fmu does not return, so the program ends at once."),
    ],
)
def test_a_prediction_that_ends_or_holds_the_program_is_named(hostile: Path, tmp_path: Path, behaviour, code, sentence):
    mark = tmp_path / "mark"
    with subprocess.Popen(
        [sys.executable, "-m", "railgrip", "run", hostile, "--set", STEPPED, "--out", tmp_path / "out"],
        stderr=subprocess.PIPE, text=True, env=os.environ | {"HOSTILE": behaviour, "HOSTILE_MARK": str(mark)},
    ) as process:  # fmt: skip
        until(mark.exists)
        if behaviour == "l":
            process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=LONGEST)
    assert process.returncode == code
    assert sentence in errors
    assert "Traceback" not in errors
