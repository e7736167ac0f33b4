"""Write docs/packages.svg, the packages in the layers of .importlinter: `.venv/bin/python docs/packages.py`."""

import configparser
from pathlib import Path

ROOT = Path(__file__).parents[1]
PICTURE = ROOT / "docs" / "packages.svg"

WIDTH, BOX, GAP = 860, 34, 16
MARGIN = 10

PURPOSE = {
    "__main__": "entry point",
    "cli": "command line",
    "studies": "one folder for each study",
    "api": "Python interface",
    "testing": "checks of a user's parts",
    "campaign": "many stops",
    "estimation": "filters over recordings",
    "simulate": "one stop: its parts, and the loop",
    "supervision": "braking curves of ETCS",
    "rolling_stock": "train files",
    "fmi": "runs and checks FMUs",
    "report": "tables, figures, pages",
    "trace": "signals and metrics of a stop",
    "recording": "signals from files of users",
    "scenario": "scenario file, track",
    "estimators": "filters",
    "kernel": "the loop in C",
    "controllers": "control laws",
    "fmus": "compiles FMUs",
    "vehicle": "formation, brakes, signals",
    "base": "errors, files, units, registry",
}


def layers() -> list[list[str]]:
    """Return the packages of each layer, highest layer first."""
    parser = configparser.ConfigParser()
    parser.read(ROOT / ".importlinter", encoding="utf-8")
    lines = parser["importlinter:contract:layers"]["layers"].split("\n")
    return [[name.strip() for name in line.split("|")] for line in lines if line.strip()]


def svg() -> str:
    """Return the picture."""
    rows = layers()
    height = 2 * MARGIN + len(rows) * BOX + (len(rows) - 1) * GAP
    shapes: list[str] = []
    for number, names in enumerate(rows):
        top = MARGIN + number * (BOX + GAP)
        width = (WIDTH - 2 * MARGIN - (len(names) - 1) * GAP) / len(names)
        for place, name in enumerate(names):
            left = MARGIN + place * (width + GAP)
            shapes += [
                f'<rect x="{left:g}" y="{top}" width="{width:g}" height="{BOX}" rx="4"/>',
                f'<text x="{left + width / 2:g}" y="{top + 15}" font-weight="bold">{name}</text>',
                f'<text x="{left + width / 2:g}" y="{top + 28}" font-size="11">{PURPOSE[name]}</text>',
            ]
        if number < len(rows) - 1:
            bottom = top + BOX
            shapes.append(f'<path d="M{WIDTH // 2} {bottom}V{bottom + GAP - 1}" marker-end="url(#arrow)"/>')
    return "\n".join(
        [
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height}" font-family="sans-serif">',
            '<defs><marker id="arrow" viewBox="0 0 10 10" refX="9" refY="5" markerWidth="7" markerHeight="7" '
            'orient="auto"><path d="M0 0L10 5L0 10z"/></marker></defs>',
            f'<rect width="{WIDTH}" height="{height}" fill="white"/>',
            "<style>rect[rx]{fill:#eef2f5;stroke:#456;stroke-width:1.2}text{text-anchor:middle;font-size:13px}"
            "text[font-size]{font-size:11px;fill:#333}path{stroke:#456;stroke-width:1.5}</style>",
            *shapes,
            "</svg>\n",
        ]
    )


if __name__ == "__main__":
    PICTURE.write_text(svg(), encoding="utf-8")
