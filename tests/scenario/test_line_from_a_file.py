"""Gradients from files: CSV and GPX, in either direction of travel, against closed forms."""

import time
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from railgrip.base.errors import ScenarioError
from railgrip.scenario.curve import read_line
from railgrip.scenario.load import load, scenario_of
from railgrip.scenario.track import slope_of, track_force_of
from railgrip.simulate.remarks import remarks_after, remarks_before

SLOPES = "distance [km],slope [permille]\n10.0,5\n11.0,-8\n12.5,0\n14.0,0\n"
HEIGHTS = "distance,height\n0,100\n1000,105\n2500,93\n4000,93\n"
GPX = (
    '<?xml version="1.0"?>\n<gpx xmlns="http://www.topografix.com/GPX/1/1"><trk><trkseg>\n'
    '<trkpt lat="{}" lon="8.0"><ele>100</ele></trkpt>\n'
    '<trkpt lat="{}" lon="8.0"><ele>100</ele></trkpt>\n'
    '<trkpt lat="{}" lon="8.0"><ele>110</ele></trkpt>\n'
    '<trkpt lat="{}" lon="8.0"><ele>105</ele></trkpt>\n</trkseg></trk></gpx>\n'
)


def scenario(folder: Path, text: str, name: str = "line.csv", adhesion: object = None, **keys: object):
    (folder / name).write_text(text, encoding="utf-8")
    table = load(Path("plain")).resolved() | ({"adhesion": adhesion} if adhesion else {})
    table["track"] = {"line": {"file": name, "origin": "10.4 km", "direction": "rising"} | keys}
    return scenario_of(table, directory=folder, origin="own")


def test_slopes_hold_from_their_chainage_on(tmp_path):
    slope = slope_of(scenario(tmp_path, SLOPES).track)
    assert [slope(at) for at in (0.0, 599.9, 600.1, 2099.9, 2100.1, 9e3)] == [0.005, 0.005, -0.008, -0.008, 0.0, 0.0]


def test_in_the_other_direction_slopes_change_their_sign(tmp_path):
    track = scenario(tmp_path, SLOPES, origin="13 km", direction="falling").track
    slope = slope_of(track)
    assert [slope(at) for at in (0.0, 499.9, 500.1, 1999.9, 2000.1, 2999.0)] == [0.0, 0.0, 0.008, 0.008, -0.005, -0.005]
    assert track.line.ends == pytest.approx((-1000.0, 3000.0))
    force = track_force_of(track, 80e3).at(np.array([100.0, 1000.0, 2500.0]))
    assert force == pytest.approx(-80e3 * 9.81 * np.sin(np.arctan([0.0, 0.008, -0.005])))


@pytest.mark.parametrize("is_falling", [False, True])
def test_heights_give_the_same_line_in_either_order(tmp_path, is_falling):
    head, *rows = HEIGHTS.splitlines()
    (tmp_path / "line.csv").write_text("\n".join([head, *(rows[::-1] if is_falling else rows)]), encoding="utf-8")
    line = read_line(tmp_path / "line.csv", 0.2)
    assert line.chainages == pytest.approx([0, 1000, 2500, 4000])
    assert line.slopes == pytest.approx([0.005, -0.008, 0.0])


def test_a_receiver_at_rest_adds_nothing_to_the_length(tmp_path):
    """Its position wanders by decimetres: ten minutes of steps of 0.3 m would be 180 m of line."""
    head, point, tail = GPX.format(47.0, 47.0, 47.01, 47.02).partition('<trkpt lat="47.01"')
    rest = "".join(f'<trkpt lat="{47.0 + 3e-6 * (k % 2):.7f}" lon="8.0"><ele>100</ele></trkpt>\n' for k in range(600))
    for name, text in (("run", head + point + tail), ("rest", head + rest + point + tail)):
        (tmp_path / f"{name}.gpx").write_text(text, encoding="utf-8")
    run, rested = (read_line(tmp_path / f"{name}.gpx", 0.2) for name in ("run", "rest"))
    np.testing.assert_allclose(rested.chainages, run.chainages)


@pytest.mark.parametrize("attribute", ["", 'ele="500" ', 'line="1" ', 'inside="true" '])
def test_a_gpx_track_has_the_length_of_the_meridian(tmp_path, attribute):
    """A degree of latitude at 47.005° is 111132.954 − 559.822 cos 2φ + 1.175 cos 4φ m (WGS84)."""
    text = GPX.format(47.0, 47.0, 47.01, 47.02).replace("<trkpt ", f"<trkpt {attribute}")
    (tmp_path / "line.gpx").write_text(text, encoding="utf-8")
    line = read_line(tmp_path / "line.gpx", 0.2)
    phi = np.radians(47.005)
    length = 0.01 * (111132.954 - 559.822 * np.cos(2 * phi) + 1.175 * np.cos(4 * phi))
    # At 100 m of height the way is longer by 1e-5 or so.
    assert line.chainages == pytest.approx([0, length, 2 * length], rel=5e-5)
    assert line.slopes == pytest.approx([10 / length, -5 / length], rel=5e-5)


AT_0 = {"origin": "0 m"}
"""Keys of a line that is a GPX file."""


POINT_IN_A_POINT = '<gpx><trk>\n<trkpt lat="4" lon="8">\n<trkpt/></trkpt></trk></gpx>'


@pytest.mark.parametrize(
    ("text", "keys", "sentence"),
    [
        (SLOPES, {"origin": "9 km"}, "origin 9000 m in direction 'rising' does not .* line.csv.*10000 m to 14000 m"),
        (SLOPES, {"origin": "14 km"}, "does not lie on line.csv, or at its end"),
        (SLOPES, {"origin": "10 km", "direction": "falling"}, "does not lie on line.csv, or at its end"),
        (SLOPES.replace("-8", "-800"), {}, "line 3: slope must be at least -0.2"),
        (SLOPES.replace("12.5", "10.5"), {}, "line 4: distance does not rise"),
        ("distance,slope\n3000,0.005\n2000,0\n1000,0\n", {}, r"line 3: distance does not rise; sort .*direction ="),
        (HEIGHTS.replace("105", "1050"), {"origin": "0 m"}, "row 2: the height changes by 950 m over 1000 m"),
        ("distance,slope\n0,0.1 %\n100,0\n", {"origin": "0 m"}, "line 2: 2 finite numbers are expected"),
        ("kilometre,slope\n0,1\n1,1\n", {}, "its first line must name distance"),
        (GPX.format(47.0, 47.0, "here", 47.02), AT_0, "line 5: a point of the track needs numbers"),
        (GPX.format(47.0, 47.0, 47.01, 147.0), AT_0, "line 6: latitude"),
        (
            GPX.format(47.0, 47.0, 47.01, 47.02).replace("<ele>110</ele>", ""),
            AT_0,
            "line 5: a point of the track needs",
        ),
        (GPX.format(47.0, 47.0, 47.0, 47.0), AT_0, "at one place"),
        ("<gpx></gpx>", AT_0, "has 0 points"),
        ("<gpx>\n<trk/>\n<trk/></gpx>", AT_0, "line 3: a second track"),
        (POINT_IN_A_POINT, AT_0, "line 3: a point .* within a point"),
        ("distance,slope\n0,0\n", AT_0, "is not XML"),
        ('<!DOCTYPE gpx [<!ENTITY a "b">]><gpx></gpx>', AT_0, "document type"),
        (GPX.format(47.0, 47.0, 47.01, 47.02).replace("110", "1100"), AT_0, "line 5: the height changes by 1000 m"),
    ],
)
def test_a_wrong_line_is_refused_with_its_place(tmp_path, text, keys, sentence):
    name = "line.gpx" if keys is AT_0 else "line.csv"
    with pytest.raises(ScenarioError, match=sentence) as refused:
        scenario(tmp_path, text, name, **keys)
    assert name in str(refused.value)


def test_a_line_and_gradients_are_not_both_given(tmp_path):
    (tmp_path / "line.csv").write_text(SLOPES, encoding="utf-8")
    table = load(Path("plain")).resolved()
    line = {"file": "line.csv", "origin": "11 km", "direction": "rising"}
    table["track"] = {"line": line, "gradient": [{"begin": 0, "slope": 0.01}]}
    with pytest.raises(ScenarioError, match="has a line, which has all gradients"):
        scenario_of(table, directory=tmp_path, origin="own")


def test_noise_of_heights_is_remarked(tmp_path):
    """One metre up and down every 20 m, as receivers have it, is 50 ‰."""
    rows = "\n".join(f"{20 * i},{300 + i % 2}" for i in range(200))
    made = scenario(tmp_path, f"distance,height\n{rows}\n", origin="0 m")
    assert any("has a gradient of 50 ‰" in remark or "of -50 ‰" in remark for remark in remarks_before(made))
    assert not any("[track.line]" in remark for remark in remarks_before(scenario(tmp_path, SLOPES)))


def test_a_stop_beyond_the_end_of_the_line_is_remarked(tmp_path):
    made = scenario(tmp_path, SLOPES, origin="13.9 km")
    assert any("ends 100 m from the start" in remark for remark in remarks_after(made, 20.0, 250.0))
    assert not remarks_after(made, 20.0, 90.0)


FRICTION = {"kind": "points", "over": "distance", "polach": "wet", "origin": "13 km"}
FALLING = {"points": [["14 km", 0.3], ["9 km", 0.05]]}


@pytest.mark.parametrize(
    ("friction", "keys", "sentence"),
    [
        (FALLING, {}, "are falling .*file line.csv has .*'rising': a train is at one chainage and runs one way"),
        (FALLING, {"origin": "11 km", "direction": "falling"}, "origin 13000 m .*file line.csv has origin 11000 m"),
        ({"points": FALLING["points"][::-1]}, {"direction": "falling"}, "are rising"),
        ("14,0.3\n9,0.05", {}, "file rail.csv has .* chainages that are falling"),
        (FALLING, {"origin": "13000 m", "direction": "falling"}, ""),
        ({"points": [["9 km", 0.1]]}, {}, ""),
        ("14,0.3\n9,0.05", {"direction": "falling"}, ""),
    ],
)
def test_a_train_is_at_one_chainage_and_runs_one_way(tmp_path, friction, keys, sentence):
    if isinstance(friction, str):
        (tmp_path / "rail.csv").write_text(f"distance [km],mu0\n{friction}\n", encoding="utf-8")
        table = {"kind": "table", "polach": "wet", "file": "rail.csv", "origin": "13 km"}
    else:
        table = FRICTION | friction
    made = partial(scenario, tmp_path, SLOPES, adhesion=table, **{"origin": "13 km"} | keys)
    if not sentence:
        assert made().track.line.origin == made().adhesion.origin
        return
    with pytest.raises(ScenarioError, match=sentence) as refused:
        made()
    assert "[adhesion]" in str(refused.value)
    assert "[track.line]" in str(refused.value)


def test_chainages_of_a_gpx_track_are_not_compared_with_those_of_friction(tmp_path):
    table = FRICTION | FALLING
    made = scenario(tmp_path, GPX.format(47.0, 47.0, 47.01, 47.02), "line.gpx", adhesion=table, origin="0 m")
    assert made.adhesion.places[0] == -1000.0


@pytest.mark.parametrize(("name", "origin"), [("line.csv", "10.4 km"), ("line.gpx", "0 m")])
def test_a_long_file_takes_seconds_not_minutes(tmp_path, name, origin):
    """100,000 rows of a CSV file, 30,000 points of a receiver: linear in their number, some 2 s of the processor."""
    csv = "distance,slope\n" + "".join(f"{at},{(at % 40 - 20) / 1e3}\n" for at in range(100_000))
    points = (f'<trkpt lat="{47 + 2e-5 * at:.6f}" lon="8.0"><ele>{at % 3 / 10}</ele></trkpt>' for at in range(30_000))
    gpx = f"<gpx><trk><trkseg>{''.join(points)}</trkseg></trk></gpx>"
    begin = time.process_time()
    track = scenario(tmp_path, csv if name == "line.csv" else gpx, name, origin=origin).track
    assert len(track_force_of(track, 80e3).begins) > 25_000
    assert time.process_time() - begin < 10.0
