"""The colours of lines differ for colour-blind readers, and in grey.

Simulation of dichromats: Machado, Oliveira and Fernandes, IEEE TVCG 15 (2009), severity 1.0, on linear sRGB. Distances
and lightness: CIELAB under D65, ΔE of 1976, of which 2.3 is just noticeable (Mahy, Van Eycken and Oosterlinck, 1994).
"""

from itertools import combinations

import numpy as np
import pytest

from railgrip.report.palette import LINES, SHADES, lead_to_trail

VISION = {
    "normal": np.eye(3),
    "protanopia": [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]],
    "deuteranopia": [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]],
    "tritanopia": [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]],
}
TO_XYZ = np.array(
    [[0.4124564, 0.3575761, 0.1804375], [0.2126729, 0.7151522, 0.0721750], [0.0193339, 0.1191920, 0.9503041]]
)


def linear(colour):
    parts = np.array([int(colour[k : k + 2], 16) for k in (1, 3, 5)]) / 255
    return np.where(parts <= 0.04045, parts / 12.92, ((parts + 0.055) / 1.055) ** 2.4)


def lab(rgb):
    ratios = TO_XYZ @ np.clip(rgb, 0, 1) / TO_XYZ.sum(axis=1)
    x, y, z = np.where(ratios > 216 / 24389, np.cbrt(ratios), (24389 / 27 * ratios + 16) / 116)
    return np.array([116 * y - 16, 500 * (x - y), 200 * (y - z)])


def test_lab_is_that_of_the_standard():
    assert lab(linear("#FFFFFF")) == pytest.approx([100, 0, 0], abs=0.01)
    assert lab(linear("#FF0000")) == pytest.approx([53.24, 80.09, 67.20], abs=0.02)  # Lindbloom's table of sRGB


@pytest.mark.parametrize("vision", VISION)
def test_two_lines_differ_by_ten_times_the_just_noticeable_difference(vision):
    seen = [lab(np.array(VISION[vision]) @ linear(colour)) for colour in LINES]
    assert min(np.linalg.norm(a - b) for a, b in combinations(seen, 2)) > 10 * 2.3


def test_lines_differ_by_lightness_in_grey_and_from_the_paper():
    lightness = sorted([*(lab(linear(colour))[0] for colour in LINES), 100.0])
    assert np.diff(lightness).min() > 10


def test_lightness_of_shades_and_wheelsets_is_monotonic():
    shades = [lab(linear(f"#{red:02X}{green:02X}{blue:02X}"))[0] for red, green, blue in SHADES]
    assert np.diff(shades).max() < -8
    wheelsets = [lab(linear(colour))[0] for colour in lead_to_trail(6)]
    assert np.diff(wheelsets).min() > 5
