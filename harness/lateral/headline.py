"""The few numbers by which a change of the lateral study is seen."""

from collections.abc import Callable
from typing import Final

from harness.lateral.judge import measure
from harness.lateral.run import Case, simulate
from harness.twins.lateral import CONDITIONS, TESTS
from harness.verdict.baseline import Finding

SPEED: Final = 25.0
SEED: Final = 1
TOLERANCE: Final = 0.05
"""Relative, of rms errors: half a million steps of a filter at 1e-7 of its scale are another machine's arithmetic."""
SETTLED: Final = 0.02
"""s, of instants."""


def headlines(tell: Callable[[str], None]) -> list[Finding]:
    """Return what the filters make of one transition through all conditions, and of a contact that is softer."""
    found: list[Finding] = []
    for plant, names in (("paper", ("literal", "known_track", "unknown_track")), ("softer", ("known_track",))):
        tell(f"lateral, plant '{plant}'")
        measured = measure(
            simulate(Case(test=TESTS[-1], speed=SPEED, plant=plant, seed=SEED)), observe=plant == "paper"
        )
        for name in names:
            who = f"lateral transition, plant '{plant}', {name}"
            rms = measured["errors"][name]["friction"]["rmse"]
            found.append(
                Finding(name=f"{who}: friction RMSE", value=rms, unit="1", tolerance=TOLERANCE * abs(rms or 1))
            )
            if name == "literal":
                continue
            counts = measured["detection"][name]["confusion"]
            right = sum(counts[k][k] for k in range(len(CONDITIONS))) / sum(map(sum, counts))
            found.append(
                Finding(name=f"{who}: share of time that the condition is right", value=right, unit="1", tolerance=0.01)
            )
        if measured["observability"] is not None:
            least = min(value for value in measured["observability"]["service"] if value is not None)
            found.append(
                Finding(name="lateral transition: least sd of mu0 from service sensors", value=least, unit="1",
                        tolerance=TOLERANCE * least)
            )  # fmt: skip
    return found
