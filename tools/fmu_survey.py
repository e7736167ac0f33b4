"""Survey the FMUs of a folder: open and step each in a separate process, and count what was refused by reason."""

import re
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import replace
from math import isfinite
from pathlib import Path
from typing import Final
from zipfile import BadZipFile

import numpy as np
import pandas

from railgrip.base.errors import Failure, FmuError, PlantFailed
from railgrip.base.limits import FmuLimits
from railgrip.fmi.archive import outline
from railgrip.fmi.description import PLATFORMS, Description, describe
from railgrip.fmi.isolation import IsolatedCoSimulation
from railgrip.fmi.mapping import Binding, side_of
from railgrip.report.frame import Frame
from railgrip.report.table import ReportTable

STEPS: Final = 20
_STEP: Final = 1e-3  # s, if the FMU suggests none
_NUMBERS: Final = ("Real", "Integer", "Boolean", "Enumeration")
_LIMITS: Final = FmuLimits(patience=60.0, memory_mib=4096)
_REFUSALS: Final = {
    r"this is FMI|fmiVersion": "another version of FMI",
    r"no binary for this platform": f"no binary for {PLATFORMS[2]}",
    r"is a clock": "clocks",
    r"not an FMU|archive": "no archive of an FMU",
    r"is not valid FMI|cannot be understood|ModelStructure|in modelDescription.xml": "a description that is not valid",
    r"does not load": "a binary that does not load",
}  # fmt: skip
"""Patterns of refusals → their common reason."""
_AFTER_NAME: Final = re.compile(r"\s*(?:Version|\(|:|,|\s-\s|\bv?\d+\.\d|(?<=[a-z])\d)")


def survey(folder: Path) -> Frame:
    """Open each FMU of a folder without setting parameters, step it by each of its interfaces and return the results.

    Returns:
        A row for each interface: `file`, relative to the folder; the `tool` that made it, without version; version of
        `FMI`, with CS or ME if it was run; `reason` why it did not step, in a few words, '' on success, and `sentence`,
        the same as the message for a user.
    """
    files = sorted(folder.rglob("*.fmu"))
    rows = [(str(file.relative_to(folder)), *row) for file in files for row in _survey_file(file)]
    return pandas.DataFrame(rows, columns=["file", "tool", "FMI", "reason", "sentence"])


def _survey_file(file: Path) -> Iterator[tuple[str, str, str, str]]:
    tool, version, step = "unknown", "", ""
    try:
        first = outline(file, _LIMITS)
        tool, version, step = _tool(first.tool), first.version or "", first.step
    except (FmuError, BadZipFile, OSError, KeyError, ValueError, RuntimeError):
        pass  # `describe` reports it
    try:
        description = describe(file, _LIMITS)
    except FmuError as error:
        yield tool, version, _reason(error), _without(file, error)
        return
    ways = {"CS": replace(description, model_exchange=None), "ME": replace(description, co_simulation=None)}
    for way, interface in ways.items():
        if interface.co_simulation is interface.model_exchange is None:
            continue
        reason = sentence = ""
        try:
            _step(interface, step)
        except FmuError as error:
            reason, sentence = _reason(error), _without(file, error)
        except PlantFailed as failed:
            reason = failed.failure.reason.replace("_", " ") if isinstance(failed.failure, Failure) else "other"
            sentence = str(failed)
        yield tool, f"{description.fmi}.0 {way}", reason, sentence


def _reason(error: FmuError) -> str:
    return next((words for pattern, words in _REFUSALS.items() if re.search(pattern, str(error))), "other")


def _step(description: Description, suggested: str) -> None:
    outputs = [v for v in description.variables.values() if v.causality == "output" and v.kind in _NUMBERS]
    binding = Binding(inputs=side_of(()), outputs=side_of(outputs), unused=(), parameters={})
    try:
        period = float(suggested)
    except ValueError:
        period = _STEP
    period = period if isfinite(period) and period > 0 else _STEP
    with IsolatedCoSimulation(description, binding, period=period, parameters={}, limits=_LIMITS) as plant:
        plant.start(np.zeros(0))
        for _ in range(STEPS):
            plant.step(np.zeros(0))


def _tool(generator: str) -> str:
    name = _AFTER_NAME.split(generator.strip(), maxsplit=1)[0].strip()
    if name.startswith(("OpenModelica", "OMCompiler")):
        return "OpenModelica"
    return "unknown" if name in ("", "an unnamed tool") else name


def _without(file: Path, error: FmuError) -> str:
    return str(error).replace(f"{file}: ", "")


def survey_table(rows: Frame) -> ReportTable:
    """Return the numbers of FMUs that step, and that do not by reason, for each tool and interface."""
    steps, why = rows["reason"] == "", "refused or failed, why"
    groups = rows.assign(order=rows["tool"].str.lower(), step=steps).groupby(["order", "tool", "FMI"])
    found = groups.agg(**{"FMUs": ("step", "size"), "step": ("step", "sum"), why: ("reason", _counted)}).reset_index()
    whole = ["", "all, each counted once", "", rows["file"].nunique(), rows["file"][steps].nunique(), ""]
    found.loc[len(found)] = whole
    return ReportTable.of_frame(found.drop(columns="order"), left=("tool", "FMI", why))


def _counted(reasons: Iterable[str]) -> str:
    return "; ".join(f"{count} {reason}" for reason, count in Counter(filter(None, reasons)).most_common())
