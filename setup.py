"""Which folder is which package, and the README as a package index shows it.

The import name is `railgrip`, the folders are named for what is in them.
"""

import re
from pathlib import Path

from setuptools import find_namespace_packages, setup

PACKAGES = ("estimators", "controllers", "fmus", "modelica")
FOLDERS = {"railgrip": "harness"} | {f"railgrip.{package}": package for package in PACKAGES}


def inside(package: str, folder: str) -> list[str]:
    """Return the packages of a folder; one of data alone is a package without a module."""
    return [f"{package}.{name}" for name in find_namespace_packages(folder, exclude=["*__pycache__*"])]


def description() -> str:
    """Return README.md without its figure, and with paths in the source distribution for links to files."""
    text = Path(__file__).with_name("README.md").read_text(encoding="utf-8")
    text = re.sub(r"<!-- figure -->.*?<!-- end -->\n+", "", text, flags=re.DOTALL)
    return re.sub(r"\[([^]]*)\]\((?!https:)([^)]*)\)", lambda link: with_path(*link.groups()), text)


def with_path(text: str, path: str) -> str:
    """Return the text of a link with its path, unless the text is the path."""
    return f"`{path}`" if text == path else f"{text} (`{path}`)"


setup(
    package_dir=FOLDERS,
    packages=[*FOLDERS, *(name for package, folder in FOLDERS.items() for name in inside(package, folder))],
    long_description=description(),
    long_description_content_type="text/markdown",
)
