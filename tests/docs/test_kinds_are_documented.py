"""A new kind fails here until its page, its defaults and its source exist; the message says what to add."""

from pathlib import Path
from typing import get_args

import pytest

from railgrip.base import registry
from railgrip.controllers.law import GroupLaw
from railgrip.estimation.models import model_of
from railgrip.estimators.design import NOISE_SETS
from railgrip.rolling_stock.brakes import LAWS as BLOCK_LAWS
from railgrip.rolling_stock.schema import BrakePipe, Electropneumatic, Train
from railgrip.scenario.faults import Fault
from railgrip.scenario.onboard import SensorModel
from railgrip.simulate.estimator import _NOISE_PREFIX
from railgrip.studies.estimators.replay import ESTIMATORS
from railgrip.studies.type_test.case_set import VERSIONS
from railgrip.studies.type_test.entrants import entrants

DOCS = Path(__file__).parents[2] / "docs"
MODELICA = Path(__file__).parents[2] / "modelica" / "RailBraking"


def classes_of(package):
    return (MODELICA / package / "package.order").read_text(encoding="utf-8").split()


TRAINS = [name for name in classes_of("Predictions") if name.startswith("TrainPrediction")]


def kinds_of(tables, field="kind"):
    return sorted({kind for table in tables for kind in get_args(table.model_fields[field].annotation)})


FAULTS = registry.parts(registry.FAULTS, Fault)
ON_PAGES = {
    "estimators.md": registry.modules(registry.FILTERS),
    "faults.md": [*kinds_of(FAULTS), *kinds_of(FAULTS, "part")],
    "type_test.md": registry.modules(registry.LAWS),
    "trains.md": [
        *(name for name, field in Train.model_fields.items() if field.annotation is not str),
        *kinds_of((BrakePipe, Electropneumatic)),
        *BLOCK_LAWS,
        *(name for package in ("Components", "Pneumatics") for name in classes_of(package) if "Brake" in name),
    ],
    "**/*.md": [*kinds_of(registry.parts(registry.SENSORS, SensorModel)), *registry.names("studies")],
}
"""Page, or pages of which any may have it → kinds."""


OTHER_FORMS = {"compiled", "decentralised", "python"}
"""Forms of the filter `fmu`: in C, by parts of the train, and in numpy."""


@pytest.mark.parametrize(("page", "kind"), [(page, kind) for page, kinds in ON_PAGES.items() for kind in kinds])
def test_each_kind_is_on_its_page(page, kind):
    text = "".join(path.read_text(encoding="utf-8") for path in DOCS.glob(page))
    # A law is a row of the table of controllers; a table of a train file is [kind], [kind.NAME] or [[kind]].
    written = (f"`{kind}`", f'"{kind}"', f"study {kind}", f"`{kind}:", f"| {kind} |", f"[{kind}]", f"[{kind}.")
    written = (*written, f".{kind}`")  # a class of Modelica after its package
    assert any(form in text for form in written), f"docs/{page} does not mention '{kind}'; add a sentence on it"


@pytest.mark.parametrize("law", registry.modules(registry.LAWS))
def test_each_law_takes_part_in_the_type_test(law):
    kinds = {entrant.tables["controller"]["kind"] for entrant in entrants(max(VERSIONS)).values()}
    # Under an emergency brake, as in all its cases, such a law is the slide protection that it contains.
    kinds |= {law} if registry.part(registry.LAWS, law, GroupLaw).exceeds_driver else set()
    assert law in kinds, f"add an entrant with kind = '{law}' to harness/studies/type_test/library/entrants.toml"


@pytest.mark.parametrize("kind", sorted(set(registry.modules(registry.FILTERS)) - OTHER_FORMS))
def test_each_filter_takes_part_in_the_comparison_of_estimators(kind):
    assert kind in ESTIMATORS, f"add '{kind}' to ESTIMATORS in harness/studies/estimators/replay.py"


@pytest.mark.parametrize("model", TRAINS)
def test_each_prediction_of_a_train_has_default_noises(model):
    assert model in _NOISE_PREFIX, f"add {model} to _NOISE_PREFIX in harness/simulate/estimator.py"
    name = f"{_NOISE_PREFIX[model]}_service"
    assert name in NOISE_SETS, f"add [sets.{name}] to estimators/noises.toml, for {model}"
    equations, noise = model_of(model), NOISE_SETS[name]
    states, outputs = ([variable.name for variable in part] for part in (equations.states, equations.outputs))
    for values in (noise.process_noise(states), noise.start_covariance(states), noise.reading_noise(outputs)):
        assert (values > 0.0).all(), f"[sets.{name}] of estimators/noises.toml has a deviation of zero"


@pytest.mark.parametrize("curve", registry.files(registry.CREEP_CURVES))
def test_each_creep_curve_states_its_source(curve):
    meaning = registry.meanings("curves")[curve]
    assert len(meaning.split()) > 2, f"add source = '…' to harness/scenario/creep_curves/{curve}.toml"
