"""Trains in files, and the library of the guide, stop with OpenModelica's FMUs as with ours. Needs omc on the PATH."""

import shutil
from pathlib import Path

import pytest

import railgrip.scenario
from railgrip.report.baseline import ACROSS_COMPILERS
from railgrip.report.results import OURS, makers
from railgrip.scenario.load import load, scenario_of
from railgrip.scenario.outcome import Outcome
from railgrip.simulate import files
from railgrip.simulate.run import run_stop

EXAMPLES = Path(__file__).parents[2] / "docs" / "examples"
TRAINS = sorted(path.stem for path in (Path(railgrip.scenario.__file__).parent / "trains").glob("*.toml"))

pytestmark = [
    pytest.mark.omc,
    pytest.mark.skipif(shutil.which("omc") is None, reason="OpenModelica's omc is not on the PATH"),
]


def dry(vehicle):
    """A full brake on a dry rail, from 85 km/h."""
    table = load(Path("plain")).resolved()
    table |= {
        "vehicle": vehicle,
        "start": {"speed": "85 km/h"},
        "estimator": {"kind": "none"},
        "controller": {"kind": "full_brake"},
    }
    table["adhesion"]["mu0"] = 0.5
    return scenario_of(table, directory=EXAMPLES, origin="dry")


@pytest.mark.parametrize(
    "vehicle",
    [
        *(pytest.param({"train": name}, id=name) for name in TRAINS),
        pytest.param({"model": "SimpleTrain.FreightTrain", "library": "SimpleTrain/package.mo"}, id="SimpleTrain"),
    ],
)
def test_a_dry_stop_is_as_long_with_the_fmu_of_either_compiler(vehicle, monkeypatch):
    distances: dict[str, float] = {}
    for compiler in ("native", "openmodelica"):
        monkeypatch.setattr("railgrip.fmus.build.choose", lambda wanted, compiler=compiler: compiler)
        for kept in (files._train_file, files._class_file):
            kept.cache_clear()
        stop = run_stop(dry(vehicle))
        assert stop.outcome is Outcome.STANDSTILL, stop.reason
        (tool,) = makers(stop.versions).values()
        assert tool.startswith(OURS) == (compiler == "native")
        distances[compiler] = stop.metrics.distance
    assert distances["openmodelica"] == pytest.approx(distances["native"], rel=ACROSS_COMPILERS)
