"""The Rao-Blackwellised particle filter in numpy."""

from railgrip.estimators.kind import FilterContext, FilterKind
from railgrip.estimators.particle import ParticleFilter


class Particle(FilterKind):
    """Particles of pad friction with an extended Kalman filter each, over an FMU."""

    prediction = "fmu"

    @classmethod
    def start(cls, task: FilterContext) -> ParticleFilter:
        """Return the filter with its first estimate."""
        return ParticleFilter.of_context(task)
