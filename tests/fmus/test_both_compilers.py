"""FMUs of OpenModelica and of the built-in compiler have equal interfaces, trajectories, derivatives and steps.

Needs omc on the PATH. Trajectories are compared through model exchange, where one integrator runs both FMUs and finds
their events. In co-simulation each has its own solver, and OpenModelica's handles events where a step ends.
"""

import shutil
from typing import NamedTuple

import numpy as np
import pytest
from bound_fmu import bind_all
from small_fmus import simulated
from test_train_fmus import HELD, STEP, STOP, held

from railgrip.fmi import CoSimulation, Description, FmuPrediction, describe
from railgrip.fmus.build import build_one
from railgrip.fmus.recipe import Cookbook, read_recipes

BOOK = read_recipes()
PLANTS = [n for n, r in BOOK.recipes.items() if "cs" in r.interfaces]
PREDICTIONS = [n for n in BOOK.recipes if n not in PLANTS and n != "LateralContact"]

pytestmark = [
    pytest.mark.omc,
    pytest.mark.skipif(shutil.which("omc") is None, reason="OpenModelica's omc is not on the PATH"),
]


AT_REST = 1e-12
"""Values that count as zero: at standstill OpenModelica's speed is 4e-21 m/s, that of the built-in compiler 0."""


class Pair(NamedTuple):
    """One class from both compilers."""

    ours: Description
    theirs: Description


@pytest.fixture(scope="module")
def pair(tmp_path_factory):
    """Return a function of a recipe's name that builds its FMU with both compilers, once."""
    pairs: dict[str, Pair] = {}
    folder = tmp_path_factory.mktemp("both")

    def build(name: str) -> Pair:
        if name not in pairs:
            recipe = BOOK[name]
            if "cs" in recipe.interfaces:
                recipe = recipe.model_copy(update={"interfaces": ("me", "cs")})
            book = Cookbook(file=BOOK.file, recipes={name: recipe})
            pairs[name] = Pair(
                *(
                    describe(build_one(name, compiler, folder / compiler, book=book).path)
                    for compiler in ("native", "openmodelica")
                )
            )
        return pairs[name]

    return build


def nudged(fmus: Pair) -> dict[str, float]:
    """Return every real parameter that both offer, one per cent below its default, where its bounds allow.

    The effect of parameters that a compiler has evaluated is in the trajectories.
    """
    parameters = [fmus.ours.variables[n] for n in fmus.ours.names("parameter") if n in fmus.theirs.names("parameter")]
    values = {v.name: 0.99 * float(v.start or 0) for v in parameters if v.kind == "Real"}
    lower = {v.name: -np.inf if v.minimum is None else v.minimum for v in parameters}
    upper = {v.name: np.inf if v.maximum is None else v.maximum for v in parameters}
    return {n: x for n, x in values.items() if lower[n] <= x <= upper[n]}


def integrated(description, inputs, start, until=STOP):
    """Return all outputs on the grid as columns by name, from CVODE in FMPy."""
    return simulated(
        description.file, inputs, description.names("output"), until, STEP,
        validate=False, fmi_type="ModelExchange", record_events=False, relative_tolerance=1e-9,
        start_values=dict(start),
    )  # fmt: skip


def stepped(description, values, until=STOP, **parameters):
    """Return each output by its name after each millisecond; the built-in solver uses a tolerance of 1e-8."""
    binding = bind_all(description)
    inputs = np.array([held(n, values) for n in binding.inputs.elements])
    own = {"_tolerance": 1e-8} if "_tolerance" in description.variables else {}
    with CoSimulation(description, binding, period=1e-3, parameters=own | parameters) as plant:
        plant.start(inputs)
        rows = np.array([plant.step(inputs) for _ in range(round(until / 1e-3))])
    return dict(zip(binding.outputs.elements, rows.T, strict=True))


def beyond(tolerance: float, fmus: Pair, ours: np.ndarray, theirs: np.ndarray) -> dict[str, float]:
    """Return the outputs that differ by more than a tolerance of their largest value.

    Rows next to one where a Boolean changes are excluded: one run reaches the event earlier by a rounding error.
    """
    assert len(ours) == len(theirs)
    turned = np.zeros(len(ours), dtype=bool)
    for n in (n for n in fmus.ours.names("output") if fmus.ours.variables[n].kind == "Boolean"):
        for run in (ours, theirs):
            turned[1:] |= run[n][1:] != run[n][:-1]
    clear = ~turned
    clear[:-1] &= ~turned[1:]
    worst: dict[str, float] = {}
    for n in ours.dtype.names or ():
        a, b = ours[n][clear].astype(float), theirs[n][clear].astype(float)
        size, difference = np.max(np.abs(a)), np.max(np.abs(a - b))
        worst[n] = 0.0 if difference <= 1e-9 else difference / max(size, 1e-300)
    return {n: share for n, share in worst.items() if share > tolerance}


def turns(run: np.ndarray) -> int:
    """Return the index of the first row that equals the last one."""
    return int(np.argmax(np.abs(run - run[-1]) <= AT_REST))


@pytest.mark.parametrize("name", BOOK.recipes)
def test_the_interface_is_the_same(pair, name):
    """Inputs, outputs and parameters with types, units, bounds and defaults; solver parameters are built-in only."""
    fmus = pair(name)

    for causality in ("input", "output", "parameter"):
        ours, theirs = ({n: d.variables[n] for n in d.names(causality) if not n.startswith("_")} for d in fmus)
        assert sorted(theirs) == sorted(ours)
        for n, v in ours.items():
            assert (theirs[n].kind, theirs[n].unit) == (v.kind, v.unit), n
        if causality == "parameter":
            for n, v in ours.items():
                assert theirs[n].settable, n
                assert float(theirs[n].start or 0) == pytest.approx(float(v.start or 0), rel=1e-12), n
                assert (theirs[n].minimum, theirs[n].maximum) == (v.minimum, v.maximum), n


@pytest.mark.parametrize("name", BOOK.recipes)
def test_the_trajectory_is_the_same(pair, name):
    """Three seconds, parameters perturbed; compilers differ by rounding, two integrations by 1e-5."""
    fmus = pair(name)
    inputs = {n: held(n) for n in fmus.ours.names("input")}
    start = nudged(fmus)
    assert beyond(1e-5, fmus, integrated(fmus.ours, inputs, start), integrated(fmus.theirs, inputs, start)) == {}


def test_the_trajectory_is_the_same_through_lock_and_standstill(pair):
    """From 3 m/s on a poor rail; after standstill the frames swing, differing by 1e-4 of the largest deflection."""
    fmus = pair("TwoPartTrain")
    inputs = {n: held(n, HELD | {"pressure_command": 2.0e5, "mu0": 0.05}) for n in fmus.ours.names("input")}
    ours, theirs = (integrated(d, inputs, {"start_speed": 3.0}, 8.0) for d in fmus)
    assert all(ours[f"locked[{group}]"][-1] for group in range(1, 5))
    assert ours["standstill"][-1]
    assert beyond(1e-4, fmus, ours, theirs) == {}


@pytest.mark.parametrize("name", PREDICTIONS)
def test_a_prediction_is_the_same_function(pair, name):
    """Derivatives, outputs and both Jacobians at 20 points: nothing is integrated, so they differ by rounding."""
    fmus = pair(name)
    assert sorted(fmus.theirs.states) == sorted(fmus.ours.states)
    names = {
        "states": fmus.ours.states,
        "inputs": fmus.ours.names("input"),
        "outputs": fmus.ours.names("output"),
    }
    u = np.array([held(n) for n in names["inputs"]])
    random = np.random.default_rng(7)
    with (
        FmuPrediction(fmus.ours, parameters={}, **names) as ours,
        FmuPrediction(fmus.theirs, parameters={}, **names) as theirs,
    ):
        assert theirs.start == pytest.approx(ours.start, rel=1e-12)
        for _ in range(20):
            x = ours.start * random.uniform(0.9, 1.1, ours.start.size) + random.uniform(1e-3, 2e-3, ours.start.size)
            for evaluate in ("derivative", "output", "derivative_jacobian", "output_jacobian"):
                expected = getattr(ours, evaluate)(x, u)
                size = np.max(np.abs(expected))
                assert getattr(theirs, evaluate)(x, u) == pytest.approx(expected, rel=1e-8, abs=1e-10 * size), evaluate


@pytest.mark.parametrize("name", PLANTS)
def test_the_harness_steps_both_to_the_same_end(pair, name):
    """Co-simulation at 1 kHz, including units. CVODE in omc is 3e-5 off; a wrong model differs by 1e-3 or more."""
    fmus = pair(name)
    ours, theirs = (stepped(d, HELD) for d in fmus)
    size = {n: max(np.max(np.abs(run)), 1e-9) for n, run in ours.items()}
    worst = {n: np.max(np.abs(run - theirs[n])) / size[n] for n, run in ours.items()}
    assert {n: w for n, w in worst.items() if w > 1e-3} == {}


def test_the_harness_steps_both_through_lock_and_standstill(pair):
    """OpenModelica's FMU locks and stops up to a step of 1 ms late, less than 1e-3 of a distance of 9 m."""
    fmus = pair("TwoPartTrain")
    values = HELD | {"pressure_command": 2.0e5, "mu0": 0.05}
    ours, theirs = (stepped(d, values, 8.0, start_speed=3.0) for d in fmus)
    for n in ("speed", "standstill", *(f"locked[{group}]" for group in range(1, 5))):
        assert theirs[n][-1] == pytest.approx(ours[n][-1], abs=AT_REST), n
        assert abs(turns(theirs[n]) - turns(ours[n])) <= 10, n
    assert theirs["distance"][-1] == pytest.approx(ours["distance"][-1], rel=1e-3)
