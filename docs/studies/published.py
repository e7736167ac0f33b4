"""The table of published quantities and ours at the head of a page."""

from collections.abc import Iterable

import pandas as pd

import railgrip as rg
from railgrip.report.table import ReportTable

COLUMNS = ["figure", "quantity", "published", "ours", "difference"]


def compare(lines: Iterable[str]) -> ReportTable:
    """Return the table of lines whose cells a bar separates; cells at the end may be left out."""
    cells = pd.Series([line.strip() for line in lines]).str.split(r"\s*\|\s*", expand=True, regex=True)
    return rg.table(cells.reindex(columns=range(5)).set_axis(COLUMNS, axis=1), left=COLUMNS[:2])
