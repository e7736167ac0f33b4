"""`railgrip study etcs` and `rg.etcs`: their files and messages."""

import csv
import re
from pathlib import Path

import pytest

import railgrip as rg
from railgrip.report.table import END

PERCENT = """
name = "ic"
source = "an example"
length = "250 m"
maximum_speed = "160 km/h"
brake_position = "passenger P"
brake_percentage = "135 %"
traction_cut_off_time = "2 s"
"""
LINE = """
speed = "140 km/h"
release = "calculated"
balise = "3000 m"
gradient = [{ begin = "0 m", slope = "-8 permille" }, { begin = "3500 m", slope = 0.005 }]
target = [
  { kind = "MRSP", at = "1500 m", speed = "80 km/h" },
  { kind = "EoA", at = "4000 m" },
  { kind = "SvL", at = "4450 m" },
]
"""


@pytest.fixture
def files(tmp_path):
    """Files of a train, a line and national values."""

    def write(**texts):
        paths = []
        for name, text in texts.items():
            paths.append(tmp_path / f"{name}.toml")
            paths[-1].write_text(text, encoding="utf-8")
        return paths

    return write


def test_the_command_writes_figure_table_and_csv(files, tmp_path, command, monkeypatch):
    train, line, national = files(ic=PERCENT, line=LINE, national="Q_NVSBTSMPERM = false\nM_NVKTINT = 1.2\n")
    monkeypatch.chdir(tmp_path)
    page = tmp_path / "docs" / "etcs.md"
    page.parent.mkdir()
    marks = [
        f"<!-- {name}: written by `railgrip study etcs vt642 --write` -->\n{END}"
        for name in ("decelerations", "limits", "sentences")
    ]
    page.write_text("\n".join(marks), encoding="utf-8")
    out = tmp_path / "out"
    end = command("study", "etcs", train, "--line", line, "--national", national, "--out", out, "--write")
    assert end.code == 0, end.err
    assert {path.name for path in out.iterdir()} >= {
        "index.html", "etcs.png", "etcs.csv", "limits.csv", "decelerations.csv",
    }  # fmt: skip
    curves = rg.etcs(train, national, line)
    with (out / "etcs.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == len(curves.to_pandas())
    assert float(rows[-1]["location_m"]) == pytest.approx(curves.to_pandas()["location_m"].iloc[-1], abs=1e-4)
    assert {row["limit"] for row in rows} == {"EBD", "EBI", "SBI2", "SBD", "SBI1", "W", "P", "I"}
    assert "Release speed" in end.out
    assert "11.1111" in (out / "index.html").read_text(encoding="utf-8")  # V_NVREL as a reader may type it in again
    assert "MRSP 80 km/h at 1500 m" in page.read_text(encoding="utf-8")
    assert str(curves.table) in page.read_text(encoding="utf-8")


def test_stops_that_begin_on_a_limit_end_at_the_target(files):
    """Full service braking after P and the driver's time ends at the EoA; the safe emergency brake before the SvL."""
    train, line = files(ic=PERCENT, line=LINE)
    eoa = {stop.name: stop.reserve for stop in rg.etcs(train, line=line).stops}
    assert eoa["full service brake after P, EoA"] == pytest.approx(0.0, abs=1e-6)
    assert eoa["nominal emergency brake from EBI, SvL"] > eoa["safe emergency brake from EBI, SvL"] > 0
    (exact,) = files(exact="Q_NVINHSMICPERM = true\n")
    without = {stop.name: stop.reserve for stop in rg.etcs(train, exact, line).stops}
    assert without["safe emergency brake from EBI, SvL"] == pytest.approx(0.0, abs=1e-6)


@pytest.mark.usefixtures("few")
def test_a_train_file_states_that_its_data_are_estimates():
    curves = rg.etcs("tram")
    (ends,) = curves.remarks
    assert "has no [etcs] maximum_speed: its curves end at 60 km/h, the speed of its fastest [[reference]]" in ends
    assert "tram lacks [etcs], [[dispersion]], [failures]: estimates of railgrip" in curves.sentences[-2]
    assert curves.table.columns == ["target", "from", "EBD", "EBI", "SBD", "SBI1", "SBI2", "W", "P", "I"]
    assert curves.figure().axes


GAMMA = """
name = "g"
source = "an example"
length = "100 m"
maximum_speed = "120 km/h"
brake_position = "passenger P"
emergency = [{ above = 0, deceleration = 1.0, k_dry = 0.8, k_wet = 0.8 }]
service = [{ above = 0, deceleration = 0.8 }]
emergency_time = "2 s"
service_time = "2 s"
traction_cut_off_time = "1 s"
"""


LEVEL = 'target = [{ kind = "EoA", at = 5000 }, { kind = "SvL", at = 5000 }]\n'
GIVEN = 'target = [{ kind = "EoA", at = 9 }, { kind = "SvL", at = 9 }]\nrelease = "given"\n'


STEPS = "service = [{ above = 0, deceleration = 1 }, { above = 60, deceleration = 1 }]"


@pytest.mark.parametrize(
    ("file", "text", "figure", "remark"),
    [
        ("national", "M_NVKVINT_passenger = [[0, 0.7, 0.7], ['100 km/h', 0.5, 0.5]]", "2380.8 m", ""),
        ("national", "M_NVKVINT_passenger = [[0, 0.7, 0.7], [100, 0.5, 0.5]]", "1933.5 m", "] is 100 m/s; usual are"),
        ("national", "M_NVKVINT_passenger = [[0, 0.7, 0.7], [80, 0.5, 0.5]]", "1933.5 m", "[2][1] is 288 km/h (80"),
        ("line", LEVEL + "speed = '140 km/h'", "EBI 149.8 km/h", ""),
        ("line", LEVEL + "speed = 140", "EBI 171.2 km/h", " speed is 140 m/s; usual are 0 to 95 m/s"),
        ("line", LEVEL + "speed = '200 km/h'", "EBI 171.2 km/h", "(55.5556 m/s), above the maximum speed of the train"),
        ("train", re.sub("service = .*]", STEPS, GAMMA), "", "[service[2]] above is 216 km/h (60 m/s), above"),
    ],
)  # fmt: skip
def test_speeds_above_that_of_the_train_have_a_remark(file, text, figure, remark, files):
    """Numbers without a unit are in m/s; figures are the intervention before the SvL and the ceiling of 140 km/h."""
    train, national, line = files(**{"train": PERCENT, "national": "", "line": LEVEL, file: text})
    curves = rg.etcs(train, national, line)
    assert figure in "\n".join((str(curves.table), *curves.sentences))
    assert [remark in line for line in curves.remarks] == [True] * bool(remark)
    assert curves.sentences[len(curves.sentences) - len(curves.remarks) :] == curves.remarks
    assert all(f"{file}.toml: " in line and line.endswith("unit is in m/s.") for line in curves.remarks)


@pytest.mark.parametrize(
    ("train", "line", "national", "sentences"),
    [
        (GAMMA.replace("above = 0, deceleration = 0.8", "above = 5, deceleration = 1"), "", "", ["first step starts"]),
        (GAMMA.replace("deceleration = 1.0", 'deceleration = "1 km/h"'), "", "", ["[emergency[1]] deceleration"]),
        (GAMMA.replace('"100 m"', '"5 km"'), "", "", ["length must be at most 4095 m"]),
        (GAMMA.replace('service_time = "2 s"', ""), "", "", ["lacks service_time; or give brake_percentage"]),
        (GAMMA + 'brake_percentage = "135 %"', "", "", ["keep one of the two models"]),
        (PERCENT.replace('"135 %"', "135"), "", "", ["brake_percentage must be at most 2.5", 'write "135 %" or 1.35']),
        (PERCENT.replace('"135 %"', '"20 %"'), "", "", ["must be at least 0.3"]),
        (PERCENT.replace('"160 km/h"', '"230 km/h"'), "", "", ["holds up to 200 km/h and 900 m", "3.13.3.2"]),
        (PERCENT.replace('"250 m"', '"901 m"'), "", "", ["holds up to 200 km/h and 900 m"]),
        (PERCENT.replace("passenger P", "P"), "", "", ["brake_position is 'P'"]),
        (PERCENT + "mass = 3\n", "", "", ["has no key 'mass'"]),
        (PERCENT, "", "M_NVEBCL = 10", ["M_NVEBCL is 10"]),
        (PERCENT, "", "M_NVAVADH = 1.5\nQ_NVSBTSMPERM = 1", ["M_NVAVADH must be at most 1", "Q_NVSBTSMPERM is 1"]),
        (PERCENT, "", "M_NVKVINT_passenger = [[0, 0.6, 0.7]]", ["give both, A_NVP12 below A_NVP23"]),
        (PERCENT, "", 'M_NVKRINT = [["100 m", 0.9]]', ["M_NVKRINT: the first step starts at 0"]),
        (PERCENT, "", "Q_NVGUIPERM = true", ["ic: lacks normal_service"]),
        (PERCENT, 'target = [{ kind = "EoA", at = 10, speed = 5 }]', "", ["EoA and SvL have 0"]),
        (PERCENT, 'target = [{ kind = "LoA", at = 10 }]', "", ["LoA has speed 0 km/h"]),
        (PERCENT, 'target = [{ kind = "LoA", at = 10, speed = "170 km/h" }]', "", ["permitted speed of 160"]),
        (PERCENT, 'target = [{ kind = "EoA", at = 9 }, { kind = "SvL", at = 5 }]', "", ["SvL at 5 m is in front"]),
        (PERCENT, 'target = [{ kind = "EoA", at = 9 }, { kind = "EoA", at = 5 }]', "", ["there is one EoA at most"]),
        (PERCENT, 'release = "calculated"', "", ["needs balise"]),
        (PERCENT, 'release_speed = "20 km/h"', "", ["need each other"]),
        (PERCENT, 'release = "national"\ntarget = [{ kind = "EoA", at = 9 }]', "", ["release needs a target"]),
        (PERCENT, GIVEN + "release_speed = 39\nspeed = 30", "", ["release_speed is not below the permitted", "of 108"]),
        (PERCENT, "low_adhesion = [{ begin = 5, end = 4 }]", "", ["end 4 m is not behind begin 5 m"]),
        (PERCENT, "gradient = [{ begin = 5, slope = 0.3 }]", "", ["slope must be below 0.2"]),
        (GAMMA, "gradient = [{ begin = 0, slope = -0.19 }]\ntarget = [{ kind = \"EoA\", at = 5000 }]", "",
         ["g, SBD of EoA: the brake does not slow the train down"]),
    ],
)  # fmt: skip
def test_what_is_wrong_is_said_in_a_sentence(train, line, national, sentences, files, tmp_path, command):
    paths = files(train=train, line=line if "target" in line else LEVEL + line, national=national)
    end = command("study", "etcs", paths[0], "--line", paths[1], "--national", paths[2], "--out", tmp_path / "out")
    assert end.code == 2, end.out
    for sentence in sentences:
        assert sentence in end.err


def test_all_problems_of_all_files_are_reported_at_once(files, tmp_path, command):
    paths = files(train=GAMMA + "a = 1\nb = 2", line="c = 3\nspeed = 500", national="d = 4")
    end = command("study", "etcs", paths[0], "--line", paths[1], "--national", paths[2], "--out", tmp_path / "out")
    expected = [f"{name}.toml: the top level has no key '{key}'" for name, key in
                (("train", "a"), ("train", "b"), ("line", "c"), ("national", "d"))]  # fmt: skip
    for sentence in (*expected, "line.toml: speed must be at most 160 m/s"):
        assert sentence in end.err, end.err


def test_missing_files_and_trains_are_named(tmp_path, command):
    end = command("study", "etcs", "emu388", "--out", tmp_path / "out")
    assert (end.code, "emu387" in end.err) == (2, True)
    end = command("study", "etcs", "emu387", "--line", tmp_path / "no.toml", "--out", tmp_path / "out")
    assert (end.code, "no.toml" in end.err) == (2, True)


def test_the_files_of_the_page_are_valid(files):
    page = Path(__file__).parents[2] / "docs" / "etcs.md"
    percent, rows, line, national = re.findall(r"```toml\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL)
    paths = files(train=percent, line=line, national=national.replace("Q_NVGUIPERM = true", ""))
    assert rg.etcs(paths[0], paths[2], paths[1]).release is not None
    times = 'emergency_time = "2 s"\nservice_time = "2 s"\nnormal_service = [{ above = 0, deceleration = 0.5 }]\n'
    by_curves = percent.replace('brake_percentage = "135 %"', times) + rows
    paths = files(train=by_curves, line=line, national=national)
    assert "GUI" in set(rg.etcs(paths[0], paths[2], paths[1]).to_pandas()["limit"])
