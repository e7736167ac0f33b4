"""What the library has by name, and schemas of files."""

import json
from typing import Annotated, Literal

import typer

from railgrip.base.registry import SECTIONS, Kind, meanings
from railgrip.report.console import say, show_table
from railgrip.report.table import Table
from railgrip.rolling_stock.schema import Train
from railgrip.scenario.json_schema import campaign_schema, scenario_schema, schema_of

FileKind = Literal["scenario", "train", "campaign"]


def list_(
    kind: Annotated[Kind | None, typer.Argument(help="One kind; all without it.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON: kind, name, meaning.")] = False,
) -> None:
    """List what may be named: scenarios, controllers, trains and more."""
    kinds = (kind,) if kind else SECTIONS
    if as_json:
        say(json.dumps({kind_: meanings(kind_) for kind_ in kinds}, indent=1, ensure_ascii=False))
        return
    for kind_ in kinds:
        rows = [{"name": name, "meaning": meaning} for name, meaning in meanings(kind_).items()]
        show_table(Table(rows, left=("name", "meaning"), title=kind_.capitalize()))


def schema(
    kind: Annotated[FileKind, typer.Argument(help="What the file is.")] = "scenario",
) -> None:
    """Print the JSON schema of a file, for editors and validators."""
    say(text_of_schema(kind))


def text_of_schema(kind: FileKind) -> str:
    """Return the JSON schema of a kind of file."""
    schemas = {"scenario": scenario_schema, "campaign": campaign_schema, "train": lambda: schema_of(Train)}
    return json.dumps(schemas[kind](), indent=1, ensure_ascii=False)
