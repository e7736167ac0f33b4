"""A mapping for a foreign FMU is found by names of many kinds, and corrected where a short run contradicts it."""

from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType

import numpy as np
import pytest
from faulty_fmu import faulty_fmu
from tiny_fmu import tiny
from wrong import table

from railgrip.base.units import conversion, unit
from railgrip.fmi import Description, Port, bind, describe
from railgrip.fmi.draft import arrays_of, draft_mapping
from railgrip.simulate.map_draft import MappingDraft, SignalMapping, _correct, find_mapping
from railgrip.simulate.plant_trial import TrialPlant
from railgrip.simulate.vehicle_data import catalogue_brakes
from railgrip.vehicle.formation import Formation
from railgrip.vehicle.signals import layout_of


@pytest.fixture
def described(foundry: Path):
    """Return a function that describes an FMU of Real variables, causality → names."""
    base = describe(tiny(foundry))

    def description(**causalities) -> Description:
        variables = {
            name: replace(base.variables["y"], name=name, causality=causality, settable=causality != "output")
            for causality, names in causalities.items()
            for name in names
        }
        return replace(base, file=Path("Train.fmu"), variables=MappingProxyType(variables))

    return description


WHEELS = Port(name="wheelset_speed", unit="rad/s", size=3, needed=True)


@pytest.mark.parametrize(
    ("names", "entry"),
    table(__file__, "tables.toml")["arrays"],
    ids=lambda value: value[0] if isinstance(value, list) else "",
)
def test_arrays_are_found_under_names_of_many_kinds(described, names, entry):
    description = described(output=[*names, "speed", "distance"])
    signals = {"wheelset_speed": (WHEELS, "output")}
    drafted = draft_mapping(description, signals)
    assert drafted == {"wheelset_speed": entry if isinstance(entry, str) else tuple(entry)}
    stated = {"variable": entry, "unit": "rad/s"} if isinstance(entry, str) else [
        {"variable": name, "unit": "rad/s"} for name in entry
    ]  # fmt: skip
    bound = bind(description, inputs=(), outputs=[WHEELS], table={"wheelset_speed": stated})
    assert sorted(bound.outputs.channels[0].variables) == sorted(names)


def test_usual_abbreviations_are_recognised(described):
    signals = {
        "pressure_command": (Port(name="pressure_command", unit="Pa", size=2, needed=True), "input"),
        "cylinder_pressure": (Port(name="cylinder_pressure", unit="Pa", size=2, needed=False), "output"),
        "start_speed": (Port(name="start_speed", unit="m/s", size=0, needed=False), "parameter"),
    }
    causalities = {"input": ["bcp_cmd_1", "bcp_cmd_2"], "output": ["bcp_1", "bcp_2"], "parameter": ["v_init", "r"]}
    table = draft_mapping(described(**causalities), signals)
    assert table == {"pressure_command": "bcp_cmd_{i}", "cylinder_pressure": "bcp_{i}", "start_speed": "v_init"}


def test_a_gap_in_the_numbers_does_not_form_an_array(described):
    names = {array.name for array in arrays_of(described(output=["omega_1", "omega_3"])) if not array.is_scalar}
    assert not names


def test_a_variable_is_used_once(described):
    signals = {
        "wheelset_speed": (WHEELS, "output"),
        "speed": (Port(name="speed", unit="m/s", size=0, needed=True), "output"),
        "slip": (Port(name="slip", unit="1", size=3, needed=False), "output"),
    }
    table = draft_mapping(described(output=["v", "omega_1", "omega_2", "omega_3"]), signals)
    assert table == {"wheelset_speed": "omega_{i}", "speed": "v"}


# ---- corrections ------------------------------------------------------------------------------------------------

FORMATION = Formation((1, 1))
LAYOUT = layout_of(FORMATION)
FULL = tuple(brake.pressure_max for brake in catalogue_brakes(2))
RADIUS, START, PERIOD = 0.46, 20.0, 0.01
UNITS = {
    "pressure_command": "Pa", "mu0": "1", "start_speed": "m/s", "distance": "m", "speed": "m/s",
    "acceleration": "m/s2", "wheelset_speed": "rad/s", "cylinder_pressure": "Pa",
}  # fmt: skip


class Train:
    """A mass whose wheels roll until its brakes demand more than the rail supports; then they lock."""

    def __init__(self, factors, table):
        """Set the units of the FMU, its factors by signal, and how a table reads them."""
        self.gain = {}
        for name, entry in table.items():
            stated, _ = conversion(unit(entry.unit), unit(UNITS[name])) if entry.unit else (1.0, 0.0)
            self.gain[name] = factors.get(name, 1.0) * stated * entry.scale
        self.v = START / self.gain["start_speed"]

    def start(self, inputs):
        self.x, self.p = 0.0, np.zeros(2)
        return self._shown(0.0, False)

    def step(self, inputs):
        command = inputs[LAYOUT.input["command"]] / self.gain["pressure_command"]
        friction = inputs[LAYOUT.input["mu0"]][0] / self.gain["mu0"]
        self.p += (command - self.p) * 0.1
        demand = max(self.p[0], 0.0) / FULL[0] * 1.1
        a = min(demand, 9.81 * max(friction, 0.0)) if self.v > 0 else 0.0
        self.x += PERIOD * (self.v - 0.5 * PERIOD * a)
        self.v -= PERIOD * a
        return self._shown(-a, demand > 9.81 * friction + 1.0)

    def _shown(self, a, locked):
        row = np.full(LAYOUT.outputs, np.nan)
        wheels = 0.0 if locked else self.v / RADIUS
        values = {
            "distance": self.x, "speed": self.v, "acceleration": a, "wheelset_speed": wheels,
            "cylinder_pressure": self.p,
        }  # fmt: skip
        for name, value in values.items():
            row[LAYOUT.output[name]] = value * self.gain[name]
        return row


def corrected(factors) -> MappingDraft:
    table = {
        name: SignalMapping(Port(name=name, unit=own, size=0, needed=True), name, 1.0, "" if own == "1" else own)
        for name, own in UNITS.items()
    }

    def run(now):
        opening = lambda: nullcontext(Train(factors, now))
        return TrialPlant(opening=opening, layout=LAYOUT, period=PERIOD, release=(0.0, 0.0), brake=FULL).trials()

    return _correct(MappingDraft(table=table, missing=(), formation=FORMATION), run, START)


KMH, BAR, KPA, RPM = 3.6, 1e-5, 1e-3, 30 / np.pi


@pytest.mark.parametrize(
    "factors",
    [
        {},
        {"acceleration": -1.0},
        {"speed": KMH},
        {"start_speed": KMH},
        {"start_speed": KMH, "speed": KMH},
        {"distance": 1e-3},
        {"wheelset_speed": RPM},
        {"wheelset_speed": -1.0},
        {"wheelset_speed": 1 / (2 * np.pi)},
        {"cylinder_pressure": BAR},
        {"pressure_command": BAR, "cylinder_pressure": BAR},
        {"pressure_command": KPA, "cylinder_pressure": KPA},
        {"mu0": 100.0},
        {"acceleration": -1.0, "wheelset_speed": RPM},
        {"start_speed": KMH, "speed": KMH, "acceleration": -1.0},
        {"start_speed": KMH, "speed": KMH, "pressure_command": BAR, "cylinder_pressure": BAR},
        {"mu0": 100.0, "acceleration": -1.0},
    ],
    ids=lambda factors: ", ".join(factors) or "nothing",
)
def test_units_and_signs_refuted_by_a_run_are_corrected_and_reported(factors):
    """With the corrected table the train is read correctly: each gain from the FMU to railgrip is 1."""
    draft = corrected(factors)
    assert [finding for finding in draft.findings if not finding.good] == []
    gains = Train(factors, draft.table).gain
    assert gains == pytest.approx(dict.fromkeys(UNITS, 1.0), rel=1e-6)
    printed = [line.split() for line in draft.lines()]
    assert {words[2] for words in printed if words[:2] == ["#", "corrected:"]} == factors.keys()
    assert draft.nominal["r_wheel"] == pytest.approx([RADIUS] * 2, rel=1e-6)


def test_a_unit_is_stated_if_the_fmu_has_none_and_scaled_otherwise():
    signal = Port(name="speed", unit="m/s", size=0, needed=True)
    assert SignalMapping(signal, "v", 1.0, "m/s").rescale(1 / 3.6).plain == {"variable": "v", "unit": "km/h"}
    assert SignalMapping(signal, "v", 1.0, "").rescale(1 / 3.6).plain == {
        "variable": "v",
        "scale": pytest.approx(1 / 3.6),
    }
    assert SignalMapping(signal, "v", 1.0, "").rescale(-1.0).plain == "-v"
    assert SignalMapping(signal, ("a", "b"), -1.0, "").plain == ["-a", "-b"]


def test_a_signal_that_is_not_found_is_reported_with_its_unit(foundry: Path):
    description = describe(faulty_fmu(foundry, names={"speed": "quantity_12"}))
    lines = list(find_mapping(description, wheelsets_per_group=(), speed=20.0, period=1e-3).lines())
    assert "# speed = ?  # needed, in m/s: no similar variable was found" in lines
    assert any(line.startswith("# not used: ") and "quantity_12" in line for line in lines)
