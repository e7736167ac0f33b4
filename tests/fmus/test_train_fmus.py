"""Every FMU of recipes.toml is valid, agrees with lock.toml, and has the trajectory of rumoca's own simulator."""

import re
from collections.abc import Mapping
from functools import cache
from pathlib import Path

import fmpy
import numpy as np
import pytest
import rumoca
from fmpy.validation import validate_fmu
from small_fmus import Fmu, away_from_events, check_directional_derivatives, compare, simulated
from wrong import table

from railgrip.base.registry import shelf
from railgrip.fmus.build import build, fmu
from railgrip.fmus.native.dae import LIBRARY, read
from railgrip.fmus.native.system import explicit
from railgrip.fmus.recipe import differences, read_lock, read_recipes
from railgrip.rolling_stock.modelica import class_name, class_text
from railgrip.rolling_stock.schema import load_train

BOOK = read_recipes()
STOP, STEP = 3.0, 0.015  # no point is at a sample of the valves, 0.5 ms + k 2 ms
# Constant value of each input: service braking on wet rail, with slightly more friction for each wheelset further back.
HELD = table(__file__, "tables.toml")["held"]


def held(name: str, values: Mapping[str, float] = HELD) -> float:
    """Return the value of a scalar input such as `mu0[2]`."""
    base, _, index = name.partition("[")
    return values[base] * (1 + 0.05 * (int(index.rstrip("]")) - 1 if index else 0))


@pytest.fixture(scope="module")
def catalogue():
    return {built.name: built for built in build(compiler="native")}


@pytest.fixture(scope="module")
def train(catalogue, tmp_path_factory):
    def load(name):
        path = catalogue[name].path
        folder = Path(fmpy.extract(str(path), str(tmp_path_factory.mktemp(name))))
        return Fmu(path, folder, fmpy.read_model_description(str(path)))

    return load


@cache
def session() -> rumoca.Session:
    """One session for all classes: it reads the library once."""
    return rumoca.Session(roots=[str(Path(LIBRARY).parent)])


def reference(
    class_name: str, inputs: Mapping[str, float], until: float = STOP, more: str = "", *, solver: str = "bdf"
) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Simulate the class with its inputs bound in a wrapper; rumoca accepts no external inputs."""
    groups: dict[str, list[float]] = {}
    for name, value in inputs.items():
        groups.setdefault(name.partition("[")[0], []).append(value)
    scalar = {name for name in inputs if "[" not in name}
    bound = [f"{k} = {v[0]}" if k in scalar else f"{k} = {{{', '.join(map(repr, v))}}}" for k, v in groups.items()]
    text = f"model Wrapped\n  {class_name} inside({', '.join(bound)}{more});\nend Wrapped;"
    model = session().loads(text, model="Wrapped", filename="wrapped/Wrapped.mo")
    result = model.simulate((0, until), dt=STEP, config=rumoca.SimConfig(solver=solver, rtol=1e-9, atol=1e-10))
    time = np.asarray(result.time)
    keep = away_from_events(time, STEP, 4e-4)
    prefix = "inside."
    return time[keep], {
        n.removeprefix(prefix): np.asarray(result[n])[keep] for n in result.names if n.startswith(prefix)
    }


@pytest.mark.parametrize("name", BOOK.recipes)
def test_the_fmu_is_valid(train, name):
    assert validate_fmu(str(train(name).path)) == []


@pytest.mark.parametrize("name", BOOK.recipes)
def test_its_interface_is_the_one_in_the_lock_file(catalogue, name):
    """A difference means that the models changed: inspect it, then run `railgrip build --check --update`."""
    assert differences(name, read_lock(), catalogue[name].interface) == []


@pytest.mark.parametrize("name", BOOK.recipes)
def test_every_variable_has_a_unit_the_compiler_knows(train, name):
    unknown = [u.name for u in train(name).description.unitDefinitions if u.baseUnit is None]
    assert unknown == []


@pytest.mark.parametrize(
    ("name", "interface"),
    [(n, i) for n, r in BOOK.recipes.items() for i in r.interfaces],
)
def test_the_trajectory_is_that_of_rumoca(train, name, interface):
    """Every output within 1e-5 of its largest value, through cylinder filling and into braking."""
    fmu = train(name)
    inputs = {n: held(n) for n in fmu.names("input")}
    settings = {"relative_tolerance": 1e-9} if interface == "me" else {"start_values": {"_tolerance": 1e-8}}
    kind = {"me": "ModelExchange", "cs": "CoSimulation"}[interface]
    found = simulated(fmu.folder, inputs, fmu.names("output"), STOP, STEP, fmi_type=kind, **settings)
    # BDF restarts at every tick of the valves' clock; both solvers agree to 1e-8 there.
    solver = "rk-like" if name in ("TwoPartTrainPneumatic", "RollerRig") else "bdf"
    compare(fmu.names("output"), found, *reference(BOOK[name].class_name, inputs, solver=solver))


def test_the_trajectory_is_that_of_rumoca_through_lock_and_standstill(train):
    """From 3 m/s on a poor rail: the wheelsets lock one after the other, and the train stops after six seconds."""
    fmu = train("TwoPartTrain")
    inputs = {n: held(n, HELD | {"pressure_command": 2.0e5, "mu0": 0.05}) for n in fmu.names("input")}
    start = {"_tolerance": 1e-8, "start_speed": 3.0}
    found = simulated(fmu.folder, inputs, fmu.names("output"), 8.0, STEP, fmi_type="CoSimulation", start_values=start)
    for group in range(1, 5):
        locked = found[f"locked[{group}]"] > 0.5
        assert not locked[1]
        assert locked[-1]
    assert 5.0 < found["time"][np.argmax(found["speed"] == 0.0)] < 7.0
    compare(fmu.names("output"), found, *reference(BOOK["TwoPartTrain"].class_name, inputs, 8.0, ", start_speed=3.0"))


@pytest.mark.parametrize("name", [n for n, r in BOOK.recipes.items() if r.interfaces == ("me",)])
def test_the_jacobian_of_a_prediction_is_its_central_difference(train, run, name):
    """Along every state and input, in braking; differences over 1e-6 of a variable allow 1e-5 of a row."""
    fmu = train(name)
    instance = run(fmu, "me")
    inputs = fmu.names("input")
    instance.set(**{n: held(n) for n in inputs})
    states = [u.variable.derivative.name for u in fmu.description.derivatives]
    values = dict(zip(states, instance.get(*states), strict=True))
    # One per cent of slip, as braking has it, and every deflection, speed and creep away from zero, where the
    # reconstructed lateral filter divides by its creep and guards the division.
    apart = {n: x * (0.99 if n.startswith("w") else 1) for n, x in values.items()}
    instance.set(**{n: x if abs(x) >= 1e-3 else 1e-3 for n, x in apart.items()})
    unknown = [f"der({n})" for n in states] + fmu.names("output", "Real")
    check_directional_derivatives(instance, unknown, states + inputs, least=1e-3, rounding=1e-15)


@pytest.mark.parametrize("name", BOOK.recipes)
def test_every_state_has_a_nominal_value(name: str) -> None:
    """Solvers scale errors of a state by it; where it is missing FMI 2.0 takes 1, for deflections as for pressures."""
    description = fmpy.read_model_description(str(fmu(name)), validate=False)
    states = [derivative.variable.derivative for derivative in description.derivatives]
    assert [state.name for state in states if not state.nominal] == []


@pytest.mark.parametrize(("train", "cars"), [("tram", 1), ("loco_coaches", 2)])
def test_every_state_of_a_train_file_has_a_nominal_value(tmp_path: Path, train: str, cars: int) -> None:
    """With every part that trains of the library have: couplers, brake pipe and distributors, track brakes.

    Only ideal cylinders are missing, and TwoPartTrain.fmu has them. A car has its first bogie: others have the same.
    """
    text, *more = re.split(r"^(?=\[\[cars\]\])", shelf("trains")[train].read_text(encoding="utf-8"), flags=re.MULTILINE)
    more[cars - 1] = re.sub(r"^coupler = .*\n", "", more[cars - 1], flags=re.MULTILINE)
    file = tmp_path / "train.toml"
    whole = "".join([text, *more[:cars]])
    file.write_text(re.sub(r"^(bogies = \[\{[^}]*\}).*\]$", r"\1]", whole, flags=re.MULTILINE), encoding="utf-8")
    found = load_train(file)
    library = tmp_path / "Train.mo"
    name = class_name(found, pneumatic=True)
    library.write_text(class_text(found, pneumatic=True), encoding="utf-8")
    system = explicit(read(name, library))
    assert len(system.states) > 15
    assert [state.name for state in system.states if "nominal" not in state.bounds] == []
