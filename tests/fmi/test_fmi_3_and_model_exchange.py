"""Plants by FMI 3.0 and by Model Exchange: the same numbers as by Co-Simulation 2.0, and as closed forms."""

import re
from contextlib import nullcontext
from pathlib import Path

import fmpy
import numpy as np
import pytest
from tiny_fmu import packed, tied, tiny, xml
from wrong import table

from railgrip.base.errors import FmuError, PlantFailed
from railgrip.fmi import Binding, CoSimulation, Description, IsolatedCoSimulation, Port, bind, describe, open_plant
from railgrip.fmi.by_fmpy import IntegratedModel
from railgrip.fmi.plant import LoadedPlant
from railgrip.fmus.native import package
from railgrip.fmus.native.package import as_fmi_3
from railgrip.fmus.native.system import System
from railgrip.fmus.native.toolchain import shared_library
from railgrip.report.stop import Stop
from railgrip.scenario.load import load
from railgrip.scenario.outcome import Outcome
from railgrip.simulate.map_draft import find_mapping
from railgrip.simulate.run import run_stop

ROOT = Path(__file__).parents[2]
HERE = Path(__file__).parent
SCENARIO = ROOT / "harness" / "scenario" / "library" / "foreign_train.toml"
PERIOD = 1e-3
BALL = (HERE / "bouncing_ball.xml").read_text()
G, BOUNCE = 9.81, 0.7


def ball(folder: Path, description: str = BALL) -> Path:
    """Build the FMU of bouncing_ball.c in `folder` and return its file."""
    source = {"bouncing_ball.c": (HERE / "bouncing_ball.c").read_text()}
    library = shared_library(source, "bouncing_ball", flags=("-fvisibility=default",))
    return packed(folder / "ball.fmu", description, library, f"{fmpy.platform_tuple}/bouncing_ball")


def ball_binding(description: Description) -> Binding:
    return bind(
        description,
        inputs=[Port(name="lift", unit="m/s2", size=0, needed=True)],
        outputs=[
            Port(name="x", unit="1", size=2, needed=True),
            Port(name="bounces", unit="1", size=0, needed=True),
        ],
        table={"x": {"variable": "x[{i}]", "unit": "1"}},
    )


def flying(foundry: Path, **parameters: float) -> IntegratedModel:
    description = describe(ball(foundry))
    return IntegratedModel(description, ball_binding(description), period=PERIOD, parameters=parameters)


def flight(plant: LoadedPlant | IsolatedCoSimulation, lift: np.ndarray) -> np.ndarray:
    """Return height, speed and bounces at the start and after each period."""
    with plant:
        rows = [plant.start(np.zeros(1))]
        rows += [plant.step(np.array([value])) for value in lift]
    return np.array(rows)


def bouncing(time: np.ndarray) -> np.ndarray:
    """Return height, speed and bounces of a ball dropped from 1 m."""
    at, speed, count = np.sqrt(2 / G), BOUNCE * np.sqrt(2 * G), 1
    rows = np.stack([1 - G * time**2 / 2, -G * time, 0 * time], axis=1)
    while at < time[-1]:
        since, later = time - at, time >= at
        rows[later] = np.stack([speed * since - G * since**2 / 2, speed - G * since, 0 * time + count], axis=1)[later]
        at, speed, count = at + 2 * speed / G, BOUNCE * speed, count + 1
    return rows


# ---- Model Exchange against closed forms -------------------------------------------------------------------------


def test_cvode_follows_inputs_that_change_at_each_period(foundry: Path):
    """x' = −rate x + gain u, with u held over each period, is stepped exactly by an exponential."""
    description = describe(tiny(foundry, description=xml(ways=("ModelExchange",))))
    held = np.repeat(np.random.default_rng(3).normal(size=20), 5)
    with open_plant(
        description, tied(description), period=0.01, parameters={"rate": 5.0}, trusted=True, notify=lambda _: None
    ) as plant:
        assert isinstance(plant, IntegratedModel)
        rows = [plant.start(held[:1])]
        rows += [plant.step(np.array([u])) for u in held]
    x = 1.0
    for k, u in enumerate(held):
        x = 3 * u / 5 + (x - 3 * u / 5) * np.exp(-5.0 * 0.01)
        # 1e-6 is allowed for each of CVODE's steps, of which there are about ten in a period; errors decay with 5/s.
        assert rows[k + 1][0] == pytest.approx(x, abs=1e-4)
        assert rows[k + 1][1] == pytest.approx(2 * rows[k + 1][0] + u, rel=1e-12), "y = 2 x + u at the end of the step"


def test_bounces_are_located_accurately(foundry: Path):
    """State events: each flight of a ball is a parabola, shorter than the last by the factor of the bounce."""
    rows = flight(flying(foundry), np.zeros(2000))
    exact = bouncing(np.arange(2001) * PERIOD)
    assert rows[-1, 2] == exact[-1, 2] == 4
    # 1e-6 is allowed for each step, and the hundred steps of a flight delay its end by up to as much of its speed.
    far = np.abs(exact[:, 0]) > 1e-3
    np.testing.assert_allclose(rows[far, :2], exact[far, :2], atol=1e-4)


# On a communication point, next to one, and between two.
@pytest.mark.parametrize("at", [0.0, 1e-20, 0.1, 0.1 + 1e-13, 0.1234567])
@pytest.mark.parametrize("given", [{}, {"constants[2]": 5.0}], ids=["one", "two"])
def test_time_events_occur_at_their_time(foundry: Path, at: float, given: dict[str, float]):
    """From `gust_at` on the acceleration is 1 m/s² larger.

    Of two, the first event announces the second at the present time, and only both together make the gust.
    """
    rows = flight(flying(foundry, gust_at=at, **given), np.zeros(300))
    time = np.arange(301) * PERIOD
    exact = 1 - G * time**2 / 2 + np.maximum(time - at, 0) ** 2 / 2
    np.testing.assert_allclose(rows[:, 0], exact, atol=1e-5)  # up to 300 steps of 1e-6; half a gust is 0.008 m off
    np.testing.assert_allclose(rows[:, 1], -G * time + np.maximum(time - at, 0), atol=1e-5)


def test_an_event_that_repeats_for_ever_ends_with_a_sentence(foundry: Path):
    plant = flying(foundry, **{"gust_at": 0.1, "constants[2]": 6.0})
    with pytest.raises(PlantFailed, match=r"at 0\.1 s .* sets its next event at the present time again"):
        flight(plant, np.zeros(300))


def test_a_single_element_of_an_array_can_be_set(foundry: Path):
    description = describe(ball(foundry))
    assert [description.variables[f"x[{i}]"].reference for i in (1, 2)] == [1, 1]
    assert description.states == ("x[1]", "x[2]")
    rows = flight(flying(foundry, **{"constants[1]": 1.62}), np.zeros(1300))  # on the moon the ball lands after 1.111 s
    assert rows[-1, 2] == 1
    assert rows[1200, 1] == pytest.approx(BOUNCE * np.sqrt(2 * 1.62) - 1.62 * (1.2 - np.sqrt(2 / 1.62)), abs=1e-4)


def test_a_separate_process_gives_the_same_result(foundry: Path):
    description, lift = describe(ball(foundry)), np.random.default_rng(5).normal(size=50)
    binding = ball_binding(description)
    plants = [
        kind(description, binding, period=PERIOD, parameters={}) for kind in (IntegratedModel, IsolatedCoSimulation)
    ]
    here, apart = (flight(plant, lift) for plant in plants)
    np.testing.assert_array_equal(here, apart)


def test_an_error_in_the_derivatives_ends_with_the_fmus_message(foundry: Path):
    with flying(foundry, **{"constants[2]": -1.0}) as plant:
        plant.start(np.zeros(1))
        with pytest.raises(PlantFailed) as failed:
            plant.step(np.zeros(1))
        with pytest.raises(PlantFailed):  # it is spent
            plant.step(np.zeros(1))
    text = str(failed.value)
    assert "fmi3GetContinuousStateDerivatives returned fmi3Error" in text
    assert "the ball is no ball" in text


@pytest.mark.parametrize(
    ("bounce", "sentence"),
    [
        (2.0, "fmi3GetEventIndicators returned a value that is not a finite number (number 1 of 1)"),
        (3.0, "fmi3GetContinuousStateDerivatives returned a value that is not a finite number (number 2 of 2)"),
        (4.0, "the solver could not integrate the FMU (it sets its next event at nan s)"),
    ],
    ids=["indicator", "derivative", "next event"],
)
def test_a_value_that_is_not_a_number_ends_the_run(foundry: Path, bounce: float, sentence: str):
    """The ball is below 0.9 m after 0.14 s; a changing lift causes an event in each period."""
    plant = flying(foundry, **{"constants[2]": bounce})
    with pytest.raises(PlantFailed) as failed:
        flight(plant, np.random.default_rng(5).normal(size=200))
    assert sentence in str(failed.value)
    assert plant.time == pytest.approx(np.sqrt(2 * 0.1 / G), abs=2e-3)  # a little earlier or later due to the lift


def stepped(**attributes: str) -> str:
    """Return the description of the bouncing ball as Co-Simulation."""
    more = "".join(f' {name}="{value}"' for name, value in attributes.items())
    return re.sub(r"<ModelExchange ([^/]*)/>", rf"<CoSimulation \1{more}/>", BALL)


@pytest.mark.parametrize(
    ("period", "near"), [(0.003, ""), (0.009, ""), (0.3, ""), (0.01, "0.009"), (0.001, "0.003"), (0.005, "0.006")]
)
def test_a_period_that_is_not_a_multiple_of_the_internal_step_is_refused(foundry: Path, period: float, near: str):
    description = describe(ball(foundry, stepped(fixedInternalStepSize="3e-3")))
    words = f"its internal step is fixed at 0.003 s, and the communication period of {period:g} s is not a whole"
    with pytest.raises(FmuError, match=re.escape(words) + f".*such as {near} s") if near else nullcontext():
        IsolatedCoSimulation(description, ball_binding(description), period=period, parameters={})


def declaring(step: str, variable: str = "false") -> str:
    text = xml(ways=("CoSimulation",)).replace('StepSize="true"', f'StepSize="{variable}"')
    return text.replace("  <ModelVariables>", f'  <DefaultExperiment stepSize="{step}"/><ModelVariables>')


@pytest.mark.parametrize("kind", [CoSimulation, IsolatedCoSimulation])
def test_the_one_step_that_an_fmu_declares_is_the_only_one(foundry: Path, kind: type[CoSimulation]):
    """A law of 20 ms that is stepped every 10 ms would count its time twice as fast."""
    description = describe(tiny(foundry, description=declaring("0.02")))
    kind(description, tied(description), period=0.02, parameters={})
    for period in (0.01, 0.04, 0.020001):
        with pytest.raises(FmuError, match=r'stepSize = 0\.02 s .* stepped every .* set its period .* to "0\.02 s"'):
            kind(description, tied(description), period=period, parameters={})


def test_a_suggested_step_does_not_limit_an_fmu_with_variable_step(foundry: Path):
    description = describe(tiny(foundry, description=declaring("0.02", "true")))
    CoSimulation(description, tied(description), period=0.01, parameters={})


@pytest.mark.parametrize("step", ["0", "-1e-3", "NaN", "INF"])
def test_a_step_that_is_not_a_time_is_refused(foundry: Path, step: str):
    with pytest.raises(FmuError, match=f"stepSize is {step}"):
        describe(tiny(foundry, description=declaring(step)))
    with pytest.raises(FmuError, match=f"fixedInternalStepSize is {step}"):
        describe(ball(foundry, stepped(fixedInternalStepSize=step)))


def test_an_fmu_that_requires_its_tool_is_reported_when_it_does_not_start(foundry: Path):
    text = xml(ways=("CoSimulation",)).replace("<CoSimulation", '<CoSimulation needsExecutionTool="true"')
    description = describe(tiny(foundry, "REFUSES", description=text))
    plant = open_plant(description, tied(description), period=0.01, parameters={}, trusted=True, notify=lambda _: None)
    with pytest.raises(PlantFailed, match=r"could not be started.* \(it needs .* on this machine\)"), plant:
        pass


@pytest.mark.parametrize(
    ("old", "new", "fact"),
    table(__file__, "tables.toml")["not_stepped"],
    ids=["clock", "size", "reference", "starts", "start", "interface", "version"],
)  # fmt: skip
def test_an_fmu_that_cannot_be_stepped_is_refused_with_the_reason(foundry: Path, old: str, new: str, fact: str):
    assert old in BALL
    with pytest.raises(FmuError, match=re.escape(fact)):
        describe(ball(foundry, BALL.replace(old, new)))


def test_a_structural_parameter_cannot_be_set(foundry: Path):
    with pytest.raises(FmuError, match="'n'"):
        flying(foundry, n=3)


# ---- the same train by every interface ---------------------------------------------------------------------------


def stop_of(foreign_train: System, folder: Path, way: str) -> Stop:
    """Return the stop of the foreign train's scenario from 20 km/h, with its plant by one of the interfaces."""
    interface = "me" if way == "ME 2.0" else "cs"
    source = package.sources(foreign_train, interfaces=(interface,), solver="rodas4", tolerance=1e-6, step=PERIOD)
    file = package.pack(as_fmi_3(source) if way == "CS 3.0" else source, folder / f"{way}.fmu")
    path = folder / f"{way}.toml"
    path.write_text(re.sub(r'plant = ".*"', f'plant = "{file}"', SCENARIO.read_text()))
    return run_stop(load(path, ["vehicle.trust=true", "start.speed=20 km/h"]))


def test_a_train_stops_at_the_same_place_by_every_interface(foreign_train: System, tmp_path: Path):
    stops = {way: stop_of(foreign_train, tmp_path, way) for way in ("CS 2.0", "CS 3.0", "ME 2.0")}
    assert {stop.outcome for stop in stops.values()} == {Outcome.STANDSTILL}
    # The solver is the FMU's own, and the same, by FMI 2.0 and 3.0.
    np.testing.assert_array_equal(stops["CS 3.0"].trace["speed"], stops["CS 2.0"].trace["speed"])
    # CVODE and the FMU's Rosenbrock method differ by 1e-6 in each step, which occasionally shifts the switching of slip
    # control by a sample: in total by less than the travel of one sample.
    distance = stops["CS 2.0"].metrics.distance
    assert stops["ME 2.0"].metrics.distance == pytest.approx(distance, abs=20 / 3.6 * PERIOD)


def test_a_train_of_arrays_by_fmi_3_is_mapped_and_stops(tmp_path: Path):
    """Elements of the arrays of PythonFMU3's train are wheelsets."""
    builder = pytest.importorskip("pythonfmu3.builder")
    file = builder.FmuBuilder.build_FMU(HERE / "array_train.py", tmp_path, needsExecutionTool=False)
    description = describe(file)
    assert (description.fmi, description.model_exchange) == (3, None)
    draft = find_mapping(description, wheelsets_per_group=(), speed=20.0, period=PERIOD)
    assert draft.table["wheelset_speed"].plain == "wheel_speed[{i}]"
    assert all(finding.good for finding in draft.findings)
    scenario, rest = tmp_path / "train.toml", SCENARIO.read_text()
    vehicle = f'[vehicle]\nplant = "{file}"\n\n' + "\n".join(draft.lines()) + "\n\n"
    scenario.write_text(rest[: rest.index("[vehicle]")] + vehicle + rest[rest.index("[start]") :])
    brakes = [
        "vehicle.formation.brakes.p_max=3 bar",
        "vehicle.formation.wheelset_load=[98.1e3, 98.1e3, 98.1e3, 98.1e3]",
    ]
    stop = run_stop(load(scenario, [*brakes, "adhesion.mu0=0.3", "start.speed=5 km/h", "controller.kind=full_brake"]))
    assert stop.outcome is Outcome.STANDSTILL, stop.reason
    # Brake moments of 10.5 kN m at 0.45 m stop 40 t and wheels of 2 t, and begin with a lag of 0.1 s.
    a, v = 4 * 10.5e3 / 0.45 / 42e3, 5 / 3.6
    # Brakes act less on wheels that hardly turn, and wheels slip a little.
    assert stop.metrics.distance == pytest.approx(v**2 / 2 / a + 0.1 * v - 0.1**2 * a / 2, rel=0.02)
