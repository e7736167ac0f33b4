"""The tables and the figure of the documentation have exactly the accepted distances."""

import html
import re

import pytest
from project_files import BASELINES, ROOT
from validation import (
    BASELINE,
    CONVERGENCE,
    CONVERGENCE_CAMPAIGNS,
    FILE,
    TABLES,
    distances_figure,
    tables,
    tolerances_table,
)

from railgrip.base.errors import InputError, RecordError, ScenarioError
from railgrip.base.registry import shelf
from railgrip.report.baseline import AcceptedValue, Baseline, load_baseline
from railgrip.report.style import save
from railgrip.report.table import END, write_tables
from railgrip.scenario.campaign import load_campaign
from railgrip.scenario.conditioning import ConditioningFile, RepeatedDistances, read_conditioning, text_of

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


def written(folder, text):
    """Return a campaign over the rail `random` of the library."""
    path = folder / "c.toml"
    path.write_text(f'name = "c"\nscenarios = ["random"]\n{text}', encoding="utf-8")
    return load_campaign(path)


BEGIN = "<!-- distances: written by `make validation` -->"


@pytest.mark.parametrize("name", TABLES)
def test_the_table_of_the_page_is_the_accepted_one(name):
    """If this fails after accepting a baseline, run `make validation`, which writes the table."""
    page, tables_of = TABLES[name]
    baseline = load_baseline(BASELINES / f"{name}.toml")
    campaign = load_campaign(BASELINES / baseline.campaign)
    text = (ROOT / "docs" / page).read_text(encoding="utf-8")
    for name, table in tables_of(campaign, baseline).items():
        assert f"{BEGIN.replace('distances', name)}\n{table}\n{END}" in text


def test_each_stop_of_the_campaigns_of_convergence_is_repeated_at_all_tolerances():
    """If this fails, run `make convergence`, which repeats the stops and writes the table of the page."""
    campaigns = [load_campaign(shelf("campaigns")[name]) for name in CONVERGENCE_CAMPAIGNS]
    for campaign in campaigns:
        repeats = read_conditioning(campaign.conditioning).stops
        current = {stop.name: stop.scenario.digest() for stop in campaign.stops}
        assert {name: one.digest for name, one in repeats.items()} == current
        assert all(set(one.tolerances) == {1e-4, 1e-6, 1e-7} for one in repeats.values())
    text = (ROOT / "docs" / CONVERGENCE).read_text(encoding="utf-8")
    assert f"{BEGIN.replace('distances', 'tolerances')}\n{tolerances_table(*campaigns)}\n{END}" in text


def description_of(svg):
    """Return the text that `save` writes into the metadata of an SVG."""
    text = svg.read_text(encoding="utf-8")
    return html.unescape(re.search(r"<dc:description>(.*?)</dc:description>", text, re.DOTALL)[1])


def test_the_figure_of_the_pages_is_of_the_accepted_distances():
    """If this fails after accepting a baseline or repeating lots of sensors, run `make validation`."""
    baseline = load_baseline(BASELINES / f"{BASELINE}.toml")
    _, numbers = distances_figure(load_campaign(BASELINES / baseline.campaign), baseline)
    assert description_of(ROOT / "docs" / FILE) == numbers
    for page in ("README.md", "docs/index.md", "docs/validation.md"):
        assert re.search(rf"!\[.+\]\((docs/)?{FILE}\)", (ROOT / page).read_text(encoding="utf-8"))


def drawn(figure):
    """Return the abscissae of the marks, ranges and published distances of the first panel."""
    lines = [(sorted(set(map(float, line.get_xdata()))), line.get_linestyle()) for line in figure.axes[0].lines]
    return (
        sorted(x[0] for x, style in lines if len(x) == 1 and style != "--"),
        sorted(x for x, _ in lines if len(x) == 2),
        sorted(x[0] for x, style in lines if style == "--"),
    )


def test_the_figure_has_distances_ranges_and_published_distances(campaign, baseline, tmp_path):
    """Of the tuned controls it has the better one."""
    figure, numbers = distances_figure(campaign, baseline)
    assert numbers.splitlines() == [
        "random-ideal-sbc: 400.0 m, paper 410.0 m",
        "random-ideal-fine: 300.0 m",
        "random-ideal-abc: 310.0 m, 290.0 to 340.0 m, paper 369.0 m",
    ]
    assert drawn(figure) == ([300, 310, 400], [[290, 340]], [369, 410])
    assert description_of(save(figure, tmp_path / "f.svg", numbers)) == numbers


def test_the_figure_has_medians_over_lots_or_else_the_accepted_distance(campaign_with_lots):
    """Of both laws it has the shorter one, by 0.1 m."""
    campaign, baseline = campaign_with_lots
    figure, _ = distances_figure(campaign, baseline)
    medians, ranges, _ = drawn(figure)
    assert medians == pytest.approx([369.9, 400])
    # Lots shift SBC by ±9.5 m, slope seeking by 1.2 times that.
    assert ranges == [pytest.approx([358.5, 381.3]), [390.5, 409.5]]
    title = figure.get_suptitle().replace("\n", " ")
    assert title == "In service slope-seeking control stops 8 % shorter than slip-based control as published"
    moved = baseline.model_copy(update={"accepted": {name: stop(500) for name in baseline.accepted}})
    assert drawn(distances_figure(campaign, moved)[0])[:2] == ([500, 500], [])


@pytest.fixture
def campaign(tmp_path):
    return written(tmp_path, EQUIPMENT)


def stop(distance, **more):
    return AcceptedValue(value=distance, unit="m", tolerance=1, reason="r", **more)


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


def test_changes_are_relative_to_the_published_and_the_best_tuned_control(campaign, baseline):
    lines = str(tables(campaign, baseline)["distances"]).splitlines()
    assert lines == [
        "| braking distance | random |",
        "|---|--:|",
        "| *published: SBC, two-state 10/15 %* | 410.0 m |",
        "| *published: peak seeking (railgrip)* | 369.0 m (−10.0 %) |",
        "| ideal, 20 ms lag: SBC, two-state 10/15 % | 400.0 m (+33.3 %) |",
        "| ideal, 20 ms lag: SBC, two-state 1/2 % | 300.0 m (−25.0 %) |",
        "| ideal, 20 ms lag: SBC, two-state 20/30 % | 500.0 m (+25.0 %, +66.7 %) |",
        # The lock of the accepted run is not that of the repeats, whose median and range these are.
        "| ideal, 20 ms lag: peak seeking (railgrip) | 310.0 m, 290.0 – 340.0 m (−22.5 %, +3.3 %) |",
    ]
    assert str(tables(campaign, baseline)["runs"]).splitlines()[2:] == [
        "| ideal, 20 ms lag: SBC, two-state 10/15 % | 0.123 | 0.0 s | 12 |",
        "| ideal, 20 ms lag: SBC, two-state 1/2 % |  |  |  |",
        "| ideal, 20 ms lag: SBC, two-state 20/30 % |  |  |  |",
        "| ideal, 20 ms lag: peak seeking (railgrip) |  | 18.9 s |  |",
    ]


WITH_LOTS = """
conditioning = "c.json"
[axes.equipment]
service = "service"
[axes.controller]
sbc = { controller.kind = "slip_two_state" }
abc = { controller.kind = "adhesion_based" }
seeking = { controller.kind = "slope_seeking" }
"""


@pytest.fixture
def campaign_with_lots(tmp_path):
    """Three controllers with service sensors: SBC at 400 m, ABC 30 m and slope seeking another 0.1 m shorter."""
    campaign = written(tmp_path, WITH_LOTS)
    # Lots shift all controllers equally by up to ±9.5 m; the last pair differs by −0.1 ± 1.9 m.
    shifts = [number - 9.5 for number in range(20)]
    lots = {
        "sbc": [400 + shift for shift in shifts],
        "abc": [370 + shift for shift in shifts],
        "seeking": [369.9 + 1.2 * shift for shift in shifts],
    }
    repeats = {}
    for one in campaign.stops:
        each = lots[one.variants["controller"]]
        repeats[one.name] = RepeatedDistances(digest=one.scenario.digest(), distances=[each[0]] * 20, lots=each)
    campaign.conditioning.write_text(text_of(ConditioningFile(relative=1e-7, stops=repeats)), encoding="utf-8")
    accepted = {f"random-service-{name}": stop(values[0]) for name, values in lots.items()}
    return campaign, Baseline(campaign="c.toml", accepted=accepted)


def test_distances_with_erroneous_sensors_are_medians_over_lots_compared_in_pairs(campaign_with_lots):
    """The accepted distance is that of one lot, here the shortest of the twenty."""
    named = tables(*campaign_with_lots)
    distances, orders = str(named["distances"]), str(named["orders"])
    assert "| service: SBC, two-state 10/15 % | 400.0 m, 390.5 – 409.5 m |" in distances
    # The median of 20 changes (370 + d)/(400 + d) − 1 is that of d = ±0.5: −30/399.5 and −30/400.5.
    assert "| service: peak seeking (railgrip) | 370.0 m, 360.5 – 379.5 m (−7.5 %) |" in distances
    assert orders.splitlines()[2:] == [
        # 95 % order interval of a median of 20: 6th and 15th value (Conover): −0.1 ± 0.2 · 4.5 m.
        "| slope-seeking control | peak seeking (railgrip) | −0.1 m [−1.0, +0.8] not separated |",
        "| peak seeking (railgrip) | SBC, two-state 10/15 % | −30.0 m [−30.0, −30.0] shorter |",
    ]


def test_a_table_without_repeats_of_the_accepted_stops_is_refused(campaign_with_lots):
    campaign, baseline = campaign_with_lots
    moved = baseline.model_copy(update={"accepted": {name: stop(500) for name in baseline.accepted}})
    words = "no repeats with other lots of sensors of random-service-sbc.* as accepted"
    with pytest.raises(ScenarioError, match=words):
        tables(campaign, moved)


def test_only_the_text_between_the_marks_is_written(tmp_path, campaign, baseline):
    path = tmp_path / "validation.md"
    path.write_text(f"before\n{BEGIN}\nold\n{END}\nafter\n", encoding="utf-8")
    table = tables(campaign, baseline)["distances"]
    write_tables(path, {"distances": table})
    assert path.read_text(encoding="utf-8") == f"before\n{BEGIN}\n{table}\n{END}\nafter\n"
    path.write_text("no marks\n", encoding="utf-8")
    with pytest.raises(RecordError, match=r"validation\.md: lacks a line that encloses the table"):
        write_tables(path, {"distances": ""})
    with pytest.raises(InputError, match="there is no such file"):
        write_tables(tmp_path / "gone.md", {"distances": ""})
