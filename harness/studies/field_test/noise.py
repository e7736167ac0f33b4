"""The twelve numbers of equation (13): variances of readings and densities of processes, and the file they live in."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from railgrip.errors import EstimationError
from railgrip.estimation.run import by_name
from railgrip.estimation.spec import NoiseTable
from railgrip.estimators.belief import Array
from railgrip.files import replacing
from railgrip.scenario.load import read_toml, validated

LIBRARY = Path(__file__).parent / "library"
GROUPS = 4
NAMES = (
    "R_v", *(f"R_w{i}" for i in range(1, GROUPS + 1)),
    "Q_v", *(f"Q_w{i}" for i in range(1, GROUPS + 1)), "Q_mu_b", "Q_alpha",
)  # fmt: skip
READINGS = ("speed", *(f"wheelset_speed[{i}]" for i in range(1, GROUPS + 1)))
PROCESSES = ("v", *(f"w[{i}]" for i in range(1, GROUPS + 1)), "mu_b", "alpha")
"""What `NAMES` are called in the [noise] of an estimation; one number for μ_B, and one for α, of all groups."""
UNITS = (
    "(m/s)2", *["(rad/s)2"] * GROUPS, "(m/s)2/s", *["(rad/s)2/s"] * GROUPS, "1/s", "1/s",
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class Noise:
    """Noises of the 13-state filter, all positive.

    Attributes:
        values: In the order of `NAMES`: variances of speed and wheelset speeds, densities of v, w, μ_B and α.
    """

    values: tuple[float, ...]

    @classmethod
    def of(cls, logarithms: ArrayLike) -> "Noise":
        """Return the noises whose decadic logarithms these are."""
        return cls(tuple(float(v) for v in 10.0 ** np.asarray(logarithms, dtype=np.float64)))

    @property
    def logarithms(self) -> Array:
        """Decadic logarithms, shape (12,)."""
        return np.log10(self.values)

    @property
    def readings(self) -> Array:
        """Variances of speed and wheelset speeds, shape (5,)."""
        return np.array(self.values[: 1 + GROUPS])

    @property
    def process(self) -> Array:
        """Densities of v, w, μ_B, α, shape (13,)."""
        v, *w, mu, alpha = self.values[1 + GROUPS :]
        return np.array([v, *w, *[mu] * GROUPS, *[alpha] * GROUPS])

    def scaled(self, readings: float, process: float) -> "Noise":
        """Return these noises with all variances of readings, and all densities, times a factor each."""
        return Noise(
            (*(v * readings for v in self.values[: 1 + GROUPS]), *(v * process for v in self.values[1 + GROUPS :]))
        )


PHYSICAL = Noise((0.03**2, *[0.02**2] * GROUPS, 1e-3**2, *[1e-2**2] * GROUPS, 0.01**2, 0.1**2))
"""From sensors and physics, without tuning: what the sensors do, 100 N of wind on 84 t, pads that change by 0.05 in a
stop, adhesion that changes by 0.03 in 0.1 s."""


def load_noise(path: Path) -> Noise:
    """Return the noises of a file of `save_noise`, which is the [noise] of an estimation.

    Raises:
        ScenarioError: No such file, or one of the twelve is missing or no positive number.
    """
    content = read_toml(path)
    table = validated(NoiseTable, content.get("noise", {}), directory=path.parent, origin=f"{path.name}: [noise]")
    if table.kind != "density":
        raise EstimationError(f"{path}: [noise] kind is '{table.kind}'; the field test's noises are densities.")
    readings = by_name(f"{path.name}: readings", table.readings, READINGS)
    process = by_name(f"{path.name}: process", table.process, PROCESSES)
    if not (process > 0.0).all():
        raise EstimationError(f"{path}: [noise.process] wants positive numbers; their logarithms are searched.")
    return Noise((*readings.tolist(), *process.tolist()))


def save_noise(noise: Noise, path: Path, *, title: str, command: str, results: dict[str, float]) -> Path:
    """Write noises with the command that found them and what they reach."""
    lines = [f"# {title}", f'command = "{command}"', "", "[noise]", 'kind = "density"', "", "[noise.readings]"]
    rows = zip((*READINGS, *PROCESSES), noise.values, UNITS, NAMES, strict=True)
    for name, value, unit, symbol in rows:
        if name == PROCESSES[0]:
            lines += ["", "[noise.process]"]
        lines.append(f'"{name}" = {value:.6e}  # {symbol}, {unit}')
    lines += ["", "[found]", *(f"{name} = {value:.6g}" for name, value in results.items()), ""]
    with replacing(path) as partial:
        partial.write_text("\n".join(lines), encoding="utf-8")
    return path
