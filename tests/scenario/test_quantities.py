"""Quantities are preserved through unit conversions, and overrides have the same effect in any order."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from railgrip.base.errors import ScenarioError
from railgrip.scenario.file import merge, nest, parts_of, read_overrides
from railgrip.scenario.quantity import BOOLEAN, Magnitude, Parameter, in_units


def test_an_unknown_parameter_is_answered_with_a_list_that_has_each_array_once():
    names = {f"J[{i}]": "kg.m2" for i in range(1, 65)} | {"m": "kg"}
    with pytest.raises(ScenarioError, match=r"^\[vehicle\.parameters\] has no parameter 'friction'; there is J, m\.$"):
        in_units("[vehicle.parameters]", {"friction": Magnitude(0.3)}, names)


@pytest.mark.parametrize(("unit", "written"), [("kg.m2", "2 kg*m**2"), ("N.m", "2 N*m"), ("m/s2", "2 m/s**2")])
def test_a_magnitude_is_checked_against_units_in_fmi_spelling(unit, written):
    assert Magnitude(written).si(unit) == 2.0
    with pytest.raises(ValueError, match="cannot be converted"):
        Magnitude(written).si("Pa")


def test_a_bare_magnitude_is_in_the_expected_unit():
    assert Magnitude(3.5).si("kg.m2") == 3.5
    assert Parameter(True).si(BOOLEAN) is True
    assert Parameter(0).si(BOOLEAN) is False
    for boolean, unit in ((True, None), (2, BOOLEAN), ("1", BOOLEAN)):
        with pytest.raises(ValueError, match="is expected"):
            Parameter(boolean).si(unit)


scalars = st.one_of(st.integers(-(2**62), 2**62), st.booleans(), st.floats(allow_nan=False, allow_infinity=False))
keys = st.text(alphabet="abcdefgh_", min_size=1, max_size=8)


@given(key=st.lists(keys, min_size=1, max_size=4), value=scalars)
def test_an_override_sets_one_value(key, value):
    written = str(value).lower() if isinstance(value, bool) else repr(value)
    tree = read_overrides([f"{'.'.join(key)}={written}"])
    for step in key:
        assert list(tree) == [step]
        tree = tree[step]
    assert tree == value
    assert type(tree) is type(value)


@given(text=st.text(alphabet=st.characters(blacklist_categories=["Cc", "Cs"]), min_size=1).filter(str.strip))
def test_a_value_that_is_not_toml_is_a_string(text):
    try:
        value = read_overrides([f"a={text}"])["a"]
    except ScenarioError:
        pytest.fail(f"refused {text!r}")
    assert not isinstance(value, str) or value in {text.strip(), text.strip()[1:-1]} or "\\" in text


tables = st.recursive(scalars, lambda inner: st.dictionaries(keys, inner, max_size=3), max_leaves=8)


@given(base=st.dictionaries(keys, tables, max_size=4), change=st.dictionaries(keys, tables, max_size=4))
def test_applying_a_change_twice_equals_applying_it_once(base, change):
    once = merge(base, change)
    assert merge(once, change) == once
    assert {key: once[key] for key in base if key not in change} == {k: v for k, v in base.items() if k not in change}


def test_overrides_do_not_depend_on_their_order():
    one = read_overrides(["adhesion.kind=random", "adhesion.mean=0.1"])
    assert one == read_overrides(["adhesion.mean=0.1", "adhesion.kind=random"])


FILTER = {"estimator": {"kind": "fmu", "model": "TrainPrediction", "noise": "ideal"}}


@pytest.mark.parametrize(
    ("base", "change", "expected"),
    [
        (
            {"adhesion": {"kind": "trapezoid", "ramp": 1}, "seed": 3},
            {"adhesion": {"kind": "constant", "mu0": 0.1}},
            {"adhesion": {"kind": "constant", "mu0": 0.1}, "seed": 3},
        ),
        *((FILTER, {"estimator": {"kind": kind}}, {"estimator": {"kind": kind}}) for kind in ("none", "module:Class")),
        (
            {"adhesion": {"kind": "sine", "ramp": 1}},
            {"adhesion": {"low": 2}},
            {"adhesion": {"kind": "sine", "ramp": 1, "low": 2}},
        ),
        # another implementation of the same filter
        *(
            (FILTER, {"estimator": {"kind": kind}}, {"estimator": FILTER["estimator"] | {"kind": kind}})
            for kind in ("compiled", "python", "fmu")
        ),
        ({"model": {"class": "W"}}, {"model": {"kind": "compiled"}}, {"model": {"class": "W", "kind": "compiled"}}),
    ],
)
def test_another_kind_clears_its_table_and_the_same_kind_keeps_its_keys(base, change, expected):
    assert merge(base, change) == expected


tree_keys = st.text(min_size=1, max_size=8).filter(lambda key: not ('"' in key and "'" in key))


@given(
    key=st.lists(tree_keys, min_size=1, max_size=4), value=st.one_of(scalars, st.dates(), st.just(None), st.tuples())
)
def test_a_value_set_by_key_is_unchanged(key, value):
    """Any text can be a key if quoted: it may contain the other kind of quotation mark."""
    quoted = [f"'{part}'" if '"' in part else f'"{part}"' for part in key]
    assert parts_of(" . ".join(quoted)) == tuple(key)
    tree = nest({".".join(quoted): value})
    for part in key:
        tree = tree[part]
    assert tree is value


@pytest.mark.parametrize(
    "key", ["", ".", "a.", ".a", "a..b", "a b", "r_wheel[2]", '"a', "a=1", "a\nb", 3, None, b"a", "a." * 900 + "a"]
)
def test_a_key_without_a_table_is_refused(key):
    with pytest.raises(ScenarioError, match=r"is not a key such as|parts; tables are nested"):
        nest({key: 1})


def test_a_multiline_text_cannot_add_a_key():
    assert read_overrides(["a=1\nb = 2"]) == {"a": "1\nb = 2"}


def test_a_list_that_contains_itself_is_refused():
    endless = []
    endless.append(endless)
    with pytest.raises(ScenarioError, match="nested deeper than"):
        nest({"a": endless})
