"""Draws adhesion over slip where slip cleans the rail: python docs/examples/rail_that_slip_cleans.py FILE.png."""

import sys

import numpy as np

from railgrip.report.palette import BLUE, GREEN, VERMILION
from railgrip.report.style import figure
from railgrip.simulate.creep_curves import curves


def main(path: str) -> None:
    """Draw two published low-adhesion curves."""
    drawing = figure(9, 3.6)
    slips = np.concatenate([[0.0], np.geomspace(2e-3, 1.0, 60)])
    for axes, (name, mu0) in zip(drawing.subplots(1, 2, sharey=True), {"low": 0.06, "leaf": 0.05}.items(), strict=True):
        as_it_lies, cleaned = curves(name, mu0, slips)
        axes.plot(slips, as_it_lies, "k--", label="rail as it lies")
        for wheelset, color in ((0, BLUE), (1, GREEN), (5, VERMILION)):
            axes.plot(slips, cleaned[:, wheelset], color=color, label=f"wheelset {wheelset + 1}")
        axes.set(
            title=f"{name}, mu0 = {mu0:g}, 80 km/h", xlabel="slip of all wheelsets [1]", xlim=(0, 1), ylim=(0, None)
        )
    drawing.axes[0].set_ylabel("adhesion [1]")
    drawing.legend(*drawing.axes[0].get_legend_handles_labels(), loc="outside right upper", frameon=False)
    drawing.savefig(path, dpi=120)


if __name__ == "__main__":
    main(sys.argv[1])
