"""For any arguments of the public API, the only exception is a RailgripError with a sentence."""

import os

import numpy as np
import pytest
import xarray
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from wrong import answered

import railgrip as rg

pytestmark = pytest.mark.filterwarnings("ignore::RuntimeWarning", "ignore::UserWarning")


class Hostile:
    """Fails on every access, as an object of a user's half-finished class may."""

    __hash__ = None

    def _fail(self, *arguments):
        raise RuntimeError("not that")

    __array__ = __repr__ = __str__ = __len__ = __iter__ = __float__ = __eq__ = __bool__ = __fspath__ = __call__ = _fail
    __deepcopy__ = __reduce__ = _fail


class HostileMapping(dict):
    def items(self):
        raise RuntimeError("not that")

    keys = __iter__ = items


class Exits:
    def __init__(self):
        raise SystemExit(0)


class Silent(Exception):
    def __str__(self):
        raise RuntimeError("no text either")


class Raises:
    def __init__(self):
        raise Silent


endless = []
endless.append(endless)
leaves = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(),
    st.floats(),
    st.complex_numbers(),
    st.text(max_size=8),
    st.binary(max_size=8),
    st.sampled_from([10**400, -1, 0, "\0", "trapezoid", "wagon", "x" * 5000, ".", "start.speed", "a..b", "a." * 900]),
    st.sampled_from([object(), Exits, Raises, len, int, type, np.ma.masked]),
    st.builds(Hostile),  # created again: Hypothesis inspects the objects that it samples from
    st.builds(lambda: HostileMapping(a=1)),
    st.just(0).map(lambda _: Hostile),
    st.sampled_from([np.float64(3), np.array([1 + 1j]), np.zeros((0, 3)), xarray.Dataset()]),
    st.builds(lambda: endless),
)
anything = st.recursive(
    leaves,
    lambda inner: st.one_of(
        st.lists(inner, max_size=3),
        st.dictionaries(st.one_of(st.text(max_size=5), st.integers(), st.just("start.speed")), inner, max_size=2),
        st.tuples(inner),
    ),
    max_leaves=4,
)
some = settings(
    max_examples=int(os.environ.get("RAILGRIP_FUZZ", "10")), deadline=None, suppress_health_check=[HealthCheck.too_slow]
)


@pytest.fixture(scope="module")
def scenario():
    return rg.Scenario.load("trapezoid", {"limits.horizon": "0.1 s", "controller.kind": "full_brake"})


@some
@given(source=anything, changes=anything)
def test_scenarios_of_any_arguments(source, changes):
    answered(lambda: rg.Scenario.load(source))
    answered(lambda: rg.Scenario.load("trapezoid", changes))
    answered(lambda: rg.Scenario.load("trapezoid").with_plant(source))
    answered(lambda: rg.Scenario.load("trapezoid").replaced(source))


@some
@given(one=anything, name=st.sampled_from(["controller", "estimator", "sensors", "plant", "import_from"]))
def test_runs_of_any_arguments(scenario, one, name):
    answered(lambda: rg.run(one))
    answered(lambda: rg.run(scenario, **{name: one}))
    if name != "controller":
        answered(lambda: rg.open(scenario, **{name: one}).reset())


@pytest.mark.parametrize("folder", [3, None, [1], b"x", "a\0b"])
def test_a_stop_is_written_to_a_path(scenario, folder):
    with pytest.raises(rg.RailgripError, match=r"directory is|is not a path"):
        rg.run(scenario).write(folder)


@pytest.mark.parametrize("filters", [3, None, "fmu", [1], {"fmu": 1, 2: 3}])
def test_filters_are_kinds(filters):
    with pytest.raises(rg.RailgripError, match="filters"):
        rg.estimate("anything.csv", "wagon", filters=filters)


@some
@given(axes=anything, one=anything)
def test_sweeps_of_any_arguments(scenario, axes, one):
    answered(lambda: rg.sweep(scenario, axes))
    answered(lambda: rg.sweep(scenario, {"seed": one}))
    answered(lambda: rg.sweep(scenario, {"seed": [1]}, controller=one))
    answered(lambda: rg.sweep(scenario, {"seed": []}, workers=one))


@some
@given(recording=anything, model=anything, changes=anything)
def test_estimates_of_any_arguments(recording, model, changes):
    answered(lambda: rg.estimate(recording))
    answered(lambda: rg.estimate(xarray.Dataset(), model))
    answered(lambda: rg.estimate(xarray.Dataset(), "wagon", changes))


@some
@given(one=anything)
def test_contracts_of_any_arguments(one):
    for check in (rg.testing.check_controller, rg.testing.check_estimator, rg.testing.check_sensors):
        answered(lambda check=check: check(one))
        answered(lambda check=check: check(lambda: one))
    answered(lambda: rg.testing.check_plant(one))


class Returns:
    """A controller, estimator, sensor model and plant that returns anything."""

    provides = ("adhesion",)

    def __init__(self, value):
        self._value = value

    def start(self, *arguments):
        return self._value

    decide = step = read = start


@some
@given(
    value=st.one_of(
        anything, anything.map(lambda inner: {"speed": inner}), anything.map(lambda a: rg.Estimate(adhesion=a))
    )
)
def test_stops_with_parts_that_return_anything(scenario, value):
    for name in ("controller", "estimator", "sensors", "plant"):
        answered(lambda name=name: rg.run(scenario, **{name: Returns(value)}))
    with rg.open(scenario) as bench:
        bench.reset()
        answered(lambda: bench.step(value))


@pytest.mark.parametrize("name", ["controller", "estimator", "sensors", "plant"])
def test_a_mapping_that_fails_on_reading_ends_the_stop(scenario, name):
    outcome = {"estimator": "diverged"}.get(name, f"{name}_failed")
    assert rg.run(scenario, **{name: Returns(HostileMapping(a=1))}).outcome.value == outcome


@some
@given(one=anything)
def test_attributes_of_any_value(scenario, one):
    for name, attribute in (("controller", "needs"), ("estimator", "provides"), ("sensors", "start")):
        part = Returns([0.0] * 4)
        setattr(part, attribute, one)
        answered(lambda name=name, part=part: rg.run(scenario, **{name: part}))
