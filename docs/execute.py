"""Run the gallery and the notebooks, and write their pages; mkdocs-gen-files runs this script during `make docs`.

`RAILGRIP_DOCS_RUN` is a pattern for the names of what is run, "*" unless given: pages of the others have no results.
"""

import ast
import logging
import os
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from fnmatch import fnmatch
from pathlib import Path
from tempfile import TemporaryDirectory

import mkdocs_gen_files
import nbformat
from mkdocs.exceptions import PluginError
from nbconvert import MarkdownExporter

log = logging.getLogger("mkdocs.plugins.execute")

DOCS = Path(__file__).parent
GALLERY = sorted((DOCS / "gallery").glob("*.py"))
NOTEBOOKS = sorted((DOCS / "examples").glob("*.ipynb"))
PATTERN = os.environ.get("RAILGRIP_DOCS_RUN", "*")

TOPICS = {
    "Stops": ["one_stop", "slip_based_against_adhesion_based", "ideal_bound", "driver_demand", "energy"],
    "Rail": ["creep_curves", "friction_level", "leaf_patches", "slip_cleans", "sanding", "gradient", "random_draws"],
    "Controllers": ["own_controller", "thresholds", "sampling_period", "wheel_diameter", "sensor_fault"],
    "Estimation": ["estimate_with_deviation", "consistency", "recording", "field_test"],
    "Trains and brakes": ["brake_pipe", "k_dry", "k_wet", "braking_curves"],
}
"""Scripts of the gallery, by the headings of its index."""


def write(path: str, content: str | bytes) -> None:
    """Write a file of the site."""
    with mkdocs_gen_files.open(path, "wb") as file:
        file.write(content.encode() if isinstance(content, str) else content)


def run(path: Path, folder: Path) -> float:
    """Run a script or notebook in a process of its own, which writes into a folder; return its duration [s].

    Raises:
        PluginError: The process has failed.
    """
    begin = time.monotonic()
    command = [sys.executable, str(DOCS / "run_one.py"), str(path), str(folder)]
    done = subprocess.run(command, capture_output=True, encoding="utf-8", errors="replace", check=False)
    if done.returncode:
        raise PluginError(f"{path.relative_to(DOCS.parent)} has failed:\n{done.stderr}")
    return time.monotonic() - begin


def run_all(paths: list[Path], folder: Path) -> None:
    """Run scripts and notebooks, one for each processor at a time, and log each as it ends."""
    pool = ThreadPoolExecutor(max_workers=min(4, os.cpu_count() or 1))
    try:
        log.info("Running %d scripts and notebooks", len(paths))
        for number, (path, seconds) in enumerate(
            zip(paths, pool.map(run, paths, [folder] * len(paths)), strict=True), start=1
        ):
            log.info("%d of %d: %s, %.0f s", number, len(paths), path.name, seconds)
    finally:
        pool.shutdown(cancel_futures=True)


def gallery_page(script: Path, folder: Path) -> str:
    """Write the page of a script, with the figure in a folder if it was run, and return its entry in the index."""
    source = script.read_text(encoding="utf-8")
    title, _, text = (ast.get_docstring(ast.parse(source)) or "").partition("\n")
    code = source.partition('"""\n\n')[2]
    name = script.stem
    figures = [figure for figure in (folder / f"{name}.png", folder / f"{name}_small.png") if figure.is_file()]
    for figure in figures:
        write(f"gallery/{figure.name}", figure.read_bytes())
    picture = f"![{title}]({name}.png)" if figures else "*Not run.*"
    parts = [f"# {title}", text.strip(), picture, f"```python\n{code}```", f"[Download {name}.py]({name}.py)"]
    write(f"gallery/{name}.md", "\n\n".join(parts) + "\n")
    thumbnail = f"![]({name}_small.png)<br>" if figures else ""
    return f"[{thumbnail}{title}]({name}.md)\n"


def gallery(folder: Path) -> None:
    """Write the pages of all scripts, with figures in a folder, and their index."""
    scripts = {script.stem: script for script in GALLERY}
    sections = [
        f'## {topic}\n\n<div class="gallery" markdown>\n\n'
        + "\n".join(gallery_page(scripts.pop(name), folder) for name in names)
        + "\n</div>"
        for topic, names in TOPICS.items()
    ]
    if scripts:
        raise ValueError(f"docs/execute.py: TOPICS lacks {', '.join(scripts)} of docs/gallery")
    introduction = (
        "Each figure comes from a script of at most 30 lines, which `make docs` has run. Choose one to see its script."
    )
    write("gallery/index.md", "\n\n".join(["# Gallery", introduction, *sections]) + "\n")


def notebook_page(path: Path, folder: Path) -> None:
    """Write the page of a notebook, with the results in a folder if it was run."""
    executed = folder / path.name
    notebook = nbformat.read(executed if executed.is_file() else path, as_version=4)
    text, resources = MarkdownExporter().from_notebook_node(notebook, {"unique_key": path.stem})
    write(f"examples/{path.stem}.md", f"{text}\n[Download {path.name}]({path.name})\n")
    for name, content in resources["outputs"].items():
        write(f"examples/{name}", content)


with TemporaryDirectory() as results:
    # Notebooks take longest.
    run_all([path for path in (*NOTEBOOKS, *GALLERY) if fnmatch(path.stem, PATTERN)], Path(results))
    gallery(Path(results))
    for notebook in NOTEBOOKS:
        notebook_page(notebook, Path(results))
