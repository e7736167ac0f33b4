"""FMUs of small Modelica models, built once per run, and ways to run them."""

from collections.abc import Callable, Iterator
from pathlib import Path

import fmpy
import pytest
from fmpy.fmi2 import FMU2Model, FMU2Slave, fmi2CallbackFunctions, fmi2CallbackLoggerTYPE
from fmpy.fmi2 import fmi2CallbackAllocateMemoryTYPE as AllocateType
from fmpy.fmi2 import fmi2CallbackFreeMemoryTYPE as FreeType
from small_fmus import FEATURES, Fmu, Running

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
def run() -> Iterator[Callable[..., Running]]:
    """Return a function that starts an FMU: run(fmu, interface="cs", start={name: value}, time=0.0, messages=[])."""
    alive: list[Running] = []

    def start(
        fmu: Fmu,
        interface: str = "cs",
        *,
        start: dict[str, float] | None = None,
        time: float = 0.0,
        messages: list[str] | None = None,
    ) -> Running:
        kind, identifier = (
            (FMU2Slave, fmu.description.coSimulation.modelIdentifier)
            if interface == "cs"
            else (FMU2Model, fmu.description.modelExchange.modelIdentifier)
        )
        instance = kind(
            guid=fmu.description.guid,
            unzipDirectory=str(fmu.folder),
            modelIdentifier=identifier,
            instanceName="under test",
        )
        running = Running(fmu, instance, [] if messages is None else messages)
        callbacks = fmi2CallbackFunctions()
        callbacks.logger = fmi2CallbackLoggerTYPE(lambda *a: running.messages.append(a[4].decode()))
        callbacks.allocateMemory = AllocateType()
        callbacks.freeMemory = FreeType()
        instance.instantiate(callbacks=callbacks)
        instance.setupExperiment(startTime=time)
        for name, value in (start or {}).items():
            (setter,) = [v for v in fmu.description.modelVariables if v.name == name]
            if setter.type == "Real":
                instance.setReal([setter.valueReference], [value])
            elif setter.type == "Boolean":
                instance.setBoolean([setter.valueReference], [bool(value)])
            else:
                instance.setInteger([setter.valueReference], [int(value)])
        instance.enterInitializationMode()
        instance.exitInitializationMode()
        alive.append(running)
        return running

    yield start
    for running in alive:
        running.instance.terminate()
        running.instance.freeInstance()
