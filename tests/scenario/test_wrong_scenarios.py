"""Each wrong scenario of wrong_scenarios.toml is refused in its sentence, at the first stage that can know."""

import pytest
from synthetic import LIBRARY
from wrong import table, words

from railgrip.base.errors import RailgripError
from railgrip.scenario.load import load
from railgrip.simulate.run import run_stop
from railgrip.simulate.vehicle_data import VehicleData

STAGES = table(__file__, "wrong_scenarios.toml")
ROWS = [(stage, base, *row) for stage, bases in STAGES.items() for base, rows in bases.items() for row in rows]


@pytest.mark.parametrize("row", ROWS, ids=lambda row: f"{row[0]} {row[1]} {' '.join(row[3:])[:80]}")
def test_a_wrong_scenario_is_refused_in_a_sentence_with_file_table_and_key(row, monkeypatch):
    monkeypatch.chdir(LIBRARY)
    stage, base, sentence, *changes = row
    name, *equipment = base.split(", ")
    file = "" if sentence.startswith("…") else rf"{name}(\.toml)?: "

    def use():
        scenario = load(LIBRARY / f"{name}.toml", changes, equipment)
        if stage != "read":
            vehicle = VehicleData(scenario)
            _ = vehicle.nominal, vehicle.track_force
        if stage == "run":
            run_stop(scenario)

    with pytest.raises(RailgripError, match=f"(?m)^{file}{words(sentence)}") as refused:
        use()
    assert all(len(line) < 500 for line in str(refused.value).splitlines())
