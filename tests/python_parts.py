"""A stop whose plant, filter and law run in Python instead of C must be bit-identical."""

from dataclasses import replace

from railgrip.simulate.assembly import assemble
from railgrip.simulate.loop.interfaces import StateEstimator
from railgrip.simulate.run import run_stop


class _Plant:
    def __init__(self, plant):
        self.start, self.step = plant.start, plant.step


class _Filter:
    def __init__(self, own):
        self.mean, self.covariance, self.advance = own.mean, own.covariance, own.advance
        self.inputs, self.readings, self.selection, self._own = own.inputs, own.readings, own.selection, own

    @property
    def squared_innovation(self):
        return self._own.squared_innovation


class _Law:
    def __init__(self, law):
        self.decide = law.decide


def hidden(parts):
    """Return parts of which the loop calls only its own in C."""
    estimator = parts.estimator
    if isinstance(estimator, StateEstimator):
        estimator = replace(estimator, filter=_Filter(estimator.filter))
    return replace(parts, plant=_Plant(parts.plant), estimator=estimator, controller=_Law(parts.controller))


def run_in_python(scenario):
    """Return the stop of a scenario with its C parts hidden."""
    with assemble(scenario) as whole:
        whole = replace(whole, parts=hidden(whole.parts))
        return whole.stop(whole.run())


def same_stop(scenario):
    """Return the stop with parts in C, after checking that parts in Python give identical bits."""
    one, other = (run(scenario) for run in (run_stop, run_in_python))
    assert (one.outcome, one.reason) == (other.outcome, other.reason)
    assert list(one.trace.data_vars) == list(other.trace.data_vars)
    for name, values in one.trace.data_vars.items():
        assert values.values.tobytes() == other.trace[name].values.tobytes(), name
    return one
