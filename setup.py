"""Which folder is which package: the import name is `railgrip`, the folders are named for what is in them."""

from setuptools import find_namespace_packages, setup

PACKAGES = ("estimators", "controllers", "fmus", "modelica")
FOLDERS = {"railgrip": "harness"} | {f"railgrip.{package}": package for package in PACKAGES}


def inside(package: str, folder: str) -> list[str]:
    """Return the packages of a folder; one of data alone is a package without a module."""
    return [f"{package}.{name}" for name in find_namespace_packages(folder, exclude=["*__pycache__*"])]


setup(
    package_dir=FOLDERS,
    packages=[*FOLDERS, *(name for package, folder in FOLDERS.items() for name in inside(package, folder))],
)
