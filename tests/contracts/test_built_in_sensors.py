"""The contract of built-in sensors: a new kind in `railgrip.simulate.sensors` fails here until it is complete."""

from functools import cache

import numpy as np
import pytest

import railgrip as rg
from railgrip.base import registry
from railgrip.scenario.load import read_toml
from railgrip.scenario.onboard import SensorModel
from railgrip.vehicle.signals import READINGS

KINDS = {name: registry.part(registry.SENSORS, name, SensorModel) for name in registry.modules(registry.SENSORS)}
FILES = [*registry.shelf("equipment").values(), *registry.shelf("scenarios").values()]
FOR_PLAIN = {"white": {"kind": "white", "noise": {"speed": "0.1 m/s"}, "bias": {"acceleration": "0.05 m/s**2"}}}
"""Tables for the train of `plain`, of kinds that the package has only with quantities of other trains."""


@pytest.mark.parametrize("kind", KINDS)
def test_each_kind_has_a_file_with_its_keys(kind):
    assert tables_of(kind), (
        f"no file has [sensors] kind = '{kind}': add harness/scenario/equipment/{kind}.toml with values and their "
        "reasons, so that users need not find all of them"
    )


@pytest.mark.parametrize("kind", KINDS)
def test_each_kind_reads_the_train_repeatably_and_does_not_change_it(kind):
    trace, again = braked(kind), braked.__wrapped__(kind)
    for signal in READINGS:
        name = signal.name
        if name not in trace:
            continue  # the train does not have it
        values = trace[name].values
        assert np.isfinite(values).any(axis=0).all(), f"{kind}: {name} is never finite"
        np.testing.assert_array_equal(
            values, again[name].values, f"{kind}: take random numbers from the scenario's seed, by `self.random`"
        )
    truth = braked("ideal")
    for name in ("speed", "wheelset_speed", "acceleration", "cylinder_pressure"):
        np.testing.assert_array_equal(
            trace[name].values, truth[name].values, f"{kind} changes the true {name} of a train without controller"
        )


def tables_of(kind):
    """Return the tables of [sensors] of this kind in the package."""
    tables = [read_toml(path).get("sensors", {}) for path in FILES]
    return [table for table in tables if table.get("kind") == kind]


@cache
def braked(kind):
    """Return the trace of the first 0.3 s of full braking on `plain` under these sensors."""
    changes = {"estimator": {"kind": "none"}, "controller": {"kind": "full_brake"}, "limits.horizon": 0.3}
    (table, *_) = [FOR_PLAIN[kind]] if kind in FOR_PLAIN else [*tables_of(kind), {"kind": kind}]
    try:
        return rg.run(rg.Scenario.load("plain", {**changes, "sensors": table})).trace
    except rg.ScenarioError as problem:
        pytest.fail(f"add a table for '{kind}' that fits the scenario plain to FOR_PLAIN: {problem}")
