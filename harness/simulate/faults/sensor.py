"""Faults of sensors, and missing teeth of pole wheels."""

from collections.abc import Sequence
from typing import Literal

from pydantic import Field

from railgrip.base.arrays import generator
from railgrip.base.errors import ScenarioError
from railgrip.scenario.faults import READ_BY, Fault, Place, amount_of
from railgrip.scenario.quantity import Magnitude
from railgrip.scenario.table import optional, table_error
from railgrip.simulate.faults.site import ReadingKind, Site, iterate_faults, places

_MAX_DRAWS = 2**17
"""Length of the noise sequence; it repeats after 131 s."""


class _SensorFault(Fault):
    part: Literal["speed_sensor", "radar", "accelerometer", "transducer", "deflection_sensor"]
    group: Place | None = optional("from 1 on; without it all groups")
    wheelset: Place | None = optional("in place of `group`, of a deflection sensor; without it all")

    def _check(self) -> None:
        key = {"radar": None, "accelerometer": None, "deflection_sensor": "wheelset"}.get(self.part, "group")
        for name in ("group", "wheelset"):
            if getattr(self, name) is not None and name != key:
                choice = "no place: there is one" if key is None else f"'{key}'"
                raise table_error(f"has '{name}', but {self.part} takes {choice}")

    def _change_readings(self, site: Site, kind: ReadingKind, value: float = 0.0) -> None:
        at = site.layout.reading[READ_BY[self.part]]
        what, number = ("wheelset", self.wheelset) if self.part == "deflection_sensor" else ("group", self.group)
        for index in places(number, at.stop - at.start, site.where, what):
            noise = None
            if kind == "noisy":
                noise = generator(site.scenario.seed, f"faults.{site.number}.{index}").standard_normal(_MAX_DRAWS)
            site.change_reading(kind, at.start + index, value=value, noise=noise)


class SilentSensor(_SensorFault):
    """The sensor delivers no new reading, repeats its last one, or reads zero."""

    kind: Literal["dead", "stuck", "zero"]

    def act_on(self, site: Site) -> None:
        """Change each affected reading; zero is a factor of 0."""
        self._change_readings(site, "scaled" if self.kind == "zero" else self.kind)


class DistortedReading(_SensorFault):
    """The reading is scaled, offset, or noisy, with white noise at 1 ms."""

    kind: Literal["scaled", "biased", "noisy"]
    value: Magnitude = Field(
        description="scaled: factor; biased: what is added, in a unit of what is read; noisy: 1σ of what is added"
    )

    def act_on(self, site: Site) -> None:
        """Change each affected reading by the value."""
        name = f"reading_{READ_BY[self.part]}"
        units = {signal.name: signal.unit for signal in site.layout.signals["reading"]}
        unit, positive = "1" if self.kind == "scaled" else units[name], self.kind if self.kind == "noisy" else ""
        self._change_readings(site, self.kind, amount_of(self.value, unit, site.where, positive))


class ToothFault(Fault):
    """Adjacent teeth are missing, and the electronics is unaware of it."""

    part: Literal["speed_sensor"]
    kind: Literal["missing_teeth"]
    group: Place | None = optional("from 1 on; without it all groups")
    value: Magnitude = Field(description="how many")

    def act_on(self, site: Site) -> None:
        """Check the fault; the sensors model their pole wheels themselves.

        Raises:
            ScenarioError: The sensors have no pole wheels.
        """
        sensors = site.scenario.sensors
        if not sensors.pulses:
            raise ScenarioError(f"{site.where} needs pole wheels, [sensors] kind 'service', and it is '{sensors.kind}'")


def missing_teeth(
    faults: Sequence[Fault], pulses: int, groups: int, period: float, horizon: float
) -> list[dict[str, int]]:
    """Return the missing teeth of each group's pole wheel, as fields of `Encoder` in sensors.h.

    They are adjacent, and missing from sample `begin` to before sample `end`.

    Args:
        faults: Faults of the scenario.
        pulses: Teeth of a wheel.
        groups: Number of groups, each of which has a wheel.
        period: Sampling period [s].
        horizon: Maximum duration of the stop [s].

    Raises:
        ScenarioError: More teeth are missing than a wheel has.
    """
    missing: list[dict[str, int]] = [{} for _ in range(groups)]
    for where, fault in iterate_faults(faults, ToothFault):
        count = amount_of(fault.value, "1", where, fault.kind)
        if count != round(count):
            raise ScenarioError(f"{where} value is a number of teeth, got {count:g}")
        if count >= pulses:
            raise ScenarioError(f"{where} takes {count:g} teeth of {pulses}; for all of them, kind 'dead'")
        for group in places(fault.group, groups, where, "group"):
            if missing[group]:
                raise ScenarioError(f"{where}: the pole wheel of group {group + 1} misses teeth twice; keep one fault")
            missing[group] = {"missing": round(count), **fault.samples(period, horizon)}
    return missing
