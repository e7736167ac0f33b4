"""A distance beside what is left of it when the plant's parameters move in the seventh digit."""

from railgrip.scenario.conditioning import Repeated

STALE = "stale: other repeats"


def spread_text(conditioning: Repeated | None, digest: str, distance: float | None) -> str:
    """Return median and range of the repeats of a stop, nothing without any; repeats of another stop are said to be so.

    Args:
        digest: Of the scenario of the stop.
        distance: Of the stop [m], None without standstill.
    """
    if conditioning is None:
        return ""
    if not conditioning.belongs(digest, distance):
        return STALE
    others = "".join(
        f"; {compiler} {'no stop' if spread is None else f'{spread:.1f} m'}"
        for compiler, spread in conditioning.compilers.items()
    )
    return f"{conditioning.median:.2f} m ({conditioning.lowest:.2f} – {conditioning.highest:.2f} m){others}"
