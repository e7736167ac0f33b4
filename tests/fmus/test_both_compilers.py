"""OpenModelica's FMUs against ours: the same face, trajectories, derivatives and steps. Needs omc on the PATH.

Trajectories are compared through model exchange, where one integrator runs both FMUs and finds their events. In
co-simulation each brings its own solver, and OpenModelica's acts on events where a step ends.
"""

import shutil
from collections.abc import Mapping
from dataclasses import dataclass

import fmpy
import numpy as np
import pytest
from test_train_fmus import HELD, held

from fmus.build import build_one
from fmus.recipe import Cookbook, read_recipes
from harness.fmu import CoSimulation, Description, FmuPrediction, Signal, bind, describe

BOOK = read_recipes()
PLANTS = [n for n, r in BOOK.recipes.items() if "cs" in r.interfaces]
PREDICTIONS = [n for n in BOOK.recipes if n not in PLANTS and n != "LateralContact"]
STOP, STEP = 3.0, 0.015

pytestmark = [
    pytest.mark.omc,
    pytest.mark.skipif(shutil.which("omc") is None, reason="OpenModelica's omc is not on the PATH"),
]


@dataclass(frozen=True, slots=True)
class Pair:
    """One class from both compilers."""

    ours: Description
    theirs: Description


@pytest.fixture(scope="module")
def pair(tmp_path_factory):
    """Return a function of a recipe's name that builds its FMU with both compilers, once."""
    made: dict[str, Pair] = {}
    folder = tmp_path_factory.mktemp("both")

    def build(name: str) -> Pair:
        if name not in made:
            recipe = BOOK[name]
            if "cs" in recipe.interfaces:
                recipe = recipe.model_copy(update={"interfaces": ("me", "cs")})
            book = Cookbook(file=BOOK.file, recipes={name: recipe})
            ours, theirs = (
                describe(build_one(name, compiler, folder / compiler, book=book).path)
                for compiler in ("native", "openmodelica")
            )
            made[name] = Pair(ours, theirs)
        return made[name]

    return build


def nudged(description: Description) -> dict[str, float]:
    """Return every real parameter one per cent below its default, where its bounds allow.

    One that a compiler has evaluated for good shows in the trajectories.
    """
    parameters = [description.variables[n] for n in description.named("parameter") if not n.startswith("_")]
    values = {v.name: 0.99 * float(v.start or 0) for v in parameters if v.kind == "Real"}
    least = {v.name: -np.inf if v.minimum is None else v.minimum for v in parameters}
    most = {v.name: np.inf if v.maximum is None else v.maximum for v in parameters}
    return {n: x for n, x in values.items() if least[n] <= x <= most[n]}


def integrated(
    description: Description, inputs: Mapping[str, float], start: Mapping[str, float], until: float = STOP
) -> np.ndarray:
    """Return all outputs on the grid, from CVODE in FMPy."""
    signals = np.array(
        [(t, *inputs.values()) for t in (0.0, until)], dtype=[("time", float), *((n, float) for n in inputs)]
    )
    return fmpy.simulate_fmu(
        str(description.file),
        validate=False,
        fmi_type="ModelExchange",
        stop_time=until,
        output_interval=STEP,
        record_events=False,
        relative_tolerance=1e-9,
        input=signals,
        start_values=dict(start),
        output=list(description.named("output")),
    )


def agree(description: Description, a: np.ndarray, b: np.ndarray, tolerance: float) -> None:
    """Compare every output on the grid with its largest value; around an event one run is a rounding error early."""
    assert len(a) == len(b)
    booleans = [n for n in description.named("output") if description.variables[n].kind == "Boolean"]
    turned = np.zeros(len(a), dtype=bool)
    for n in booleans:
        for run in (a, b):
            turned[1:] |= run[n][1:] != run[n][:-1]
    clear = ~turned
    clear[:-1] &= ~turned[1:]
    for n in description.named("output"):
        ours, theirs = a[n][clear].astype(float), b[n][clear].astype(float)
        assert np.max(np.abs(ours - theirs)) <= tolerance * np.max(np.abs(ours)) + 1e-9, n


@pytest.mark.parametrize("name", BOOK.recipes)
def test_the_face_is_the_same(pair, name):
    """Inputs, outputs, parameters, their types, units, bounds and defaults; ours has parameters of the solver more."""
    fmus = pair(name)

    for causality in ("input", "output", "parameter"):
        ours, theirs = (
            {n: d.variables[n] for n in d.named(causality) if not n.startswith("_")} for d in (fmus.ours, fmus.theirs)
        )
        assert sorted(theirs) == sorted(ours)
        for n, v in ours.items():
            assert (theirs[n].kind, theirs[n].unit_name) == (v.kind, v.unit_name), n
        if causality == "parameter":
            for n, v in ours.items():
                assert theirs[n].settable, n
                assert float(theirs[n].start or 0) == pytest.approx(float(v.start or 0), rel=1e-12), n
                assert (theirs[n].minimum, theirs[n].maximum) == (v.minimum, v.maximum), n


@pytest.mark.parametrize("name", BOOK.recipes)
def test_the_trajectory_is_the_same(pair, name):
    """Three seconds, parameters nudged; a difference of compilers is one in rounding, of two integrations 1e-5."""
    fmus = pair(name)
    inputs = {n: held(n) for n in fmus.ours.named("input")}
    start = nudged(fmus.ours)
    agree(fmus.ours, integrated(fmus.ours, inputs, start), integrated(fmus.theirs, inputs, start), 1e-5)


def test_the_trajectory_is_the_same_through_lock_and_standstill(pair):
    """From 3 m/s on bad rail; after standstill the frames swing out, 1e-4 of their largest deflection apart."""
    fmus = pair("TwoPartTrain")
    inputs = {n: held(n, HELD | {"pressure_command": 2.0e5, "mu0": 0.05}) for n in fmus.ours.named("input")}
    ours, theirs = (integrated(d, inputs, {"speed_start": 3.0}, 8.0) for d in (fmus.ours, fmus.theirs))
    assert all(ours[f"locked[{group}]"][-1] for group in range(1, 5))
    assert ours["standstill"][-1]
    agree(fmus.ours, ours, theirs, 1e-4)


@pytest.mark.parametrize("name", PREDICTIONS)
def test_a_prediction_is_the_same_function(pair, name):
    """Derivatives, outputs and both Jacobians at 20 points: nothing is integrated, so they differ by rounding."""
    fmus = pair(name)
    assert sorted(fmus.theirs.states) == sorted(fmus.ours.states)
    names = {
        "states": fmus.ours.states,
        "inputs": fmus.ours.named("input"),
        "outputs": fmus.ours.named("output"),
    }
    u = np.array([held(n) for n in names["inputs"]])
    random = np.random.default_rng(7)
    with (
        FmuPrediction(fmus.ours, parameters={}, **names, differentiation="directional") as ours,
        FmuPrediction(fmus.theirs, parameters={}, **names, differentiation="directional") as theirs,
    ):
        assert theirs.start == pytest.approx(ours.start, rel=1e-12)
        for _ in range(20):
            x = ours.start * random.uniform(0.9, 1.1, ours.start.size) + random.uniform(1e-3, 2e-3, ours.start.size)
            for evaluate in ("derivative", "output", "derivative_jacobian", "output_jacobian"):
                expected = getattr(ours, evaluate)(x, u)
                size = np.max(np.abs(expected))
                assert getattr(theirs, evaluate)(x, u) == pytest.approx(expected, rel=1e-8, abs=1e-10 * size), evaluate


@pytest.mark.parametrize("name", PLANTS)
def test_the_harness_steps_it_to_the_same_end(pair, name):
    """Co-simulation at 1 kHz, units and all. CVODE as omc sets it is 3e-5 off; a wrong model is 1e-3 and more."""
    fmus = pair(name)
    ours, theirs = (stepped(d, HELD, {}) for d in (fmus.ours, fmus.theirs))
    scale = np.max(np.abs(ours), axis=0)
    worst = np.max(np.abs(ours - theirs), axis=0) / np.maximum(scale, 1e-9)
    names = fmus.ours.named("output")
    assert {n: w for n, w in zip(names, worst, strict=True) if w > 1e-3} == {}


def test_the_harness_steps_it_through_lock_and_standstill(pair):
    """Theirs locks and stops up to a step of 1 ms late, which a distance of 9 m does not show to 1e-3."""
    fmus = pair("TwoPartTrain")
    values = HELD | {"pressure_command": 2.0e5, "mu0": 0.05}
    ours, theirs = (stepped(d, values, {"speed_start": 3.0}, 8.0) for d in (fmus.ours, fmus.theirs))
    names = fmus.ours.named("output")
    for n in ("speed", "standstill", *(f"locked[{group}]" for group in range(1, 5))):
        at = names.index(n)
        assert theirs[-1, at] == ours[-1, at], n
        turned = [np.argmax(run[:, at] == run[-1, at]) for run in (ours, theirs)]
        assert abs(int(turned[1]) - int(turned[0])) <= 10, n
    distance = names.index("distance")
    assert theirs[-1, distance] == pytest.approx(ours[-1, distance], rel=1e-3)


def stepped(
    description: Description, values: Mapping[str, float], parameters: Mapping[str, float], until: float = STOP
) -> np.ndarray:
    """Return the outputs after each millisecond, shape (steps, outputs); our own solver is given 1e-8."""

    def signals(causality: str) -> list[Signal]:
        return [
            Signal(name=n, unit=description.variables[n].unit_name or "1", size=0, needed=True)
            for n in description.named(causality)
        ]

    binding = bind(description, inputs=signals("input"), outputs=signals("output"))
    inputs = np.array([held(n, values) for n in binding.inputs.elements])
    own = {"_tolerance": 1e-8} if "_tolerance" in description.variables else {}
    with CoSimulation(description, binding, period=1e-3, parameters={**own, **parameters}) as plant:
        plant.start(inputs)
        return np.array([plant.step(inputs) for _ in range(round(until / 1e-3))])
