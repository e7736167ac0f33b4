"""The parts of a stop as structs of `kernel/cycle.h`."""

import ctypes
from dataclasses import dataclass
from functools import cache

import casadi as ca
import numpy as np

from railgrip.base.errors import LoopError
from railgrip.controllers.sampled import Sampled
from railgrip.estimators.compiled import StepInC
from railgrip.fmi import CoSimulation
from railgrip.fmus.native.c_library import Struct
from railgrip.fmus.native.functions import in_c
from railgrip.fmus.native.toolchain import shared_library
from railgrip.kernel import kernel, rate_of, texts
from railgrip.simulate.loop.parts import BLOCK, Parts, SensorsInC, StateEstimator, Vector
from railgrip.vehicle.signals import BELIEVED, ESTIMATES, Layout, Role, length


@dataclass(frozen=True, slots=True, eq=False)
class Structs:
    """Structs of a stop, each named for its type in cycle.h.

    Attributes:
        filter: None without a filter.
    """

    cycle: Struct
    plant: Struct
    instruments: Struct
    filter: Struct | None
    onboard: Struct
    record: Struct


def structs_of(parts: Parts, inputs: Vector, outputs: Vector) -> Structs:
    """Return the structs of a stop; the functions of parts in Python are null pointers.

    Args:
        parts: Parts of the stop; the plant has been started.
        inputs: Inputs with which the plant has been started.
        outputs: Outputs at the start.

    Raises:
        LoopError: A law is for a different number of groups.
    """
    clock, driver = parts.clock, parts.driver
    plant, instruments, filter_ = _plant(parts, inputs, outputs), _instruments(parts), _filter(parts)
    onboard, record = _onboard(parts), _record(parts)
    cycle = kernel(parts.layout).struct("Cycle", plant=plant, plausibility=parts.plausibility.struct,
        rail=parts.rail.struct, driver=driver.struct if driver.has_phases else None, instruments=instruments,
        faults=parts.faults and parts.faults.struct, filter=filter_, onboard=onboard, record=record,
        period=clock.period, stop_speed=parts.stop_speed, samples=clock.samples, block=BLOCK,
    )  # fmt: skip
    return Structs(cycle, plant, instruments, filter_, onboard, record)


def _plant(parts: Parts, inputs: Vector, outputs: Vector) -> Struct:
    layout, plant = parts.layout, parts.plant
    # A plant without slip outputs leaves NaN there; the cycle then computes slip from speed and wheel speed.
    has_slip = not np.isnan(outputs[layout.output["slip"]]).any()
    radius = None if has_slip else np.array(layout.formation.wheel_radius, dtype=np.float64)
    if not isinstance(plant, CoSimulation):
        return kernel(layout).struct("Plant", inputs=inputs, outputs=outputs, slip_radius=radius)
    plant.inputs[:] = inputs
    return kernel(layout).struct("Plant", step=plant.entry, interface=plant.plan, inputs=plant.inputs,
        outputs=plant.outputs, slip_radius=radius,
    )  # fmt: skip


def _instruments(parts: Parts) -> Struct:
    fields = parts.sensors.fields if isinstance(parts.sensors, SensorsInC) else dict[str, object]()
    return kernel(parts.layout).struct("Instruments", every=parts.clock.sensors, block=BLOCK, **fields)


def _filter(parts: Parts) -> Struct | None:
    layout, estimator = parts.layout, parts.estimator
    if not isinstance(estimator, StateEstimator):
        return None
    filter_ = estimator.filter
    reference = np.zeros(length(layout.places["reference"]))
    reference[layout.places["reference"]["speed"]] = np.nan
    states = [getattr(estimator, signal.name.removeprefix("estimate_")) for signal in BELIEVED]
    struct = kernel(layout).struct("Filter", mean=filter_.mean, covariance=filter_.covariance,
        stride=filter_.covariance.strides[0] // filter_.covariance.itemsize, inputs=filter_.inputs,
        readings=filter_.readings, selection=filter_.selection, squared_innovation=np.zeros(1), reference=reference,
        reading_at=np.ascontiguousarray(estimator.reading_places, dtype=np.longlong),
        reading_count=estimator.reading_places.size, state_at=np.hstack(states).astype(np.longlong),
        reference_speed=_formula(layout, estimator.free_wheel, "reference_input"),
    )  # fmt: skip
    if isinstance(filter_, StepInC):
        advance, memory, squared_innovation = filter_.entry
        struct.set(advance=advance, memory=memory, squared_innovation=squared_innovation)
    return struct


def _onboard(parts: Parts) -> Struct:
    layout, clock, estimator = parts.layout, parts.clock, parts.estimator
    has_states = isinstance(estimator, StateEstimator)
    return kernel(layout).struct("Onboard", law=_formula(layout, parts.controller, "observation"),
        train_level=_formula(layout, parts.train_level, "train_input"),
        valves=_formula(layout, parts.valves, "valve_input"),
        magnets=parts.controller.visible_state("magnets") if isinstance(parts.controller, Sampled) else None,
        maximum=parts.limits and parts.limits.maximum, full=np.array(parts.driver.full, dtype=np.float64),
        radius=np.array(estimator.wheel_radius if has_states else parts.wheel_radius, dtype=np.float64),
        has_estimator=estimator is not None and not has_states,
        estimator_rate=rate_of(layout, clock.estimator), controller_rate=rate_of(layout, clock.controller),
    )  # fmt: skip


def _record(parts: Parts) -> Struct:
    layout, recorder, law = parts.layout, parts.recorder, parts.law
    first = {role: recorder.block(layout.signals[role]).start for role in ("output", "input", "reading")}
    first |= {name: recorder.at.get(name, -1) for name in ("demand", "driver_demand", "traction")}
    struct = kernel(layout).struct("Record", rows=recorder.rows, width=recorder.rows.shape[1],
        capacity=recorder.rows.shape[0], reference=recorder.at.get("reference_speed", -1), **first,
    )  # fmt: skip
    if isinstance(parts.estimator, StateEstimator):
        struct.set(estimate=recorder.block(ESTIMATES).start, estimate_count=length(layout.places["estimate"]))
    if law is not None:
        struct.set(law_state=law.values, law_state_at=law.places, law_count=law.places.size)
        struct.set(law=recorder.block(law.signals).start)
    return struct


def _formula(layout: Layout, formula: object, inputs: Role) -> Struct:
    """Return the struct `Formula`; its function is null if `formula` is not a sampled system.

    Raises:
        LoopError: The inputs of the formula are not the elements of the vector `inputs`, in the same order.
    """
    if not isinstance(formula, Sampled):
        return kernel(layout).struct("Formula")
    name, expected = formula.formula.name, layout.elements(inputs)
    found = tuple(variable.name for variable in formula.formula.inputs)
    if len(found) != len(expected):
        groups = layout.formation.groups
        raise LoopError(f"{name}: takes {len(found)} inputs, and {len(expected)} belong to {groups} groups.")
    for place, (element, signal) in enumerate(zip(found, expected, strict=True), start=1):
        if element != signal:
            raise LoopError(f"{name}: takes {element} as input {place}, which is {signal}.")
    address = _address_of(formula.step)
    return kernel(layout).struct("Formula", call=address, state=formula.state, parameter=formula.parameters)


@cache
def _address_of(step: ca.Function) -> int:
    """Return the address of `evaluate` in formula.c for a function (state, input, parameter) → (state, output).

    Raises:
        railgrip.base.errors.CompilerMissing: No C compiler was found.
    """
    sizes, text = in_c([step])
    macros = "".join(f"#define {name} {size}\n" for name, size in {"STATES": step.numel_out(0), **sizes}.items())
    header = f"{macros}#define CASADI_SYMBOL_EXPORT static\n{text}"
    sources = {"step.h": header} | texts("formula.c", "export.h")
    library = ctypes.CDLL(str(shared_library(sources, "formula")))
    return ctypes.cast(library.evaluate, ctypes.c_void_p).value or 0
