"""Over the signals of a stop the train is drawn as it is: each car, and wheelsets in the colour of their group."""

from dataclasses import replace

import numpy as np
import pytest
from synthetic import COARSE, LIBRARY
from synthetic_runner import run_stop

from railgrip.report.index import stop_page
from railgrip.report.signals import signals_plot
from railgrip.report.stop import read_stop, write_stop
from railgrip.rolling_stock.schema import load_train
from railgrip.scenario.load import load
from railgrip.simulate.run import cars_of


@pytest.mark.parametrize(("name", "cars"), [("flirt", 4), ("loco_coaches", 11), ("eanos_wagon", 1)])
def test_cars_have_the_lengths_of_the_train_file(name, cars):
    """Also those of an articulated train, which move as one body."""
    scenario = load(LIBRARY / "railcar.toml", [f"vehicle.train={name}"])
    train, ends = load_train(scenario.vehicle.source.file.path), cars_of(scenario.vehicle.source)
    assert len(ends) == cars
    assert np.diff(ends).ravel() == pytest.approx([car.length for car in train.cars])
    assert [end for _, end in ends[:-1]] == [begin for begin, _ in ends[1:]]
    first = train.axles[0].position
    assert (ends[0][0], ends[-1][1]) == pytest.approx((-first, train.length - first))


def test_a_plant_without_a_train_file_has_the_cars_that_it_declares(tmp_path):
    scenario = load(LIBRARY / "trapezoid.toml", COARSE)
    assert cars_of(scenario.vehicle.source) == ()
    train = signals_plot(run_stop(scenario).trace)["layout"]["meta"]["train"]
    assert all(begin < end for begin, end in train["cars"])
    known = ((0.0, 12.0), (12.0, 30.0))
    write_stop(replace(run_stop(scenario), cars=known), tmp_path)
    plot = stop_page(read_stop(tmp_path)).signals
    assert plot["layout"]["meta"]["train"]["cars"] == list(known)
