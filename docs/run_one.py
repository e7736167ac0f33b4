"""Run one script of the gallery or one notebook and write its page's files into a folder: run_one.py FILE FOLDER."""

import os
import runpy
import sys
import warnings
from pathlib import Path
from tempfile import TemporaryDirectory


def run_script(script: Path, folder: Path) -> None:
    """Run a script in an empty folder; write its last figure as NAME.png and NAME_small.png."""
    import matplotlib
    import matplotlib.pyplot as plt

    matplotlib.use("Agg")
    with TemporaryDirectory() as empty, warnings.catch_warnings():
        os.chdir(empty)
        warnings.filterwarnings("ignore", message="FigureCanvasAgg is non-interactive")
        runpy.run_path(str(script), run_name="__main__")
        os.chdir(folder)
    for suffix, dpi in (("", 140), ("_small", 50)):
        plt.figure(plt.get_fignums()[-1]).savefig(folder / f"{script.stem}{suffix}.png", dpi=dpi)


def run_notebook(path: Path, folder: Path) -> None:
    """Execute a notebook in an empty folder; write it with its results as NAME.ipynb."""
    import nbformat
    from nbclient import NotebookClient

    notebook = nbformat.read(path, as_version=4)
    with TemporaryDirectory() as empty:
        NotebookClient(
            notebook,
            timeout=600,
            extra_arguments=["--log-level=ERROR"],
            resources={"metadata": {"path": empty}},
        ).execute()
    nbformat.write(notebook, folder / path.name)


if __name__ == "__main__":
    source, target = Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve()
    (run_notebook if source.suffix == ".ipynb" else run_script)(source, target)
