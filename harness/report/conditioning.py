"""A distance beside what is left of it when the plant's parameters move in the seventh digit."""

from railgrip.scenario.conditioning import Repeated

STALE = "stale: other repeats"


def spread_text(repeated: Repeated | None, digest: str, distance: float | None) -> str:
    """Return median and range of the repeats of a stop, nothing without any; repeats of another stop are said to be so.

    Args:
        repeated: The repeats.
        digest: Of the scenario of the stop.
        distance: Of the stop [m], None without standstill.
    """
    if repeated is None:
        return ""
    if not repeated.belongs(digest, distance):
        return STALE
    others = "".join(
        f"; {compiler} {'no stop' if found is None else f'{found:.1f} m'}"
        for compiler, found in repeated.compilers.items()
    )
    return f"{repeated.median:.2f} m ({repeated.lowest:.2f} – {repeated.highest:.2f} m){others}"
