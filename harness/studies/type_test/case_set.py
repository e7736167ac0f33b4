"""Sets of cases: versions of the type test, seeds, the sealed set of a controller, and how often results were read."""

import json
import re
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import Final, Self

from railgrip.base import cache
from railgrip.base.errors import RecordError, ScenarioError
from railgrip.base.files import write_json
from railgrip.base.units import cut
from railgrip.report.table import ReportTable
from railgrip.studies.type_test import design
from railgrip.studies.type_test.design import Case
from railgrip.studies.type_test.track_case import (
    TrackCase,
    passage_cases,
    published_rails,
    track_cases,
)

AnyCase = Case | TrackCase


Draw = Callable[[int, int], tuple[AnyCase, ...]]
"""Returns a number of cases of a seed."""
Part = tuple[Callable[[int], int], Draw]
"""Number of further cases for a number of cases, and their draw."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Version:
    """A version of the type test.

    Attributes:
        count, small: Number of cases of the full set, and of the small one.
        test, validation, training: Seeds of the sets.
        draw: Returns a number of cases of a seed.
        parts: Letter in the names of further cases → their number and draw.
    """

    count: int
    small: int
    test: int
    validation: int
    training: int
    draw: Draw
    parts: Mapping[str, Part] = field(default_factory=dict[str, Part])

    def design(self, count: int, seed: int) -> tuple[AnyCase, ...]:
        """Return a number of cases of a seed, followed by those of its further parts.

        The rails of Table 1 have no draw: they are only in the set of the test.
        """
        further = [
            case
            for letter, (number, draw) in self.parts.items()
            if letter != _PUBLISHED or seed == self.test
            for case in draw(number(count), seed)
        ]
        return (*self.draw(count, seed), *further)


_PASSAGE, _PUBLISHED = "p", "t"
"""Letters of the cases on rails that passing wheels clean, and of those on the rails of Table 1."""
_PASSED: Final = 6
"""Number of cases for one that passing wheels clean."""

VERSIONS: Final[Mapping[int, Version]] = MappingProxyType(
    {
        1: Version(
            count=design.CASES,
            small=design.SMALL,
            test=design.SEED,
            validation=design.VALIDATION_SEED,
            training=design.TRAINING_SEED,
            draw=design.cases,
        ),
        2: Version(
            count=432,
            small=24,
            test=25595,
            validation=64105,
            training=3021,
            draw=track_cases,
            parts={
                _PASSAGE: (lambda count: count // _PASSED, passage_cases),
                _PUBLISHED: (lambda count: 3 if count > 3 else 0, published_rails),
            },
        ),
    }
)

"""Number → version. A stop of version 2 takes 0.75 s of processor time in the mean of all controllers in the small set,
so that the full set of one controller takes some 3 minutes on two idle cores."""

SEALED: Final = 48
"""Number of cases of a sealed set, if none is given."""
_SEALED_FROM: Final = 10**9
"""Seeds of sealed sets are above those that a name of a case may have: their cases are not run one by one."""
_LOOKS: Final = Path("type_test") / "looks.json"
"""File in the cache folder that counts how often results were read."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CaseSet:
    """A set of cases, from which the cases follow.

    Attributes:
        version: Version of the type test.
        count: Number of cases.
        seed: Seed of the draw.
        part: Key of `Version.parts`, or '' for the cases of `Version.draw`.
    """

    version: int
    count: int
    seed: int
    part: str = ""

    @classmethod
    def of(cls, name: str) -> Self | None:
        """Return the set that is in the name of a case, None for another name."""
        match = re.fullmatch(r"\d+of(\d{1,5})(?:v(\d)([a-z]?))?-(\d{1,10})", name)
        if match is None or not int(match[1]):
            return None
        version, part = int(match[2] or 1), match[3] or ""
        if version not in VERSIONS or (part and part not in VERSIONS[version].parts):
            return None
        return cls(version=version, count=int(match[1]), seed=int(match[4]), part=part)

    @classmethod
    def sealed(cls, version: int, digest: str, count: int = SEALED) -> Self:
        """Return the set that is drawn from the digest of a controller."""
        return cls(version=version, count=count, seed=_SEALED_FROM + int(digest[:8], 16) % _SEALED_FROM)

    @property
    def is_sealed(self) -> bool:
        """Whether its cases follow from a controller."""
        return self.seed >= _SEALED_FROM

    @property
    def kind(self) -> str:
        """What it is for: test, validation, training, sealed, or other."""
        version = VERSIONS[self.version]
        if self.is_sealed:
            return "sealed"
        return next(
            (kind for kind in ("test", "validation", "training") if getattr(version, kind) == self.seed), "other"
        )

    @property
    def label(self) -> str:
        """Its version, kind and number of cases."""
        return f"version {self.version}, {self.kind}, {self.count} cases"

    def cases(self) -> tuple[AnyCase, ...]:
        """Return its cases."""
        version = VERSIONS[self.version]
        draw = version.parts[self.part][1] if self.part else version.draw
        return draw(self.count, self.seed)


def case_named(name: str) -> AnyCase:
    """Return the case of a name, which contains its set.

    Raises:
        ScenarioError: The case does not exist, or its set is sealed.
    """
    of_name = CaseSet.of(name)
    if of_name and of_name.is_sealed:
        raise ScenarioError(f"--case {cut(name)}: cases of a sealed set are run together, by --sealed")
    found = next((case for case in of_name.cases() if case.name == name), None) if of_name else None
    if found is None:
        example = design.cases(design.SMALL)[0].name
        raise ScenarioError(f"--case {cut(name)}: there is no such case; it is named like {example}")
    return found


def count_look(case_set: str, digests: Iterable[str]) -> Mapping[str, Mapping[str, int]]:
    """Count one look at the results of controllers in a set; return set → digest of a controller → number of looks.

    The file has no dates: it is the same for the same looks.

    Raises:
        RecordError: The file cannot be written.
    """
    path = cache.folder() / _LOOKS
    counts = _counts(path)
    of_set = counts.setdefault(case_set, {})
    for digest in digests:
        of_set[digest] = of_set.get(digest, 0) + 1
    path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
    write_json(path, counts)
    return counts


def _counts(path: Path) -> dict[str, dict[str, int]]:
    """Return the counts in a file; none if it does not exist.

    Raises:
        RecordError: The file is damaged, so that earlier looks would be lost.
    """
    with suppress(FileNotFoundError):
        try:
            return json.loads(path.read_text(encoding="utf-8"))
        except ValueError as problem:
            raise RecordError(f"{path}: is not a count of looks; move it away to begin a new one") from problem
    return {}


def table_of_looks(counts: Mapping[str, Mapping[str, int]], case_set: str) -> ReportTable:
    """Return the number of looks at each set and the maximum of one controller; the present set comes first."""
    rows = [
        {
            "set": name,
            "looks": sum(counts[name].values()),
            "controllers": len(counts[name]),
            "maximum of one controller": max(counts[name].values()),
        }
        for name in sorted(counts, key=lambda name: (name != case_set, name))
    ]
    return ReportTable(rows, left=("set",))
