"""The front in the brake pipe, compared with an independent solver on finer grids."""

import pytest
from pipe_by_hand import SOUND, Pipe
from pipe_fronts import fronts as fronts_of
from sampling import sample

from railgrip.rolling_stock.modelica import CELLS_OF_A_CAR

CASES = sample([(0.0, 0.02), (1.5, 0.01), (4.5, 0.005), (3.0, 0.005)], 2)
"""Volume of the branches [l], error of the front on the grid of trains."""


@pytest.fixture(scope="module")
def fronts():
    rows = fronts_of(CELLS_OF_A_CAR, [litres for litres, _ in CASES])
    return {(row["litres"], row["accelerators"]): row["front"] for row in rows}


@pytest.mark.parametrize(("litres", "error"), CASES)
def test_the_front_is_that_of_an_independent_solver(fronts, litres, error):
    """Without branches the front stays sharp, and both grids smear it; see docs/studies/brake_pipe.md."""
    fine = Pipe(cells=17, branch=1e-3 * litres).front()
    assert fronts[litres, "none"] == pytest.approx(fine, rel=error)


def test_the_front_with_accelerators_is_that_of_an_independent_solver(fronts):
    fine = Pipe(cells=17, branch=3e-3, vent=2e-7).front()
    assert fronts[3.0, "in each car"] == pytest.approx(fine, rel=0.02)
    # No small wave is faster than the sound, which branches slow down.
    assert fine < SOUND / (1 + 3e-3 / (26.4 * 8.042e-4)) ** 0.5
    assert fronts[3.0, "none"] < fronts[3.0, "in each car"]


def test_the_independent_solver_converges():
    """Tripling the cells moves its front by less each time; the error with 17 is below that of the tolerances above."""
    coarse, medium, fine = (Pipe(cells=cells, branch=3e-3).front() for cells in (3, 9, 27))
    assert abs(fine - medium) < abs(medium - coarse)
    assert fine == pytest.approx(medium, rel=3e-3)
