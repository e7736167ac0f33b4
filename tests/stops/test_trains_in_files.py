"""A train file runs: compiled from components of RailBraking, with the distance of the same train written by hand."""

import shutil
from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from braked import dry
from sampling import FUZZ
from small_train import COUPLED, without_command
from train_stops import filling_of

import railgrip.scenario
from railgrip.base.errors import ScenarioError
from railgrip.report.results import OURS, fmu_tools
from railgrip.rolling_stock.schema import load_train
from railgrip.rolling_stock.stopping import by_hand
from railgrip.scenario.load import load
from railgrip.scenario.outcome import Outcome
from railgrip.simulate import named_models
from railgrip.simulate.named_models import plant_description
from railgrip.simulate.run import braking_distance, run_stop, trace_of
from railgrip.simulate.vehicle_data import VehicleData
from railgrip.vehicle.signals import PLANT

TRAINS = Path(railgrip.scenario.__file__).parent / "trains"
EXAMPLES = Path(__file__).parents[2] / "docs" / "examples"


@pytest.fixture(scope="module")
def direct(tmp_path_factory):
    """Return the folder of direct.toml, the two-part train without its electropneumatic command.

    tests/stops/test_detailed_mechanics.py has the same class, which is therefore built once.
    """
    folder = tmp_path_factory.mktemp("direct")
    text = (TRAINS / "vt642.toml").read_text(encoding="utf-8")
    (folder / "direct.toml").write_text(without_command(text), encoding="utf-8")
    return folder


def test_bogies_of_train_files_are_wired_as_the_bogie_of_the_library(direct):
    """`plant.mo.jinja` has the parts of `Components.Bogie`, of which TwoPartTrain consists, next to each other.

    The same train gives the same outputs but for rounding, which the stop amplifies little: groups brake differently,
    slide and lock. Its electropneumatic command is left out, which TwoPartTrain lacks.
    """
    each = {"pressure": ["1 bar", "1.5 bar", "0.3 bar", "2 bar"], "until": {"duration": "2 s"}}
    phases = [each, {"pressure": 0, "until": {"duration": "1 s"}}, {"pressure": "full"}]
    adhesion = load(Path("random")).resolved()["adhesion"]
    of_bogies, of_file = (
        dry(vehicle, "40 km/h", direct, adhesion=adhesion, demand={"phases": phases})
        for vehicle in ({"plant": "TwoPartTrain"}, {"train": "direct.toml"})
    )
    remedy = "change modelica/RailBraking/Components/Bogie.mo and harness/rolling_stock/plant.mo.jinja alike"
    states, others = (
        Counter(name.rpartition(".")[2] for name in VehicleData(scenario).file.states)
        for scenario in (of_bogies, of_file)
    )
    assert states == others, f"the states of both trains differ: {remedy}"
    trace, other = trace_of(of_bogies), trace_of(of_file)
    assert trace["locked"].values.any()
    assert trace.sizes == other.sizes, f"both trains stop at different times: {remedy}"
    for signal in PLANT:
        values = trace[signal.name].values
        scale = np.abs(values).max()
        np.testing.assert_allclose(other[signal.name].values, values, rtol=0, atol=1e-9 * scale, err_msg=remedy)


@pytest.mark.parametrize(("train", "actuation"), [("tram", "ideal"), ("vt642", "pneumatic")])
def test_a_named_train_stops_as_calculated_by_hand(train, actuation):
    """Within 3 %; valves add up to their dead time and filling time constant, 0.45 s."""
    scenario = dry({"train": train}, "50 km/h", actuation={"kind": actuation})
    stop = run_stop(scenario)
    assert stop.outcome is Outcome.STANDSTILL, stop.reason
    expected = by_hand(load_train(Path(train)), 50 / 3.6).distance
    late = stop.metrics.distance - expected
    assert -0.03 * expected < late < 0.03 * expected + (0.45 * 50 / 3.6 if actuation == "pneumatic" else 0.0)


def test_kinds_of_bogies_with_similar_names_keep_their_pads(tmp_path):
    """Friction of the first two pads falls with speed, that of the last does not: a difference of a tenth or more.

    Coupled axles and three bogies instead of four take half as long to build.
    """
    text = COUPLED.replace("NAME", "alike")
    head, cars = text.split("[[cars]]", 1)
    bogie = head[head.index("[bogies.trailer]") : head.index("[couplers.bar]")]
    pads = head[head.index("[pads.organic]") : head.index("[brakes.disc]")]
    brake = head[head.index("[brakes.disc]") : head.index("# [track_brakes")]
    head = head.replace(bogie, "").replace(pads, "").replace(brake, "")
    pads = pads.replace('"13 m/s"', '"9 m/s"')
    for kind, effect in (("tr-a", 0.8), ("tr.a", 0.8), ("tr_a", 0.0)):
        new = pads.replace("pads.organic", f'pads."{kind}"').replace("effect = 0.12 ", f"effect = {effect} ")
        new += brake.replace("brakes.disc", f'brakes."{kind}"').replace('"organic"', f'"{kind}"')
        head += new + bogie.replace("bogies.trailer", f'bogies."{kind}"').replace('"disc"', f'"{kind}"')
    for kind in ("tr-a", "tr.a", "tr_a"):
        cars = cars.replace('"trailer"', f'"{kind}"', 1)
    cars = cars.replace(', { kind = "trailer", at = "20.5 m" }', "")
    (tmp_path / "alike.toml").write_text(f"{head}[[cars]]{cars}", encoding="utf-8")
    expected = by_hand(load_train(tmp_path / "alike.toml"), 120 / 3.6).distance
    distance = braking_distance(dry({"train": "alike.toml"}, "120 km/h", tmp_path))
    assert distance == pytest.approx(expected, rel=0.03)  # as for the trains of the library


def test_a_train_file_has_one_central_filter_in_four_ways(direct):
    """A class from its nominal data: as generated C, in numpy, as a recorded FMU, and as one that integrates itself."""
    adhesion = load(Path("plain")).resolved()["adhesion"] | {"mu0": 0.08}
    ways = [{"kind": kind} for kind in ("compiled", "python", "fmu")]
    ways.append({"kind": "fmu", "interface": "co_simulation"})
    estimates = []
    for way in ways:
        changes = {"estimator": way | {"noise": "ideal"}, "controller": {"kind": "slip_two_state"}}
        stop = run_stop(dry({"train": "direct.toml"}, "15 km/h", direct, adhesion=adhesion, **changes))
        assert ("ConsistPrediction.fmu" in stop.fmus) == (way["kind"] == "fmu")
        estimates.append(stop.trace[["estimate_adhesion", "estimate_slip", "estimate_pad_friction"]].to_array().values)
        rolling = (stop.trace["time"] > 0.5) & (stop.trace["speed"] > 1)
        truth = stop.trace["group_adhesion"].values[rolling]
        assert np.abs(estimates[-1][0][rolling] - truth).max() < 0.01
    for found, error in zip(estimates[1:], (1e-9, 1e-9, 1e-6), strict=True):
        np.testing.assert_allclose(found, estimates[0], rtol=1e-6, atol=error)


@pytest.fixture
def coaches(tmp_path):
    """Return a scenario's [vehicle] of coaches with a brake pipe, the second one without a distributor."""

    def vehicle(name, count=2, metres=24, **keys):
        text = COUPLED.replace("NAME", name)
        begin, resistance, cars = text.index("[command]"), text.index("[resistance]"), text.index("[[cars]]")
        pipe = '[command]\nkind = "brake_pipe"\ndiameter = "32 mm"\nbranch_volume = "3 l"\nfill_time = "4 s"\n'
        pipe += 'reservoir = "150 l"\nestimated = true\n'
        tables = "\n".join(line.removeprefix("# ") for line in text[text.index("# [distributors") : cars].splitlines())
        rest = text[resistance : text.index("# [distributors")]
        own = "".join(
            f'[[cars]]\nname = "{i}"\nlength = "{metres} m"\nmass = "22 t"\nestimated = true\n'
            + f'bogies = [{{ kind = "trailer", at = "{metres // 2} m" }}]\n'
            + "".join(f'{key} = "{value}"\n' for key, value in keys.items() if i != 1 or key != "distributor")
            for i in range(count)
        )
        file = tmp_path / f"{name}.toml"
        file.write_text(text[:begin] + pipe + rest + tables + "\n" + own, encoding="utf-8")
        return {"train": file.name}

    return vehicle


@pytest.mark.parametrize("actuation", ["ideal", "pneumatic"])
def test_position_r_goes_low_at_its_changeover_speed(coaches, tmp_path, actuation):
    """A coach with a distributor has half of the pressure below 50 km/h, and not before; the one without has all."""
    scenario = dry(coaches("staged", distributor="R"), "120 km/h", tmp_path, actuation={"kind": actuation})
    stop = run_stop(scenario)
    assert stop.outcome is Outcome.STANDSTILL, stop.reason
    speed, pressure = stop.trace["speed"].values, stop.trace["cylinder_pressure"].values
    full = 3.2e5
    high = (speed > 50 / 3.6) & (stop.trace["time"].values > 8)
    assert pressure[high] == pytest.approx(full, rel=1e-2)
    falling = np.argmax((pressure[:, 0] < 0.995 * full) & (stop.trace["time"].values > 8))
    # Valves follow with 0.4 s, in which the train loses half a kilometre an hour.
    assert 3.6 * speed[falling] == pytest.approx(50, abs=0.2 if actuation == "ideal" else 0.5)
    assert pressure[-1] == pytest.approx([full / 2, full], rel=1e-2)
    by_calculation = by_hand(load_train(tmp_path / "staged.toml"), 120 / 3.6).distance
    assert stop.metrics.distance == pytest.approx(by_calculation, rel=0.03)


def test_a_stop_started_between_both_speeds_is_in_the_low_stage(coaches, tmp_path):
    stop = run_stop(dry(coaches("staged", distributor="R"), "60 km/h", tmp_path))
    assert float(stop.trace["cylinder_pressure"].values[:, 0].max()) == pytest.approx(1.6e5, rel=1e-2)


def test_accelerators_speed_up_the_brake_of_a_long_train(coaches, tmp_path):
    """Position P fills in 3 to 5 s. No front is faster than a small wave, which branches slow down from 290 m/s.

    With cells of 9.6 m the foot of a front with accelerators is ahead by some per cent. Only with accelerators does the
    front reach the 250 m/s of UIC 540. The pipe is that of eight coaches, in four of twice the length and with
    accelerators twice as large: a quarter of the build time of eight.
    """
    fillings, limits = [], load(Path("plain")).resolved()["limits"] | {"horizon": "10 s"}  # all are full after 8
    for keys in ({}, {"accelerator": "quick"}):
        name = "".join(("pipe", *keys))
        vehicle = coaches(name, 4, 48, **keys)
        file = tmp_path / vehicle["train"]
        file.write_text(file.read_text(encoding="utf-8").replace("2e-7 m3/(s.Pa)", "4e-7 m3/(s.Pa)"), encoding="utf-8")
        stop = run_stop(dry(vehicle, "120 km/h", tmp_path, limits=limits))
        fillings.append(filling_of(load_train(file), stop.trace))
    plain, quick = fillings
    for one in fillings:
        assert np.all((one.filling > 3.0) & (one.filling < 5.0))
    small_wave = 290.0 / (1 + 3e-3 / (48 * np.pi / 4 * 0.032**2)) ** 0.5
    assert 240.0 < plain.propagation < 250.0 < quick.propagation < 1.05 * small_wave
    assert quick.propagation > 1.03 * plain.propagation
    assert quick.begin[-1] + quick.filling[-1] < plain.begin[-1] + plain.filling[-1] - 0.05


COMPILED_QUICKLY = {"eanos_wagon", "tram", "two_axle_wagon"}
"""Trains that OpenModelica compiles quickly; `make fuzz` has all but the forty wagons of freight_train."""


@pytest.mark.omc
@pytest.mark.skipif(shutil.which("omc") is None, reason="OpenModelica's omc is not on the PATH")
@pytest.mark.parametrize(("speed", "mu0"), [("85 km/h", 0.5), ("40 km/h", 0.05)], ids=["dry", "low adhesion"])
@pytest.mark.parametrize(
    "vehicle",
    [
        *(
            pytest.param({"train": path.stem}, id=path.stem)
            for path in sorted(TRAINS.glob("*.toml"))
            if path.stem in COMPILED_QUICKLY or (FUZZ and path.stem != "freight_train")
        ),
        pytest.param(
            {"model": "SimpleTrain.FreightTrain", "library": f"{EXAMPLES}/SimpleTrain/package.mo"}, id="SimpleTrain"
        ),
        pytest.param({"model": "MyTrains.Wagon", "library": "MyTrains.mo"}, id="own_modelica.md"),
    ],
)
def test_a_stop_has_the_same_distance_with_the_fmu_of_either_compiler(vehicle, speed, mu0, tmp_path, monkeypatch):
    page = (EXAMPLES.parent / "tutorials" / "own_modelica.md").read_text(encoding="utf-8")
    text = page.partition('Path("MyTrains.mo").write_text("""')[2].partition('"""')[0]
    (tmp_path / "MyTrains.mo").write_text(text, encoding="utf-8")
    distances: dict[str, float] = {}
    for compiler in ("native", "openmodelica"):
        monkeypatch.setattr("railgrip.fmus.build.choose", lambda wanted, compiler=compiler: compiler)
        for kept in (named_models._train_file, named_models._class_file):
            kept.cache_clear()
        stop = run_stop(dry(vehicle, speed, tmp_path, mu0=mu0))
        assert stop.outcome is Outcome.STANDSTILL, stop.reason
        (tool,) = fmu_tools(stop.versions).values()
        assert tool.startswith(OURS) == (compiler == "native")
        distances[compiler] = stop.metrics.distance
    assert distances["openmodelica"] == pytest.approx(distances["native"], rel=2e-3)


def test_its_formation_is_that_of_the_file():
    scenario = dry({"train": "tram"}, "50 km/h")
    formation = VehicleData(scenario).formation
    assert formation.wheelsets_per_group == (1, 1, 1, 1)
    assert formation.wheelset_position == pytest.approx((0, 1.9, 6.4, 8.3))


def test_a_changed_file_is_another_train_and_a_moved_one_the_same(tmp_path):
    shutil.copy(TRAINS / "tram.toml", tmp_path / "mine.toml")
    named, copied = dry({"train": "tram"}, "50 km/h"), dry({"train": "mine.toml"}, "50 km/h", tmp_path)
    assert plant_description(named).digest == plant_description(copied).digest
    assert named.resolved()["vehicle"]["train"] == "tram"
    before = copied.digest()
    text = (tmp_path / "mine.toml").read_text(encoding="utf-8")
    (tmp_path / "mine.toml").write_text(text.replace('mass = "16 t"', 'mass = "17 t"'), encoding="utf-8")
    changed = dry({"train": "mine.toml"}, "50 km/h", tmp_path)
    assert changed.digest() != before


def test_an_invalid_train_is_refused_in_a_sentence(tmp_path):
    with pytest.raises(ScenarioError, match=r"\[vehicle\] train is 'nothing': there is no such file, and no train"):
        dry({"train": "nothing"}, "50 km/h")
    (tmp_path / "bad.toml").write_text('name = "bad"\n', encoding="utf-8")
    with pytest.raises(ScenarioError, match=r"bad.toml: \[brakes\] is missing"):
        plant_description(dry({"train": "bad.toml"}, "50 km/h", tmp_path))


def test_an_unknown_load_changes_the_mass_and_not_the_initial_speed():
    """A fifth more mass takes about a fifth more distance: brakes and rotating masses do not change."""
    stop, heavy = (run_stop(dry({"train": "tram"}, "50 km/h", truth={"load": load})) for load in ([1.0], [1.2]))
    assert float(heavy.trace["speed"].values[0]) == pytest.approx(50 / 3.6, rel=1e-9)
    assert 1.1 < heavy.metrics.distance / stop.metrics.distance < 1.25
