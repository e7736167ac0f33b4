"""The front in the brake pipe, compared with an independent solver on finer grids."""

from types import SimpleNamespace

import pytest
from pipe_by_hand import SOUND, Pipe
from sampling import sample

from railgrip.rolling_stock.modelica import CELLS_OF_A_CAR
from railgrip.studies import brake_pipe

CASES = sample([(0.0, 0.02), (1.5, 0.01), (4.5, 0.005), (3.0, 0.005)], 2)
"""Volume of the branches [l], error of the front on the grid of trains."""


@pytest.fixture(scope="module")
def fronts():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(brake_pipe, "LITRES", [litres for litres, _ in CASES])
        return brake_pipe.fronts(CELLS_OF_A_CAR)


@pytest.mark.parametrize(("litres", "error"), CASES)
def test_the_front_is_that_of_an_independent_solver(fronts, litres, error):
    """Without branches the front stays sharp, and both grids smear it; see the table in docs/train_models.md."""
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


def test_the_table_states_the_error_of_the_grid_of_trains():
    speeds = {1: {(0.0, "none"): 280.0}, CELLS_OF_A_CAR: {(0.0, "none"): 270.0}, 17: {(0.0, "none"): 266.0}}
    (row,) = brake_pipe.table_of(speeds).texts
    assert (row["1 cell"], row["17 cells"], row["grid error"]) == ("280.0 m/s", "266.0 m/s", "+1.5 %")


def test_the_quick_form_has_an_error_relative_to_a_finer_grid():
    """A front that is 1 % faster with every cell: the error is that of the additional cells of the finer grid."""
    work = SimpleNamespace(map=lambda function, grids: [{(0.0, "none"): 250.0 * 1.01**cells} for cells in grids])
    (row,) = brake_pipe.BrakePipeStudy(quick=True).page(work).screen[0].rows
    finest = int(list(row)[-2].removesuffix(" cells"))
    assert finest > CELLS_OF_A_CAR
    assert row["grid error"] == pytest.approx(1.01 ** (CELLS_OF_A_CAR - finest) - 1)
