"""Commands for the library: names, schemas of files, and templates."""

import json
import re
import shlex
from pathlib import Path
from typing import Annotated, Literal

import typer

from railgrip.base.errors import InputError
from railgrip.base.files import write_text
from railgrip.base.registry import SECTIONS, Kind, meanings
from railgrip.base.tables import JsonObject
from railgrip.cli.app import BASELINES, AsJson, print_json
from railgrip.report.console import remark, say, show_table
from railgrip.report.table import ReportTable
from railgrip.rolling_stock.schema import Train
from railgrip.scenario.keys import campaign_schema, extending_schema, scenario_schema, schema_of

FileKind = Literal["scenario", "train", "campaign", "estimation"]


def list_(
    kind: Annotated[Kind | None, typer.Argument(help="Kind to list; all unless given.")] = None,
    as_json: AsJson = False,
) -> None:
    """List the names of scenarios, controllers, trains and more."""
    kinds = (kind,) if kind else SECTIONS
    if as_json:
        print_json({kind_: meanings(kind_) for kind_ in kinds})
        return
    for kind_ in kinds:
        rows = [{"name": name, "meaning": meaning} for name, meaning in meanings(kind_).items()]
        show_table(ReportTable(rows, left=("name", "meaning"), title=kind_.capitalize()))


def schema(
    kind: Annotated[FileKind, typer.Argument(help="What the file is.")] = "scenario",
) -> None:
    """Print the JSON schema of a file, for editors and validators."""
    say(text_of_schema(kind))


def text_of_schema(kind: FileKind) -> str:
    """Return the JSON schema of a kind of file."""
    schemas = {
        "scenario": scenario_schema,
        "campaign": campaign_schema,
        "train": lambda: schema_of(Train),
        "estimation": _estimation_schema,
    }
    return json.dumps(schemas[kind](), indent=1, ensure_ascii=False)


def _estimation_schema() -> JsonObject:
    from railgrip.estimation.spec import Specification  # loads xarray, which takes as long as all other imports

    schema = extending_schema(Specification, "estimation")
    file = {
        "type": "object",
        "properties": {"file": {"type": "string", "description": "whose [noise] is taken"}},
        "required": ["file"],
        "additionalProperties": False,
    }
    for table in (schema, schema["$defs"][Specification.__name__]):
        tables = [table["properties"]["noise"], file]
        table["properties"]["noise"] = {"anyOf": tables, "description": "variances, or the file that contains them"}
    return schema


_TEMPLATES = Path(__file__).parent / "templates"
_LINE = Path(__file__).parents[1] / "studies" / "benefit" / "library" / "line_commuter.toml"

_NEXT = {
    "scenario": "railgrip run {file}",
    "train": "railgrip train show {file}",
    "campaign": "railgrip campaign {file}",
    "regression": "railgrip maintain regress{baselines}",
    "controller": "python {file}",
    "estimator": "python {file}",
    "line": "railgrip study benefit emu387 --line {file}",
}
"""Next step for a new file, by its kind."""


def new(
    kind: Annotated[
        Literal["scenario", "train", "controller", "estimator", "campaign", "line", "regression"],
        typer.Argument(help="What to write."),
    ],
    file: Annotated[Path, typer.Argument(metavar="FILE", help="File to write (.toml or .py); it must not exist yet.")],
    workflow: Annotated[
        bool, typer.Option("--workflow", help="With a regression, also a workflow of GitHub Actions that runs it.")
    ] = False,
) -> None:
    """Write a commented file to start from, which runs as it is.

    With a TOML file, except that of a line, comes its JSON schema, which editors with Even Better TOML or taplo use to
    complete and check it. A regression is a campaign, with its baseline below tests/baselines in the same folder.
    """
    if workflow and (kind != "regression" or file.is_absolute()):
        raise InputError(f"--workflow: expects a regression in a file relative to the repository, got {kind} {file}")
    template = _LINE if kind == "line" else next(_TEMPLATES.glob(f"{kind}.*"))
    if file.suffix != template.suffix:
        raise InputError(f"{file}: the file of a {kind} ends in {template.suffix}")
    wanted, what = r"[A-Za-z0-9][A-Za-z0-9_.-]*", "letters, digits, dots, - and _, a letter or digit first"
    if file.suffix == ".py":
        wanted, what = r"[A-Za-z_][A-Za-z0-9_]*", "letters, digits and _, no digit first, as Python imports it"
    if not re.fullmatch(wanted, file.stem):
        raise InputError(f"{file}: the name of a {kind} has {what}")
    texts = {file: template}
    if kind == "regression":
        texts[file.parent / BASELINES / file.name] = _TEMPLATES / "baseline.toml"
    if workflow:
        texts[Path(".github/workflows") / f"{file.stem}.yml"] = _TEMPLATES / "workflow.yml"
    for path in texts:
        if path.exists():
            raise InputError(f"{path} exists; choose another file")
    name_of_class = "".join(part[:1].upper() + part[1:] for part in file.stem.split("_")) or "Own"
    baselines = "" if file.parent == Path() else f" --baselines {shlex.quote(str(file.parent / BASELINES))}"
    for path, source in texts.items():
        text = source.read_text(encoding="utf-8").replace(kind.upper(), name_of_class).replace("NAME", file.stem)
        write_text(path, text.replace(" --baselines BASELINES", baselines))
    if kind in ("scenario", "train", "campaign", "regression"):
        write_schema("campaign" if kind == "regression" else kind, file)
    say(f"{', '.join(map(str, texts))}; continue with: {_NEXT[kind].format(file=file, baselines=baselines)}")


def write_schema(kind: FileKind, file: Path) -> None:
    """Write the schema that the first line of a new file refers to, unless the file exists."""
    schema_file = file.with_name(f"{kind}.schema.json")
    if not schema_file.exists():
        write_text(schema_file, text_of_schema(kind) + "\n")
        remark(f"{schema_file}, used by editors to check the file")
