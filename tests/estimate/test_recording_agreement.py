"""A recording whose signals contradict each other is refused or reported, and one that is right is not.

Right recordings come from Newton's second law: speed and slip are chosen, and pad forces follow from

    F = m (-v' + g gradient) - drag,    T_i = r_i F_i - J w_i'
"""

import re
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import xarray
from hypothesis import given, settings
from hypothesis import strategies as st
from sampling import FUZZ
from typer.testing import CliRunner

import railgrip as rg
from railgrip.base.errors import EstimationError
from railgrip.cli.app import app
from railgrip.estimation.agreement import disagreements
from railgrip.estimation.sources import recording_of_estimation
from railgrip.estimation.spec import LIBRARY, load_specification
from railgrip.recording.samples import recording_of

PERIOD, G = 0.02, 9.81
MASS, INERTIA, RADIUS, UNITS, R_FRICTION, DRAG = 40e3, 130.0, 0.46, 2.0, 0.25, 1.2 / 2 * 0.9 * 10.0
"""Parameters of WagonPrediction."""

NOISE = {"speed": 0.01, "wheelset_speed": 0.02, "pad_force": 100.0}
SIGNALS = ("speed", "wheelset_speed[1]", "wheelset_speed[2]", "pad_force[1]", "pad_force[2]")


def wagon(
    *,
    start=30.0,
    braking=0.8,
    gradient=0.0,
    loading=1.0,
    friction=0.35,
    radii=(1.0, 1.0),
    slides=(),
    coasting=8.0,
    seed=0,
) -> dict[str, np.ndarray]:
    """Time and signals of a wagon that coasts and then brakes to 1 m/s.

    Args:
        braking: Deceleration by the brakes [m/s2].
        gradient: Positive downhill.
        loading, radii: Mass and radii relative to those of the model.
        slides: Wheelset, start after brake application [s], duration [s] and depth of each slide.
    """
    mass, radius = MASS * loading, RADIUS * np.array(radii)
    time, speed, forces = [0.0], [start], []
    while speed[-1] > 1.0 and time[-1] < 150.0:
        forces.append(mass * braking * np.clip((time[-1] - coasting) / 1.0, 0.0, 1.0))
        slowing = (forces[-1] + DRAG * speed[-1] ** 2) / mass - G * gradient
        speed.append(speed[-1] - PERIOD * slowing)
        time.append(time[-1] + PERIOD)
    t, v, force = np.array(time[:-1]), np.array(speed[:-1]), np.array(forces)
    slip = np.outer(0.01 * force / mass, [1.0, 1.0])
    for wheelset, begin, length, depth in slides:
        inside = np.clip((t - coasting - 1.0 - begin) / length, 0.0, 1.0)
        slip[:, wheelset] += depth * np.sin(np.pi * inside) ** 2
    w = (1.0 - np.minimum(slip, 0.97)) * v[:, None] / radius
    torque = radius * force[:, None] / 2.0 - INERTIA * np.gradient(w, PERIOD, axis=0)
    pads = np.maximum(torque / (UNITS * friction * R_FRICTION), 0.0) * (force[:, None] > 0.0)
    noise = np.random.default_rng(seed).standard_normal((5, t.size))
    values = [v, w[:, 0], w[:, 1], pads[:, 0], pads[:, 1]]
    signals = {
        name: column + NOISE[name.partition("[")[0]] * white
        for name, column, white in zip(SIGNALS, values, noise, strict=True)
    }
    return {"time": t} | signals


def recording(signals: dict[str, np.ndarray]) -> xarray.Dataset:
    units = {"speed": "m/s", "wheelset_speed": "rad/s", "pad_force": "N"}
    readings = {name: (signals[name], units[name.partition("[")[0]]) for name in SIGNALS}
    count = signals["time"].size
    readings |= {name: (np.zeros(count), "N.m") for name in ("wheel_torque[1]", "wheel_torque[2]")}
    return recording_of(readings | {"track_force": (np.zeros(count), "N")}, period=PERIOD, name="run")


def changed(signals: dict[str, np.ndarray], base: str, change) -> dict[str, np.ndarray]:
    """Return the signals; a function of time and values changes those named `base`."""
    return {name: change(signals["time"], x) if name.startswith(base) else x for name, x in signals.items()}


def times(factor):
    return lambda time, values: factor * values


def later(delay=0.0, drift=0.0):
    return lambda time, values: np.interp((1.0 - drift) * time - delay, time, values)


def kinds(signals: dict[str, np.ndarray]) -> list[str]:
    return [each.kind for each in disagreements(load_specification(Path("wagon")), recording(signals))]


# ---- recordings that were once estimated without a warning ---------------------------------------------------

MAP = """
extends = "wagon"
[data]
time = { column = "time", unit = "s" }
period = "20 ms"
longest_gap = "100 ms"
frozen = "2 s"
spike = 8.0
CONTRADICTIONS
[data.columns]
speed = { column = "v", unit = "km/h" }
"wheelset_speed[1]" = { column = "n1", unit = "rev/min" }
"wheelset_speed[2]" = { column = "n2", unit = "rev/min" }
"pad_force[1]" = { column = "F1", unit = "kN" }
"pad_force[2]" = { column = "F2", unit = "kN" }
track_force = { value = "0 N" }
"wheel_torque[1]" = { value = "0 N.m" }
"wheel_torque[2]" = { value = "0 N.m" }
"""
CASES = [
    ("speed", times(1 / 3.6), 2, r"\(column 'v'\).*Ratio 3\.6: is column 'v' in m/s, not km/h\?"),
    ("wheelset_speed", times(np.pi / 30), 2, r"\(columns 'n1', 'n2'\).*is column 'n1' in rad/s, not rev/min\?"),
    ("wheelset_speed", times(2.0), 2, r"wheelset_speed \(columns 'n1', 'n2'\).* is 2 times speed .* expected is 1"),
    ("pad_force", times(10.0), 2, r"brake force computed from pad_force \(columns 'F1', 'F2'\).* is 10 times"),
    ("wheelset_speed", later(0.5), 0, r"wheelset_speed \(columns 'n1', 'n2'\) is about 0\.\d+ s behind speed"),
    ("wheelset_speed", later(drift=0.01), 0, r"wheelset_speed .* behind .* clocks run (1|0\.9) % slow\?"),
]  # fmt: skip


def written(folder: Path, signals: dict[str, np.ndarray], contradictions: str = "") -> list[str]:
    """Write a recording in customary units and its estimation; return the arguments of `railgrip estimate`."""
    rates = {"speed": 3.6, "wheelset_speed": 30 / np.pi, "pad_force": 1e-3}
    columns = dict(zip(SIGNALS, ("v", "n1", "n2", "F1", "F2"), strict=True))
    frame = {"time": signals["time"]}
    frame |= {columns[name]: rates[name.partition("[")[0]] * signals[name] for name in SIGNALS}
    pd.DataFrame(frame).to_csv(folder / "run.csv", index=False)
    (folder / "run.toml").write_text(MAP.replace("CONTRADICTIONS", contradictions), encoding="utf-8")
    return ["estimate", str(folder / "run.toml"), "--data", str(folder / "run.csv"), "--out", str(folder / "out")]


@pytest.mark.usefixtures("blank_figures")
@pytest.mark.parametrize(("base", "change", "code", "sentence"), CASES)
def test_a_wrong_scale_or_clock_is_refused_or_reported(tmp_path, base, change, code, sentence):
    """Impossible signals are refused unless [data] accepts them; doubtful ones are reported in output and result."""
    signals = changed(wagon(), base, change)
    result = CliRunner().invoke(app, written(tmp_path, signals))
    if code:
        assert isinstance(result.exception, EstimationError), result.output
        with pytest.raises(EstimationError, match=rf"^run\.csv: .*{sentence}"):
            raise result.exception
        assert not (tmp_path / "out").exists()
        result = CliRunner().invoke(app, written(tmp_path, signals, 'contradictions = "warn"'))
    assert result.exit_code in (0, 3), result.output
    estimates = xarray.load_dataset(tmp_path / "out" / "estimates.nc", engine="h5netcdf")
    (warning,) = estimates.attrs["warnings"].splitlines()[:1]
    assert re.search(rf"^run\.csv: .*{sentence}", warning)
    assert warning in result.output
    if not code:
        assert f"warning: {warning}" in repr(rg.estimate(tmp_path / "run.csv", tmp_path / "run.toml"))


def test_a_unit_in_the_header_is_named_as_the_cause(tmp_path):
    """A force in newtons whose header says kilonewtons is a thousand times too large."""
    arguments = written(tmp_path, changed(wagon(), "pad_force", times(1e3)))
    for name in ("run.csv", "run.toml"):
        text = (tmp_path / name).read_text(encoding="utf-8")
        text = text.replace(', unit = "kN"', "").replace('"F1"', '"F1 [kN]"').replace('"F2"', '"F2 [kN]"')
        (tmp_path / name).write_text(text.replace("F1,F2", "F1 [kN],F2 [kN]"), encoding="utf-8")
    result = CliRunner().invoke(app, arguments)
    assert "is column 'F1 [kN]' in N, not kN?" in str(result.exception)


# ---- the same for random values -----------------------------------------------------------------------------------

SLIDES = st.lists(
    st.tuples(st.integers(0, 1), st.floats(0.0, 20.0), st.floats(1.0, 5.0), st.floats(0.05, 0.9)), max_size=8
)
"""Up to eight slides of one or both wheelsets, down to a tenth of the speed."""
TAME = {"start": (20.0, 50.0), "braking": (0.6, 1.3), "gradient": (-5e-3, 5e-3), "coasting": (5.0, 20.0)}
"""Ranges for stops with enough adhesion to reveal a delay, which slip would hide."""


def vehicles(radius=0.02, **ranges):
    """Arguments of `wagon` within ranges, `TAME` unless given, and radii within a share of their size."""
    numbers = {name: st.floats(*ends) for name, ends in (TAME | ranges).items()}
    radii = st.floats(1.0 - radius, 1.0 + radius)
    return st.fixed_dictionaries(numbers | {"radii": st.tuples(radii, radii), "seed": st.integers(0, 9)})


def scales(low, high):
    """Factors between these, and their reciprocals."""
    return st.floats(low, high).flatmap(lambda factor: st.sampled_from([factor, 1.0 / factor]))


VARIED = vehicles(
    0.03, start=(12.0, 50.0), braking=(0.4, 1.3), gradient=(-25e-3, 25e-3), loading=(0.7, 1.3), friction=(0.25, 0.45),
    coasting=(0.0, 20.0),
)  # fmt: skip
few = settings(max_examples=100 if FUZZ else 12, derandomize=True)


@given(VARIED, SLIDES)
def test_no_consistent_recording_disagrees(vehicle, slides):
    """Slides to a tenth of the speed, radii 3 % off, gradients of 25 per mille, loads 30 % off, other pads."""
    assert kinds(wagon(**vehicle, slides=slides)) == []


@few
@given(vehicles(), SLIDES, scales(1.75, 60.0), st.sampled_from(["speed", "wheelset_speed"]))
def test_every_wrong_speed_scale_is_impossible(vehicle, slides, factor, base):
    signals = changed(wagon(**vehicle, slides=slides), base, times(factor))
    found = disagreements(load_specification(Path("wagon")), recording(signals))
    assert [each.kind for each in found][:1] == ["scale"]
    assert found[0].is_impossible


@few
@given(vehicles(), scales(1.1, 1.5))
def test_every_wrong_radius_is_reported_and_accepted(vehicle, factor):
    signals = changed(wagon(**vehicle), "wheelset_speed", times(factor))
    found = disagreements(load_specification(Path("wagon")), recording(signals))
    assert {each.kind for each in found} == {"scale"}
    assert not any(each.is_impossible for each in found)


@few
@given(vehicles(loading=(0.7, 1.3)), SLIDES, scales(8.0, 1000.0))
def test_every_wrong_force_scale_is_reported(vehicle, slides, factor):
    assert "brake force" in kinds(changed(wagon(**vehicle, slides=slides), "pad_force", times(factor)))


@pytest.mark.parametrize("place", ["[1] is", "fastest", "mean"])
@pytest.mark.parametrize("resolution", [1e-4, 0.1 / 3.6])
def test_a_speed_that_is_computed_from_axles_that_slide_is_impossible(place, resolution):
    signals = wagon(slides=[(0, 2.0, 1.5, 0.3), (1, 2.2, 1.5, 0.3), (0, 8.0, 1.5, 0.3), (1, 8.2, 1.5, 0.3)])
    rims = RADIUS * np.stack([signals["wheelset_speed[1]"], signals["wheelset_speed[2]"]])
    source = {"[1] is": rims[0], "fastest": rims.max(axis=0), "mean": rims.mean(axis=0)}[place]
    recorded = recording(signals | {"speed": np.round(source / resolution) * resolution})
    (found,) = [each for each in disagreements(load_specification(Path("wagon")), recorded) if each.kind == "origin"]
    assert place.split()[0] in found.sentence
    assert found.is_impossible
    # With an accelerometer it is reported only.
    measured = np.gradient(signals["speed"], PERIOD)
    with_one = recorded.assign(reading_acceleration=("time", measured, {"units": "m/s2"}))
    found = disagreements(load_specification(Path("wagon")), with_one)
    assert [each.is_impossible for each in found if each.kind == "origin"] == [False]


@few
@given(vehicles(), st.floats(0.5, 3.0))
def test_every_late_wheelset_is_reported(vehicle, delay):
    assert "timing" in kinds(changed(wagon(**vehicle), "wheelset_speed", later(delay)))


def test_most_early_wheelsets_are_reported():
    """At good adhesion: a steady slip speed, as on a poor rail, looks like a lead, so a few are missed."""
    draw = np.random.default_rng(7)
    found = []
    for seed in range(40):
        vehicle = {name: draw.uniform(*ends) for name, ends in TAME.items()}
        signals = wagon(**vehicle, radii=draw.uniform(0.98, 1.02, 2), seed=seed)
        found.append("timing" in kinds(changed(signals, "wheelset_speed", later(-draw.uniform(0.5, 3.0)))))
    assert np.mean(found) >= 0.8


@few
@given(vehicles(start=(35.0, 65.0), coasting=(15.0, 30.0)), st.floats(0.01, 0.05))
def test_every_slow_clock_is_reported(vehicle, drift):
    """In a long run: 1 % of 40 s is 0.4 s."""
    assert "timing" in kinds(changed(wagon(**vehicle), "wheelset_speed", later(drift=drift)))


# ---- recordings of simulated stops ----------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["wagon", "rig_own", "rig_paper", "field"])
def test_recordings_of_the_library_agree(name):
    specification = load_specification(LIBRARY / f"{name}.toml")
    assert disagreements(specification, recording_of_estimation(specification)) == []


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"vehicle.parameters": {f"r_wheel[{i}]": 0.38 * f for i, f in enumerate((0.97, 1.03, 1.0, 0.98), start=1)}},
        {"controller": {"kind": "full_brake"}},
    ],
    ids=["slides", "radii", "locked"],
)  # fmt: skip
@pytest.mark.parametrize("scenario", ["trapezoid", "sine_sweep"])
def test_stops_of_a_train_at_low_adhesion_agree(scenario, changes):
    """The adhesion of these scenarios is a third of the demand, so wheelsets slide throughout or lock."""
    stop = rg.run(rg.Scenario.load(scenario).changed(changes))
    trace = stop.trace.assign(reading_track_force=("time", np.zeros(stop.trace.sizes["time"]), {"units": "N"}))
    assert disagreements(load_specification(LIBRARY / "stop.toml"), trace) == []
