"""A page that runs the stop of a scenario in a browser: its C code as WebAssembly, and its memory before the start."""

import base64
import json
import re
import zlib
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager, suppress
from dataclasses import dataclass
from functools import partial
from importlib import resources
from math import prod
from pathlib import Path
from typing import Any, Final, Literal

import numpy as np
from markupsafe import Markup

from railgrip.base.arrays import Mask, Vector
from railgrip.base.errors import FmuError, ScenarioError
from railgrip.base.files import write_text
from railgrip.base.names import ElementName
from railgrip.base.tables import JsonObject
from railgrip.controllers.law import GroupLaw
from railgrip.controllers.sampled import Sampled
from railgrip.estimators.compiled import StepInC
from railgrip.fmi import CoSimulation
from railgrip.fmi.archive import read_sources
from railgrip.fmus.native.discrete import MemoryImage, align_pointers, memory_image
from railgrip.fmus.native.package import HEADERS
from railgrip.fmus.native.toolchain import WEB, binary
from railgrip.kernel import headers, kernel, texts
from railgrip.report.page import render
from railgrip.scenario.adhesion import profile_of, recovery_of
from railgrip.scenario.outcome import Outcome
from railgrip.scenario.schema import Scenario
from railgrip.scenario.table import Custom
from railgrip.simulate.assembly import StopAssembly, assemble
from railgrip.simulate.contact import contact_header
from railgrip.simulate.export.c_parts import sources_of_filter, with_filter_in_c, write_call
from railgrip.simulate.loop.interfaces import Parts, StateEstimator
from railgrip.simulate.loop.loop import Loop
from railgrip.simulate.sensors.service import ServiceSensors
from railgrip.simulate.user_parts import NO_CUSTOM_PARTS, CustomParts, class_of
from railgrip.simulate.vehicle_data import VehicleData, law_named

LAWS: Final = ("slip_two_state", "full_brake")
"""Laws next to the scenario's own."""

LARGEST: Final = 1.5e6  # bytes of a page
_HERE: Final = Path(__file__).parent
_UNITS: Final = ("cycle.c", "onboard.c", "sensors.c", "rail.c", "driver.c", "plausible.c", "faults.c")
_FLAGS: Final = ("-O2", "-msimd128", "-mexec-model=reactor", "-Wl,-z,stack-size=1048576")
_ENDS: Final = {
    "STANDING": Outcome.STANDSTILL,
    "AT_HORIZON": Outcome.HORIZON,
    "NOT_PLAUSIBLE": Outcome.IMPLAUSIBLE,
    "PLANT_FAILED": Outcome.PLANT_FAILED,
    "DIVERGED": Outcome.DIVERGED,
    "NO_COMMAND": Outcome.CONTROLLER_FAILED,
}
"""Enumerators of cycle.h → outcome of the stop."""
_STRIDE: Final = 0.01  # s between two rows that the page draws
_ROUNDING: Final = 1e-11
"""Relative difference of a word from its formula: rounding in the assembly of a stop."""

Load = Callable[[Sequence[str]], Scenario]
"""Returns the scenario with further overrides, as of `--set`."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Control:
    """A quantity that a reader may change.

    Attributes:
        name: Label.
        unit: Unit on the page, in which a value has `factor` times its value in SI units.
        start, low, high: Value of the scenario and range, in SI units.
        overrides: Returns the overrides of the scenario for a value.
    """

    name: str
    unit: str
    factor: float
    start: float
    low: float
    high: float
    overrides: Callable[[float], list[str]]

    def step(self, value: float, power: int = 1) -> float:
        """Return the change of what memory is linear in: the value or its inverse, for a gradient the sine."""

        def term(value: float) -> float:
            return value / float(np.sqrt(1.0 + value * value)) if self.name == GRADIENT else value**power

        return term(value) - term(self.start)


GRADIENT: Final = "gradient"
Term = tuple[Control, int]
"""A control and the power of its value."""


@dataclass(frozen=True, slots=True, kw_only=True)
class _StopAtStart:
    """A stop before its first sample.

    Attributes:
        image: Memory of the loop; friction, the plant and its inputs and outputs are set in the browser.
        words: The image, and the values of the plant's parameters that the scenario sets.
        law: The law.
    """

    image: MemoryImage
    words: Vector
    law: Sampled


_OpenAt = Callable[..., AbstractContextManager[tuple[StopAssembly, _StopAtStart]]]
"""Opens a stop at values of the controls, and with further overrides."""


def write_page(load: Load, file: Path, objects: CustomParts = NO_CUSTOM_PARTS) -> list[str]:
    """Write a page that runs the stop of a scenario; return sentences on what it leaves out.

    Args:
        load: Function that loads the scenario.
        file: The page.
        objects: Folders of the classes that the scenario names.

    Raises:
        ScenarioError: A part of the stop is not in C, or the page would be too large.
        CompilerMissing, BuildFailed: Raised by the compiler in `ziglang`.
    """
    scenario, remarks = load([]), list[str]()
    every, kinds = [*_controls(scenario, remarks)], dict.fromkeys((scenario.controller.kind, *LAWS))
    data, files, variables = JsonObject(), dict[str, str](), dict[str, Any]()
    laws, controls = list[JsonObject](), every
    for kind in kinds:
        at = partial(_assembled, load, objects, kind if laws else "", every)
        try:
            with at({}) as (opened, stop):
                code = _code_of_law(opened.parts, len(laws))
                if not laws:
                    data, (files, variables) = _data(opened), _files(opened)
        except ScenarioError as problem:
            if not laws:
                raise
            remarks.append(f"The page is without the law {kind}: {problem}")
            continue
        controls, fit = _fit(stop.words, at, controls, remarks)
        of_law = {"kind": kind, "words": _pack(stop.words.tobytes()), "image": stop.image.words.size, "fit": fit}
        of_law |= {"thresholds": _thresholds(kind, stop, at, objects, remarks)}
        laws.append(of_law | {"links": stop.image.links.ravel().tolist()} | code)
    data["controls"] = [
        {n: getattr(c, n) for n in ("name", "unit", "factor", "start", "low", "high")} for c in controls
    ]
    files["browser_parts.h"] = render("simulate/kernel/browser_parts.h.jinja", laws=laws, **variables)
    data["laws"] = [{key: value for key, value in law.items() if key not in ("code", "calls")} for law in laws]
    units = [name for name in files if name in (*_UNITS, "plain.c", "browser.c", "set_step_get.c", "plant_model.c")]
    page = render("simulate/export/browser.html.jinja", is_html=True, name=scenario.name, remarks=remarks,
        data=Markup(json.dumps(data, allow_nan=False).replace("<", "\\u003c")),
        module=_pack(binary(files, "stop", units=units, include=[HEADERS], flags=_FLAGS, target=WEB)),
        **{name: Markup((_HERE / f"{name}.js").read_text(encoding="utf-8")) for name in ("browser", "browser_worker")},
    )  # fmt: skip
    if len(page) > LARGEST:
        raise ScenarioError(
            f"{scenario.name}: the page would have {len(page) / 1e6:.1f} MB, and {LARGEST / 1e6:g} MB is the most; "
            "use a train with fewer wheelsets, a shorter [limits] horizon, or --library"
        )
    write_text(file, page)
    return remarks


def _pack(content: bytes) -> str:
    return base64.b64encode(zlib.compress(content, 9)).decode()


@contextmanager
def _assembled(
    load: Load,
    objects: CustomParts,
    kind: str,
    controls: Sequence[Control],
    values: Mapping[Control, float],
    *more: str,
) -> Generator[tuple[StopAssembly, _StopAtStart]]:
    """Open a stop at values of the controls, with another kind of law if one is given."""
    law = [f"controller.kind={kind}"] if kind else []
    scenario = load([*law, *(each for c in controls for each in c.overrides(values.get(c, c.start))), *more])
    with assemble(with_filter_in_c(scenario), objects=objects, capacity=1) as opened:
        parts = opened.parts
        plant, law = _require_c(scenario, parts)
        structs, layout = Loop(parts).structs, parts.layout
        image = memory_image(
            structs.cycle.copy_with(
                plant=structs.plant.copy_with(inputs=np.zeros(layout.inputs), outputs=np.zeros(layout.outputs)),
                rail=parts.rail.struct.copy_with(friction=np.zeros(1)),
                record=structs.record.copy_with(rows=np.zeros(parts.recorder.rows.shape[1])),
            )
        )
        of_plant = np.array([value for each in plant.setup[2] for value in each.values], dtype=np.float64)
        yield opened, _StopAtStart(image=image, words=np.concatenate([image.words.view(np.float64), of_plant]), law=law)


def _require_c(scenario: Scenario, parts: Parts) -> tuple[CoSimulation, Sampled]:
    """Return plant and law.

    Raises:
        ScenarioError: Parts of the stop are not in C; a sentence for each.
    """
    plant, law, estimator = parts.plant, parts.controller, parts.estimator
    has_plant = isinstance(plant, CoSimulation) and bool(_sources_of(plant))
    has_filter = isinstance(estimator, StateEstimator) and isinstance(estimator.filter, StepInC)
    problems = {
        "[vehicle] the plant has no C code of this project's compiler; use a train of this project, a train file, or "
        "[vehicle] model with your Modelica class": not has_plant,
        "[vehicle.parameters] set whole numbers or switches; leave these out": isinstance(plant, CoSimulation)
        and any(each.carrier != "Real" for each in plant.setup[2]),
        "[sensors] have noise, which is drawn in Python; use kind = 'ideal'": isinstance(parts.sensors, ServiceSensors)
        or "noise" in getattr(parts.sensors, "fields", ("noise",)),
        f"[estimator] kind '{scenario.estimator.kind}' is not in C; use compiled, fmu, python or decentralised with a "
        "model of this project, or none": not (estimator is None or has_filter),
        f"[controller] kind '{scenario.controller.kind}' is not a formula; choose a built-in law, or derive your class "
        "from GroupLaw": not isinstance(law, Sampled),
    }
    if any(problems.values()):
        sentences = [f"{scenario.name}: {problem}" for problem, is_true in problems.items() if is_true]
        raise ScenarioError("\n".join([*sentences, "--page runs only stops whose parts are all in C."]))
    assert isinstance(plant, CoSimulation)
    assert isinstance(law, Sampled)
    return plant, law


def _sources_of(plant: CoSimulation) -> dict[str, str]:
    """Return the C code in the plant's FMU, names prefixed by `plant_`; empty if this project did not write it."""
    files = read_sources(plant.setup[0].file)
    if "advance.c" not in files or "elimination.c" in files:
        return {}
    include = re.compile(rf'#include "({"|".join(map(re.escape, files))})"')
    return {f"plant_{name}": include.sub(r'#include "plant_\1"', text) for name, text in files.items()}


def _code_of_law(parts: Parts, number: int) -> JsonObject:
    """Return C code of the formulas of a stop, and the functions that its memory calls."""
    formulas = {"onboard->law": parts.controller, "onboard->valves": parts.valves}
    calls = list[tuple[str, str]]()
    if isinstance(parts.estimator, StateEstimator):
        formulas |= {"filter->reference_speed": parts.estimator.free_wheel}
        formulas |= {"filter->body_force": parts.estimator.body_force}
        calls.append(("filter->advance", "step_plain"))
    named = {f"{place.rpartition('>')[2]}_{number}": (place, formula) for place, formula in formulas.items()}
    there = {name: (place, formula) for name, (place, formula) in named.items() if isinstance(formula, Sampled)}
    calls += [(f"{place}.call", f"call_{name}") for name, (place, _) in there.items()]
    return {"code": "\n".join(write_call(name, formula) for name, (_, formula) in there.items()), "calls": calls}


def _files(opened: StopAssembly) -> tuple[dict[str, str], dict[str, Any]]:
    """Return the C code of a stop, file name → text, and variables of the template of browser_parts.h."""
    parts = opened.parts
    plant, _ = _require_c(opened.vehicle.scenario, parts)
    files = headers(parts.layout) | texts(*_UNITS) | {"export.h": "#define EXPORT\n"}
    if isinstance(parts.estimator, StateEstimator) and isinstance(parts.estimator.filter, StepInC):
        files |= sources_of_filter(parts.estimator.filter)
    places = {"fmi": ("set_step_get.c", "set_step_get.h"), "simulate": ("browser.c",)}
    for package, names in places.items():
        folder = resources.files(f"railgrip.{package}") / "kernel"
        files |= {name: (folder / name).read_text(encoding="utf-8") for name in names}
    aligned = {name: align_pointers(text) if name.endswith(".h") else text for name, text in files.items()}
    sources, (_, binding, assignments) = _sources_of(plant), plant.setup
    guid = re.search(r"#define MODEL_GUID (.*)", sources["plant_model.c"])
    return aligned | sources | {"contact.h": contact_header(*opened.vehicle.contact_arguments())}, {
        "guid": guid and guid[1],
        "begin": repr(opened.vehicle.scenario.plant_begin),
        "references": [reference for each in assignments for reference in each.references],
        "inputs": binding.inputs.channels,
        "outputs": binding.outputs.channels,
    }


def _data(opened: StopAssembly) -> JsonObject:
    """Return the data of a page that all laws share."""
    parts, scenario = opened.parts, opened.vehicle.scenario
    adhesion, period = scenario.adhesion, scenario.periods.communication
    formation, conditioning = parts.layout.formation, adhesion.conditioning
    even = adhesion.model_copy(update={"level": 1.0, "calibrated": {}, "conditioning": None})
    shape = profile_of(scenario.model_copy(update={"adhesion": even}), formation).mu0_at
    if np.all(shape == shape[:, :1]):
        shape = shape[:, :1]
    bits = np.ascontiguousarray(shape).view(np.int64)
    bits = np.diff(bits, 2, axis=0, prepend=np.zeros_like(bits[:2]))  # straight lines become zeros, except for rounding
    recovery = np.zeros(formation.wheelsets) if conditioning is None else recovery_of(conditioning, formation)
    functions = kernel(parts.layout).functions
    return {
        "ends": {getattr(functions, name): outcome for name, outcome in _ENDS.items()},
        "period": period,
        "stride": max(1, round(_STRIDE / period)),
        "samples": parts.clock.samples,
        "columns": {name: [place.start, place.stop] for name, place in parts.recorder.columns.items()},
        "width": parts.recorder.rows.shape[1],
        "first": np.cumsum([0, *formation.wheelsets_per_group])[:-1].tolist(),
        "radius": list(parts.wheel_radius),
        "rail": {
            "shape": _pack(bits.tobytes()),
            "rows": len(shape),
            "columns": shape.shape[1],
            "factor": adhesion.factor / adhesion.level,
            "level": adhesion.level,
            "recovery": recovery.tolist(),
            "recovered": 0.0 if conditioning is None else conditioning.recovered,
        },
    }


def _controls(scenario: Scenario, remarks: list[str]) -> Iterator[Control]:
    level, speed, vehicle = scenario.adhesion.level, scenario.start.speed, VehicleData(scenario)
    yield Control(name="friction", unit="%", factor=100.0 / level, start=level, low=0.5 * level, high=1.5 * level,
        overrides=lambda value: [f"adhesion.level={value!r}"])  # fmt: skip
    if speed:
        yield Control(name="start speed", unit="km/h", factor=3.6, start=speed, low=0.5 * speed, high=1.5 * speed,
            overrides=lambda value: [f"start.speed={value!r}"])  # fmt: skip
    known = vehicle.fmu_parameters | vehicle.changes
    for name, arrays in (("load", ("m_wheelset",)), ("pad friction", ("mu_b_nominal", "mu_b_start"))):
        if values := {key: value for key, value in known.items() if ElementName.of(key).array in arrays}:
            yield Control(name=name, unit="%", factor=100.0, start=1.0, low=0.8, high=1.25,
                overrides=partial(_scale, values))  # fmt: skip
    if scenario.track.model_dump(exclude_defaults=True):
        remarks.append("The page is without a slider of the gradient, because the scenario has a [track].")
    else:
        yield Control(name=GRADIENT, unit="‰", factor=1e3, start=0.0, low=-0.03, high=0.03,
            overrides=lambda value: [f"track.gradient=[{{begin=0,slope={value!r}}}]"])  # fmt: skip


def _scale(values: Mapping[str, float], share: float) -> list[str]:
    return [f'vehicle.parameters."{key}"={share * value!r}' for key, value in values.items()]


def _fit(
    base: Vector, open_at: _OpenAt, controls: Sequence[Control], remarks: list[str]
) -> tuple[list[Control], list[Any]]:
    """Find how the words of a stop depend on the controls: linear in each or its inverse, and in products of two.

    All is compared with stops that are assembled at other values. Returns the controls for which this holds, and the
    coefficients: terms, and for each word its coefficient. A sentence for each other control is added to the remarks.
    """
    kept, slopes = list[Control](), dict[tuple[Term, ...], Vector]()

    def words_at(values: Mapping[Control, float]) -> Vector:
        with open_at(values) as (_, found):
            if found.words.shape != base.shape:
                raise ScenarioError("it changes the size of the stop's memory")
            with np.errstate(invalid="ignore"):  # infinite words, which do not change
                return np.where(found.words.view(np.uint64) == base.view(np.uint64), 0.0, found.words - base)

    def missing(values: Mapping[Control, float]) -> Vector:
        """Return the change of each word that the coefficients do not explain."""
        found, expected = words_at(values), np.zeros(base.shape)
        for terms, slope in slopes.items():
            if all(control in values for control, _ in terms):
                expected += slope * prod(control.step(values[control], power) for control, power in terms)
        size = np.abs(base) + np.abs(base + found)
        return np.where(np.abs(found - expected) <= _ROUNDING * size, 0.0, found - expected)

    def add(*terms: Term, where: Mask | Literal[True] = True) -> None:
        rest = missing({control: control.high for control, _ in terms})
        slopes[terms] = np.where(where, rest / prod(c.step(c.high, power) for c, power in terms), 0.0)

    for control in controls:
        try:
            add((control, 1))
            is_curved = missing({control: control.low}) != 0.0
            slopes[((control, 1),)][is_curved] = 0.0
            if is_curved.any() and control.start:
                add((control, -1), where=is_curved)
            for other in kept:
                add((other, 1), (control, 1))
            if missing({control: control.low}).any() or missing({each: each.low for each in (*kept, control)}).any():
                raise ScenarioError("the stop depends on it by no formula that the page has")
            kept.append(control)
        except (ScenarioError, FmuError) as problem:
            slopes = {terms: slope for terms, slope in slopes.items() if control not in dict(terms)}
            remarks.append(f"The page is without a slider of the {control.name}: {problem}.")
    return kept, [
        [[[control.name, power] for control, power in terms], [[int(at), slope[at]] for at in np.flatnonzero(slope)]]
        for terms, slope in slopes.items()
        if slope.any()
    ]


def _thresholds(
    law: str, stop: _StopAtStart, open_at: _OpenAt, objects: CustomParts, remarks: list[str]
) -> list[JsonObject]:
    """Return the parameters of a law that the page may change, and those that each of them must not exceed."""
    kind: type[GroupLaw] = law_named(law) or class_of(Custom(kind=law), "controllers", objects.folders)
    tuning, names = kind.tuning, [variable.name for variable in stop.law.formula.parameters]
    values = dict(zip(names, stop.law.parameters.tolist(), strict=True))
    free = {name: unit for name, unit in tuning.units().items() if values.get(name)}
    first = stop.image.places.get(stop.law.parameters.ctypes.data, 0)
    places = {name: first + names.index(name) for name in free}
    raised, scaled = stop.words.copy(), {name: 1.05 * values[name] for name in free}
    for name, place in places.items():
        raised[place] = scaled[name]
    try:
        with open_at({}, *(f"controller.parameters.{n}={v!r}" for n, v in scaled.items())) as (_, found):
            if not np.array_equal(found.words.view(np.uint64), raised.view(np.uint64)):
                raise ScenarioError("other parts of the stop depend on them")
    except ScenarioError as problem:
        remarks.append(f"The page is without the parameters of {law}: {problem}.")
        return []
    every = {name: value for name, value in values.items() if name in tuning.meanings()}

    def is_valid(**changes: float) -> bool:
        with suppress(ValueError):
            return bool(tuning(**every | changes))
        return False

    return [
        {
            "name": name,
            "unit": unit,
            "meaning": tuning.meanings()[name][1],
            "place": places[name],
            "start": values[name],
            "below": [
                other
                for other in free
                if is_valid(**{name: 0.99 * values[other]}) and not is_valid(**{name: 1.01 * values[other]})
            ],
        }
        for name, unit in free.items()
    ]
