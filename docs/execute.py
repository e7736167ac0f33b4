"""Run the gallery and the notebooks, and write their pages; mkdocs-gen-files runs this script during `make docs`.

`RAILGRIP_DOCS_RUN` is a pattern for the names of what is run, "*" unless given: pages of the others have no results.
"""

import ast
import os
import runpy
import warnings
from collections.abc import Iterator
from contextlib import chdir
from fnmatch import fnmatch
from pathlib import Path
from tempfile import TemporaryDirectory

import matplotlib
import matplotlib.pyplot as plt
import mkdocs_gen_files
import nbformat
from nbclient import NotebookClient
from nbconvert import MarkdownExporter

DOCS = Path(__file__).parent
GALLERY = sorted((DOCS / "gallery").glob("*.py"))
NOTEBOOKS = sorted((DOCS / "examples").glob("*.ipynb"))
PATTERN = os.environ.get("RAILGRIP_DOCS_RUN", "*")

TOPICS = {
    "Stops": ["one_stop", "slip_based_against_adhesion_based", "ideal_bound", "driver_demand", "energy"],
    "Rail": ["creep_curves", "friction_level", "leaf_patches", "slip_cleans", "sanding", "gradient", "random_draws"],
    "Controllers": ["own_controller", "thresholds", "sampling_period", "wheel_diameter", "sensor_fault"],
    "Estimation": ["estimate_with_deviation", "consistency", "recording", "field_test", "lateral_wheelset"],
    "Trains and brakes": ["brake_pipe", "k_dry", "k_wet"],
}
"""Scripts of the gallery, by the headings of its index."""


def write(path: str, content: str | bytes) -> None:
    """Write a file of the site."""
    with mkdocs_gen_files.open(path, "wb") as file:
        file.write(content.encode() if isinstance(content, str) else content)


def drawn(script: Path) -> Iterator[plt.Figure]:
    """Run a script in an empty folder and yield its figures; none where the pattern leaves it out."""
    if not fnmatch(script.stem, PATTERN):
        return
    matplotlib.use("Agg")
    with TemporaryDirectory() as folder, chdir(folder), warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="FigureCanvasAgg is non-interactive")
        runpy.run_path(str(script), run_name="__main__")
    yield from map(plt.figure, plt.get_fignums())
    plt.close("all")


def gallery_page(script: Path) -> str:
    """Write the page of a script and return its entry in the index."""
    source = script.read_text(encoding="utf-8")
    title, _, text = (ast.get_docstring(ast.parse(source)) or "").partition("\n")
    code = source.partition('"""\n\n')[2]
    name = script.stem
    figures = list(drawn(script))
    for figure in figures:
        for suffix, dpi in (("", 140), ("_small", 50)):
            with mkdocs_gen_files.open(f"gallery/{name}{suffix}.png", "wb") as file:
                figure.savefig(file, format="png", dpi=dpi)
    picture = f"![{title}]({name}.png)" if figures else "*Not run.*"
    parts = [f"# {title}", text.strip(), picture, f"```python\n{code}```", f"[Download {name}.py]({name}.py)"]
    write(f"gallery/{name}.md", "\n\n".join(parts) + "\n")
    thumbnail = f"![]({name}_small.png)<br>" if figures else ""
    return f"[{thumbnail}{title}]({name}.md)\n"


def gallery() -> None:
    """Write the pages of all scripts and their index."""
    scripts = {script.stem: script for script in GALLERY}
    sections = [
        f'## {topic}\n\n<div class="gallery" markdown>\n\n'
        + "\n".join(gallery_page(scripts.pop(name)) for name in names)
        + "\n</div>"
        for topic, names in TOPICS.items()
    ]
    if scripts:
        raise ValueError(f"docs/execute.py: TOPICS lacks {', '.join(scripts)} of docs/gallery")
    introduction = (
        "Each figure comes from a script of at most 30 lines, which `make docs` has run. Choose one to see its script."
    )
    write("gallery/index.md", "\n\n".join(["# Gallery", introduction, *sections]) + "\n")


def notebook_page(path: Path) -> None:
    """Write the page of a notebook with its results."""
    notebook = nbformat.read(path, as_version=4)
    if fnmatch(path.stem, PATTERN):
        with TemporaryDirectory() as folder:
            quiet = ["--log-level=ERROR"]
            NotebookClient(
                notebook, timeout=600, extra_arguments=quiet, resources={"metadata": {"path": folder}}
            ).execute()
    text, resources = MarkdownExporter().from_notebook_node(notebook, {"unique_key": path.stem})
    write(f"examples/{path.stem}.md", f"{text}\n[Download {path.name}]({path.name})\n")
    for name, content in resources["outputs"].items():
        write(f"examples/{name}", content)


gallery()
for path in NOTEBOOKS:
    notebook_page(path)
