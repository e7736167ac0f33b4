"""An insufficient supply of air."""

from typing import Annotated, Literal

from pydantic import Field

from railgrip.base.errors import ScenarioError
from railgrip.scenario.faults import Fault, amount_of
from railgrip.scenario.quantity import Magnitude, UnitRange
from railgrip.scenario.table import optional
from railgrip.simulate.faults.site import Site


class SupplyLoss(Fault):
    """The reservoir is emptied by the air consumption of the plant."""

    part: Literal["supply"]
    kind: Literal["sagging"]
    value: Magnitude = Field(description="volume of the reservoir")
    pressure: Annotated[float, UnitRange("Pa", above=0, at_most=1e8)] = Field(description="of the full reservoir")
    refill: (
        Annotated[float, UnitRange("m3/s", above=0, at_most=1, because="compressors deliver some m3 a minute")] | None
    ) = optional("free air that its compressor delivers; without it, none")

    def act_on(self, site: Site) -> None:
        """Limit the command to each group to the reservoir's pressure.

        Raises:
            ScenarioError: The plant lacks the output for its air consumption.
        """
        if "air_used" not in site.outputs:
            raise ScenarioError(f"{site.where} empties a reservoir, but the plant does not show the air that it uses")
        volume = amount_of(self.value, "m3", site.where, self.kind)
        samples = self.samples(site.scenario)
        refill = (self.refill or 0.0) * site.scenario.periods.communication
        for group in site.groups(None):
            site.faults.add_command("limited", group, value=volume, pressure=self.pressure, refill=refill, **samples)
