"""Results print in five lines, display in notebooks, and load matplotlib only when they are drawn."""

import subprocess
import sys
from itertools import product
from pathlib import Path

import numpy as np
import pytest
import xarray
from synthetic_runner import stop_with as stop

from railgrip.campaign.sweep import Result, Sweep
from railgrip.report.estimates import Estimates, as_estimates


def sweep():
    axes = {"start.speed": (10.0, 20.0, 30.0), "controller.kind": ("full_brake", "adhesion_based")}
    stops = (stop(f"start.speed={speed} m/s", f"controller.kind={kind}") for speed, kind in product(*axes.values()))
    return Sweep(axes, tuple(Result(one.outcome.value, one.reason, one.metrics) for one in stops))


def estimates():
    values = np.linspace(1.0, 0.5, 12).reshape(6, 2)
    return as_estimates(
        xarray.Dataset(
            {
                "mean": (("time", "state"), values),
                "sd": (("time", "state"), 0.1 * values),
                "nis": ("time", values[:, 0]),
                "readings": ("time", np.ones(6)),
            },
            coords={"time": 0.1 * np.arange(6), "state": ["speed", "pad_friction"]},
            attrs={"ended": "", "name": "run 1", "nis_ratio": 0.9, "period": 0.1},
        )
    )


def test_a_sweep_prints_its_shortest_and_longest_stop():
    lines = repr(sweep()).splitlines()
    assert len(lines) == 5
    assert lines[0] == "Sweep of 6 stops over start.speed (3), controller.kind (2)"
    assert lines[2] == "  shortest 52.63 m with start.speed = 10.0, controller.kind = adhesion_based"
    # The mean of the third and fourth of six distances.
    assert lines[3] == f"  median {np.median(sweep().distances):.2f} m of 6 with standstill"
    assert lines[4] == "  longest 900.00 m with start.speed = 30.0, controller.kind = full_brake"


def test_a_sweep_without_a_standstill_is_also_printed():
    nothing = Sweep({"seed": (1,)}, (Result("refused", "no train", None),))
    assert repr(nothing).splitlines()[2:] == ["  shortest none", "  median none", "  longest none"]


def test_estimates_print_in_five_lines_and_stay_a_dataset():
    own = estimates()
    lines = repr(own).splitlines()
    assert len(lines) == 5
    assert lines[1] == "  2 states, at the end speed 0.5455 ± 0.055, pad_friction 0.5 ± 0.05"
    assert isinstance(own, xarray.Dataset)
    assert own["mean"].sel(state="speed").values[0] == 1.0
    assert "Estimates" in repr(own[["nis"]]), "a part of it as xarray shows it"
    assert isinstance(own.isel(time=slice(2)), Estimates)


@pytest.mark.parametrize("own", [stop, sweep, estimates], ids=lambda make: make.__name__)
def test_each_has_html_and_a_figure(own):
    value = own()
    assert value._repr_html_().startswith("<pre>")
    drawing = value.plot()
    assert drawing.axes
    for panel in drawing.axes:
        assert panel.has_data()


def test_the_figure_of_a_sweep_has_the_distances():
    own = sweep()
    (panel,) = own.plot().axes
    lines = {line.get_label(): line.get_ydata() for line in panel.get_lines()}
    np.testing.assert_allclose(lines["controller.kind full_brake"], [100.0, 400.0, 900.0], rtol=1e-3)
    assert [tick.get_text() for tick in panel.get_xticklabels()] == ["10", "20", "30"]


def test_nothing_is_drawn_unless_requested():
    program = (
        "import sys; sys.path.insert(0, 'tests/report'); sys.path.insert(0, 'tests')\n"
        "import test_in_short as own\n"
        "import railgrip\n"
        "for value in (own.stop(), own.sweep(), own.estimates(), railgrip.compare(own.stop(), own.stop('seed=3'))):\n"
        "    repr(value), value._repr_html_()\n"
        "assert not any(name.startswith('matplotlib') for name in sys.modules), 'matplotlib was loaded'\n"
        "own.stop().plot()\n"
        "assert 'matplotlib' in sys.modules\n"
    )
    root = Path(__file__).parents[2]
    done = subprocess.run([sys.executable, "-c", program], cwd=root, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
