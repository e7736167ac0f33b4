"""docs/packages.svg has the layers of .importlinter."""

import runpy

from project_files import ROOT


def test_the_picture_of_the_packages_is_up_to_date():
    """If this fails, run `.venv/bin/python docs/packages.py` to draw the picture again."""
    script = runpy.run_path(str(ROOT / "docs/packages.py"))
    assert script["PICTURE"].read_text(encoding="utf-8") == script["svg"]()
