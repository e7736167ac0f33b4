"""What a study is, and how any of them is run."""

from abc import ABC, abstractmethod
from collections.abc import Iterable
from importlib import import_module
from pathlib import Path

from railgrip.campaign.one_stop import make_folder
from railgrip.campaign.work import Work, work
from railgrip.errors import InputError
from railgrip.report.baseline import Finding, Findings
from railgrip.report.page import Page
from railgrip.studies import names


class Study(ABC):
    """What is run, and what is shown of it; a frozen dataclass, whose fields are the options of its command.

    A field says in `Annotated` how typer shows it. Those that many commands have, `overrides`, `import_from` and
    `quick`, say nothing.
    """

    @property
    def name(self) -> str:
        """Its folder here, and, unless another is named, that of its results in build/."""
        return type(self).__module__.split(".")[-2]

    @property
    def place(self) -> str:
        """Folder inside that of the results: where a variant of the study does not overwrite the whole."""
        return ""

    @abstractmethod
    def page(self, work: Work) -> Page:
        """Run what is to be run, and return what was found."""

    def headlines(self, work: Work) -> Iterable[Finding]:
        """Return the few numbers that `railgrip maintain regress` compares to detect a change of the whole study.

        Each is found in a reduced form of the study, in seconds, from fixed seeds. A tolerance is what another
        machine's arithmetic may do to the number: little to a mean over thousands of samples, one sample to an
        instant, more to the largest of many errors. A changed law moves it further.
        """
        return ()


def study_named(name: str) -> type[Study]:
    """Return a study.

    Raises:
        InputError: There is none of that name.
    """
    if name not in names():
        raise InputError(f"there is no study '{name}'; there is {', '.join(names())}.")
    return import_module(f"railgrip.studies.{name}.study").STUDY


def conduct(
    study: Study, out: Path, *, workers: int = 2, scheduler: str | None = None, fresh: bool = False
) -> tuple[Page, Path]:
    """Run a study, write its page and all that lies beside it, and return it and its path.

    Raises:
        RecordError: Results cannot be written there; nothing was run.
        RailgripError: A case failed; results before it are kept, and found by the next one who asks.
    """
    folder = out / study.place
    make_folder(folder)
    with work(study.name, folder, workers=workers, scheduler=scheduler, fresh=fresh) as own:
        page = study.page(own)
        own.notify("page")
        return page, page.write(folder)


def headlines(name: str, *, workers: int = 2) -> Findings:
    """Return the headline numbers of a study."""
    study = study_named(name)()
    with work(name, workers=workers) as own:
        return Findings(values=tuple(study.headlines(own)))
