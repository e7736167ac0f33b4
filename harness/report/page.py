"""Pages of results: a summary, figures, tables and provenance in one self-contained file; texts from templates."""

import base64
import gzip
import json
import subprocess
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from functools import cache
from importlib import metadata
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, Any, Literal

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markdown_it import MarkdownIt
from markupsafe import Markup

from railgrip.base.errors import InputError
from railgrip.base.files import write_json, write_text
from railgrip.base.programs import environment_of_programs, find_program
from railgrip.base.records import claim, discard, recorded_files
from railgrip.base.tables import JsonObject
from railgrip.report.table import ReportTable, as_html, as_markdown

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_ROOT = Path(__file__).parents[1]

Kind = Literal["html", "markdown", "plain"]

FORMATS = ("png", "svg", "pdf")
"""Formats of figure files."""

_PIXELS = 105.0
"""Pixels per inch of a figure, so that letters of 8 to 11 points are as large as the text of a page."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Page:
    """The content of a page: of a stop, a campaign, a comparison or a study.

    Attributes:
        title: Heading of the page.
        question: Question, one sentence.
        answer: The result, in two sentences.
        caveats: Sentences without which the answer could be misread, below it.
        template: Path in this package of the Markdown text that follows, `*.md.jinja`. It includes each figure except
            the first as `![caption]({{ figures["name.png"] }})`, and tables as variables.
        values: Variables of the template.
        overview: Table of the answer, between the answer and the first figure.
        note: Sentences next to this table.
        figures: File name → figure; the first one answers the question and is placed below the answer.
        narrow: File name → the same figure for a narrow screen.
        signals: `data` and `layout` of plotly.js for the signals of a stop, which only the page has, below the answer.
        provenance: Basis of the results: versions, seeds, digests.
        tables: File name → table, as CSV.
        data: File name → content, as JSON.
        files: File name → function that writes it.
        documented: Name of a mark → table or Markdown of a study for its page of the documentation.
        screen: Tables and sentences for the terminal.
        exit_code: Exit code of the command line; 0 if no case failed.
    """

    title: str
    question: str
    answer: str
    template: str
    caveats: Sequence[str] = ()
    values: Mapping[str, Any] = field(default_factory=dict[str, Any])
    overview: ReportTable | None = None
    note: str = ""
    figures: "Mapping[str, Figure]" = field(default_factory=dict[str, "Figure"])
    narrow: "Mapping[str, Figure]" = field(default_factory=dict[str, "Figure"])
    signals: Mapping[str, Any] | None = None
    provenance: Mapping[str, str] = field(default_factory=dict[str, str])
    tables: Mapping[str, ReportTable] = field(default_factory=dict[str, ReportTable])
    data: JsonObject = field(default_factory=JsonObject)
    files: Mapping[str, Callable[[Path], object]] = field(default_factory=dict[str, Callable[[Path], object]])
    documented: Mapping[str, ReportTable | str] = field(default_factory=dict[str, ReportTable | str])
    screen: Sequence[ReportTable | str] = ()
    exit_code: int = 0

    def write(self, folder: Path, formats: Sequence[str] = FORMATS[:1]) -> Path:
        """Write index.html to a folder, with figures, tables and data as separate files; return the path of the page.

        Args:
            folder: Folder, created if necessary.
            formats: Formats of the figure files, from `FORMATS`.

        Raises:
            RecordError: Files of the user would be overwritten; nothing was written.
        """
        files = self.file_names(formats)
        claim(folder, *files)
        if self.figures:
            from railgrip.report.style import save_as  # matplotlib takes half a second to load

            for name, figure in self.figures.items():
                save_as(figure, folder / name, formats)
        for name, table in self.tables.items():
            table.write_csv(folder / name)
        for name, content in self.data.items():
            write_json(folder / name, content)
        for name, write in self.files.items():
            write(folder / name)
        page = folder / "index.html"
        write_text(page, self._html())
        # Figures of an earlier page that this one does not have.
        discard(folder, {name for name in recorded_files(folder) if name.startswith("figures/")} - files)
        return page

    def file_names(self, formats: Sequence[str] = FORMATS[:1]) -> set[str]:
        """Return the names of the files that `write` writes."""
        figures = {str(PurePosixPath(name).with_suffix(f".{form}")) for name in self.figures for form in formats}
        return {"index.html", *figures, *self.tables, *self.data, *self.files}

    def _html(self) -> str:
        body = render(self.template, is_html=True, figures={name: name for name in self.figures}, **self.values)
        origin = {
            **self.provenance,
            "railgrip": metadata.version("railgrip"),
            **({"commit": commit()} if commit() else {}),
            "page written": datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC"),
        }
        return render(
            "report/page.html.jinja",
            is_html=True,
            page=self,
            first=self._picture(*list(self.figures)[:1]) if self.figures else "",
            body=Markup(self._html_of(body)),
            origin=ReportTable([{"": key, "value": value} for key, value in origin.items()], left=("", "value")),
            # Of letters and digits: a search for characters to escape would take as long as the rest of the page.
            signals=Markup(_pack(json.dumps(self.signals, ensure_ascii=False, allow_nan=False).encode())),
            plotly=Markup(_plotly()) if self.signals else "",
            script=Markup((_ROOT / "report/page.js").read_text(encoding="utf-8")),
        )

    def _html_of(self, markdown: str) -> str:
        parser = MarkdownIt("commonmark", {"html": True}).enable("table")

        def picture(_: Any, tokens: Any, index: int, options: Any, environment: Any) -> str:
            return self._picture(tokens[index].attrGet("src"), as_html(tokens[index].content))

        parser.add_render_rule("image", picture)
        return parser.render(markdown)

    def _picture(self, name: str, caption: str = "") -> Markup:
        """Return a figure with its caption, and the figure for a narrow screen, if it has one."""
        from railgrip.report.style import svg

        shown = {"broad": self.figures[name]} | ({"narrow": self.narrow[name]} if name in self.narrow else {})
        images = [
            f'<img class="{screen}" alt="{caption or PurePosixPath(name).stem}" style="width: {_PIXELS * width:.0f}px" '
            f'src="data:image/svg+xml;base64,{base64.b64encode(svg(drawing)).decode()}">'
            for screen, drawing in shown.items()
            for width, _ in (drawing.get_size_inches(),)
        ]
        return Markup(f'<span class="figure">{"".join(images)}</span><span class="caption">{caption}</span>')


def formats_of(text: str) -> list[str]:
    """Return the formats of figures in a comma-separated list.

    Raises:
        InputError: A format is not in `FORMATS`.
    """
    formats = [name.strip().lower() for name in text.split(",")]
    unknown = [name for name in formats if name not in FORMATS]
    if unknown:
        raise InputError(f"--format {text}: {', '.join(FORMATS)} are possible, got '{unknown[0]}'.")
    return formats


def render(template: str, *, is_html: bool = False, **values: Any) -> str:
    """Return the text of a template; see `as_html` and `as_markdown` of `railgrip.report.table` for texts.

    Args:
        template: Its path in this package, as "report/distances.md.jinja". Values are escaped only in Markdown and HTML
            templates.
        is_html: Whether the text becomes HTML: tables are then HTML, which Markdown may contain.
        values: Variables of the template.
    """
    kind: Kind = "html" if is_html else "markdown" if template.endswith(".md.jinja") else "plain"
    return _environment(kind).get_template(template).render(values).rstrip("\n") + "\n"


@cache
def commit() -> str:
    """Return the commit of the checkout with this package, `-dirty` if files differ from it.

    The text is empty outside of a checkout.
    """
    checkout = _ROOT.parent
    if not (checkout / ".git").exists():
        return ""
    git = find_program("git")
    if git is None:
        return ""
    command = [git, "-C", str(checkout), "describe", "--always", "--dirty", "--abbrev=12"]
    try:
        found = subprocess.run(
            command, capture_output=True, encoding="utf-8", timeout=10, check=False, env=environment_of_programs()
        )
        return found.stdout.strip()
    except (OSError, subprocess.TimeoutExpired):  # git is not installed
        return ""


def _pack(content: bytes) -> str:
    return base64.b64encode(gzip.compress(content, 1, mtime=0)).decode()


@cache
def _plotly() -> str:
    """Return plotly.js 4.1.1 with the traces of axes alone, which the browser decompresses.

    The file is plotly-cartesian.min.js of the npm package plotly.js-cartesian-dist-min, compressed by `gzip -9 -n`.
    """
    return base64.b64encode((_ROOT / "report/plotly/plotly-cartesian.min.js.gz").read_bytes()).decode()


def _html_value(value: Any) -> Any:
    return as_html(value) if type(value) is str else value


def _markdown_value(value: Any) -> Any:
    if isinstance(value, ReportTable):
        return value.with_texts(as_markdown)
    return as_markdown(value) if type(value) is str else value


@cache
def _environment(kind: Kind) -> Environment:
    finalize = {"html": _html_value, "markdown": _markdown_value, "plain": None}[kind]
    return Environment(
        loader=FileSystemLoader(_ROOT),
        autoescape=kind == "html",
        finalize=finalize,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
