"""Execute pages of studies: scripts in percent format, whose text cells are Markdown, as Jupytext reads them.

The value of the last expression of a code cell is displayed, and what it prints is Markdown. A cell with the tag
`parameters` sets `quick = False`, which the quick form replaces.
"""

import ast
import re
import sys
from collections.abc import Iterator
from contextlib import chdir, redirect_stdout
from io import StringIO
from pathlib import Path
from typing import Any, NamedTuple

from matplotlib import pyplot
from matplotlib.figure import Figure

from railgrip.base.files import write_text
from railgrip.base.records import make_folder
from railgrip.report.style import save
from railgrip.report.table import ReportTable

FOLDER = Path("docs/studies")
"""Relative to the folder of the project, in which the command runs."""
_HEAD = re.compile(r"^# %%(.*)\n", re.MULTILINE)
_UNIT = re.compile(r"(?<=\d) (?=[^\W\d]|%)")


class Cell(NamedTuple):
    """A cell of a page: the rest of its first line, its content, and the number of lines before it."""

    head: str
    content: str
    before: int

    @property
    def is_text(self) -> bool:
        """Whether it has text; a title may be before the mark."""
        return "[markdown]" in self.head or "[md]" in self.head


def pages(folder: Path = FOLDER) -> dict[str, Path]:
    """Return the pages in a folder by their names; its other scripts are modules with functions."""
    found = {path.stem: path for path in sorted(folder.glob("*.py"))}
    return {name: path for name, path in found.items() if _HEAD.search(path.read_text(encoding="utf-8"))}


def cells(text: str) -> Iterator[Cell]:
    """Yield the cells of a script in percent format."""
    heads = list(_HEAD.finditer(text))
    for head, end in zip(heads, [*(head.start() for head in heads[1:]), len(text)], strict=True):
        yield Cell(head[1].strip(), text[head.end() : end].strip("\n"), text.count("\n", 0, head.end()))


def text_of(cell: Cell) -> str:
    """Return the Markdown of a text cell: comments, or a string as editors of notebooks may write it."""
    if cell.content.lstrip("r").startswith('"""'):
        return ast.literal_eval(cell.content).strip()
    return re.sub(r"^# ?", "", cell.content, flags=re.MULTILINE)


def execute(page: Path, out: Path, *, quick: bool = False, anew: bool = False) -> Path:
    """Execute a page and write NAME.md and its figures into a folder; return the path of NAME.md.

    Cells run in the folder of the page, next to its stored tables. In the quick form, or with all cases run anew, they
    run in the folder of the output, which gets their tables.
    """
    names: dict[str, Any] = {"__name__": "__main__"}
    parts: list[str] = []
    make_folder(out)
    pyplot.switch_backend("Agg")
    source, target = page.resolve(), out.resolve()
    if str(source.parent) not in sys.path:
        sys.path.append(str(source.parent))
    with chdir(target if quick or anew else source.parent):
        for cell in cells(source.read_text(encoding="utf-8")):
            if cell.is_text:
                parts.append(text_of(cell))
                continue
            printed, value = run(cell, names, str(source))
            if quick and "parameters" in cell.head:
                names["quick"] = True
            if isinstance(value, Figure):
                drawing = target / f"{page.stem}_{sum(part.startswith('![') for part in parts) + 1}.svg"
                save(value, drawing)
                pyplot.close(value)
                value = f"![{value.get_label()}]({drawing.name})"
            if isinstance(value, ReportTable):  # no cell breaks between a number and its unit
                value = _UNIT.sub("\u00a0", str(value))
            parts += [str(part) for part in (printed, value) if part is not None and part != ""]
    parts.append(f"`python tools pages {page.stem}` has written this page from [{page.name}]({page.name}).")
    write_text(out / f"{page.stem}.md", "\n\n".join(parts) + "\n")
    return out / f"{page.stem}.md"


def run(cell: Cell, names: dict[str, Any], file: str) -> tuple[str, Any]:
    """Run a code cell; return its output and the value of its last expression, or None."""
    tree = ast.parse("\n" * cell.before + cell.content, file)
    last = tree.body[-1] if tree.body else None
    shown = ast.Expression(last.value) if isinstance(last, ast.Expr) else None
    if shown is not None:
        tree.body.pop()
    with redirect_stdout(StringIO()) as printed:
        exec(compile(tree, file, "exec"), names)
        value = eval(compile(shown, file, "eval"), names) if shown is not None else None
    return printed.getvalue().strip(), value
