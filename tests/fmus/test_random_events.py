"""Random combinations of events agree with an independent evaluation on a fine grid of time."""

import itertools
import random

import fmpy
import numpy as np
import pytest
from sampling import sample
from small_fmus import SCOPE

STEP = 5e-6
"""Grid of the reference; the states of the reference are wrong by a few steps or less for each event."""


def relation(draw):
    """Return a relation of time, of which `s` is a state that equals it; both in Modelica and in numpy."""
    a, b, f = (round(draw.uniform(0.07, 0.5), 4) for _ in range(3))
    t = draw.choice(["time", "time", "s", f"(time - {b})", f"({a} - time)"])
    function = draw.choice([
        f"mod({t}, {a}) - {a * f:.6f}", f"rem({t}, {a}) - {a * f:.6f}", f"floor({t}/{a}) - {draw.randint(0, 3)}.5",
        f"abs({t} - {a}) - {f}", f"sign({t} - {a}) - {f}", f"{t} - {a}", f"mod(abs({t} - {a}), {b}) - {b * f:.6f}",
        f"sin({draw.randint(5, 40)}*{t}) - {f}", f"min(mod({t}, {a}), {b}) - {min(a, b) * f:.6f}",
        f"max({t}, {b} - {t}) - {b + f:.6f}", f"ceil({t}/{b}) - integer({t}/{a}) - 0.5", f"div({t}, {a}) - 0.5",
    ])  # fmt: skip
    return f"{function} {draw.choice(['>', '>=', '<', '<='])} 0"


def model(draw):
    """Return conditions, start and period of a clock, and the Modelica text."""
    first, second = relation(draw), relation(draw)
    join = draw.choice(["c0 and not c1", "c0 or c1", "not c0 and c1", "c0 <> c1"])
    start, period = round(draw.uniform(0.01, 0.2), 4), round(draw.uniform(0.05, 0.3), 4)
    text = f"""model M
  Real s(start=0, fixed=true), x(start=0, fixed=true), y(start=0, fixed=true);
  Boolean c0 = {first}, c1 = {second}, c2 = {join};
  Integer n0(start=0, fixed=true), n1(start=0, fixed=true), n2(start=0, fixed=true), n3(start=0, fixed=true);
  discrete Real d(start=1, fixed=true);
equation
  der(s) = 1;
  der(x) = if c2 then 1 elseif {second} then -0.5 else 0.25;
  der(y) = d;
  when c0 then
    n0 = pre(n0) + 1;
  end when;
  when {{c1, sample({start}, {period})}} then
    n1 = pre(n1) + 1;
  end when;
  when change(c2) then
    n2 = pre(n2) + (if edge(c2) then 1 else 10);
    d = 1 + 0.1*n0 - 0.1*pre(n1);
  end when;
  when pre(n0) + pre(n1) > 3 then
    n3 = pre(n3) + 1;
  end when;
  when c1 then
    reinit(x, 0.5*pre(x) + 1);
  end when;
end M;
"""
    return first, second, join, start, period, text


def reference(first, second, join, start, period):
    """Return the final values of the model, or None if two events are too close to be distinguished on the grid."""
    t = np.concatenate([[0.0], (np.arange(round(1 / STEP)) + 0.4321) * STEP])
    c0, c1 = (eval(e, SCOPE | {"time": t, "s": t}) for e in (first, second))
    c2 = eval(
        join.replace("<>", "!=").replace("not ", "~").replace("and", "&").replace("or", "|"), {"c0": c0, "c1": c1}
    )
    c0, c1, c2 = (np.broadcast_to(c, t.shape) for c in (c0, c1, c2))
    tick = np.zeros(t.shape, dtype=bool)
    tick[np.searchsorted(t, np.arange(start, 1, period))] = True
    # The first point is the start: an edge just after it is an event.
    points = [k for k in range(1, len(t)) if tick[k] or c0[k] != c0[k - 1] or c1[k] != c1[k - 1]]
    if any(b - a < 100 for a, b in itertools.pairwise(points)):
        return None
    x, y, d, n0, n1, n2, n3, many, last = 0.0, 0.0, 1.0, 0, 0, 0, 0, False, 0
    for k in [*points, len(t) - 1]:
        duration = (k - last) * STEP
        x += duration * (1 if c2[last] else -0.5 if c1[last] else 0.25)
        y += duration * d
        if k == points[-1] and last == k:
            break
        up = [c[k] and not c[k - 1] for c in (c0, c1, c2)]
        before = n1
        n0 += up[0]
        n1 += up[1] or bool(tick[k])
        if c2[k] != c2[k - 1]:
            n2 += 1 if up[2] else 10
            d = 1 + 0.1 * n0 - 0.1 * before
        if up[1]:
            x = 0.5 * x + 1
        # This clause reads pre() of the counters, so that it acts in the following pass.
        n3 += n0 + n1 > 3 and not many
        many = n0 + n1 > 3
        last = k
    return {"x": x, "y": y, "n0": n0, "n1": n1, "n2": n2, "n3": n3, "d": d}


@pytest.mark.parametrize("seed", sample(range(12), 4))
def test_random_events_agree_with_a_grid_of_time(modelica, seed):
    draw = random.Random(seed)
    wanted = None
    while wanted is None:
        *parts, text = model(draw)
        wanted = reference(*parts)
    fmu = modelica(text)
    for interface, settings in (
        ("CoSimulation", {"start_values": {"_tolerance": 1e-7}}),
        ("ModelExchange", {"relative_tolerance": 1e-7}),
    ):
        for interval in (0.013, 0.25):
            found = fmpy.simulate_fmu(
                str(fmu.folder), stop_time=1.0, output=list(wanted), output_interval=interval, fmi_type=interface,
                **settings,
            )  # fmt: skip
            end = {name: float(found[name][-1]) for name in wanted}
            # 40 events, each late by a step of the grid or less, with rates of at most 1.5 and d of at most 5.
            assert end == pytest.approx(wanted, abs=40 * 5 * STEP), (seed, interface, interval, text)
