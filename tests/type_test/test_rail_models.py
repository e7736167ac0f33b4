"""Every rail model of the schema is in a case of version 2 of the type test, or the page explains its absence."""

import re
from pathlib import Path
from typing import Literal, get_args, get_origin

import pytest

from railgrip.scenario.file import merge
from railgrip.scenario.load import scenario_of
from railgrip.scenario.profile import Adhesion, Conditioning
from railgrip.scenario.surface import Polach
from railgrip.studies.type_test.case_set import VERSIONS
from railgrip.studies.type_test.entrants import train_of

PAGE = Path(__file__).parents[2] / "docs" / "type_test.md"
SECOND = VERSIONS[2]
DESIGN = SECOND.design(SECOND.count, SECOND.test)


def models_of_schema():
    """Return every kind of profile and every key of [adhesion], with the words of its choices, as `key = "word"`."""
    found = set()
    for profile in get_args(get_args(Adhesion)[0]):
        (kind,) = get_args(profile.model_fields["kind"].annotation)
        found |= {f'kind = "{kind}"', *profile.model_fields}
    found |= {f"polach.{key}" for key in Polach.model_fields}
    for key in ("fraction", "recovered", "by"):
        annotation = Conditioning.model_fields[key].annotation
        words = get_args(annotation) if get_origin(annotation) is Literal else ()
        found |= {f'conditioning.{key} = "{word}"' for word in words} or {f"conditioning.{key}"}
    return found - {"kind"}


def models_in(table):
    """Return those of a valid table of [adhesion] that differ from what the schema assumes."""
    merged = merge(train_of(None), {"name": "rail", "adhesion": table})
    adhesion = scenario_of(merged, directory=Path(), origin="test").adhesion
    found = {f'kind = "{adhesion.kind}"'}
    for key, field in type(adhesion).model_fields.items():
        if field.is_required() or getattr(adhesion, key) != field.get_default(call_default_factory=True):
            found.add(key)
    for key in Polach.model_fields:
        if getattr(adhesion.polach, key) is not None:
            found.add(f"polach.{key}")
    if (passage := adhesion.conditioning) is not None:
        found |= {"conditioning.fraction", "conditioning.recovered", f'conditioning.by = "{passage.by}"'}
    return found - {"kind"}


@pytest.fixture(scope="module")
def present():
    tables = {repr(table): table for case in DESIGN for table in [case.tables(4)["adhesion"]]}
    return set().union(*map(models_in, tables.values()))


@pytest.fixture(scope="module")
def absent():
    """Return name → reason, from the table of the page."""
    text = PAGE.read_text(encoding="utf-8").partition("| absent rail model |")[2].partition("\n\n")[0]
    rows = [line.strip("|").split("|") for line in text.splitlines() if line.startswith("| `")]
    return {name: reason.strip() for names, reason in rows for name in re.findall(r"`([^`]+)`", names)}


def test_every_rail_model_is_in_a_case_or_its_absence_is_explained(present, absent):
    assert present | absent.keys() == models_of_schema()


def test_no_rail_model_of_a_case_is_said_to_be_absent(present, absent):
    assert not present & absent.keys()
    assert all(len(reason.split()) >= 5 for reason in absent.values())


def test_a_model_that_is_in_no_case_is_noticed(present):
    """The rails of passing wheels alone have a sine sweep and a conditioned rail."""
    of_others = {repr(table): table for case in SECOND.draw(SECOND.count, SECOND.test)
                 for table in [case.tables(4)["adhesion"]]}  # fmt: skip
    missing = present - set().union(*map(models_in, list(of_others.values())[:96]))
    assert {'kind = "sine_sweep"', "conditioning", 'conditioning.by = "wheelset"'} <= missing
