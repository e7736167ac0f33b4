"""Any two variants of a campaign are compared in pairs, and a variant that violates a clause is never recommended."""

import re
from dataclasses import replace
from functools import cache

import pytest
from command_line import exit_code

from railgrip.base.errors import InputError
from railgrip.report.distances import headline
from railgrip.report.distribution import ReferenceVariant, changes_against
from railgrip.report.frame import frame_of
from railgrip.report.index import write_report
from railgrip.report.results import read_results

SAND = """
name = "sand"
scenarios = ["{library}/random.toml"]
{draws}
[axes.sand]
none = {{ }}
some = {{ adhesion.level = 1.1 }}
[axes.controller]
sbc = {{ controller.kind = "slip_two_state" }}
abc = {{ controller.kind = "adhesion_based" }}
"""
DRAWS = "[draws]\nfirst = 1\nlast = 8"
SEEDS = "[sweep]\nseed = [1, 2, 3]"


@pytest.fixture(scope="module")
def campaign(tmp_path_factory, write_campaign):
    @cache
    def write(drawn=DRAWS):
        folder = tmp_path_factory.mktemp("sand")
        write_campaign(folder, text=SAND.replace("{draws}", drawn))
        return folder

    return write


def with_metrics(results, change):
    """Return results with other figures of each stop."""
    stops = (replace(stop, metrics=replace(stop.metrics, **change(stop))) for stop in results.stops)
    return replace(results, stops=tuple(stops))


def with_distances(results, shorter):
    """Return stops whose distance grows with the seed, and is shorter with sand by a share that depends on the seed."""

    def change(stop):
        seed = stop.inputs["seed"]
        share = shorter(seed) if stop.variants["sand"] == "some" else 0.0
        return {"distance": (300.0 + 50.0 * seed) * (1.0 - share)}

    return with_metrics(results, change)


def changes_of(results, text="none"):
    reference = ReferenceVariant.find(text, [stop.variants for stop in results.stops])
    return reference, changes_against(reference, results.stops, frame_of(results))


def test_a_pair_differs_only_in_the_variant(campaign):
    """Distances differ by 50 m between draws, and within each pair exactly by the share of its seed."""
    results = with_distances(read_results(campaign()), lambda seed: 0.01 * seed)
    _, changes = changes_of(results)
    found = [(change.conditions["controller"], change.variant) for change in changes]
    assert found == [("sbc", "some"), ("abc", "some")]
    for change in changes:
        assert change.paired.draws == 8
        assert change.paired.changes == pytest.approx([-0.01 * seed for seed in range(1, 9)])
        assert change.paired.change == pytest.approx(-0.045)
        # Order statistics of eight: the smallest and the largest miss the median with 2 × 2^-8 = 0.8 %.
        assert change.paired.change_interval == pytest.approx((-0.08, -0.01))


def test_any_variant_may_be_the_reference(campaign):
    results = read_results(campaign())
    _, changes = changes_of(results, "abc")
    assert {change.variant for change in changes} == {"sbc"}
    assert all(change.paired.change > 0 for change in changes)
    assert {change.conditions["sand"] for change in changes} == {"none", "some"}


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("nobody", "--against nobody: the campaign has no such variant; it has scenario: random; sand: none, some;"),
        ("random", "--against random: the axis 'scenario' has no other variant to compare with it"),
    ],
)
def test_a_variant_that_cannot_be_compared_is_refused(campaign, text, sentence):
    with pytest.raises(InputError, match=re.escape(sentence)):
        changes_of(read_results(campaign()), text)


def test_a_variant_of_two_axes_needs_the_name_of_its_axis():
    stops = [{"sand": sand, "valves": valves} for sand in ("none", "some") for valves in ("none", "fast")]
    with pytest.raises(InputError, match="choose one of sand=none, valves=none"):
        ReferenceVariant.find("none", stops)
    assert ReferenceVariant.find("valves=none", stops) == ReferenceVariant(axis="valves", variant="none")


@pytest.mark.usefixtures("blank_figures")
def test_page_and_terminal_list_the_pairs(campaign, capfd):
    folder = campaign()
    assert "Variants in pairs" not in write_report(folder, panels="none").read_text(encoding="utf-8")
    assert exit_code("report", folder, "--panels", "none", "--against", "none") == 0
    page, out = (folder / "index.html").read_text(encoding="utf-8"), capfd.readouterr().out
    assert "Variants in pairs" in page
    for text in (page, out):
        assert "change vs none" in text
        assert re.search(r"Against sand none,\s+with controller sbc, some", text)


def test_a_stop_has_no_variants(campaign):
    folder = next(path.parent for path in campaign().glob("*/stop.json"))
    with pytest.raises(InputError, match="holds a stop; only a campaign has variants"):
        write_report(folder, against="none")


def locked(results, controller, seconds):
    """Return results in which stops of a controller have a wheel locked above 15 km/h; others violate no clause."""

    def change(stop):
        longest = (0.0, seconds if stop.variants["controller"] == controller else 0.0)
        return {"longest_lock_fast": longest, "utilisation": 0.95}

    return with_metrics(results, change)


def harmless(results):
    return locked(results, "", 0.0)


def test_a_law_that_locks_wheels_is_not_recommended(campaign):
    """9.3 s of lock where the clause allows 0.4 s."""
    results = harmless(read_results(campaign()))
    assert "peak seeking (railgrip) changes the distance by" in headline(frame_of(results))
    assert "not recommended" not in headline(frame_of(results))
    text = headline(frame_of(locked(results, "abc", 9.3)))
    assert "peak seeking (railgrip) breaks the limit on locked wheels in 16 of 16 stops" in text
    assert "is not recommended" in text
    assert "largest reduction" not in text


def test_a_law_that_satisfies_all_clauses_precedes_one_that_locks(campaign):
    results = locked(read_results(campaign()), "abc", 9.3)
    reference, changes = changes_of(results)
    text = headline(frame_of(results), reference, changes)
    assert text.startswith("Against sand none, with controller sbc, some changes the distance by")
    assert "With controller abc, some breaks the limit on locked wheels in 8 of 8 stops" in text
