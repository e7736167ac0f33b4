"""The interface of a study, and how every study is run."""

from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from importlib import import_module
from pathlib import Path
from typing import Any, ClassVar, Self

from railgrip.base.errors import InputError
from railgrip.base.names import nearest
from railgrip.base.records import make_folder, require_own
from railgrip.campaign.run import input_versions
from railgrip.campaign.work import Work, work
from railgrip.report.baseline import Finding, Findings
from railgrip.report.page import FORMATS, Page
from railgrip.report.table import write_tables
from railgrip.studies import module_of, names


@dataclass(frozen=True, kw_only=True)
class Study(ABC):
    """A study as a frozen dataclass, whose fields are the options of its command, with the same names.

    `Annotated` describes a field for typer. The fields that many commands share, `overrides` and `import_from`, need no
    description.

    Every study has a quick form, which checks within 60 s on two idle cores that the study runs.

    Attributes:
        quick: Whether to run the quick form.
        quick_form: Difference of the quick form from the whole study, a clause: "2 draws on each rail in place of 10".
        quick_sizes: Options with other values in the quick form.
        has_cases: Whether a cluster can run cases of the study, unlike measurements of durations.
        documentation: Page of the documentation, relative to the folder of the project, into which a study with the
            option `write` writes what its page declares as `documented`.
    """

    quick: bool = False
    quick_form: ClassVar[str]
    quick_sizes: ClassVar[Mapping[str, Any]]
    has_cases: ClassVar[bool] = True
    documentation: ClassVar[Path]

    def __init_subclass__(
        cls, *, quick: str, sizes: Mapping[str, Any] | None = None, whole: Sequence[str] = ()
    ) -> None:
        """Declare the quick form, without which a study cannot be defined.

        Args:
            cls: The study.
            quick: See `quick_form`.
            sizes: See `quick_sizes`; the quick form refuses other values of them.
            whole: Further options that the quick form refuses, in addition to `write`.
        """
        cls.quick_form, cls.quick_sizes, cls._whole = quick, sizes or {}, ("write", *whole)

    _whole: ClassVar[Sequence[str]]

    @property
    def name(self) -> str:
        """Name of the study, and of its folder of results in build/ by default."""
        return type(self).__module__.split(".")[2]

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

    def reduce(self) -> Self:
        """Return the study with the sizes of its quick form.

        Raises:
            InputError: Options are given that only the whole study has; the message names all of them.
        """
        own = {field.name: field.default for field in fields(self)}
        given = [name for name in (*self._whole, *self.quick_sizes) if name in own and getattr(self, name) != own[name]]
        if given:
            options = ", ".join(f"--{name.replace('_', '-')}" for name in given)
            raise InputError(f"{options}: only for the whole study; leave out --quick.")
        return replace(self, **self.quick_sizes)

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
        InputError: There is a `scheduler`, but the study has no cases for it, or it is not an address; or options of
            the whole study are given for its quick form.
        RecordError: Results cannot be written into the folder; nothing was run.
        RailgripError: A case failed; earlier results are kept in the cache.
    """
    if scheduler is not None and not study.has_cases:
        raise InputError(f"--scheduler {scheduler}: study {study.name} has no cases for a cluster; omit it.")
    if study.quick:
        study = study.reduce()
    # The quick form does not overwrite results of the whole study.
    folder = out / ("quick" if study.quick else "") / study.place
    require_own(folder)
    make_folder(folder)
    with work(study.name, folder, workers=workers, scheduler=scheduler, fresh=fresh) as job:
        page = study.page(job)
        origin = {"study": study.options, **input_versions()}
        page = replace(page, provenance={**origin, **page.provenance})
        if study.quick:
            page = _as_quick(page, study.quick_form)
        if page.documented and getattr(study, "write", False):
            write_tables(study.documentation, page.documented)
        job.notify("drawing the page")
        return page, page.write(folder, formats)


def _as_quick(page: Page, form: str) -> Page:
    about = f"This is the quick form of the study, which checks that it runs: {form}."
    title, answer = f"{page.title} (quick form)", f"{about} {page.answer}"
    return replace(page, title=title, answer=answer, screen=(about, *page.screen))


def headlines(name: str, *, workers: int = 2) -> Findings:
    """Return the headline numbers of a study."""
    study = study_named(name)()
    with work(name, workers=workers) as job:
        return Findings(values=tuple(study.headlines(job)))
