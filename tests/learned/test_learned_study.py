"""The study from runs to scores, figures and estimators, on synthetic runs with known properties."""

from dataclasses import replace

import axle_box_runs
import numpy as np
import pandas as pd
import pytest

from railgrip.base.arrays import generator
from railgrip.estimation.axle_box.evaluate import TrainingRecipe, best_of
from railgrip.estimation.axle_box.instrumented_car import OTHER_CHAINS, LabelledRun
from railgrip.estimation.axle_box.training import QUICK, dry_or_not, estimators_of, export, passes
from railgrip.estimators.learned.trained import load

SIZE = replace(QUICK, starts=2, members=6)
SHARED = (axle_box_runs.runs_of, axle_box_runs._plan, axle_box_runs._general)


def made_up(run):
    """Return a run with individual levels, which a network can recognise and which are independent of friction."""
    draw = generator(run.seed, f"{run.name} {run.condition}")
    level = draw.uniform(0, 3, 20)
    return LabelledRun(
        name=run.name, group=60, speed=26.8, friction=run.friction,
        blocks=np.abs(level + 0.02 * draw.standard_normal((100, 20))),
        other_blocks={name: draw.uniform(0, 3, (100, 20)) for name in OTHER_CHAINS},
        slow=np.column_stack([draw.standard_normal((1000, 8)), np.full(1000, 26.8)]), slope=0.4,
        slip_rate=0.1 / run.friction, slip_acceleration=0.1,
    )  # fmt: skip


@pytest.fixture(scope="module")
def scores():
    for each in SHARED:
        each.cache_clear()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(axle_box_runs, "_map", lambda function, cases: [function(case) for case in cases])
        patch.setitem(axle_box_runs.SIZES, "quick", SIZE)
        patch.setattr(axle_box_runs, "run_of", made_up)
        frame = pd.DataFrame(axle_box_runs.score_rows("quick"))
        yield frame.set_index(["table", "row"])
    for each in SHARED:
        each.cache_clear()


def test_the_study_reveals_that_networks_recognise_runs(scores):
    mae = scores["mae"]
    assert mae["split", "labels exchanged"] < 0.01
    assert mae["split", "first second is zero"] > 3 * mae["split", "labels exchanged"]
    assert mae["honest", "a run left out"] > 0.03


def test_the_error_of_one_of_the_best_networks_is_that_of_the_drawn_network(scores):
    runs, recipe = axle_box_runs.runs_of("quick", "campaign"), TrainingRecipe(starts=1)
    network = best_of(runs, recipe)
    # The last fifth of 100 blocks, which was not used for training.
    errors = [network(recipe.blocks(run)[80:]) - run.friction for run in runs]
    assert scores["mae"]["best"].item() == pytest.approx(np.abs(errors).mean())


def test_the_number_of_hidden_neurons_is_that_of_the_recipe(scores):
    x = [(np.random.default_rng(0).uniform(0, 1, (30, 4)), np.full(30, 0.2))]
    network = TrainingRecipe(starts=1, steps=2, hidden=3).fit(x, "test")[0].network
    assert network.hidden_weights.shape == (3, 4)
    assert list(scores["mae"]["neurons"].index) == ["2", "4", "6", "9"]
    assert scores["mae"]["neurons"].is_unique


def test_the_rule_of_dry_or_not_is_judged_like_the_estimator(scores):
    """0.30 and 0.35 are the dry rails at 60 mph, the other four are contaminated; labels are means of the design."""
    sets = passes(SIZE)
    rule = dry_or_not(sets)
    dry = np.mean([p.friction for p in sets["design"] if p.condition == "dry"])
    rest = np.mean([p.friction for p in sets["design"] if p.condition != "dry"])
    assert sorted(set(rule["campaign"].values())) == pytest.approx([rest, dry])
    errors = [abs(p.friction - (dry if p.friction in (0.30, 0.35) else rest)) for p in sets["campaign"]]
    assert scores["mae_of_rule"]["general", "campaign"] == pytest.approx(np.mean(errors))
    assert set(rule["one surface for all"].values()) == {rest}


@pytest.mark.usefixtures("scores")
def test_figures_are_drawn_and_estimators_exported(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    axle_box_runs.draw("quick")
    assert all((tmp_path / f"axle_box_fig{number}.png").stat().st_size > 3_000 for number in (8, 10))
    rows = axle_box_runs.run_rows("quick")
    assert {row["set"] for row in rows} == {*passes(SIZE), "design on one surface"}
    assert all(row["blocks"] == 100 and row["slip_rate"] == 0.1 / row["friction"] for row in rows)
    recipe = TrainingRecipe(starts=1, steps=2)
    network = best_of(axle_box_runs.runs_of("quick", "campaign"), recipe)
    export(estimators_of(axle_box_runs._general("quick")[0], {60: network}, recipe), tmp_path)
    assert (tmp_path / "friction.fmu").stat().st_size > 10_000
    answer = load(tmp_path / "friction_60mph.json").offline(
        np.full((500, 12), 268.0), np.full(500, 26.8), backwards=False
    )
    assert len(answer.friction) == 500 // 50
