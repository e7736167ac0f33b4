"""Pages from templates: `*.html.jinja`, in which what is not markup of ours is escaped, and `*.md.jinja`."""

import base64
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from railgrip.files import write_text

if TYPE_CHECKING:
    from jinja2 import Environment

_ROOT = Path(__file__).parents[1]


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
def _environment() -> "Environment":
    from jinja2 import Environment, FileSystemLoader, StrictUndefined, select_autoescape

    return Environment(
        loader=FileSystemLoader(_ROOT),
        autoescape=select_autoescape(("html.jinja",)),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
