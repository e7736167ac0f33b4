"""Which compiler made the FMUs that results rest on."""

from collections import Counter
from collections.abc import Mapping, Sequence

from railgrip.report.results import Result

OURS = "railgrip"
"""How the built-in compiler's name begins, in FMUs and results."""


def makers(versions: Mapping[str, str]) -> dict[str, str]:
    """Return FMU → tool that made it, of the versions in a result."""
    return {name: tool for name, tool in versions.items() if name.endswith(".fmu")}


def by_compiler(stops: Sequence[Result]) -> list[str]:
    """Return a sentence for each tool that made FMUs of these stops, ours or another."""
    fmus: dict[str, set[str]] = {}
    for stop in stops:
        for name, tool in makers(stop.record.versions).items():
            fmus.setdefault(tool or "an unnamed tool", set()).add(name)
    return [f"FMUs by {tool}: {', '.join(sorted(names))}." for tool, names in sorted(fmus.items())]


def from_elsewhere(stops: Sequence[Result]) -> list[str]:
    """Return a sentence for each FMU that another compiler than ours made; none when all are ours."""
    counts = Counter(pair for stop in stops for pair in makers(stop.record.versions).items())
    return [
        f"{name} was made by {tool or 'an unnamed tool'} in {count} of {len(stops)} stops."
        for (name, tool), count in sorted(counts.items())
        if not tool.startswith(OURS)
    ]
