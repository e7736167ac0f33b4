"""Actuation that is none."""


class Direct:
    """The plant takes the demanded pressures themselves."""

    def command(self, demands: tuple[float, ...], measured: tuple[float, ...]) -> tuple[float, ...]:
        """Return the demands [Pa]."""
        return demands
