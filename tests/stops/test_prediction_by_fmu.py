"""The filter that evaluates a prediction FMU is the filter that has its equations compiled, in each step of a stop."""

import ctypes
from pathlib import Path

import numpy as np
import pytest

import railgrip.scenario
from railgrip.estimators.compiled import CompiledFilter
from railgrip.estimators.filters import compiled
from railgrip.estimators.prediction import CasadiPrediction
from railgrip.fmi import FmuPrediction
from railgrip.fmus.native.toolchain import shared_library
from railgrip.scenario.campaign import load_campaign
from railgrip.scenario.outcome import Outcome
from railgrip.simulate.files import lowered
from railgrip.simulate.run import run_stop

CAMPAIGN = load_campaign(Path(railgrip.scenario.__file__).parent / "campaigns" / "table1.toml")
STOPS = {stop.name: stop.scenario for stop in CAMPAIGN.stops if stop.scenario.estimator.kind == "fmu"}


class Both(ctypes.Structure):
    _fields_ = (
        *((name, ctypes.c_void_p * 2) for name in ("step", "block", "mean", "covariance", "inputs", "readings")),
        *((name, ctypes.c_longlong) for name in ("states", "width", "n_inputs", "n_readings")),
        ("largest", ctypes.c_double),
        ("steps", ctypes.c_longlong),
    )


class BothFilters(CompiledFilter):
    """The filter over an FMU which, at each step, makes the one over the equations do the same."""

    last: "BothFilters"

    def __init__(self, prediction, *arguments):
        super().__init__(prediction, *arguments)
        assert isinstance(prediction, FmuPrediction)
        model = lowered("RailBraking.Predictions.TrainPrediction")
        equations = CasadiPrediction(model, {variable.name: variable.start for variable in model.parameters})
        assert equations.states == prediction.states
        self.other = CompiledFilter(equations, *arguments)
        source = (Path(__file__).parent / "both_filters.c").read_text()
        exported = '__attribute__((visibility("default"))) int step_both'
        library = shared_library({"both.c": source.replace("int step_both", exported)}, "both")
        self.both_library = ctypes.CDLL(str(library))
        BothFilters.last = self

    @property
    def entry(self):
        step, block, squared = super().entry
        other_step, other_block, _ = self.other.entry
        self.both = both = Both(states=self.mean.size, n_inputs=self.inputs.size, n_readings=self.readings.size)
        both.width = self.covariance.strides[0] // self.covariance.itemsize
        both.step[:], both.block[:] = (step, other_step), (block, other_block)
        for name in ("mean", "covariance", "inputs", "readings"):
            getattr(both, name)[:] = [getattr(of, name).ctypes.data for of in (self, self.other)]
        return ctypes.cast(self.both_library.step_both, ctypes.c_void_p).value, ctypes.addressof(both), squared


def test_table_1_predicts_with_fmus():
    """Every stop whose controller needs an estimate, or takes one: five controllers, three rails, two outfits."""
    assert len(STOPS) == 30
    assert {stop.scenario.estimator.kind for stop in CAMPAIGN.stops} == {"none", "fmu"}


@pytest.mark.parametrize("name", STOPS)
def test_each_step_is_that_of_the_compiled_filter(name, monkeypatch):
    monkeypatch.setattr(compiled, "CompiledFilter", BothFilters)
    stop = run_stop(STOPS[name])
    both = BothFilters.last.both
    assert stop.outcome is Outcome.STANDSTILL
    period = STOPS[name].periods.estimator
    assert both.steps == pytest.approx(float(stop.trace["time"][-1]) / period, abs=1.5)
    # The same expressions, differentiated and ordered by two code generators: rounding, of some hundred operations.
    assert both.largest < 1e-12
    assert np.isfinite(both.largest)
