"""Write the reference pages from the code; mkdocs-gen-files runs this script during `make docs`."""

import inspect
import io
import re
import tomllib
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from enum import Enum
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin

import mkdocs_gen_files
import numpy as np
import typer
from annotated_types import Ge, Gt, Le, Lt
from matplotlib.figure import Figure
from pydantic import BaseModel
from pydantic.fields import FieldInfo

import railgrip
from railgrip.base import registry
from railgrip.cli.app import app
from railgrip.estimation.spec import Specification
from railgrip.rolling_stock.schema import Train
from railgrip.scenario.campaign import CampaignFile
from railgrip.scenario.file import NamedFile
from railgrip.scenario.quantity import Magnitude, UnitRange
from railgrip.scenario.schema import Scenario
from railgrip.scenario.surface import Polach
from railgrip.scenario.table import ONE_OR_EACH, ByKind
from railgrip.simulate.contact import compiled_contact
from railgrip.simulate.named_models import compile_class
from railgrip.studies.benefit.line import LineOfStudy
from railgrip.supervision.line import Line
from railgrip.supervision.model import TrainData
from railgrip.supervision.national import NationalValues
from railgrip.trace.metrics import FIGURES
from railgrip.vehicle import signals

BY_NAME = "by name"
"""In place of a kind: tables whose names the user chooses."""

TYPES = {float: "number", int: "integer", str: "text", bool: "true or false", NamedFile: "path", Any: "any"}


def markdown_table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    cells = ([cell.replace("|", "\\|").replace("\n", " ") for cell in row] for row in rows)
    lines = [head, ["---"] * len(head), *cells]
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)


def write(page: str, title: str, *paragraphs: str) -> None:
    with mkdocs_gen_files.open(f"reference/{page}.md", "w") as file:
        file.write("\n\n".join([f"# {title}", *paragraphs]) + "\n")


def first_line(documented: object) -> str:
    return (inspect.getdoc(documented) or "").partition("\n")[0]


@dataclass
class Key:
    """The type of a key, collected from its annotation.

    Attributes:
        types: In words.
        units: SI units.
        limits: In words.
        tables: Models with the keys below this one, by the text of the kind that selects each, "" without a kind.
    """

    types: list[str] = field(default_factory=list)
    units: list[str] = field(default_factory=list)
    limits: list[str] = field(default_factory=list)
    tables: dict[str, type[BaseModel]] = field(default_factory=dict)


def key_of(annotation: Any, metadata: Sequence[Any]) -> Key:
    key = Key()
    collect(key, annotation, metadata)
    return key


def collect(key: Key, annotation: Any, metadata: Sequence[Any], plural: str = "") -> None:
    """Add what an annotation and its metadata say to a key; `plural` is "list of " inside of a list."""
    for entry in flat(metadata):
        if isinstance(entry, ByKind):
            key.tables |= tables_by_kind(entry)
            key.types.append(f"{plural}table")
            return
        if isinstance(entry, UnitRange):
            key.units.append(entry.unit)
            key.limits.append(range_of(entry))
    bounds = [bound_of(entry) for entry in flat(metadata)]
    key.limits.append(", ".join(bound for bound in bounds if bound))
    origin, arguments = get_origin(annotation), get_args(annotation)
    if origin is Annotated:
        collect(key, arguments[0], arguments[1:], plural)
    elif origin in (Union, UnionType):
        for argument in arguments:
            collect(key, argument, (), plural)
    elif origin in (tuple, list):
        if ONE_OR_EACH in metadata:
            collect(key, arguments[0], (), plural)
        collect(key, arguments[0], (), "list of ")
    elif isinstance(annotation, type) and issubclass(annotation, Enum):
        key.types.append(plural + ", ".join(f"`{member.value}`" for member in annotation))
    elif origin is Literal:
        key.types.append(plural + ", ".join(f"`{argument}`" for argument in arguments))
    elif origin is dict:
        collect_named(key, arguments[1])
    elif isinstance(annotation, type) and issubclass(annotation, BaseModel):
        key.types.append(f"{plural}table")
        kinds = get_args(annotation.model_fields["kind"].annotation) if "kind" in annotation.model_fields else ()
        key.tables[", ".join(map(str, kinds))] = annotation
    elif isinstance(annotation, type) and issubclass(annotation, Magnitude):
        key.types.append(f"{plural}number with its unit")
    elif annotation is not NoneType:
        key.types.append(plural + TYPES[annotation])


def collect_named(key: Key, entry: Any) -> None:
    """Add a table whose keys are names that the user chooses."""
    kinds = Key()
    if get_origin(entry) is Annotated:
        collect(kinds, entry, ())
    if isinstance(entry, type) and issubclass(entry, BaseModel):
        kinds.tables[""] = entry
    if kinds.tables:
        key.types.append("tables by name")
        key.tables |= {BY_NAME + kind: table for kind, table in kinds.tables.items()}
    else:
        key.types.append("table of parameters" if entry is Magnitude else "table")


def flat(metadata: Iterable[Any]) -> Iterator[Any]:
    for entry in metadata:
        yield from entry.metadata if isinstance(entry, FieldInfo) else (entry,)


def tables_by_kind(by_kind: ByKind) -> dict[str, type[BaseModel]]:
    kinds: dict[type[BaseModel], list[str]] = {}
    for kind, table in by_kind.ours().items():
        kinds.setdefault(table, []).append(kind)
    if by_kind.role:
        kinds.setdefault(by_kind.custom, []).append("module:Class")
    return {", ".join(names): table for table, names in kinds.items()}


def range_of(unit: UnitRange) -> str:
    signs = {"above": ">", "at least": "≥", "below": "<", "at most": "≤"}
    return ", ".join(f"{signs[words]} {limit:g}" for words, limit in unit.limits.items() if limit is not None)


def bound_of(entry: Any) -> str:
    match entry:
        case Gt(gt=limit):
            return f"> {limit}"
        case Ge(ge=limit):
            return f"≥ {limit}"
        case Lt(lt=limit):
            return f"< {limit}"
        case Le(le=limit):
            return f"≤ {limit}"
    return ""


def default_of(field_: FieldInfo) -> str:
    if field_.is_required():
        return "required"
    match field_.get_default(call_default_factory=True, validated_data={}):
        case None | "" | () | {}:
            return "none"
        case BaseModel():
            return "as described below"
        case {"kind": kind}:
            return f"kind `{kind}`"
        case bool() as flag:
            return f"`{str(flag).lower()}`"
        case Magnitude() as magnitude:
            return f"`{magnitude.entry}`"
        case value:
            return f"`{value}`"


def joined(texts: Iterable[str], separator: str = " or ") -> str:
    return separator.join(dict.fromkeys(text for text in texts if text))


class FilePage:
    """The tables of a TOML file, each model described once."""

    def __init__(self) -> None:
        self.sections: list[str] = []
        self.anchors: dict[type[BaseModel], tuple[str, str]] = {}

    def add(self, name: str, kind: str, model: type[BaseModel]) -> None:
        title = f"[{name}]" if name else "Keys outside of tables"
        title += f", kind {kind}" if kind else ""
        anchor = re.sub(r"[^a-z0-9]+", "-", title.lower()).strip("-")
        self.anchors[model] = (title, anchor)
        below: list[tuple[str, str, type[BaseModel]]] = []
        rows: list[list[str]] = []
        place = len(self.sections)
        self.sections.append("")
        for name_, field_ in model.model_fields.items():
            key = field_.alias or name_
            described = key_of(field_.annotation, field_.metadata)
            path = f"{name}.{key}" if name else key
            new = [
                (f"{path}.NAME", kind_.removeprefix(BY_NAME), table)
                if kind_.startswith(BY_NAME)
                else (path, kind_, table)
                for kind_, table in described.tables.items()
                if table not in self.anchors
            ]
            below += [entry for entry in new if entry[2] not in [table for *_, table in below]]
            rows.append(self.row(key, field_, described, kind))
        for entry in below:
            if entry[2] not in self.anchors:
                self.add(*entry)
        for row in rows:
            row[-1] = self.with_links(row[-1])
        intro = first_line(model) if name else ""
        head = ("key", "type", "SI unit", "range", "default", "meaning")
        self.sections[place] = f"## {title} {{ #{anchor} }}\n\n{intro}\n\n{markdown_table(head, rows)}"

    def row(self, key: str, field_: FieldInfo, described: Key, kind: str) -> list[str]:
        models = list(dict.fromkeys(described.tables.values()))
        meaning = field_.description or (first_line(models[0]) if len(models) == 1 else "")
        links = "".join(f"\0{model.__module__}.{model.__qualname__}\0" for model in models)
        types = joined(described.types)
        if key == "kind" and kind:
            types = ", ".join(f"`{name}`" for name in kind.split(", "))
        unit = joined(described.units)
        return [
            f"`{key}`", types, "" if unit == "1" else unit, joined(described.limits), default_of(field_),
            f"{meaning} {links}".strip(),
        ]  # fmt: skip

    def with_links(self, meaning: str) -> str:
        by_name = {f"{model.__module__}.{model.__qualname__}": place for model, place in self.anchors.items()}
        text = meaning.partition("\0")[0].strip()
        links = [by_name[name] for name in meaning.split("\0")[1::2]]
        # A class of one's own has the same keys in several tables: the link says its kind, not its first table.
        names = [(title.partition(", ")[2] or title.strip("[]"), anchor) for title, anchor in links]
        shown = "; ".join(f"[{name}](#{anchor})" for name, anchor in names)
        return text + (f" → {shown}" if shown else "")


def file_page(name: str, model: type[BaseModel], *paragraphs: str) -> None:
    """Write the page of a kind of TOML file: paragraphs, and its tables as pydantic has them."""
    page = FilePage()
    page.add("", "", model)
    write(name, f"{name.capitalize()} file", *paragraphs, *page.sections)


def scenario_page() -> None:
    file_page(
        "scenario",
        Scenario,
        "A scenario is a TOML file that decides everything about a stop, including the seed of its random numbers. "
        'A quantity is a text with a unit (`"80 km/h"`, `"3.4 bar"`) or a number in the SI unit of its key. Unknown '
        "keys are refused.",
        "Train, start speed, friction and controller have no default. Unless the file says so, sensors and actuation "
        "are ideal, there is no estimator, and the scenario is named as its file. `extends`, the name of a scenario of "
        "the library or the path of a file from the folder of this one, lays the file over that scenario, table by "
        "table; a table of another `kind` begins anew.",
    )


def train_page() -> None:
    file_page(
        "train",
        Train,
        "A train file is a TOML file with cars, bogies and brakes; [Describe a train in a file](../trains.md) "
        "shows how to write one. Quantities are written as in a [scenario file](scenario.md). `NAME` in the title of a "
        "table is a name of your choice, to which other tables refer.",
    )


def campaign_page() -> None:
    file_page(
        "campaign",
        CampaignFile,
        "A campaign file is a TOML file that names scenarios and axes of variants; every combination is a stop. "
        "`railgrip new campaign FILE` writes a commented one, `railgrip campaign FILE` runs it.",
    )


def estimation_page() -> None:
    file_page(
        "estimation",
        Specification,
        "An estimation file is a TOML file that decides how a filter runs over a recording: the model, its noises, the "
        "start, and where the recording comes from. Quantities are written as in a [scenario file](scenario.md). "
        "`extends` names an estimation of the library or a file, which this one extends. `railgrip inspect FILE` "
        "proposes `[data]` for a recording; `railgrip estimate FILE` runs an estimation.",
    )


def etcs_pages() -> None:
    how_to = "[Compute braking curves of ETCS](../etcs.md) shows how to use it."
    file_page(
        "line", Line, f"A line file is a TOML file with gradients and targets, in the direction of travel. {how_to}"
    )
    file_page(
        "national",
        NationalValues,
        f"A file of national values is a TOML file with the names of SUBSET-026. {how_to} Steps are lists of start and "
        "value; a step includes its end and not its start.",
    )
    file_page(
        "braking",
        TrainData,
        "A braking file is a TOML file with deceleration curves or a brake percentage, for trains without a train "
        f"file. {how_to}",
    )


def benefit_page() -> None:
    file_page(
        "benefit",
        LineOfStudy,
        "A line file for `railgrip study benefit` is a TOML file with the rails of a line, its blocks and its "
        "signalling. [What measures against low adhesion buy](../benefit.md) shows how to use it; "
        "`railgrip new line FILE` writes a commented one.",
    )


SIGNALS = {
    "Plant outputs": signals.PLANT,
    "Further plant outputs": signals.EXTRA,
    "Plant inputs": signals.PLANT_INPUTS,
    "Plant inputs of a train with couplers on an uneven track": signals.CAR_TRACK_FORCE,
    "Plant inputs on a rail with several creep curves": signals.CURVE,
    "Controller": signals.CONTROLLER_DEMAND,
    "Driver": signals.TABLE["driver"],
    "Readings": signals.READINGS,
    "Further readings": signals.EXTRA_READINGS,
    "Estimates": signals.ESTIMATES,
    "Reference speed without radar": signals.REFERENCE,
}


def signal_section(title: str, group: Iterable[signals.Signal]) -> str:
    rows = ([f"`{signal.name}`", signal.extent, signal.unit, signal.meaning] for signal in group)
    return f"## {title}\n\n" + markdown_table(("signal", "one value per", "unit", "meaning"), rows)


def signals_page() -> None:
    write(
        "signals",
        "Signals",
        "Variables of a trace: `stop.trace` in Python, `trace.nc` on disk. Plant outputs are the simulated truth, "
        "readings come from the sensors, and estimates from the estimator. The last table has the inputs of a control "
        "law: attributes of `rg.Observation`, and inputs of a controller FMU.",
        *(signal_section(title, group) for title, group in SIGNALS.items()),
        signal_section("Observation of a controller", signals.OBSERVATION),
    )


def metrics_page() -> None:
    rows = (
        [f"`{name}`", figure.extent, figure.unit, figure.better, figure.meaning] for name, figure in FIGURES.items()
    )
    write(
        "metrics",
        "Metrics",
        "Figures of a stop: `stop.metrics` in Python, `stop.json` on disk. Values of wheelsets or groups are listed "
        "from the leading one to the trailing one. A figure that does not exist is NaN or `None`, in JSON `null`.",
        markdown_table(("metric", "one value per", "unit", "better", "definition"), rows),
    )


def commands_of(command: Any, name: str) -> Iterator[tuple[str, str]]:
    """Yield the full name and the help of each command, those of groups included."""
    context = command.make_context(name, [], resilient_parsing=True, max_content_width=100)
    yield name, command.get_help(context)
    if hasattr(command, "list_commands"):
        for below in command.list_commands(context):
            yield from commands_of(command.get_command(context, below), f"{name} {below}")


def commands_page() -> None:
    commands = commands_of(typer.main.get_command(app), "railgrip")
    write(
        "commands",
        "Command line",
        "A command ends with exit code 0 if it has a result, 2 if its input is wrong, and 3 if a run failed.",
        *(f"## {name}\n\n```text\n{text}\n```" for name, text in commands),
    )


def python_page() -> None:
    sections: list[str] = []
    for name in railgrip.__all__:
        offered = getattr(railgrip, name)
        if isinstance(offered, str):  # the version
            continue
        identifier = offered.__name__ if inspect.ismodule(offered) else f"{offered.__module__}.{offered.__qualname__}"
        more = "      inherited_members: true\n" if name == "Stop" else ""
        sections.append(f"::: {identifier}\n    options:\n      heading_level: 2\n{more}")
    write(
        "python",
        "Python interface",
        "Everything below is available as `railgrip.NAME`. [Use railgrip from Python](../api.md) shows how the parts "
        "work together.",
        *sections,
    )


SPEED, LOAD = 80 / 3.6, 1e5
"""Of the plotted curves: train speed [m/s] and load of a wheelset [N]."""


def creep_curves() -> Iterator[tuple[str, str, Polach, np.ndarray]]:
    """Yield name, source, curve and cold adhesion over mu0 at `SLIPS` of each named creep curve."""
    for name, path in registry.files(registry.CREEP_CURVES).items():
        curve = Polach.model_validate(name)
        shape = curve.plant_parameters()
        contact = compiled_contact(compile_class("RailBraking.FMUs.ContactPoint"), {}, shape)
        adhesion = contact(SLIPS, np.full_like(SLIPS, SPEED), np.full_like(SLIPS, LOAD), np.full_like(SLIPS, MU0))
        yield name, tomllib.loads(path.read_text(encoding="utf-8"))["source"], curve, adhesion / MU0


SLIPS = np.geomspace(1e-4, 1.0, 400)
MU0 = 0.1


def creep_curves_page() -> None:
    figure = Figure(figsize=(8, 4.5), layout="constrained")
    axes = figure.subplots()
    rows: list[list[str]] = []
    for number, (name, source, curve, ratio) in enumerate(creep_curves()):
        axes.semilogx(100 * SLIPS, ratio, label=name, linestyle=("-", "--")[number // 10])
        peak = int(np.argmax(ratio))
        numbers = [f"{value:g}" for value in curve.plant_parameters().values()]
        numbers += ["", ""] if curve.recovery is None else [f"{curve.temperature_loss:g}", f"{curve.recovery.rate:g}"]
        rows.append([f"`{name}`", *numbers, f"{100 * SLIPS[peak]:.2g} %", f"{ratio[peak]:.2f}", source])
    axes.set(xlabel="slip [%]", ylabel="adhesion / mu0", xlim=(0.01, 100), ylim=(0, 1))
    axes.grid(alpha=0.3)
    figure.legend(loc="outside right center", fontsize="small")
    picture = io.StringIO()
    figure.savefig(picture, format="svg")
    with mkdocs_gen_files.open("reference/creep_curves.svg", "w") as file:
        file.write(picture.getvalue())
    write(
        "creep_curves",
        "Creep curves",
        'Named sets of the parameters of Polach (Wear 258 (2005) 992): `polach = "leaf"` in `[adhesion]`. `k_A` and '
        "`k_S` reduce the slope in the areas of adhesion and slip, `A` is friction at infinite slip speed over maximum "
        "friction, and `B` [s/m] is the decay of friction with slip speed. `temperature_loss` (loss, [1/K]) and "
        "the rate of `recovery` [m/J] are of curves whose contact slip heats and cleans; see "
        "[Models of the rail](../rail_models.md#slip-heats-the-contact). They are drawn cold and uncleaned.",
        "![Adhesion over maximum friction against slip](creep_curves.svg)",
        f"The figure and the columns on the peak are for {3.6 * SPEED:.0f} km/h, a wheelset load of "
        f"{LOAD / 1e3:.0f} kN and `mu0` = {MU0}.",
        markdown_table(
            ("name", "k_A", "k_S", "A", "B", "loss", "rate", "slip at the peak", "peak / mu0", "source"), rows
        ),
    )


scenario_page()
train_page()
campaign_page()
estimation_page()
etcs_pages()
benefit_page()
signals_page()
metrics_page()
commands_page()
python_page()
creep_curves_page()
