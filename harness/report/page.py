"""Pages from templates: `*.html.jinja`, in which what is not markup of ours is escaped, and `*.md.jinja`."""

import base64
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined, select_autoescape

from railgrip.base.files import write_json, write_text
from railgrip.report.table import Table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_ROOT = Path(__file__).parents[1]


@dataclass(frozen=True, slots=True, kw_only=True)
class Page:
    """What a study has to show: a page, the files beside it, and what a screen is told.

    Attributes:
        template: Path of the page's template in this package, `*.md.jinja` or `*.html.jinja`.
        values: What it names; besides, each of `figures` is there by its file name, as the address of an image.
        figures: File name → figure.
        tables: File name → table, as CSV.
        data: File name → content, as JSON.
        files: File name → what writes it.
        screen: Tables and sentences.
        exit_code: What the command line answers with; 0 where no case failed.
    """

    template: str
    values: Mapping[str, Any]
    figures: "Mapping[str, Figure]" = field(default_factory=dict[str, Any])
    tables: Mapping[str, Table] = field(default_factory=dict[str, Table])
    data: Mapping[str, Any] = field(default_factory=dict[str, Any])
    files: Mapping[str, Callable[[Path], object]] = field(default_factory=dict[str, Any])
    screen: Sequence[Table | str] = ()
    exit_code: int = 0

    def write(self, folder: Path) -> Path:
        """Write everything into a folder; return the page, index.html or what its template is called.

        A page in HTML holds its figures, so that it can be mailed alone.
        """
        from railgrip.report.style import save  # matplotlib takes half a second to load

        is_html = self.template.endswith(".html.jinja")
        addresses: dict[str, str] = {}
        for name, figure in self.figures.items():
            path = save(figure, folder / name)
            addresses[name] = image(path) if is_html else name
        for name, table in self.tables.items():
            table.write_csv(folder / name)
        for name, content in self.data.items():
            write_json(folder / name, content)
        for name, write in self.files.items():
            write(folder / name)
        name = "index.html" if is_html else Path(self.template).stem
        return write_page(folder / name, self.template, figures=addresses, **self.values)


def write_page(path: Path, template: str, **values: Any) -> Path:
    """Write a page and return its path.

    Args:
        template: Its path in this package, as "report/campaign.html.jinja".
        values: What the template names; of numbers and texts, `Table`s and images.
    """
    write_text(path, rendered(template, **values))
    return path


def rendered(template: str, **values: Any) -> str:
    """Return the text of a page; see `write_page`."""
    return _environment().get_template(template).render(values).rstrip("\n") + "\n"


def image(path: Path) -> str:
    """Return a figure as the address of an image inside the page, so that the page can be mailed alone."""
    return f"data:image/png;base64,{base64.b64encode(path.read_bytes()).decode()}"


@cache
def _environment() -> Environment:
    return Environment(
        loader=FileSystemLoader(_ROOT),
        autoescape=select_autoescape(("html.jinja",)),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
