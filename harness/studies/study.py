"""The interface of a study, and how every study is run."""

from abc import ABC, abstractmethod
from collections.abc import Iterable, Sequence
from dataclasses import fields, replace
from importlib import import_module
from pathlib import Path
from typing import ClassVar

from railgrip.base.errors import InputError
from railgrip.base.names import nearest
from railgrip.base.records import make_folder, require_own
from railgrip.campaign.run import input_versions
from railgrip.campaign.work import Work, work
from railgrip.report.baseline import Finding, Findings
from railgrip.report.page import FORMATS, Page
from railgrip.studies import module_of, names


class Study(ABC):
    """A study as a frozen dataclass, whose fields are the options of its command.

    `Annotated` describes a field for typer. The fields that many commands share, `overrides`, `import_from` and
    `quick`, need no description.

    Attributes:
        has_cases: Whether a cluster can run cases of the study, unlike measurements of durations.
    """

    has_cases: ClassVar[bool] = True

    @property
    def name(self) -> str:
        """Name of the study, and of its folder of results in build/ by default."""
        return type(self).__module__.removesuffix(".study").rpartition(".")[2]

    @property
    def place(self) -> str:
        """Folder inside the folder of results, so that a variant does not overwrite the whole study."""
        return ""

    @property
    def options(self) -> str:
        """Name of the study with its options, for the provenance of its page."""
        values = {field.name: getattr(self, field.name) for field in fields(self)}  # pyright: ignore[reportArgumentType]
        given = (f"{name} {value}" for name, value in values.items() if value is not None and value is not False)
        return ", ".join((self.name, *given))

    @abstractmethod
    def page(self, work: Work) -> Page:
        """Run the cases of the study and return its page."""

    def headlines(self, work: Work) -> Iterable[Finding]:
        """Return the few numbers that reveal a change of the whole study; `railgrip maintain regress` compares them.

        They come from a reduced form of the study with fixed seeds, in seconds. A tolerance covers the arithmetic of
        another machine: small for a mean over thousands of samples, one sample for an instant, larger for the maximum
        of many errors. A changed law changes the number by more.
        """
        return ()


def study_named(name: str) -> type[Study]:
    """Return a study.

    Raises:
        InputError: The name of the study is unknown.
    """
    if name not in names():
        near = nearest(name, names())
        hint = f"did you mean `railgrip study {near[0]}`?" if near else f"there are {', '.join(names())}."
        raise InputError(f"there is no study '{name}'; {hint}")
    return import_module(module_of(name)).STUDY


def conduct(
    study: Study,
    out: Path,
    *,
    workers: int = 2,
    scheduler: str | None = None,
    fresh: bool = False,
    formats: Sequence[str] = FORMATS[:1],
) -> tuple[Page, Path]:
    """Run a study, write its page and further files; return the page and its path.

    Raises:
        InputError: There is a `scheduler`, but the study has no cases for it, or it is not an address.
        RecordError: Results cannot be written into the folder; nothing was run.
        RailgripError: A case failed; earlier results are kept in the cache.
    """
    if scheduler is not None and not study.has_cases:
        raise InputError(f"--scheduler {scheduler}: study {study.name} has no cases for a cluster; omit it.")
    folder = out / study.place
    require_own(folder)
    make_folder(folder)
    with work(study.name, folder, workers=workers, scheduler=scheduler, fresh=fresh) as job:
        page = study.page(job)
        origin = {"study": study.options, **input_versions()}
        page = replace(page, provenance={**origin, **page.provenance})
        job.notify("page")
        return page, page.write(folder, formats)


def headlines(name: str, *, workers: int = 2) -> Findings:
    """Return the headline numbers of a study."""
    study = study_named(name)()
    with work(name, workers=workers) as job:
        return Findings(values=tuple(study.headlines(job)))
