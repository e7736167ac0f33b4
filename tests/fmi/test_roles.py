"""Each FMU is recognised by its inputs and outputs: a wrong key refuses it and names the right one."""

import re
import tomllib
from pathlib import Path

import casadi as ca
import pytest
from command_line import done
from faulty_fmu import faulty_fmu, stop_of_plant
from sampled_systems import sampled
from wrong import table

from railgrip.base.errors import RailgripError
from railgrip.base.system import SampledSystem
from railgrip.fmi import describe
from railgrip.fmus.build import fmu
from railgrip.fmus.native.discrete import sources
from railgrip.fmus.native.package import pack
from railgrip.scenario.load import load
from railgrip.scenario.outcome import Outcome
from railgrip.simulate.export.c_parts import part_fmu
from railgrip.simulate.export.controller_and_plant import controller_fmu
from railgrip.simulate.map_draft import find_mapping
from railgrip.simulate.run import run_stop


def law(*, wheel: str, demand: str) -> SampledSystem:
    """Return a controller that releases a wheel that turns backwards; `{i}` in names is the group."""
    speeds = ca.SX.sym("speeds", 4)
    demands = ca.if_else(speeds < 0.0, 0.0, 2e5)
    return sampled(
        ca.Function("step", [ca.SX.sym("calls"), speeds, ca.SX(0, 1)], [ca.SX(1.0), demands]),
        period=10e-3,
        states=[("calls", "1", 0.0)],
        inputs=[(wheel.format(i=i), "rad/s", 0.0) for i in range(1, 5)],
        outputs=[(demand.format(i=i), "Pa", 0.0) for i in range(1, 5)],
    )


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("roles")


PLANTS = {"TwoPartTrain", "ForeignTrain", "unnumbered"}
CONTROLLERS = {"law", "numbered", "renamed"}
ADVICE = table(__file__, "tables.toml")["advice"]
FILES = (*sorted(PLANTS), *sorted(CONTROLLERS), "TrainPrediction", "onboard", "sensors", "estimator", "track")


@pytest.fixture(scope="module")
def files(folder: Path) -> dict[str, Path]:
    """Return one FMU of each role, plants and controllers with names of several tools."""
    trapezoid = load(Path("trapezoid"))
    numbered = law(wheel="wheelset_speed_{i}", demand="demand_{i}")
    renamed = law(wheel="omega{i}", demand="p_set{i}")
    found = {name: fmu(name) for name in ("TwoPartTrain", "ForeignTrain", "TrainPrediction")}
    found["unnumbered"] = faulty_fmu(folder, names={"speed": "v_train", "acceleration": "retardation"})
    found["law"] = pack(controller_fmu(trapezoid), folder / "law.fmu")
    found["numbered"] = pack(sources(numbered), folder / "numbered.fmu")
    found["renamed"] = pack(sources(renamed), folder / "renamed.fmu")
    for part in ("onboard", "sensors", "estimator", "track"):
        found[part] = pack(part_fmu(trapezoid, part), folder / f"{part}.fmu")
    return found


def expected_role(name: str) -> str:
    if name in PLANTS:
        return "plant"
    return "controller" if name in CONTROLLERS else {"TrainPrediction": "prediction"}.get(name, name)


def refusal(path: str | Path, *overrides: str) -> str:
    """Return the message of a scenario that is refused; empty if it runs."""
    try:
        run_stop(load(Path(path), ["limits.horizon=0.2 s", *overrides]))
    except RailgripError as problem:
        return str(problem)
    return ""


@pytest.mark.parametrize("key", ["plant", "controller", "prediction"])
@pytest.mark.parametrize("name", FILES)
def test_a_key_accepts_fmus_of_its_role_and_refuses_others_with_their_key(name, key, files, folder):
    """ForeignTrain and similar FMUs have other names: they are refused for lack of a map, not for their role."""
    tables = {
        "plant": ("vehicle", f'plant = "{files[name]}"'),
        "controller": ("controller", f'kind = "fmu"\nfile = "{files[name]}"'),
        "prediction": ("estimator", f'kind = "fmu"\nfile = "{files[name]}"\ntrust = true\nnoise = "ideal"'),
    }
    base, path = folder / "base.toml", folder / f"{name}-{key}.toml"
    stop_of_plant(base, "TwoPartTrain", trust=False)
    path.write_text('extends = "base.toml"\n[{}]\n{}\n'.format(*tables[key]))
    message = refusal(path)
    if expected_role(name) == key:
        wants_map = name in ("ForeignTrain", "unnumbered", "renamed")
        assert "railgrip map" in message or "neither demand nor command" in message if wants_map else message == ""
    else:
        advice = ADVICE[expected_role(name) if expected_role(name) in ADVICE else name]
        assert re.search(advice, message), message


@pytest.mark.parametrize(
    ("actuation", "plant", "remedy"),
    [("ideal", "TwoPartTrainPneumatic", "pneumatic"), ("pneumatic", "TwoPartTrain", "ideal")],
)
def test_a_plant_for_another_actuation_is_refused_with_the_actuation(actuation, plant, remedy):
    message = refusal("trapezoid", f"vehicle.plant={plant}", f"actuation.kind={actuation}")
    assert f"set actuation.kind = '{remedy}'" in message
    assert "[vehicle.map]" not in message


@pytest.mark.parametrize("recipe", ["ContactPoint", "LateralWheelset", "MultiPurposeVehicle", "LateralPrediction"])
def test_a_recipe_that_is_not_a_train_is_refused_with_a_list_of_trains(recipe):
    message = refusal("trapezoid", f"vehicle.plant={recipe}")
    assert "is not a train" in message
    assert "TwoPartTrainPneumatic" in message
    assert "lacks" not in message


@pytest.mark.parametrize(
    ("override", "sentence"),
    [
        ("vehicle.plant=emu387", "[vehicle] plant 'emu387' is a train file of this package; write train = 'emu387'"),
        ("vehicle.plant=TwoPartTran", "did you mean TwoPartTrain?"),
        ("estimator.noise=idal", "did you mean 'ideal'?"),
        ("estimator.model=TrainPredicton", "did you mean 'TrainPrediction'?"),
    ],
)
def test_a_mistyped_plant_or_model_is_refused_with_the_nearest(override, sentence):
    assert sentence in refusal("trapezoid", override)


# ---- output of `railgrip map` runs --------------------------------------------------------------------------------

KNOWN = {
    "wheelset_load": '"130 kN"', "p_max": '"3.4 bar"', "n_units": "3", "r_friction": "0.23", "J": "100",
    "A_piston": "0.0324", "F_spring": "1200", "i_rigging": "6", "eta_rigging": "0.95", "r_wheel": "0.46",
}  # fmt: skip
"""Values that a user fills in."""


def completed(text: str, wheelsets: int, leave_out: str = "") -> str:
    """Return the output of `railgrip map` with a value for each question mark, except for one key."""

    def value(line: re.Match[str]) -> str:
        key = line[1]
        if key == leave_out or key not in KNOWN:
            return ""
        each = f"[{', '.join([KNOWN[key]] * wheelsets)}]"
        return f"{key} = {each if key == 'wheelset_load' else KNOWN[key]}"

    return re.sub(r"^# (\w+) = \?  # required.*$", value, text, flags=re.MULTILINE)


@pytest.fixture(scope="module")
def plant_text(foundry: Path) -> str:
    """Return the printed map of a plant without declared data, with a formation unlike the library's."""
    file = faulty_fmu(foundry, names={"speed": "v_train"})
    return "\n".join(find_mapping(describe(file), wheelsets_per_group=(), speed=20.0, period=1e-2).lines())


def scenario_with(text: str, foundry: Path, folder: Path, controller: str) -> Path:
    return stop_of_plant(folder / "written.toml", foundry / "well.fmu", controller, more=text)


@pytest.mark.parametrize("controller", ["full_brake", "slip_two_state", "slip_three_state"])
def test_the_printed_lines_of_a_plant_are_sufficient_for_a_run(plant_text, controller, foundry, folder):
    text = completed(plant_text.replace("[2, 1, 1, 2]", "[1, 2, 2, 1]"), 6)
    stop = run_stop(load(scenario_with(text, foundry, folder, controller)))
    assert stop.outcome is Outcome.STANDSTILL, stop.reason


@pytest.mark.parametrize("key", ["wheelset_load", "p_max"])
def test_a_line_that_is_always_required_is_named_when_it_is_missing(plant_text, key, foundry, folder):
    assert f"# {key} = ?  # required: " in plant_text
    text = completed(plant_text.replace("[2, 1, 1, 2]", "[1, 2, 2, 1]"), 6, leave_out=key)
    with pytest.raises(RailgripError, match=rf"\[vehicle.formation\] lacks .*{key} \("):
        run_stop(load(scenario_with(text, foundry, folder, "full_brake")))


def test_parameters_with_standard_names_are_printed_with_their_values():
    lines = list(find_mapping(describe(fmu("TwoPartTrain")), wheelsets_per_group=(), speed=20.0, period=1e-3).lines())
    table = tomllib.loads("\n".join(lines))["vehicle"]["formation"]
    assert table["brakes"]["p_max"] == [3.4e5, 2e5, 2e5, 3.4e5]
    assert table["brakes"]["n_units"] == [3, 2, 2, 3]
    assert sum(table["wheelset_load"]) == pytest.approx(84e3 * 9.81, rel=1e-3)


# ---- controllers --------------------------------------------------------------------------------------------------


def test_the_printed_map_of_a_controller_runs(files, folder, capfd):
    printed = done(capfd, "map", files["renamed"]).out
    table = tomllib.loads(printed)["controller"]
    assert table["map"] == {"wheelset_speed": "omega{i}", "demand": "p_set{i}"}
    assert (table["kind"], table["file"]) == ("fmu", "renamed.fmu")
    path = folder / "with_controller.toml"
    path.write_text('extends = "trapezoid"\n' + printed)
    assert refusal(path) == ""


SLIP_ALONE = """
class SlipAlone:
    def start(self, formation):
        self.full = formation.pressure_max
        {more}
    def decide(self, observation):
        return self.full * (observation.slip < 0.2)
"""


def plain_plant(plant_text: str, foundry: Path, folder: Path, controller: str) -> Path:
    """Return a scenario whose plant gives loads, highest pressure and radius only."""
    formation = completed(plant_text.replace("[2, 1, 1, 2]", "[1, 2, 2, 1]"), 6)
    extra = "|".join(KNOWN.keys() - {"wheelset_load", "p_max", "r_wheel"})
    formation = re.sub(rf"^({extra}) = .*$", "", formation, flags=re.MULTILINE)
    path = scenario_with(formation, foundry, folder, "full_brake")
    path.write_text(path.read_text().replace('kind = "full_brake"', controller))
    return path


def test_a_controller_fmu_that_uses_slip_alone_requires_no_other_data(plant_text, files, foundry, folder):
    path = plain_plant(plant_text, foundry, folder, f'kind = "fmu"\nfile = "{files["numbered"]}"')
    stop = run_stop(load(path))
    assert stop.outcome is Outcome.STANDSTILL, stop.reason


@pytest.mark.parametrize(
    ("more", "sentence"),
    [("", ""), ("self.inertia = formation.brakes[0].inertia", r"lacks J \(rotational inertia"),
     ("self.force = formation.brakes[0].pad_force(1e5)", r"lacks A_piston \(of one brake cylinder"),
     ("print(formation)", "")],
)  # fmt: skip
def test_a_class_requires_only_the_data_that_it_reads(more, sentence, plant_text, foundry, tmp_path, capfd):
    module = f"slip_alone_{abs(hash(more))}"
    (tmp_path / f"{module}.py").write_text(SLIP_ALONE.format(more=more))
    path = plain_plant(plant_text, foundry, tmp_path, f'kind = "{module}:SlipAlone"')
    ended = done(capfd, "run", path, "--import-from", tmp_path, "--out", tmp_path / "out")
    assert ended.code == (2 if sentence else 0), ended.err
    assert re.search(sentence, ended.err)
