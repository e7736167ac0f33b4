"""Demands of the driver through brake pipe and wire: graduated steps, release, re-application, and reservoirs."""

import re

import numpy as np
import pytest
from braked import dry
from small_train import COUPLED, dynamic_brake, halved, with_constant_friction
from synthetic import MOTOR

from railgrip.base.errors import ScenarioError
from railgrip.rolling_stock.check import findings
from railgrip.rolling_stock.schema import load_train
from railgrip.simulate.run import run_stop

FULL, FREE = 3.2e5, 101325.0  # Pa
UNITS = 8  # of a car: two bogies of two axles with two units each
CYLINDER = 3e-3  # m3, of a unit


def write(folder, name, *, command=None, air="", second=True):
    """Write the file of a train; one with a second car has a single bogie there, which is also built sooner."""
    begin, end, last = COUPLED.index("[command]"), COUPLED.index("[resistance]"), COUPLED.rindex("[[cars]]")
    text = COUPLED[:begin] + (COUPLED[begin:end] if command is None else command) + air + COUPLED[end:last]
    if second:
        text += halved(COUPLED[last:])
    else:
        text = re.sub(r'^coupler = "bar".*\n', "", text, flags=re.MULTILINE)
    (folder / f"{name}.toml").write_text(text.replace("NAME", name), encoding="utf-8")
    return folder / f"{name}.toml"


def stop_of(file, phases):
    """Return a stop with phases of demands: (pressure, duration in s), the last one without."""
    *first, last = phases
    demand = {"phases": [{"pressure": p, "until": {"duration": t}} for p, t in first] + [{"pressure": last}]}
    pneumatic = {"actuation": {"kind": "pneumatic"}, "demand": demand}
    return run_stop(dry({"train": file.name}, "100 km/h", file.parent, mu0=0.3, **pneumatic)).trace


PIPE = """[command]
kind = "brake_pipe"
diameter = "32 mm"
branch_volume = "3 l"
fill_time = "4 s"
reservoir = "100 l"
estimated = true

"""


def test_a_brake_pipe_applies_in_steps_releases_and_applies_again(tmp_path):
    """1 % of the full pressure is what leaks and the control of the pipe leave.

    The release choke has the time constant 17 s/ln(p_max/0.4 bar); a second is what the pipe takes to be filled.
    """
    file = write(tmp_path, "piped", command=PIPE)
    trace = stop_of(file, [(0, 2), (0.4 * FULL, 8), (0.2 * FULL, 12), (0, 12), "full"])
    pressure = trace["cylinder_pressure"].values[:, 0]

    def at(time):
        return pressure[np.searchsorted(trace["time"].values, time)]

    assert pressure[trace["time"].values < 2.0].max() == 0.0
    assert [at(9.9), at(21.9)] == pytest.approx([0.4 * FULL, 0.2 * FULL], abs=0.01 * FULL)
    choke = 17 / np.log(FULL / 0.4e5)
    released = trace["time"].values[np.flatnonzero((pressure < 0.4e5) & (trace["time"].values > 22))[0]] - 22
    assert 0.0 < released - choke * np.log(0.2 * FULL / 0.4e5) < 1.0
    assert at(33.9) < 0.2e5
    assert at(40.0) == pytest.approx(FULL, rel=0.01)  # applied again, within 4 s and the rise of the pipe
    assert np.all(np.diff(trace["reservoir_pressure"].values) < 1.0)  # nothing fills the reservoirs


def test_a_group_is_not_braked_beyond_its_demand(tmp_path):
    """The pipe brings the largest demand to all cars; 3 % of full pressure is the band of the valves."""
    file = write(tmp_path, "piped", command=PIPE)
    groups = [0.2 * FULL, 0, 0.4 * FULL]
    trace = stop_of(file, [(groups, 8), (0, 4), "full"])
    pressure = trace["cylinder_pressure"].values[np.searchsorted(trace["time"].values, 7.9)]
    assert pressure[2] == pytest.approx(0.4 * FULL, abs=0.01 * FULL)
    assert pressure[:2] == pytest.approx([0.2 * FULL, 0], abs=0.03 * FULL)


AIR = """[air]
main_reservoir = "25 l"
pressure = "7 bar"
reservoir = "21 l"
conductance = "1e-6 m3/(s.Pa)"
compressor = "1e-3 m3/s"
estimated = true

"""


@pytest.fixture(scope="module")
def cycled(tmp_path_factory):
    """Full brake for 3 s and release for 3 s, five times: a car with a small reservoir and a small compressor."""
    file = write(tmp_path_factory.mktemp("air"), "supplied", air=AIR, second=False)
    return stop_of(file, [phase for _ in range(5) for phase in (("full", 3), (0, 3))] + ["full"])


def test_reservoirs_balance_compressor_and_cylinders(cycled):
    """(p − p_0) V/p_free = q t − air used, at rest; 2 % of 7 bar is what the check valves hold back in motion."""
    volume, time = 25e-3 + 21e-3, cycled["time"].values
    expected = 7e5 + FREE / volume * (1e-3 * time - cycled["air_used"].values)
    assert cycled["reservoir_pressure"].values == pytest.approx(expected, abs=0.02 * 7e5)
    once = np.searchsorted(time, 2.9)
    filled = UNITS * CYLINDER * cycled["cylinder_pressure"].values[once, 0] / FREE
    assert float(cycled["air_used"][once]) == pytest.approx(filled, rel=0.03)  # and what leaked


def test_an_exhausted_reservoir_limits_the_cylinders(cycled):
    reservoir, pressure = cycled["reservoir_pressure"].values, cycled["cylinder_pressure"].values.max(axis=1)
    braked = cycled["brake_demand"].values == 1.0
    assert reservoir.min() < 0.7 * FULL
    assert np.all(pressure[braked] < np.maximum(reservoir[braked], 1e4) + 0.1 * FULL)
    last = cycled["time"].values > 33.0
    assert pressure[last] == pytest.approx(reservoir[last], rel=0.05)


def test_dynamic_brakes_take_their_part_of_half_a_brake(tmp_path):
    """Friction brakes give way to as much force: the stop is as long as without dynamic brakes.

    2 %: pads fade less where they are relieved, and blending has the nominal friction.
    """
    plain = write(tmp_path, "plain_train", second=False)
    text = with_constant_friction(plain.read_text(encoding="utf-8"))
    plain.write_text(text, encoding="utf-8")
    driven = tmp_path / "driven_train.toml"
    text = text.replace("plain_train", "driven_train")
    text = text.replace("[resistance]", f"{dynamic_brake('motor', MOTOR)}\n[resistance]", 1)
    driven.write_text(text.replace("wheel_radius", 'dynamic_brake = "motor"\nwheel_radius', 1), encoding="utf-8")
    stops = [stop_of(file, [0.5 * FULL]) for file in (plain, driven)]
    half = np.searchsorted(stops[0]["time"].values, 8.0)
    assert stops[0]["cylinder_pressure"].values[half, 0] == pytest.approx(0.5 * FULL, rel=0.01)
    assert stops[1]["cylinder_pressure"].values[half, 0] < 0.3 * FULL
    distances = [float(trace["distance"][-1]) for trace in stops]
    assert distances[1] == pytest.approx(distances[0], rel=0.02)


@pytest.mark.parametrize(
    ("air", "command", "sentence"),
    [
        (AIR.replace('reservoir = "21 l"\n', ""), None, r"\[air\] needs the reservoir of each car"),
        (AIR, PIPE, r"\[air\] needs no reservoir behind a brake pipe"),
        (
            AIR.rstrip() + '\nfeed = "brake_pipe"\n\n',
            None,
            r"\[air\] feed = 'brake_pipe' needs \[command\] kind = 'brake_pipe'",
        ),
        (AIR.rstrip() + '\ncompressor_on = "10 bar"\n\n', None, "compressor_on must be lower"),
        (AIR, "", r"give \[command\], too"),
    ],
)
def test_an_air_supply_that_cannot_be_is_refused(tmp_path, air, command, sentence):
    file = write(tmp_path, "wrong", command=command, air=air)
    with pytest.raises(ScenarioError, match=sentence):
        load_train(file)


def test_a_reservoir_that_a_single_application_empties_is_wrong(tmp_path):
    """7 bar in 20 l less 8 · 3 l of 3.2 bar leave 3.16 bar, isothermally."""
    wrong = [
        remark
        for remark in findings(load_train(write(tmp_path, "small", air=AIR.replace("21 l", "20 l"))))
        if remark.wrong
    ]
    assert [str(remark) for remark in wrong] == [
        "[air] reservoir: of A falls to 3.16 bar when its cylinders fill, below the 3.2 bar of pressure_max; it "
        "needs 20 l"
    ]


@pytest.mark.parametrize(
    ("pressure", "changes", "found"),
    [("5 bar", {"command": PIPE}, "is 5 bar, but its reservoir has only 5"), ("6 bar", {"command": PIPE}, "is 6 bar"),
     ("3.2 bar", {"air": AIR.replace("7 bar", "3 bar")}, "is 3.2 bar, but its reservoir has only 3")],
)  # fmt: skip
def test_cylinders_need_less_pressure_than_their_reservoirs_have(tmp_path, pressure, changes, found):
    file = write(tmp_path, "strong", **changes)
    text = file.read_text(encoding="utf-8")
    assert 'pressure_max = "3.2 bar"' in text
    file.write_text(text.replace('pressure_max = "3.2 bar"', f'pressure_max = "{pressure}"'), encoding="utf-8")
    wrong = [str(remark) for remark in findings(load_train(file)) if remark.wrong]
    assert any(f"[brakes] pressure_max: of A {found}" in sentence for sentence in wrong)
