"""FMUs of small Modelica models, built once per run, and ways to run them."""

from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path

import fmpy
import pytest
from slave import Slave
from small_fmus import FEATURES, Fmu

from railgrip.fmus.native.dae import read
from railgrip.fmus.native.package import pack, sources
from railgrip.fmus.native.system import explicit


@pytest.fixture(scope="session")
def built(tmp_path_factory: pytest.TempPathFactory) -> Callable[[Path, str], Fmu]:
    """Return a function of (library or file, class) that builds an FMU for both interfaces once."""
    cache: dict[tuple[Path, str], Fmu] = {}

    def build(library: Path, class_name: str) -> Fmu:
        if (library, class_name) not in cache:
            folder = tmp_path_factory.mktemp(class_name.replace(".", "_"))
            source = sources(explicit(read(class_name, library)), interfaces=("me", "cs"))
            path = pack(source, folder / f"{class_name.rpartition('.')[2]}.fmu", flags=("-O0",))
            unpacked = Path(fmpy.extract(str(path), str(folder / "unpacked")))
            cache[library, class_name] = Fmu(path, unpacked, fmpy.read_model_description(str(path)))
        return cache[library, class_name]

    return build


@pytest.fixture(scope="session")
def feature(built: Callable[[Path, str], Fmu]) -> Callable[[str], Fmu]:
    """Return a function of a class name in Features."""
    return lambda name: built(FEATURES, f"Features.{name}")


@pytest.fixture(scope="session")
def modelica(built: Callable[[Path, str], Fmu], tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Fmu]:
    """Return a function of the text of `model M ... end M;`."""
    folder = tmp_path_factory.mktemp("texts")

    def build(text: str) -> Fmu:
        file = folder / f"M{abs(hash(text))}.mo"
        file.write_text(text)
        return built(file, "M")

    return build


@pytest.fixture
def written(tmp_path: Path) -> Callable[..., Path]:
    """Return a function that writes a text into a file, M.mo unless it has another name, and returns its path."""

    def write(text: str, name: str = "M.mo") -> Path:
        (tmp_path / name).write_text(text)
        return tmp_path / name

    return write


@pytest.fixture
def run() -> Iterator[Callable[..., Slave]]:
    """Return a function that starts an FMU: run(fmu, interface="cs", start={name: value}, time=0.0, messages=[])."""
    with ExitStack() as running:
        yield lambda fmu, interface="cs", **more: running.enter_context(
            Slave(fmu.path, folder=fmu.folder, interface=interface, **more)
        )
