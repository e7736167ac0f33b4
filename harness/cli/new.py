"""Files to begin with."""

import re
from pathlib import Path
from typing import Annotated, Literal

import typer

from railgrip.base.errors import InputError
from railgrip.base.files import write_text
from railgrip.cli.library import text_of_schema
from railgrip.report.console import remark, say

_TEMPLATES = Path(__file__).parent / "templates"

_NEXT = {
    "scenario": "railgrip run {file}",
    "train": "railgrip train show {file}",
    "campaign": "railgrip campaign {file}",
    "controller": "python {file}",
    "estimator": "python {file}",
}
"""What to do with a new file, by its kind."""


def new(
    kind: Annotated[
        Literal["scenario", "train", "controller", "estimator", "campaign"], typer.Argument(help="What to write.")
    ],
    file: Annotated[Path, typer.Argument(metavar="FILE", help="File to write (.toml or .py); it must not exist yet.")],
) -> None:
    """Write a commented file to begin with, which runs at once.

    Beside a TOML file comes its JSON schema, by which an editor with Even Better TOML or taplo completes and checks it.
    """
    template = next(_TEMPLATES.glob(f"{kind}.*"))
    if file.suffix != template.suffix:
        raise InputError(f"{file}: the file of a {kind} ends in {template.suffix}")
    wanted, what = r"[A-Za-z0-9][A-Za-z0-9_.-]*", "letters, digits, dots, - and _, a letter or digit first"
    if file.suffix == ".py":
        wanted, what = r"[A-Za-z_][A-Za-z0-9_]*", "letters, digits and _, no digit first, as Python imports it"
    if not re.fullmatch(wanted, file.stem):
        raise InputError(f"{file}: the name of a {kind} has {what}")
    if file.exists():
        raise InputError(f"{file} is already there; name another file")
    name_of_class = "".join(part[:1].upper() + part[1:] for part in file.stem.split("_")) or "Own"
    text = template.read_text(encoding="utf-8").replace("CLASS", name_of_class).replace("NAME", file.stem)
    write_text(file, text)
    if kind in ("scenario", "train", "campaign"):
        _write_schema(kind, file.with_name(f"{kind}.schema.json"))
    say(f"{file}; go on with: {_NEXT[kind].format(file=file)}")


def _write_schema(kind: Literal["scenario", "train", "campaign"], file: Path) -> None:
    """Write the schema that the first line of the new file names, unless one is there."""
    if not file.exists():
        write_text(file, text_of_schema(kind) + "\n")
        remark(f"{file}, by which editors check what you write")
