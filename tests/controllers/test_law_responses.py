"""Regression of the control laws in open loop: the answer of each set of parameters to the same slides.

Braking distances of laws that chatter scatter too much to show a parameter that moved by a tenth. Here the observations
are given, so that no deviation is amplified.

    python tests/controllers/test_law_responses.py     # accept the present answers
"""

import json
from itertools import product
from math import pi, sin
from pathlib import Path

import numpy as np
import pytest
from wheelset import GROUP, observed

from railgrip.base import registry
from railgrip.controllers.law import GroupLaw
from railgrip.controllers.parameters import SEARCHED, TYPE_TEST, file_of

ACCEPTED = Path(__file__).with_name("law_responses.json")
SETS = (SEARCHED, "paper", *TYPE_TEST.values())
PERIODS = {"ideal": 1e-3, "pneumatic": 1e-2}
COMMAND = "`python tests/controllers/test_law_responses.py`"
DURATION = 24.0
"""Seconds: six slides, from short and shallow to long and deep."""


def slide(time):
    """Return slip and adhesion: slides of 4 s to slips of 2 to 30 % on a curve whose peak drifts around 4 % slip."""
    number, phase = divmod(time, 4.0)
    deepest = (0.02, 0.05, 0.10, 0.15, 0.20, 0.30)[int(number)]
    slip = deepest * sin(pi * phase / 4.0) ** 2 + 0.002 * sin(2 * pi * 3.0 * time)
    peak = 0.08 + 0.02 * sin(2 * pi * time / 9.0)
    return slip, 2 * peak * 0.04 * slip / (0.04**2 + slip**2)


def response(law, tuning, period):
    """Return the mean and the RMS of the demand [bar] during the slides; the pressure lags the demand by 0.1 s."""
    controller, pressure, demands = law([GROUP], tuning), 0.0, []
    for k in range(round(DURATION / period)):
        time = k * period
        slip, adhesion = slide(time)
        speed = 22.0 - 0.8 * time
        observation = observed(time, speed, -0.8, (slip,), (adhesion,), (0.35,), (pressure,))
        (demand,) = controller.decide(observation)
        pressure += (demand - pressure) * min(period / 0.1, 1.0)
        demands.append(demand / 1e5)
    return [float(np.mean(demands)), float(np.sqrt(np.mean(np.square(demands))))]


def tuned_laws():
    """Return name → law, tuning and period: each set of each law once, for each actuation and source of the slip."""
    found = {}
    files = registry.files(registry.LAWS)
    for kind in registry.modules(registry.LAWS):
        law = registry.part(registry.LAWS, kind, GroupLaw)
        has_set = {name: file_of(kind, name).removesuffix(".toml") in files for name in SETS}
        names = [name for name in SETS if has_set[name]] or [SEARCHED]
        for name, (actuation, period), slip in product(names, PERIODS.items(), ("read", "estimated")):
            try:
                tuning = law.load_tuning(actuation, slip, name, period=period, adhesion_max=0.15, pressure_lag=0.0)
            except ValueError:
                continue  # a set for valves only
            if (law, tuning, period) not in found.values():
                found[f"{kind}, {name}, {actuation}, {slip}"] = law, tuning, period
    return found


LAWS = tuned_laws()


@pytest.mark.parametrize("name", LAWS)
def test_the_response_of_each_law_is_the_accepted_one(name):
    """Equal to 1e-6: another C library changes last digits; a parameter changed by 1 % has a far larger effect."""
    accepted = json.loads(ACCEPTED.read_text(encoding="utf-8"))
    assert name in accepted, f"{name} is a new set of parameters: accept its response by {COMMAND}"
    assert response(*LAWS[name]) == pytest.approx(accepted[name], rel=1e-6), (
        f"{name} demands other pressures than before: its law or its parameters changed. If that is intended, accept "
        f"the response by {COMMAND} and say in the commit which braking distances move"
    )


def test_every_accepted_response_is_of_a_law():
    others = ", ".join(sorted(set(json.loads(ACCEPTED.read_text(encoding="utf-8"))) - set(LAWS)))
    assert not others, f"no law has the parameters of {others}: if they were removed on purpose, run {COMMAND}"


if __name__ == "__main__":
    answers = {name: response(*arguments) for name, arguments in LAWS.items()}
    lines = ",\n".join(f" {json.dumps(name)}: {json.dumps(answer)}" for name, answer in answers.items())
    ACCEPTED.write_text(f"{{\n{lines}\n}}\n", encoding="utf-8")
