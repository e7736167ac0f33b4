"""Faults of valves."""

from typing import Literal

from pydantic import Field

from railgrip.base.errors import ScenarioError
from railgrip.scenario.faults import Fault, Place, amount_of
from railgrip.scenario.quantity import Magnitude
from railgrip.scenario.table import optional
from railgrip.simulate.faults.site import Site

_SLOWEST = 10.0  # s
_VENT, _HOLD, _FILL = -1.0, 0.0, 1.0


class _ValveFault(Fault):
    part: Literal["valve"]
    group: Place | None = optional("from 1 on; without it all groups")


class StuckValve(_ValveFault):
    """The valve keeps its position, whatever the command.

    With ideal actuation a valve stuck at filling gives full pressure, one stuck at dumping 0, and one stuck at holding
    the pressure demanded before.
    """

    kind: Literal["filled", "dumped", "held"]

    def act_on(self, site: Site) -> None:
        """Fix the command to a value, or to the last one."""
        samples = self.samples(site.scenario)
        for group in site.groups(self.group):
            if self.kind == "held" and not site.valves:
                site.faults.add_command("kept", group, **samples)
            else:
                pressures = {"filled": site.brakes[group].pressure_max, "dumped": 0.0}
                positions = {"filled": _FILL, "dumped": _VENT, "held": _HOLD}
                value = (positions if site.valves else pressures)[self.kind]
                site.faults.add_command("fixed", group, value=value, **samples)


class SlowValve(_ValveFault):
    """The valve reacts late."""

    kind: Literal["slow"]
    value: Magnitude = Field(description="added dead time")

    def act_on(self, site: Site) -> None:
        """Delay the command to each group.

        Raises:
            ScenarioError: The delay is so long that the valve should be described as held.
        """
        amount = amount_of(self.value, "s", site.where, self.kind)
        if amount > _SLOWEST:
            raise ScenarioError(
                f"{site.where} delays a valve by {amount:g} s; at most {_SLOWEST:g} s are possible; use 'held'"
            )
        delay = round(amount / site.scenario.periods.communication)
        for group in site.groups(self.group):
            site.faults.add_command("late", group, delay=delay, **self.samples(site.scenario))
