"""The tables of the documentation have the accepted distances and no others."""

from pathlib import Path

import pytest

from railgrip.base.errors import RecordError
from railgrip.report.baseline import Accepted, Baseline, load_baseline, write_baseline
from railgrip.report.marked import END, write_tables
from railgrip.report.validation import TABLES, cases_table, table
from railgrip.scenario.campaign import load_campaign

ROOT = Path(__file__).parents[2]
BASELINES = ROOT / "tests" / "baselines"

EQUIPMENT = """
[axes.equipment]
ideal = {}
[axes.controller]
sbc = { controller.kind = "slip_two_state" }
fine = { controller = { kind = "slip_two_state", parameters = { low = 0.01, high = 0.02 } } }
coarse = { controller = { kind = "slip_two_state", parameters = { low = 0.2, high = 0.3 } } }
abc = { controller.kind = "adhesion_based" }
[[reference]]
match = { controller = "sbc" }
distance = 410
source = "a book"
[[reference]]
match = { controller = "abc" }
distance = 369
source = "a book"
"""

BEGIN = "<!-- distances: written by `make validation` -->"


@pytest.mark.parametrize("name", TABLES)
def test_the_table_of_the_page_is_the_accepted_one(name):
    """Fails if a baseline was accepted without `make validation`, which writes the table."""
    page, table_of = TABLES[name]
    baseline = load_baseline(BASELINES / f"{name}.toml")
    campaign = load_campaign(BASELINES / baseline.campaign)
    text = (ROOT / "docs" / page).read_text(encoding="utf-8")
    assert f"{BEGIN}\n{table_of(campaign, baseline)}\n{END}" in text


def test_a_baseline_of_some_stops_has_a_row_for_each_case(tmp_path):
    from synthetic import LIBRARY

    path = tmp_path / "c.toml"
    path.write_text(
        f'''name = "c"
scenarios = ["{(LIBRARY / "random.toml").as_posix()}"]
[axes.case.light_train]
truth.load = 0.8
[axes.case.as_believed]
[axes.controller.sbc]
controller.kind = "slip_two_state"
[axes.controller.abc]
controller.kind = "adhesion_based"
''',
        encoding="utf-8",
    )
    campaign, patterns = load_campaign(path), ("*-sbc",)
    accepted = {"random-light_train-sbc": stop(400), "random-as_believed-sbc": stop(310, lowest=290, highest=340)}
    some = Baseline(campaign="c.toml", stops=patterns, accepted=accepted)
    assert [one.name for one in some.selection(campaign).stops] == [*accepted]
    assert cases_table(campaign, some).splitlines() == [
        "| case | SBC, two-state 10/15 % |",
        "|---|--:|",
        "| light train | 400.0 m |",
        "| as believed | 310.0 m, 290.0 – 340.0 m |",
    ]
    write_baseline(some, tmp_path / "some.toml")
    assert load_baseline(tmp_path / "some.toml") == some


@pytest.fixture
def campaign(tmp_path):
    from synthetic import LIBRARY

    path = tmp_path / "c.toml"
    path.write_text(
        f'name = "c"\nscenarios = ["{(LIBRARY / "random.toml").as_posix()}"]\n{EQUIPMENT}', encoding="utf-8"
    )
    return load_campaign(path)


def stop(distance, **more):
    return Accepted(value=distance, unit="m", tolerance=1, reason="r", **more)


@pytest.fixture
def baseline():
    return Baseline(
        campaign="c.toml",
        accepted={
            "random-ideal-sbc": stop(400, adhesion_peak=0.1234, longest_lock=0.0, valve_strokes=12),
            "random-ideal-fine": stop(300),
            "random-ideal-coarse": stop(500),
            "random-ideal-abc": stop(310, lowest=290, highest=340, longest_lock=18.94),
        },
    )


def test_changes_are_against_the_published_and_the_best_tuned_and_ranges_are_ranges(campaign, baseline):
    lines = table(campaign, baseline).splitlines()
    assert lines == [
        "| braking distance | random | greatest adhesion | longest lock | valve strokes |",
        "|---|--:|--:|--:|--:|",
        "| *paper: SBC, two-state 10/15 %* | 410.0 m |  |  |  |",
        "| *paper: ABC* | 369.0 m (−10.0 %) |  |  |  |",
        "| ideal, 20 ms lag: SBC, two-state 10/15 % | 400.0 m (+33.3 %) | 0.123 | 0.0 s | 12 |",
        "| ideal, 20 ms lag: SBC, two-state 1/2 % | 300.0 m (−25.0 %) |  |  |  |",
        "| ideal, 20 ms lag: SBC, two-state 20/30 % | 500.0 m (+25.0 %, +66.7 %) |  |  |  |",
        "| ideal, 20 ms lag: ABC | 310.0 m, 290.0 – 340.0 m (−22.5 %, +3.3 %) |  | 18.9 s |  |",
    ]


def test_only_what_stands_between_the_marks_is_written(tmp_path, campaign, baseline):
    path = tmp_path / "validation.md"
    path.write_text(f"before\n{BEGIN}\nold\n{END}\nafter\n", encoding="utf-8")
    write_tables(path, {"distances": table(campaign, baseline)})
    assert path.read_text(encoding="utf-8") == f"before\n{BEGIN}\n{table(campaign, baseline)}\n{END}\nafter\n"
    path.write_text("no marks\n", encoding="utf-8")
    with pytest.raises(RecordError, match=r"validation\.md: lacks a line that encloses the table"):
        write_tables(path, {"distances": ""})
    with pytest.raises(RecordError, match="cannot be read: No such file"):
        write_tables(tmp_path / "gone.md", {"distances": ""})
