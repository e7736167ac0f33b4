"""What the library has by name."""

import json
from typing import Annotated

import typer

from railgrip.base.registry import SECTIONS, Kind, meanings
from railgrip.report.console import say, show_table
from railgrip.report.table import Table


def list_(
    kind: Annotated[Kind | None, typer.Argument(help="One kind; all without it.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON: kind, name, meaning.")] = False,
) -> None:
    """List what may be named: scenarios, controllers, trains and more."""
    kinds = (kind,) if kind else SECTIONS
    if as_json:
        say(json.dumps({one: meanings(one) for one in kinds}, indent=1, ensure_ascii=False))
        return
    for one in kinds:
        rows = [{"name": name, "meaning": meaning} for name, meaning in meanings(one).items()]
        show_table(Table(rows, left=("name", "meaning"), title=one.capitalize()))
