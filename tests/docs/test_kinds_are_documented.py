"""A new kind fails here until its page, its defaults and its source exist; the message says what to add."""

from functools import partial
from pathlib import Path
from typing import get_args

import pytest

from railgrip.base import registry
from railgrip.base.names import ElementName
from railgrip.controllers.law import GroupLaw
from railgrip.estimation.lateral import run as lateral
from railgrip.estimation.models import model_of, of_train
from railgrip.estimation.spec import LIBRARY as ESTIMATION_LIBRARY
from railgrip.estimation.spec import load_specification, settings_for
from railgrip.estimators.design import NOISE_SETS
from railgrip.rolling_stock.brakes import LAWS as BLOCK_LAWS
from railgrip.rolling_stock.schema import BrakePipe, Electropneumatic, Train
from railgrip.scenario.faults import Fault
from railgrip.scenario.file import NamedFile
from railgrip.scenario.load import read_toml
from railgrip.scenario.onboard import SensorModel
from railgrip.simulate.estimator import _NOISE_PREFIX
from railgrip.simulate.train_prediction import CENTRAL
from railgrip.studies.estimators.replay import ESTIMATORS
from railgrip.studies.type_test.case_set import VERSIONS
from railgrip.studies.type_test.entrants import entrants

DOCS = Path(__file__).parents[2] / "docs"
MODELICA = Path(__file__).parents[2] / "modelica" / "RailBraking"


def classes_of(package):
    return (MODELICA / package / "package.order").read_text(encoding="utf-8").split()


VT642 = partial(of_train, NamedFile(entry="vt642", path=registry.shelf("trains")["vt642"]))


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
        *registry.modules(registry.DYNAMIC_BRAKES),
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


ESTIMATIONS = {
    tables["model"]["class"]: path
    for path in sorted(ESTIMATION_LIBRARY.glob("*.toml"))
    if "class" in (tables := read_toml(path)).get("model", {})
}
LATERAL = {name.rpartition(".")[2]: filter_ for filter_, name in lateral.CLASSES.items()}
INTEGRALS = {"y", "psi", "track"}
"""States of lateral predictions that are integrals of others, so that they have no process noise."""


@pytest.mark.parametrize("model", [name for name in (*classes_of("Predictions"), *CENTRAL) if name not in LATERAL])
def test_each_prediction_of_a_train_or_rig_has_default_noises(model):
    if model.startswith("TrainPrediction"):
        assert model in _NOISE_PREFIX, f"add {model} to _NOISE_PREFIX in harness/simulate/estimator.py"
    elif model not in ESTIMATIONS:
        assert model in CENTRAL, (
            f"no noises for {model}: add a file with [model] class = '{model}' and [noise] to "
            "harness/estimation/library, or its noises to harness/estimation/lateral/run.py"
        )
    if model in ESTIMATIONS and model not in _NOISE_PREFIX:
        specification = load_specification(ESTIMATIONS[model])
        equations, settings = specification.model.prediction.model, settings_for(specification, 0.01)
        given = {"process": settings.process, "deviation": settings.start_deviation, "readings": settings.readings}
        where = f"harness/estimation/library/{ESTIMATIONS[model].name}"
    else:
        # A train file has one prediction for all its groups, with the noises of TrainPrediction.
        name = f"{_NOISE_PREFIX.get(model, 'train')}_service"
        assert name in NOISE_SETS, f"add [sets.{name}] to estimators/noises.toml, for {model}"
        equations, noise = model_of(model) if model in _NOISE_PREFIX else VT642(model).model, NOISE_SETS[name]
        given = {"process": noise.process, "deviation": noise.start, "readings": noise.readings}
        where = f"[sets.{name}] of estimators/noises.toml"
    names = {"process": equations.states, "deviation": equations.states, "readings": equations.outputs}
    for table, values in given.items():
        bases = {ElementName.of(variable.name).array for variable in names[table]}
        lacking = sorted(bases - {name for name, value in values.items() if value > 0.0})
        assert not lacking, f"{where}: give {', '.join(lacking)} of {model} a positive value among its {table}"


@pytest.mark.parametrize("model", LATERAL)
def test_each_lateral_prediction_has_default_noises(model):
    where, equations = "of harness/estimation/lateral/run.py", model_of(model)
    states, readings = [variable.name for variable in equations.states], lateral.PLANTS["paper"].sensors
    assert len(readings) == len(equations.outputs), f"sensors {where} have no noise for each output of {model}"
    if LATERAL[model] == "reconstruction":
        for condition, noise in lateral.PAPER_NOISE.items():
            assert len(noise) == len(states), f"PAPER_NOISE['{condition}'] {where} needs one noise for each of {states}"
        return
    lacking = sorted(set(states) - lateral.PROCESS_NOISE.keys() - INTEGRALS)
    assert not lacking, f"add {', '.join(lacking)} of {model} to PROCESS_NOISE {where}; otherwise its noise is 0"
    lacking = sorted(set(states) - lateral.FIRST_DEVIATION.keys())
    assert not lacking, f"add {', '.join(lacking)} of {model} to FIRST_DEVIATION {where}"


@pytest.mark.parametrize("curve", registry.files(registry.CREEP_CURVES))
def test_each_creep_curve_states_its_source(curve):
    meaning = registry.meanings("curves")[curve]
    assert len(meaning.split()) > 2, f"add source = '…' to harness/scenario/creep_curves/{curve}.toml"


def test_a_new_train_file_names_each_kind_of_dynamic_brake():
    text = (DOCS.parent / "harness/cli/templates/train.toml").read_text(encoding="utf-8")
    assert [kind for kind in registry.modules(registry.DYNAMIC_BRAKES) if f'"{kind}"' not in text] == []
