"""The Python interface and the command give the same answer to the same recording."""

import warnings
from pathlib import Path

import numpy as np
import pytest
from test_recording_agreement import changed, times, wagon, written
from typer.testing import CliRunner

import railgrip as rg
from railgrip.base.errors import EstimateWarning, InputError
from railgrip.cli.app import app
from railgrip.scenario.file import inline_toml


def answer_of_command(arguments):
    """Return the exit code of a command, 2 for a refusal, and what it prints or refuses with."""
    result = CliRunner().invoke(app, arguments)
    if isinstance(result.exception, InputError):
        return 2, str(result.exception)
    return result.exit_code, result.output


def answer_of_python(folder: Path, changes):
    """Return 0, 2 for an exception, 3 for a warning that the estimates are not to be used, and the sentences."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            estimates = rg.estimate(folder / "run.csv", folder / "run.toml", changes)
        except InputError as refusal:
            return 2, str(refusal)
    issued = [str(each.message) for each in caught if each.category is EstimateWarning]
    assert bool(issued) == bool(estimates.attrs["problems"])
    return (3 if issued else 0), "\n".join([*issued, estimates.attrs["warnings"], estimates.attrs["repairs"]])


def missing(share):
    def change(time, values):
        values = values.copy()
        values[np.random.default_rng(1).random(values.size) < share] = np.nan
        return values

    return change


FAULTS = {
    "none": ("", None, {}),
    "a start of 35": ("", None, {"start.mean": {"mu_b": 35.0, "alpha": 0.0}}),
    "an adhesion of 2 that is known": ("", None, {"start.mean": {"mu_b": 0.35, "alpha": 2.0},
                                                  "start.deviation.alpha": 1e-6, "noise.process.alpha": 0.0}),
    "speed in another unit": ("speed", times(1 / 3.6), {}),
    "the same, accepted": ("speed", times(1 / 3.6), {"data.contradictions": "warn"}),
    "speed of the other sign": ("speed", times(-1.0), {"data.contradictions": "warn"}),
    "98 % of the speed missing": ("speed", missing(0.98), {}),
    "98 % of all wheelset speeds missing": ("wheelset_speed", missing(0.98), {}),
    "all of a pressure missing": ("pad_force[1]", missing(2.0), {}),
    "forces a hundred times too large": ("pad_force", times(100.0), {"data.contradictions": "warn"}),
    "infinite noise": ("", None, {"noise.readings.speed": 1e30}),
    "an unknown parameter": ("", None, {"model.parameters": {"masss": 3}}),
}  # fmt: skip


@pytest.mark.usefixtures("blank_figures")
@pytest.mark.parametrize("fault", FAULTS)
def test_estimate_and_its_command_agree(tmp_path, fault):
    """Code 2 is an exception and code 3 a warning, and each problem that one states is stated by the other."""
    base, change, changes = FAULTS[fault]
    signals = wagon() if change is None else changed(wagon(), base, change)
    arguments = written(tmp_path, signals)
    options = [f"--set={key}={inline_toml(value)}" for key, value in changes.items()]
    code, text = answer_of_command([*arguments, *options])
    found, sentences = answer_of_python(tmp_path, changes)
    assert found == code, f"{text}\n{sentences}"
    for line in sentences.splitlines():
        assert "".join(line.split()) in "".join(text.split())
    assert code == 0 or fault != "none"
