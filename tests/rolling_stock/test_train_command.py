"""`railgrip train`: a template file, a drawing to scale, and inconsistencies with exit code 2."""

from pathlib import Path

import pytest
from matplotlib.patches import Circle

from railgrip.rolling_stock.drawing import drawing
from railgrip.rolling_stock.schema import load_train

PNG, SVG = b"\x89PNG", b"<?xml"


@pytest.fixture
def mine(railgrip, tmp_path):
    """A new train file."""
    assert railgrip("new", "train", "mine.toml")[0] == 0
    return tmp_path / "mine.toml"


def replace(file, *changes):
    """Replace texts of a file, each of which it must contain."""
    text = file.read_text(encoding="utf-8")
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    file.write_text(text, encoding="utf-8")


def test_an_inconsistency_is_reported_with_file_and_key(railgrip, mine):
    replace(mine, ('mass = "44 t"', 'mass = "4 t"'))
    code, _, err = railgrip("train", "check", "mine.toml")
    assert code == 2
    where = "mine.toml: [bogies.trailer] frame_mass"
    assert f"{where}: frame and axles have a mass of 5.6 t, but the bogie's axles carry only 2 t" in err
    assert railgrip("train", "check", "nothing")[0] == 2


@pytest.mark.parametrize(
    ("strong", "weak"),
    [
        ('piston_area = "0.0324 m2"', 'piston_area = "0.00376 m2"'),
        ('pressure_max = "3.2 bar"', 'pressure_max = "0.371 bar"'),  # the force of the spring plus 1 N
    ],
)
def test_brakes_that_cannot_stop_a_train_are_reported_and_listed(railgrip, mine, strong, weak, monkeypatch):
    monkeypatch.setattr("railgrip.rolling_stock.stopping._STEP", 0.1)  # ten minutes in a tenth of the steps
    replace(mine, ('rolling_arm = "0.4 mm"', "rolling_arm = 0"), (strong, weak), ("0.0018", "1e-9"))
    code, _, err = railgrip("train", "check", "mine.toml")
    assert code == 2
    assert "mine.toml: [brakes]: by hand calculation the brakes do not stop mine from 120 km/h within 600 s; " in err
    code, out, err = railgrip("train", "show", "mine.toml")
    assert (code, err) == (0, "")
    assert "full brake" in out


def test_distributors_and_accelerators_are_drawn_and_described(railgrip, mine):
    text = mine.read_text(encoding="utf-8")
    text = text.replace('kind = "electropneumatic"', 'kind = "brake_pipe"').replace(
        'delay = "0.4 s"                    # from the demand to the first pressure\ntime_constant = "0.5 s"',
        'diameter = "32 mm"\nbranch_volume = 0\nfill_time = "4 s"\nreservoir = "100 l" ',
    )
    begin, end = text.index("# [distributors.R]"), text.index("[[cars]]")
    tables = "\n".join(line.removeprefix("# ") for line in text[begin:end].splitlines())
    cars = text[end:].replace('name = "A"', 'name = "A"\ndistributor = "R"\naccelerator = "quick"')
    mine.write_text(text[:begin] + tables + "\n" + cars, encoding="utf-8")
    code, out, err = railgrip("train", "show", "mine.toml")
    assert code == 0, err
    row = next(line for line in out.splitlines() if "quick" in line)
    assert row.split() == ["A", "R", "0.50", "50", "km/h", "70", "km/h", "quick", "0.7", "bar/s", "2.5", "bar"]
    code, out, err = railgrip("train", "check", "mine.toml")
    assert (code, err) == (0, "")
    assert "R in 1 of 2 cars: 50 % of the pressure below 50 km/h, the full pressure from 70 km/h" in out
    assert "quick in 1 of 2 cars vents the pipe where it falls by 0.7 bar/s, down to 2.5 bar" in out


@pytest.mark.parametrize(("suffix", "begins"), [("png", PNG), ("svg", SVG)])
def test_a_train_is_drawn(railgrip, tmp_path, suffix, begins):
    code, out, _ = railgrip("train", "show", "loco_coaches", "--out", f"train.{suffix}")
    assert code == 0
    assert out.count("coach") == 40
    first = (tmp_path / f"train.{suffix}").read_bytes()
    assert first.startswith(begins)
    railgrip("train", "show", "loco_coaches", "--out", f"train.{suffix}")
    assert (tmp_path / f"train.{suffix}").read_bytes() == first


def test_the_drawing_is_to_scale():
    train = load_train(Path("emu387"))
    (axes,) = drawing(train).axes
    assert axes.get_aspect() == 1
    wheels = [one for one in axes.patches if isinstance(one, Circle) and one.radius == 0.42]
    assert [wheel.center[0] for wheel in wheels] == pytest.approx([axle.position for axle in train.axles])
