"""Colours of all figures, on paper and on pages, independent of a plotting library.

The line colours were searched for distance under simulated colour blindness and for steps of lightness in grey;
tests/report/test_palette.py checks minima of both.
"""

BLUE, ORANGE, GREEN, VERMILION, PURPLE, SKY, BLACK = (
    "#003D7C", "#FE9207", "#00A661", "#AE1E03", "#B416FF", "#3FDCFF", "#000000",
)  # fmt: skip
GREY = "#767676"
LINES = (BLUE, VERMILION, GREEN, ORANGE, PURPLE, SKY, BLACK)
"""Colours of lines without a fixed meaning, in this order."""
DARK = {GREY, BLUE, VERMILION, PURPLE, BLACK}
"""Colours on which text is white."""

SHADES = ((253, 231, 37), (122, 209, 81), (34, 168, 132), (42, 120, 142), (65, 68, 135), (68, 1, 84))
"""From low, light, to high, dark, as red, green and blue; viridis of Smith and van der Walt (2015), reversed."""

_LEAD_TO_TRAIL = (BLUE, "#7B5FC0", "#E39BD3")


def mix(first: str, second: str, share: float) -> str:
    """Return a colour as #RRGGBB between two."""
    parts = ((int(colour[k : k + 2], 16) for colour in (first, second)) for k in (1, 3, 5))
    return "#" + "".join(f"{round(low + share * (high - low)):02X}" for low, high in parts)


def lighter(colour: str, steps: int) -> str:
    """Return a colour nearer to white with each step."""
    return mix(colour, "#FFFFFF", 1 - 1 / (1 + 0.5 * steps)) if steps else colour


def of_groups(count: int) -> list[str]:
    """Return a colour for each group of wheelsets; black is that of the train, and further groups have lighter ones."""
    colours = [colour for colour in LINES if colour != BLACK]
    return [lighter(colours[number % len(colours)], number // len(colours)) for number in range(count)]


def lead_to_trail(count: int) -> list[str]:
    """Return colours from blue, the first wheelset, to purple, the last."""
    first, middle, last = _LEAD_TO_TRAIL
    places = [2 * number / max(count - 1, 1) for number in range(count)]
    return [mix(first, middle, place) if place <= 1 else mix(middle, last, place - 1) for place in places]
