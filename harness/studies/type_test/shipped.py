"""Results of built-in controllers that are part of the package, so that a single controller is ranked among them.

A file has the stops of one set of cases, after a line with the digest of these cases and the version of railgrip.
`railgrip study type_test --write` writes it. Results of cases that differ from the present ones are rejected.
"""

import csv
import hashlib
import json
import math
import re
from collections.abc import Iterable, Mapping, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any

import pandas

from railgrip.base.files import write_text
from railgrip.report.frame import Frame
from railgrip.studies.type_test.case_set import AnyCase, CaseSet
from railgrip.studies.type_test.entrants import LIBRARY
from railgrip.studies.type_test.judge import SHIPPED, frame_of_rows


def digest_of(design: Iterable[AnyCase], train: Mapping[str, Any]) -> str:
    """Return a SHA-256 of everything that defines the stops of a test except the controllers and their task."""
    two_groups = [[case.name, case.tables(2), case.fault_tables(2), *filter(None, [case.train])] for case in design]
    return hashlib.sha256(json.dumps([train, two_groups], sort_keys=True, default=str).encode()).hexdigest()


def write_shipped(stops: Frame, design: Sequence[AnyCase], train: Mapping[str, Any], folder: Path) -> list[Path]:
    """Write the stops of each set of cases into its file in a folder; return the files."""
    shipped = stops[list(SHIPPED)].sort_values(["case", "controller"]).astype({"strokes": "Int64"})
    paths: list[Path] = []
    for case_set, of_the_set in _by_set(design).items():
        header = f"# cases {digest_of(of_the_set, train)}, railgrip {version('railgrip')}\n"
        own = shipped[shipped["case"].isin([case.name for case in of_the_set])]
        paths.append(folder / _file_of(case_set))
        write_text(paths[-1], header + own.to_csv(index=False, lineterminator="\n"))
    return paths


def read_shipped(
    design: Iterable[AnyCase], train: Mapping[str, Any], folder: Path = LIBRARY
) -> tuple[Frame, list[str]]:
    """Return the packaged stops for some cases, and a sentence about each set of cases.

    Args:
        design: The cases.
        train: Tables of the train, `train_of`.
        folder: Folder of the files.
    """
    frames: list[Frame] = []
    sentences: list[str] = []
    for case_set, of_the_set in _by_set(design).items():
        file = _file_of(case_set)
        if not (folder / file).exists():
            sentences.append(
                f"No results of railgrip's controllers come with these {case_set.count} cases; "
                "they come with those of --quick."
            )
            continue
        header, *lines = (folder / file).read_text(encoding="utf-8").splitlines()
        digest, release = re.findall(r"# cases (\w+), railgrip (.+)", header)[0]
        if digest != digest_of(case_set.cases(), train):
            sentences.append(
                f"The results of railgrip's controllers in {file} are not shown: they are of other cases or of another "
                "train. `railgrip study type_test --write` writes those of the present cases on the train of railgrip."
            )
            continue
        by_name = {case.name: case for case in of_the_set}
        found = pandas.DataFrame([row for row in csv.DictReader(lines) if row["case"] in by_name])
        numbers = found.columns.difference(["case", "controller", "outcome"])
        found[numbers] = found[numbers].replace("", math.nan).astype(float)
        variants = [
            {name: value for name, value in by_name[case].variants().items() if name != "case"}
            for case in found["case"]
        ]
        speeds = [by_name[case].speed for case in found["case"]]
        frames.append(frame_of_rows(found.assign(variants=variants, speed=speeds)))
        sentences.append(f"Shipped results come with the package and are of railgrip {release}.")
    return pandas.concat(frames, ignore_index=True) if frames else frame_of_rows([]), sentences


def _by_set(design: Iterable[AnyCase]) -> dict[CaseSet, list[AnyCase]]:
    sets: dict[CaseSet, list[AnyCase]] = {}
    for case in design:
        sets.setdefault(_set_of(case), []).append(case)
    return sets


def _file_of(case_set: CaseSet) -> str:
    version = "" if case_set.version == 1 else f"v{case_set.version}{case_set.part}_"
    return f"results_{version}{case_set.count}_{case_set.seed}.csv"


def _set_of(case: AnyCase) -> CaseSet:
    found = CaseSet.of(case.name)
    assert found is not None, case.name
    return found
