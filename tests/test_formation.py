"""A formation: which wheelsets turn as one."""

from functools import partial

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from railgrip.vehicle.formation import Formation, formation_of
from railgrip.vehicle.signals import PLANT, PLANT_INPUTS, READINGS, layout_of

COUNTS = st.lists(st.integers(1, 5), min_size=1, max_size=12).map(tuple)


@given(COUNTS)
def test_sums_over_groups_equal_those_by_membership(counts):
    """Compared with numpy's own sums by bin."""
    formation = Formation(counts)
    values = np.random.default_rng(1).uniform(size=(3, formation.wheelsets))
    expected = [np.bincount(formation.group_of_wheelset, weights=row, minlength=formation.groups) for row in values]
    assert formation.sum_by_group(values) == pytest.approx(np.array(expected), rel=1e-15)
    assert formation_of(formation.group_of_wheelset.tolist()) == formation


@given(COUNTS)
def test_every_value_has_a_separate_index_in_a_layout(counts):
    layout = layout_of(Formation(counts))
    for columns, size, signals in (
        (layout.input, layout.inputs, PLANT_INPUTS),
        (layout.output, layout.outputs, PLANT),
        (layout.reading, layout.readings, READINGS),
    ):
        places = np.concatenate([np.arange(place.start, place.stop) for place in columns.values()])
        assert places.tolist() == list(range(size))
        widths = {"train": 1, "group": len(counts), "wheelset": sum(counts)}
        assert [place.stop - place.start for place in columns.values()] == [widths[s.extent] for s in signals]


@pytest.mark.parametrize(
    ("make", "words"),
    [
        *((partial(Formation, counts), "one wheelset or more in each of its groups") for counts in ((), (2, 0), (-1,))),
        (partial(formation_of, [1, 2, 1]), "must be adjacent"),
        (partial(Formation, (2, 1), wheelsets_per_car=(2, 2)), "wheelsets_per_car has 4 wheelsets"),
        (partial(Formation, (2, 1), wheelset_position=(0.0, 1.0)), "wheelset_position is for 2 wheelsets"),
        (partial(Formation, (2, 1), wheelset_position=(1.0, 2.0, 3.0)), "start with 0"),
        (partial(Formation, (2, 1), wheelset_load=(1e5, -1e5, 1e5)), "wheelset_load must be positive"),
    ],
)
def test_an_inconsistent_formation_is_refused(make, words):
    with pytest.raises(ValueError, match=words):
        make()
