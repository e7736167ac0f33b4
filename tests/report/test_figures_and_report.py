"""Figures have labels and units, contain the data of the results, and form one self-contained page."""

import hashlib
import re
from dataclasses import replace

import numpy as np
import pandas
import pytest
from matplotlib.text import Text
from pages import figures_of, needs_nothing_else, numbers, signals_of

from railgrip.report import palette, style
from railgrip.report.campaign_figures import adhesion_figure, distance_figure, friction_figure
from railgrip.report.frame import frame_of
from railgrip.report.index import IN_BROWSER, write_report
from railgrip.report.results import read_results
from railgrip.trace.recorder import write_trace

KEPT = {"slip_two_state", "adhesion_based"}


def is_ideal(stop, controllers):
    return stop.variants["equipment"] == "ideal" and stop.variants["controller"] in controllers


def kept(stop):
    return is_ideal(stop, KEPT)


def test_friction_has_a_panel_for_each_scenario_from_blue_to_purple(stops):
    selection = [stops[f"{name}-ideal-slip_two_state"] for name in ("trapezoid", "sine_sweep", "random")]
    panels = friction_figure(selection).axes
    assert len(panels) == 3
    for panel, stop in zip(panels, selection, strict=True):
        assert "μ₀" in panel.get_ylabel()
        mu0 = stop.trace["mu0"].values
        # Coupled wheelsets find the same friction: one line for both, labelled with both.
        assert len(panel.lines) == len(np.unique(mu0, axis=1).T) == 4
        assert panel.lines[0].get_ydata() == pytest.approx(mu0[:, 0])
        assert panel.lines[-1].get_ydata() == pytest.approx(mu0[:, 5])
        assert panel.lines[0].get_color() == pytest.approx(palette.lead_to_trail(6)[0])
    assert "[s]" in panels[-1].get_xlabel()
    assert panels[0].get_legend().get_texts()[0].get_text() == "wheelsets 1, 2"


def test_adhesion_includes_sbc_abc_estimate_maximum_and_limit(stops):
    sbc, abc = stops["trapezoid-ideal-slip_two_state"], stops["trapezoid-ideal-adhesion_based"]
    panel = adhesion_figure(sbc, abc).axes[0]
    lines = {line.get_label(): line for line in panel.lines}
    stops_of = {"SBC": sbc.trace, "peak seeking": abc.trace}
    greatest = [f"greatest possible, {name}" for name in stops_of]
    assert list(lines) == ["SBC, two-state", "peak seeking", *greatest, "limit 0.15", "peak seeking, estimated"]
    assert lines["peak seeking"].get_ydata() == pytest.approx(stops_of["peak seeking"]["adhesion"].values[:, 0])
    for name, trace in stops_of.items():
        assert lines[f"greatest possible, {name}"].get_ydata() == pytest.approx(trace["peak_adhesion"].values[:, 0])
    assert panel.get_xlim()[1] == max(trace["time"].values[-1] for trace in stops_of.values())


def test_distances_are_drawn_next_to_the_published_ones(tmp_path, write_campaign):
    """Those of the two controllers of the paper; railgrip's peak seeking has no mark."""
    write_campaign(tmp_path, lambda stop: is_ideal(stop, {*KEPT, "adhesion_literal"}))
    frame = frame_of(read_results(tmp_path))
    panels_of_rails = distance_figure(frame).axes
    lengths = sorted(bar.get_width() for panel in panels_of_rails for bar in panel.patches)
    assert lengths == pytest.approx(sorted(frame["distance"]))
    marks = sorted(float(line.get_xdata()[0]) for panel in panels_of_rails for line in panel.lines)
    assert marks == sorted([382.9, 333.4, 316.2, 286.6, 339.6, 309.6])


def test_signals_missing_in_a_plant_have_no_row_and_no_number(tmp_path, write_campaign):
    campaign = write_campaign(tmp_path, lambda stop: stop.name == "random-ideal-slip_two_state")
    (stop,) = read_results(tmp_path).stops
    trace = stop.trace.drop_vars("pad_friction")
    trace["cylinder_pressure"] = trace["cylinder_pressure"] * np.nan
    path = stop.directory / "trace.nc"
    write_trace(trace, path)
    without_utilisation = replace(
        stop,
        metrics=replace(stop.metrics, utilisation=float("nan")),
        trace_digest=hashlib.sha256(path.read_bytes()).hexdigest(),
    )
    figure = without_utilisation.plot()
    labels = [panel.get_ylabel() for panel in figure.axes if panel.get_ylabel()]
    assert labels == ["speed [km/h]", "slip [%]", "adhesion"]
    assert all(panel.lines for panel in figure.axes)
    assert "nan" not in figure.get_suptitle()
    assert "adhesion used" not in figure.get_suptitle()
    # One draw of many states its number.
    assert figure.get_suptitle().startswith(f"random, seed {campaign.stops[0].scenario.seed}: ")


def of_case(frame, name):
    """Return the stops as those of a case."""
    return frame.assign(case=name, label=frame["scenario"] + ", " + name)


def test_distances_of_many_stops_are_drawn_as_a_distribution(folder):
    """The figure of draws: a line for each controller, with a dot for each stop, and constant height."""
    frame = frame_of(read_results(folder))
    seeds = [(f"seed {seed}", seed) for seed in range(30)]
    cases = [of_case(frame, name).assign(distance=frame["distance"] + seed) for name, seed in seeds]
    figure = distance_figure(many := pandas.concat(cases))
    assert len(figure.axes) == 3 * 2  # scenarios; distance, and change against the published control
    for panel in figure.axes[::2]:
        names = [text.get_text() for text in panel.get_yticklabels()]
        assert names == ["SBC, two-state 10/15 %", "peak seeking (railgrip)"]
        assert [len(line.get_xdata()) for line in panel.lines if line.get_marker() == "."] == [30, 30]
    assert "[m]" in figure.axes[-2].get_xlabel()
    assert figure.legends[0].get_texts()[0].get_text() == "a stop"
    assert figure.get_figheight() == distance_figure(pandas.concat([many, many])).get_figheight()


def test_each_of_a_few_cases_has_a_line_with_its_friction(folder):
    """Ten cases with a friction each, in two families: a panel of distances and one of changes for each family."""
    frame = frame_of(read_results(folder)).query("scenario == 'trapezoid'")
    cases = [
        of_case(frame, f"case {number}").assign(friction=f"0.{number:02}", polach="dry" if number < 8 else "leaf",
                     distance=np.nan if number == 9 else frame["distance"])
        for number in range(10)
    ]  # fmt: skip
    figure = distance_figure(pandas.concat(cases))
    names = [[text.get_text() for text in panel.get_yticklabels()] for panel in figure.axes[::2]]
    assert [len(lines) for lines in names] == [8, 2]
    assert names[1][1] == "case 9, μ₀ 0.09"
    of_first = [line.get_xdata()[0] for line in figure.axes[0].lines]
    assert sorted(of_first) == pytest.approx(sorted(8 * frame["distance"].tolist()))
    assert [line.get_marker() for line in figure.axes[2].lines].count("x") == len(frame)


def test_the_same_figure_gives_the_same_bytes(stops, tmp_path):
    stop = stops["trapezoid-ideal-slip_two_state"]
    one, other = (style.save(friction_figure([stop]), tmp_path / f"{k}.png").read_bytes() for k in (1, 2))
    assert one == other


def test_a_campaign_yields_one_self_contained_page(folder):
    (folder / IN_BROWSER).write_text("a stop", encoding="utf-8")
    page = write_report(folder, panels="abc", formats=("png", "svg", "pdf"))
    assert needs_nothing_else(page)
    # The overview, distances, friction, and the adhesion of every stop with peak seeking.
    assert len(figures_of(page)) == 3 + 3
    assert (folder / "table1.json").exists()
    heads = {suffix: (folder / "figures" / f"friction.{suffix}").read_bytes()[:5] for suffix in ("png", "svg", "pdf")}
    assert heads == {"png": b"\x89PNG\r", "svg": b"<?xml", "pdf": b"%PDF-"}
    linked = set(re.findall(r'<a href="([^"]*)">', page.read_text(encoding="utf-8")))
    stops = {f"{name}-ideal-adhesion_based/index.html" for name in ("trapezoid", "sine_sweep", "random")}
    assert linked == {*stops, IN_BROWSER}
    assert all((folder / one).exists() for one in linked)


def test_a_single_stop_also_has_a_page(folder, stops):
    page = write_report(folder / "trapezoid-ideal-adhesion_based")
    assert needs_nothing_else(page)
    lines, trace = signals_of(page)["data"], stops["trapezoid-ideal-adhesion_based"].trace
    for panel, name in (("y3", "adhesion"), ("y4", "mu0")):
        for k in range(6):
            (line,) = [one for one in lines if (one["yaxis"], one["name"]) == (panel, f"wheelset {k + 1}")]
            assert numbers(line["y"]) == pytest.approx(trace[name].values[:, k], rel=1e-6)
    train = signals_of(page)["layout"]["meta"]["train"]
    assert numbers(train["distance"]) == pytest.approx(trace["distance"].values, rel=1e-6)
    assert len(train["signals"]["slip"]["values"]) == len(train["positions"]) == 6


@pytest.mark.parametrize("name", ["costs $5 and $6", r"share $\frac{1}{$ of all", "a < b & c", "制动 קטר"])
@pytest.mark.filterwarnings("error:Glyph")
def test_a_name_is_drawn_as_it_is_written(name):
    """In titles, labels, legends and at ticks; powers of ten remain formulas.

    Characters without a glyph, or of right-to-left scripts, are codes.
    """
    drawing, axes = style.panels(6, 4)
    axes.semilogx([1, 1e4], [0, 1], label=name)
    style.dress(axes, x=name, y=name, title=name)
    axes.set_yticks([0], [name])
    style.legend(axes)
    drawing.draw_without_rendering()
    coded = name.replace("制动 קטר", "[U+5236][U+52A8] [U+05E7][U+05D8][U+05E8]")
    texts = [text for text in drawing.findobj(Text) if text.get_text() == coded]
    assert len(texts) == 6  # two at the tick, one of which is invisible
    assert not any(text.get_parse_math() for text in texts)
    assert all(text.get_parse_math() for text in axes.get_xticklabels())


def test_a_campaign_without_any_result_still_has_a_page(tmp_path, write_campaign):
    campaign = write_campaign(tmp_path, lambda stop: stop.name == "trapezoid-ideal-full_brake")
    (tmp_path / campaign.stops[0].name / "stop.json").unlink()
    assert "Not run: trapezoid-ideal-full_brake" in write_report(tmp_path).read_text(encoding="utf-8")
