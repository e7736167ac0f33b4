"""What 10 s of a wheelset at 50 µs cost: the plant and one filter, 200 000 steps of both, in the loop in C."""

import time
from collections.abc import Sequence
from dataclasses import dataclass

from railgrip.studies.lateral.filters import NAMES, Name
from railgrip.studies.lateral.run import Case, simulate
from railgrip.studies.lateral.wheelset import TESTS


@dataclass(frozen=True, slots=True, kw_only=True)
class RunCost:
    """Cost of a run of 200 000 steps with one filter.

    Attributes:
        filter: Which, or "none" for the plant alone.
        wall: Best time of the loop [s].
        processor: Best processor time of the loop and what is around it [s]: the wall on a free machine.
    """

    filter: str
    wall: float
    processor: float


def run_costs(rounds: int = 3) -> tuple[RunCost, ...]:
    """Return the cost of the plant alone and with each filter, best of `rounds`."""
    parties: Sequence[tuple[Name, ...]] = ((), *((name,) for name in NAMES))
    return tuple(_cost(names, rounds) for names in parties)


def _cost(names: tuple[Name, ...], rounds: int) -> RunCost:
    walls: list[float] = []
    processor: list[float] = []
    # The transition, whose changes of condition are the worst for the solver; compiled before the clock starts.
    case = Case(test=TESTS[-1], speed=25.0, plant="paper", seed=1)
    simulate(Case(test=TESTS[-1].shortened(0.01), speed=25.0, plant="paper", seed=1), names)
    for _ in range(rounds):
        begin = time.process_time()
        walls.append(simulate(case, names).wall)
        processor.append(time.process_time() - begin)
    return RunCost(filter=names[0] if names else "none", wall=min(walls), processor=min(processor))


if __name__ == "__main__":
    for cost in run_costs():
        print(f"{cost.filter:15} wall {cost.wall:.2f} s, processor {cost.processor:.2f} s for 200 000 steps")
