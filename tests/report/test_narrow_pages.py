"""On a narrow screen the train, its caption and the braking distances are visible, and no label of a figure is cut."""

import json
import re

import pytest
from legible import in_frames, needs_browser

from railgrip.report.campaign_figures import distance_figure
from railgrip.report.frame import frame_of
from railgrip.report.index import write_report
from railgrip.report.results import read_results

WIDTH = 390
SPEEDS = """
name = "speeds"
scenarios = ["{library}/trapezoid.toml"]
sweep = {{ "start.speed" = ["80 km/h", "120 km/h"], "estimator.kind" = ["none"] }}
[axes.controller]
sbc = {{ controller.kind = "slip_two_state" }}
abc = {{ controller.kind = "adhesion_based" }}
"""
BOXES = """<script>
addEventListener("load", async () => {
  await drawn();
  if (WHAT.printed) dispatchEvent(new Event("beforeprint"));
  const boxes = (what) => [...document.querySelectorAll(what)].map((one) => {
    const { left, right, top, bottom } = one.getBoundingClientRect();
    return { left, right, top, bottom, text: one.textContent, size: parseFloat(getComputedStyle(one).fontSize) };
  });
  parent.document.title = JSON.stringify({ width: innerWidth, ...Object.fromEntries(
    Object.entries(WHAT).filter(([, what]) => what !== "").map(([name, what]) => [name, boxes(what)])) });
});
</script>"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory, write_campaign):
    directory = tmp_path_factory.mktemp("narrow")
    write_campaign(directory, text=SPEEDS)
    write_report(directory)
    return directory


FRAMES = {
    "stop": {"caption": ".controls + .caption", "train": "svg circle", "plot": ".plot .svg-container"},
    "printed stop": {"printed": "html", "plot": ".plot .svg-container"},
    "campaign": {
        "head": "table.data th", "cells": "table.data td",
    },
}  # fmt: skip
"""Page → name → selector of elements."""


@pytest.fixture(scope="module")
def boxes(folder, tmp_path_factory):
    """By page and name the boxes of elements on a screen of `WIDTH` pixels, in pixels; one browser draws all pages."""
    stop = next(folder.glob("*abc*/index.html"))
    frames = [
        (folder / "index.html" if name == "campaign" else stop, BOXES.replace("WHAT", json.dumps(what)), WIDTH, 900)
        for name, what in FRAMES.items()
    ]
    return dict(zip(FRAMES, in_frames(frames, tmp_path_factory.mktemp("screen")), strict=True))


@needs_browser
def test_train_and_signals_of_a_stop_fit_a_narrow_screen(boxes):
    found = boxes["stop"]
    (caption,) = found["caption"]
    assert re.fullmatch(r"\d+\.\d\d s, \d+\.\d m; slip from .*", caption["text"])
    assert caption["size"] >= 12  # pixels: as small as the letters of a table there
    for box in (caption, *found["train"], *found["plot"]):
        assert 0 <= box["left"] < box["right"] <= WIDTH


@needs_browser
def test_distances_of_a_campaign_fit_a_narrow_screen(folder, boxes):
    found = boxes["campaign"]
    (distance,) = (box for box in found["head"] if box["text"] == "distance")
    assert distance["right"] <= WIDTH
    cells = [
        box
        for box in found["cells"]
        if abs(box["right"] - distance["right"]) < 1 and re.match(r"\d+\.\d\b.*m$", box["text"])
    ]
    assert len(cells) == len(frame_of(read_results(folder)))


@needs_browser
def test_figures_are_as_wide_as_paper(boxes):
    """A4 without margins is 690 pixels wide; the summary leaves most of the height to a figure of a stop."""
    (plot,) = boxes["printed stop"]["plot"]
    assert plot["right"] - plot["left"] == pytest.approx(690, abs=1)
    assert plot["bottom"] - plot["top"] > 400  # below the text of a narrow screen


def test_panels_of_bars_are_named_by_their_differences(folder):
    panels = distance_figure(frame_of(read_results(folder))).axes
    assert [panel.get_title(loc="left") for panel in panels] == ["start.speed 80 km/h", "start.speed 120 km/h"]
