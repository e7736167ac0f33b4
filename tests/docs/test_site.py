"""The documentation builds without warnings, loads nothing from the network, and describes the whole interface."""

import json
import re
import sys
import tomllib
from collections.abc import Collection, Iterator, Mapping
from html import unescape
from pathlib import Path
from typing import Any

import pytest
import typer
from command_line import NO_NETWORK, ran
from legible import needs_browser, title_of
from project_files import ROOT

import railgrip
from railgrip.base import registry
from railgrip.cli.app import app
from railgrip.trace.metrics import FIGURES
from railgrip.vehicle.signals import ESTIMATES, EXTRA, OBSERVATION, PLANT, PLANT_INPUTS, READINGS

FREE = {"parameters", "map", "brakes", "calibrated", "noise", "bias"}
"""Tables whose keys are names of parameters, variables, creep curves or signals."""


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Build the site with one script of the gallery and one notebook; all proxies point to a closed port."""
    folder = tmp_path_factory.mktemp("site")
    build = [sys.executable, "-m", "mkdocs", "build", "--strict", "--site-dir", folder]
    done = ran(build, ROOT, **NO_NETWORK, DISABLE_MKDOCS_2_WARNING="true", RAILGRIP_DOCS_RUN="recording")
    assert done.returncode == 0, done.stderr
    return folder


def inline_code(page: Path) -> set[str]:
    return set(map(unescape, re.findall(r"<code\b[^>]*>([^<]+)", page.read_text(encoding="utf-8"))))


def test_no_page_loads_external_resources(site: Path):
    pages = [path for path in site.rglob("*.html") if "examples" not in path.parts]
    assert len(pages) > 20
    address = re.compile(r"""<link\b[^>]*?\bhref=["']?([^"'\s>]+)|<[^>]*?\ssrc=["']?([^"'\s>]+)""")
    addresses = {found[1] or found[2] for page in pages for found in address.finditer(page.read_text(encoding="utf-8"))}
    assert any(address.endswith(".css") for address in addresses)
    assert not [address for address in addresses if re.match(r"(https?:)?//", address)]


SEARCH = """<iframe id="site" src="site/index.html" style="width:1200px;height:800px"></iframe><script>
document.getElementById("site").onload = async ({ target }) => {
  const page = target.contentDocument, found = () => [...page.querySelectorAll(".md-search-result__item a")];
  const field = page.querySelector("input.md-search__input");
  field.focus();
  field.value = "wheelset_position";
  for (let n = 0; n < 100 && !found().length; n++) {
    field.dispatchEvent(new Event("input", { bubbles: true }));
    field.dispatchEvent(new KeyboardEvent("keyup", { bubbles: true }));
    await new Promise((done) => setTimeout(done, 200));
  }
  document.title = JSON.stringify({ protocol: page.location.protocol, found: found().map((link) => link.href) });
};
</script>"""


@needs_browser
def test_the_search_works_in_pages_opened_as_files(site: Path, tmp_path: Path):
    (tmp_path / "site").symlink_to(site, target_is_directory=True)
    (tmp_path / "search.html").write_text(SEARCH, encoding="utf-8")
    result = json.loads(title_of(tmp_path / "search.html", tmp_path, "--virtual-time-budget=60000"))
    assert result["protocol"] == "file:"
    assert any("scenario.html" in address or "own_plant.html" in address for address in result["found"])


def keys_of(table: Mapping[str, Any], free: Collection[str] = FREE) -> Iterator[str]:
    """Yield the keys of a table and its subtables, except those in `free`."""
    for key, value in table.items():
        yield key
        for entry in value if isinstance(value, list) else [value]:
            if isinstance(entry, dict) and key not in free:
                yield from keys_of(entry, free)


NAMED = {
    "pads", "blocks", "brakes", "track_brakes", "dynamic_brakes", "parking_brakes", "bogies", "couplers",
    "distributors", "accelerators", "load_valves",
}  # fmt: skip
"""Tables of a train file whose keys are chosen by the author."""

LIBRARIES = {
    "scenario": ("scenario/library", FREE),
    "train": ("scenario/trains", NAMED),
    "campaign": ("scenario/campaigns", {"axes", "match", "sweep", "exclude"}),
    "estimation": (
        "estimation/library",
        {"process", "readings", "mean", "deviation", "scale", "noise", "inputs", "parameters", "columns", "extends"},
    ),
}
"""Reference page → folder of files, and tables whose keys are names."""


@pytest.mark.parametrize("page", LIBRARIES)
def test_every_key_of_the_files_of_the_library_is_described(site: Path, page: str):
    folder, free = LIBRARIES[page]
    described = inline_code(site / f"reference/{page}.html")
    for path in sorted((ROOT / "harness" / folder).glob("*.toml")):
        table = tomllib.loads(path.read_text(encoding="utf-8"))
        named = [inner for name in NAMED & table.keys() for inner in table[name].values()]
        noise = table.pop("noise", {})  # its keys are not names, such as those of [source] noise
        keys = {key for each in (table, *named, noise) for key in keys_of(each, free)}
        assert len(keys) > 2, path.name
        assert keys - ({"extends"} & free) <= described, path.name


def test_every_signal_metric_curve_and_command_is_described(site: Path):
    signals = {signal.name for signal in (*PLANT, *EXTRA, *PLANT_INPUTS, *READINGS, *ESTIMATES, *OBSERVATION)}
    assert signals <= inline_code(site / "reference/signals.html")
    assert FIGURES.keys() <= inline_code(site / "reference/metrics.html")
    assert registry.files(registry.CREEP_CURVES).keys() <= inline_code(site / "reference/creep_curves.html")
    commands = (site / "reference/commands.html").read_text(encoding="utf-8")
    program = typer.main.get_command(app)
    names = program.list_commands(program.make_context("railgrip", [], resilient_parsing=True))
    assert "run" in names
    assert not [name for name in names if f'id="railgrip-{name}"' not in commands]


def test_every_name_of_the_python_interface_is_described(site: Path):
    page = (site / "reference/python.html").read_text(encoding="utf-8")
    names = set(railgrip.__all__) - {"__version__"}
    assert not [name for name in names if not re.search(rf'id="railgrip\.([a-z_.]+\.)?{name}"', page)]


def test_every_file_named_on_the_architecture_page_exists():
    """By its path from the root, from `harness/`, or from the folder with the C code of the loop."""
    named = re.findall(r"`([\w/]+\.(?:py|c|h|toml))`", (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8"))
    folders = (ROOT, ROOT / "harness", ROOT / "harness/kernel")
    of_any_kind = {"KIND.py", "NAME.toml", "KIND.toml"}
    paths = [path for path in named if path.rpartition("/")[2] not in of_any_kind]
    assert len(paths) > 20
    assert not [path for path in paths if not any((folder / path).is_file() for folder in folders)]
