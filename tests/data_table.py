"""The table [data] of an estimation, which maps the columns of a file to signals."""

from pathlib import Path

from railgrip.recording.table import DataTable
from railgrip.scenario.load import validate_table


def data_table(columns, **changes):
    """Return the table for these columns of a file with the time in seconds in a column `t`, every 10 ms."""
    values = {"time": {"column": "t", "unit": "s"}, "period": 0.01, "longest_gap": 0.1, "frozen": 1.0, "spike": 8.0}
    return validate_table(DataTable, values | changes | {"columns": columns}, directory=Path(), origin="run.toml")
