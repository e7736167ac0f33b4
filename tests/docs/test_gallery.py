"""The scripts of the gallery run, are short, use only the public interface, and label their axes."""

import ast
import runpy
from collections.abc import Callable, Iterator
from pathlib import Path

import matplotlib
import matplotlib.pyplot as plt
import pytest
from matplotlib.figure import Figure
from sampling import FUZZ

SCRIPTS = sorted((Path(__file__).parents[2] / "docs/gallery").glob("*.py"))
LONG = {
    *("brake_pipe", "k_dry", "own_controller", "friction_level", "random_draws", "thresholds"),
    *("field_test", "wheel_diameter", "sampling_period", "sanding", "ideal_bound", "slip_cleans", "k_wet", "gradient"),
    "consistency",
}
"""Scripts that take seconds or minutes, for a train to compile or for many stops: for `make fuzz` and `make docs`."""
LINES = 30


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda script: script.stem)
def test_a_script_is_short_and_uses_no_internals(script: Path):
    source = script.read_text(encoding="utf-8")
    assert len(source.splitlines()) <= LINES
    imports = [node for node in ast.walk(ast.parse(source)) if isinstance(node, ast.Import | ast.ImportFrom)]
    names = {
        node.module if isinstance(node, ast.ImportFrom) else alias.name for node in imports for alias in node.names
    }
    assert not [name for name in names if name and name.startswith("railgrip.")]


@pytest.fixture
def figures(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Iterator[Callable[[Path], list[Figure]]]:
    """Return a function that runs a script in an empty folder and returns its figures."""
    monkeypatch.chdir(tmp_path)
    matplotlib.use("Agg")

    def run(script: Path) -> list[Figure]:
        runpy.run_path(str(script), run_name="__main__")
        return [plt.figure(number) for number in plt.get_fignums()]

    yield run
    plt.close("all")


@pytest.mark.filterwarnings("ignore:FigureCanvasAgg is non-interactive")
@pytest.mark.parametrize("script", [s for s in SCRIPTS if FUZZ or s.stem not in LONG], ids=lambda script: script.stem)
def test_axes_of_a_script_have_units(script: Path, figures: Callable[[Path], list[Figure]]):
    """Exceptions: panels share labels, bars have names instead of a label, and wheelset numbers have no unit."""
    drawn = figures(script)
    assert drawn
    for figure in drawn:
        labels = {label for axes in figure.axes for label in (axes.get_xlabel(), axes.get_ylabel())} - {"", "wheelset"}
        assert labels
        assert all("[" in label for label in labels), labels
