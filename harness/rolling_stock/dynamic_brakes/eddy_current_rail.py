"""Linear eddy-current brakes."""

from typing import Any, ClassVar, Literal

from railgrip.rolling_stock.brakes import EddyCurrent, RailBrake, Within, limit


class EddyCurrentRail(EddyCurrent, RailBrake):
    """The linear eddy-current brake of a bogie, used in an emergency: RailBraking.Components.EddyCurrentBrake."""

    instance: ClassVar[str] = "eddy_current"
    kind: Literal["eddy_current_rail"]

    @property
    def parameters(self) -> str:
        """Parameters of its component, in Modelica."""
        return (
            f"F_max={self.force}, v_peak={self.speed_peak}, v_full={self.speed_full},\n"
            f"    v_end={self.speed_end}, T={self.time_constant}"
        )

    def force_at(self, speed: Any, *, within: Within = limit) -> Any:
        """Return the developed force at a speed [m/s] [N]; `within` limits values, for speeds that are expressions."""
        return self.force_of(1.0, speed, within)
