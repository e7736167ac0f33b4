"""The table of signals defines the header in C, the observation of a law and the reference page."""

import runpy
from pathlib import Path

import mkdocs_gen_files
import numpy as np
import pytest
from synthetic import BRAKES, TWO_PART_TRAIN

from railgrip.base.errors import LoopError
from railgrip.controllers.law import Law, law
from railgrip.simulate.loop.loop import _formula
from railgrip.vehicle import signals
from railgrip.vehicle.signals import OBSERVATION, TABLE, Signal, layout_of, names_of

EXTENDED = (*OBSERVATION, Signal("lining_wear", "group", "m", "wear of the brake linings"))
LAYOUT = layout_of(TWO_PART_TRAIN, observation=EXTENDED)


def half(observed):
    """Return a law of 4 groups that demands half of its last input."""

    def demands(draft, parameters, train):
        return [0.5 * getattr(group, observed[-1].name) for group in train]

    return law("Half", "", 4, demands, observed=observed)


def test_a_law_receives_a_new_row_by_its_name():
    formula = half(EXTENDED)
    assert [quantity.name for quantity in formula.inputs] == [*LAYOUT.elements("observation")]
    inputs = np.zeros(30)
    inputs[LAYOUT.places["observation"]["lining_wear"]] = 1.0, 2.0, 3.0, 4.0
    parameters = [quantity.start for quantity in formula.parameters]
    assert formula.step([], inputs, parameters)[1].full().ravel().tolist() == [0.5, 1.0, 1.5, 2.0]


def test_a_law_without_inputs_is_refused():
    with pytest.raises(AttributeError, match="has no 'lining_wear'; it has speed, acceleration, slip"):
        law("Half", "", 4, lambda draft, parameters, train: [group.lining_wear for group in train])


def test_a_new_row_is_on_the_reference_page(monkeypatch, tmp_path):
    def create(name, mode):
        return (tmp_path / Path(name).name).open(mode, encoding="utf-8")

    monkeypatch.setattr(mkdocs_gen_files, "open", create)
    monkeypatch.setattr(signals, "OBSERVATION", EXTENDED)
    runpy.run_path(str(Path(__file__).parents[1] / "docs/generate.py"))
    page = (tmp_path / "signals.md").read_text(encoding="utf-8")
    assert "| `lining_wear` | group | m | wear of the brake linings |" in page


def test_a_law_with_swapped_inputs_is_refused():
    first, second, *others = OBSERVATION
    swapped = Law(half((second, first, *others)), BRAKES, {})
    with pytest.raises(LoopError, match="takes acceleration as input 1, which is speed"):
        _formula(layout_of(TWO_PART_TRAIN), swapped, "observation")


def test_a_law_written_for_another_table_is_refused():
    with pytest.raises(LoopError, match="takes 30 inputs, and 26 belong to 4 groups"):
        _formula(layout_of(TWO_PART_TRAIN), Law(half(EXTENDED), BRAKES, {}), "observation")


@pytest.mark.parametrize("role", TABLE)
def test_names_of_a_vector_are_unique_and_in_the_header(role):
    """Those of a new row, too."""
    assert len(set(LAYOUT.elements(role))) == len(LAYOUT.elements(role))
    constants = dict(line.split()[1:] for line in LAYOUT.header().splitlines())
    for row in EXTENDED if role == "observation" else TABLE[role]:
        name = f"{role}_{row.name.removeprefix(f'{role}_')}".upper()
        place = LAYOUT.elements(role).index(names_of(row, TWO_PART_TRAIN)[0])
        assert int(constants[name]) == place, name
