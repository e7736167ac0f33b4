"""Parts as users write them, and a package that provides one."""

from pathlib import Path

import numpy as np

import railgrip as rg

SHORT = {"limits.horizon": "0.2 s", "start.speed": "30 km/h", "estimator.kind": "none"}
"""Changes of a scenario whose stop only shows that its parts run."""


class Hold:
    """A law that demands a share of full pressure."""

    def __init__(self, share=0.5):
        self.share = share

    def start(self, formation):
        self.demand = self.share * formation.pressure_max

    def decide(self, observation):
        return self.demand


class Drag:
    """An estimator of adhesion from the deceleration of the train."""

    provides = ("adhesion",)

    def start(self, first, formation):
        self.n = formation.groups

    def step(self, observation):
        return rg.Estimate(adhesion=np.full(self.n, -observation.acceleration / 9.81))


class Exact:
    """Sensors without errors but a factor of the speed."""

    def __init__(self, factor=1.0):
        self.factor = factor

    def start(self, formation, random):
        self.random = random

    def read(self, time, truth):
        names = ("speed", "wheelset_speed", "acceleration", "cylinder_pressure")
        return {name: truth[name] for name in names} | {"speed": self.factor * truth["speed"]}


def install_part(folder: Path, role: str, place: str) -> None:
    """Write the metadata of an installed package that provides the part `mine`, a class in a module."""
    package = folder / "mine-1.0.dist-info"
    package.mkdir()
    (package / "METADATA").write_text("Metadata-Version: 2.1\nName: mine\nVersion: 1.0\n")
    (package / "entry_points.txt").write_text(f"[railgrip.{role}]\nmine = {place}\n")
