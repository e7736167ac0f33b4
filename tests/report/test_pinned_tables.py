"""Tables, files and comparisons of small results equal those in `pinned`, character by character.

The stops are synthetic, so that only a change of the tables can cause a difference. If it is intended, write the files
again with `RAILGRIP_PIN=1 python -m pytest tests/report/test_pinned_tables.py` and review their difference.
"""

import json
import os
from dataclasses import replace
from pathlib import Path

import pytest
from synthetic_runner import stop_with
from test_distributions import CAMPAIGN as DRAWS
from test_variants import DRAWS as EIGHT
from test_variants import SAND, SEEDS

import railgrip as rg
from railgrip.campaign.sweep import csv_of
from railgrip.report.distances import headline, overview_of, overview_table, write_table
from railgrip.report.distribution import change_table, changes_against, distributions_of, quantile_table, worst_table
from railgrip.report.frame import frame_of
from railgrip.report.index import reference_of
from railgrip.report.results import read_results
from railgrip.report.stop import metrics_table
from railgrip.report.table import ReportTable

PINNED = Path(__file__).parent / "pinned"


def check(name: str, text: str) -> None:
    """Compare a text with the file of this name, or write it."""
    path = PINNED / name
    if os.environ.get("RAILGRIP_PIN"):
        path.write_text(text, encoding="utf-8")
    assert text == path.read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def results(tmp_path_factory, write_campaign):
    """Return a function that writes a campaign and reads its results."""

    def read(name, text="", keep=lambda _: True):
        folder = tmp_path_factory.mktemp(name)
        write_campaign(folder, keep, text=text)
        return folder, read_results(folder)

    return read


def test_the_table_of_a_campaign(results):
    folder, found = results("table1", keep=lambda stop: stop.variants["scenario"] == "trapezoid")
    check("table1.md", write_table(found, folder)[1].read_text(encoding="utf-8"))
    rows = frame_of(found)
    check("table1_overview.md", f"{headline(rows)}\n\n{overview_table(overview_of(rows))}\n")


def test_the_tables_of_draws(results):
    folder, found = results("drawn", DRAWS)
    rows = frame_of(found)
    tables = (quantile_table(distributions_of(rows), 300.0), worst_table(rows, {}, 3))
    text = write_table(found, folder)[1].read_text(encoding="utf-8")
    check("drawn.md", "\n\n".join([text, *map(str, tables), headline(rows)]) + "\n")


@pytest.mark.parametrize(("name", "draws"), [("sand", EIGHT), ("seeds", SEEDS)])
def test_variants_in_pairs(results, name, draws):
    text = SAND.replace("{draws}", draws)
    _, found = results("sand", text)
    rows, reference = frame_of(found), reference_of(found.stops, "sand=none")
    changes = changes_against(reference, found.stops, rows)
    check(f"{name}.md", f"{change_table(reference, changes)}\n\n{headline(rows, reference, changes)}\n")


def test_the_json_and_csv_of_a_campaign(results):
    """Numbers to nine digits: the last ones of a sum depend on the machine."""
    folder, found = results("drawn", DRAWS)
    content = json.loads(write_table(found, folder)[0].read_text(encoding="utf-8"))
    check("drawn.json", json.dumps(_rounded(content), indent=1, ensure_ascii=False) + "\n")
    head, first, *_ = csv_of(rg.load(folder).to_pandas()).splitlines()
    cells = dict(zip(head.split(","), first.split(","), strict=True))
    lines = (f"{name}: {_rounded(json.loads(cell)) if _is_number(cell) else cell}" for name, cell in cells.items())
    check("drawn_csv.txt", "\n".join(lines) + "\n")


def _is_number(text):
    return text.replace(".", "").replace("-", "").replace("e", "").isdigit()


def _rounded(value):
    if isinstance(value, dict):
        return {key: _rounded(each) for key, each in value.items()}
    if isinstance(value, list):
        return [_rounded(each) for each in value]
    # Residuals of an exact balance consist of rounding alone.
    return (float(f"{value:.9g}") if abs(value) > 1e-9 else 0.0) if isinstance(value, float) else value


def test_the_comparison_and_the_figures_of_a_stop():
    stop, other = (stop_with(f"controller.kind={kind}") for kind in ("adhesion_based", "slip_two_state"))
    # These two consist of rounding, or differ by it, which depends on the machine.
    exact = {"energy_residual": 1e-6, "adhesion_sd": (0.01,) * 4}
    stop, other = (replace(one, metrics=replace(one.metrics, **exact)) for one in (stop, other))
    screen = rg.compare(stop, other).page().screen
    check("comparison.md", "\n\n".join(str(part) for part in screen if part) + "\n")
    assert all(isinstance(part, ReportTable | str) for part in screen)
    check("metrics.md", f"{metrics_table(stop.figures)}\n")
