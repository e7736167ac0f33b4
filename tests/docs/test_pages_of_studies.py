"""Every study is described in the documentation, with the command that runs it."""

import re
from pathlib import Path

from railgrip.studies import names, summary

ROOT = Path(__file__).parents[2]


def test_every_study_is_described_in_the_documentation():
    """A page has its command, or a target of the Makefile that runs it."""
    pages = "\n".join(path.read_text(encoding="utf-8") for path in (*ROOT.glob("docs/**/*.md"), ROOT / "README.md"))
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    recipes = re.findall(r"^([a-z-]+):.*\n((?:\t.*\n)+)", makefile, re.MULTILINE)

    def is_described(name):
        targets = [target for target, recipe in recipes if re.search(rf"study {name}\b", recipe)]
        return any(re.search(rf"{command}\b", pages) for command in (f"study {name}", *(f"make {t}" for t in targets)))

    missing = [name for name in names() if not is_described(name)]
    assert missing == [], (
        f"no page names {', '.join(f'`railgrip study {name}`' for name in missing)}; "
        "add a row to the table of docs/how_to/studies.md"
    )


def test_every_study_has_a_summary_for_the_command_line():
    short = [name for name in names() if len(summary(name)) < 20]
    assert short == [], f"{', '.join(short)}: the first line of the docstring of a study describes it in a sentence"
