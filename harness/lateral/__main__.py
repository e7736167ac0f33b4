"""`python -m harness.lateral`, the same as `railgrip lateral`."""

import typer

from harness.lateral.command import lateral

if __name__ == "__main__":
    typer.run(lateral)
