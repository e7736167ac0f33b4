"""lock.toml: the interfaces and digests of all FMUs, so that a change of the models is visible in review."""

import json
import tomllib
from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path
from typing import Any

from railgrip.fmus.native.code import layout_of
from railgrip.fmus.native.equations import output_scalars
from railgrip.fmus.native.system import System
from railgrip.fmus.native.variables import Scalar
from railgrip.fmus.recipe import Cookbook, Recipe

LOCK = Path(__file__).with_name("lock.toml")

Entry = dict[str, Any]


def interface_of(recipe: Recipe, system: System, digest: str) -> Entry:
    """Return the entry of an FMU in lock.toml.

    Keys: class; digest of C code and XML; states, inputs, outputs as name = unit; nonlinear_loops as lists of
    their unknowns; parameters (public ones), event_indicators, time_events, clocks, discretes, assertions as counts.
    """
    layout = layout_of(system)
    return {
        "class": recipe.class_name,
        "digest": digest,
        "parameters": sum(not p.protected for p in layout.parameters[: layout.free]),
        "discretes": len(layout.discretes),
        "event_indicators": system.indicators.numel(),
        "time_events": system.instants.numel(),
        "clocks": len(system.clocks),
        "assertions": len(system.assertions),
        "nonlinear_loops": [list(block) for block in system.loops.blocks],
        "states": _units(layout.states),
        "inputs": _units(layout.inputs),
        "outputs": _units(output_scalars(system)),
    }


def _units(scalars: list[Scalar]) -> dict[str, str]:
    return {s.name: s.attributes.get("unit") or "" for s in scalars}


def read_lock(file: Path = LOCK) -> Mapping[str, Entry]:
    """Return the entries of a lock file by FMU, and `tools`; empty without a file."""
    return tomllib.loads(file.read_text(encoding="utf-8")) if file.exists() else {}


def write_lock(book: Cookbook, entries: Mapping[str, Entry], file: Path = LOCK) -> None:
    """Write a lock file."""
    lines = [
        "# Written by `railgrip build --check --update`; a change here is a change of the models' faces.",
        "",
        "[tools]",
    ]
    lines += [f"{tool} = {_toml(version(tool))}" for tool in ("rumoca", "casadi")]
    for name in book.recipes:
        lines += ["", f"[{name}]"]
        tables: list[str] = []
        for key, value in entries[name].items():
            if isinstance(value, dict):
                tables += ["", f"[{name}.{key}]", *(f"{_toml(k)} = {_toml(v)}" for k, v in value.items())]
            else:
                lines.append(f"{key} = {_toml(value)}")
        lines += tables
    file.write_text("\n".join([*lines, ""]), encoding="utf-8")


def _toml(value: object) -> str:
    return json.dumps(value, ensure_ascii=False)  # of texts, numbers and lists of them the same in TOML


def differences(name: str, lock: Mapping[str, Entry], entry: Entry) -> list[str]:
    """Return the differences from the lock file.

    The digest is compared only under the same tool versions: another version of CasADi may write other C code.
    """
    if name not in lock:
        return ["is not in lock.toml"]
    same_tools = all(lock.get("tools", {}).get(tool) == version(tool) for tool in ("rumoca", "casadi"))
    out: list[str] = []
    for key, value in entry.items():
        before = lock[name].get(key)
        if before == value or (key == "digest" and not same_tools):
            continue
        if isinstance(value, dict) and isinstance(before, dict):
            for k in [*before, *(k for k in value if k not in before)]:
                if before.get(k) != value.get(k):
                    out.append(f"{key}: {k} was {before.get(k)!r}, is {value.get(k)!r}")
            if list(before) != list(value) and not out:
                out.append(f"{key}: the order has changed")
        else:
            out.append(f"{key} was {before!r}, is {value!r}")
    return out
