"""Drafts of a scenario's tables for a foreign FMU: by names and, for a plant, corrected by a short run."""

import itertools
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import product
from typing import Any

import numpy as np

from railgrip.base.names import ElementName
from railgrip.base.tables import TomlTable
from railgrip.base.units import GRAVITY, mistake, mistaken_factor
from railgrip.controllers.law import FULL_PRESSURE
from railgrip.fmi import Description, Port, bind, open_plant, shared_budget
from railgrip.fmi.description import Causality
from railgrip.fmi.draft import draft_mapping, sizes_of
from railgrip.fmi.mapping import known_unit
from railgrip.scenario.file import inline_toml
from railgrip.simulate.bound_plant import plant_signals
from railgrip.simulate.controller import controller_signals
from railgrip.simulate.loop.plausible import slowing_of
from railgrip.simulate.named_models import parameters_of
from railgrip.simulate.plant_trial import LONGEST_TRIAL, SignalCheck, Trial, TrialPlant, Trials, findings
from railgrip.simulate.vehicle_data import catalogue_brakes, catalogue_counts
from railgrip.vehicle.formation import Formation, carried_mass
from railgrip.vehicle.parameters import (
    COUNTS,
    DESCRIPTIVE,
    array_of,
    counts_of,
    meanings_of_brakes,
    units_of_nominal_data,
    with_each,
)
from railgrip.vehicle.signals import layout_of

_SMALLEST, _LARGEST = 0.25, 0.7
"""Radii of wheels on rails [m]: of a car carrier and of a steam locomotive's carrying wheels, with a margin."""
_UNITS = {
    ("m/s", 3.6): "km/h", ("Pa", 1e-5): "bar", ("Pa", 1e-3): "kPa", ("m", 1e-3): "km", ("m", 1e3): "mm",
    ("1", 100.0): "percent",
}  # fmt: skip
"""(SI unit, factor of a mistake) → unit to state in the map for a variable without a declared unit."""
_PRESSURES = (1e5, 1e3, 1e6, -1.0)
"""Factors for commands in bar, kPa or MPa, or with the opposite sign."""
_ROUNDS = 6
_NAMED = 20
"""Number of unused variables that are listed: an FMU may have thousands of parameters."""


@dataclass(frozen=True, slots=True)
class SignalMapping:
    """One signal of [vehicle.map].

    Attributes:
        signal: Port of the harness.
        variables: Name, pattern or names in the FMU.
        scale: Value in the harness over value in the FMU, after conversion of units.
        unit: Unit stated for a variable without one; "" if the FMU declares it, or if none is needed.
    """

    signal: Port
    variables: str | tuple[str, ...]
    scale: float
    unit: str

    def rescale(self, factor: float) -> "SignalMapping":
        """Return the entry with harness values `factor` times as large, by another unit where that expresses it."""
        unit = _UNITS.get((self.signal.unit, _round(1.0 / factor))) if self.unit == self.signal.unit else None
        return replace(self, unit=unit) if unit else replace(self, scale=_round(self.scale * factor))

    @property
    def plain(self) -> Any:
        """The entry as a table has it."""
        if isinstance(self.variables, tuple):
            return [replace(self, variables=name).plain for name in self.variables]
        if not self.unit and abs(self.scale) == 1.0:
            return f"-{self.variables}" if self.scale < 0 else self.variables
        sign, scale = ("-", -self.scale) if self.scale < 0 else ("", self.scale)
        details: TomlTable = {"variable": f"{sign}{self.variables}"}
        return details | ({"unit": self.unit} if self.unit else {}) | ({"scale": scale} if scale != 1.0 else {})


@dataclass(frozen=True, slots=True, kw_only=True)
class MappingDraft:
    """Tables of a scenario for an FMU.

    Attributes:
        table: Entries of the map by signal.
        missing: Signals that the FMU must have and that were not found.
        unused: If signals are missing, the inputs, outputs and parameters of the FMU that the table does not use.
        formation: Groups and wheelsets of the FMU.
        declared: Names of the parameters by which the FMU itself declares groups, wheelsets or valves.
        nominal: Values for [vehicle.formation] by key, those of its brakes by parameter; from parameters or a run.
        corrections: Corrections of the table after the run, in sentences.
        findings: Results of the run with the table.
    """

    table: Mapping[str, SignalMapping]
    missing: Sequence[Port]
    formation: Formation
    declared: frozenset[str] = frozenset()
    nominal: Mapping[str, Sequence[float]] = field(default_factory=dict[str, Sequence[float]])
    corrections: Sequence[str] = ()
    findings: Sequence[SignalCheck] = ()
    unused: Sequence[str] = ()

    def lines(self) -> Iterator[str]:
        """Yield TOML to paste: the map, everything else that a run requires, and the results of the run as comments."""
        yield "[vehicle.map]"
        yield from self.map_lines()
        for signal in self.missing:
            yield f"# {signal.name} = ?  # needed, in {signal.unit}: no similar variable was found"
        if self.missing:
            yield f"# not used: {_some(self.unused) or 'none'}"
            yield "# add the missing lines; without a short run, units that the FMU does not declare are assumptions"
        yield ""
        yield "[vehicle.formation]"
        if COUNTS not in self.declared:
            yield f"{COUNTS} = {list(self.formation.wheelsets_per_group)}"
        yield self._nominal_line("wheelset_load", "static force of each wheelset on the rail [N]")
        if "wheelset_position" not in self.declared:
            yield (
                "# wheelset_position = ?  # required if adhesion or gradient vary along the track: distance of each "
                "wheelset behind the leading one [m]"
            )
        yield ""
        yield "[vehicle.formation.brakes]"
        always = meanings_of_brakes(FULL_PRESSURE)
        for name, meaning in always.items():
            yield self._nominal_line(name, meaning)
        for name, meaning in meanings_of_brakes().items():
            if name not in always:
                yield self._nominal_line(name, meaning, "required by Kalman filters, redistribution and some laws")
        yield ""
        for sentence in self.corrections:
            yield f"# corrected: {sentence}"
        for finding in self.findings:
            yield f"# {'fits' if finding.good else 'WRONG'}: {finding.signal} {finding.sentence}"

    def map_lines(self) -> Iterator[str]:
        """Yield the entries of the map as TOML."""
        for name, entry in self.table.items():
            yield f"{name} = {inline_toml(entry.plain)}"

    def _nominal_line(self, key: str, meaning: str, use: str = "required") -> str:
        """Return the line of a key of [vehicle.formation]; a comment to complete if its value is not known."""
        if values := self.nominal.get(key):
            return f"{key} = {[float(f'{value:.4g}') for value in values]}"
        return f"# {key} = ?  # {use}: {meaning}"


def controller_lines(description: Description) -> Iterator[str]:
    """Yield TOML to paste for a controller FMU, drafted by names; see `ControllerFmu`."""
    sizes = sizes_of(description, "output") or (1,)
    draft = max((_draft_table(description, *controller_signals(groups)) for groups in sizes), key=len)
    if "demand" in draft:
        draft.pop("command", None)
    yield "[controller]"
    yield 'kind = "fmu"'
    yield f"file = {inline_toml(description.file.name)}"
    yield ""
    yield "[controller.map]"
    yield from MappingDraft(table=draft, missing=(), formation=Formation((1,))).map_lines()
    if not {"demand", "command"} & draft.keys():
        yield "# demand = ?  # required, in Pa: the brake cylinder pressure of each group"
    if unused := _unused_variables(description, draft, max(sizes), ("input", "output")):
        yield f"# not used: {_some(unused)}"


def find_mapping(
    description: Description,
    *,
    wheelsets_per_group: tuple[int, ...],
    speed: float,
    period: float,
    notify: Callable[[str], None] = lambda sentence: None,
) -> MappingDraft:
    """Return a mapping that agrees with a short run of the FMU, as far as such a mapping exists.

    Args:
        description: Description of the FMU.
        wheelsets_per_group: Formation; if empty, it is read from the FMU's parameters or guessed from its arrays.
        speed: Initial speed of the run [m/s].
        period: Communication period of the run [s].
        notify: Called with a sentence before each trial run.

    Raises:
        FmuError: The FMU does not fit.
        PlantFailed: The run ended early.
    """
    declared = frozenset(ElementName.of(name).array for name in description.names("parameter")) & DESCRIPTIVE.keys()
    draft = replace(_draft_mapping(description, wheelsets_per_group), declared=declared)
    if draft.missing:
        kinds: Sequence[Causality] = ("input", "output", "parameter")
        unused = _unused_variables(description, draft.table, draft.formation.wheelsets, kinds)
        draft = replace(draft, unused=unused)
    else:
        first_draft, numbers = draft, itertools.count(1)

        def run(table: Mapping[str, SignalMapping]) -> Trials:
            notify(f"{description.file.name}: trial run {next(numbers)}")
            return _run(description, first_draft.formation, table, speed=speed, period=period)

        with shared_budget():
            draft = _correct(draft, run, speed)
    return replace(draft, nominal={**draft.nominal, **_nominal_parameters(description, draft.formation)})


def _nominal_parameters(description: Description, formation: Formation) -> dict[str, tuple[float, ...]]:
    units = units_of_nominal_data(formation)
    values = {
        name: value
        for name, value in parameters_of(description).items()
        if name in units and description.variables[name].unit in ("", units[name])
    }
    each = with_each(values, formation)
    data = {name: array_of(each, name) for name in meanings_of_brakes()}
    load = tuple(mass * GRAVITY for mass in array_of(each, "m_wheelset"))
    return {name: found for name, found in (data | {"wheelset_load": load}).items() if found}


def _draft_table(
    description: Description, inputs: Sequence[Port], outputs: Sequence[Port], parameters: Sequence[Port] = ()
) -> dict[str, SignalMapping]:
    kinds: dict[Causality, Sequence[Port]] = {"input": inputs, "output": outputs, "parameter": parameters}
    signals: dict[str, tuple[Port, Causality]] = {
        port.name: (port, kind) for kind, ports in kinds.items() for port in ports
    }
    found = draft_mapping(description, signals)
    return {name: _entry(description, signals[name][0], variables) for name, variables in found.items()}


def _draft_mapping(description: Description, wheelsets_per_group: tuple[int, ...]) -> MappingDraft:
    declared = wheelsets_per_group or counts_of(parameters_of(description))
    sizes = [(1,) * size for size in sizes_of(description, "input")]
    choices = [declared] if declared else [catalogue_counts(), *sizes, (1,)]
    drafts: list[MappingDraft] = []
    for counts in choices:
        inputs, outputs, start = plant_signals(layout_of(Formation(counts)), pneumatic=False, track_force=False)
        table = _draft_table(description, inputs, outputs, [start])
        missing = [port for port in (*inputs, *outputs, start) if port.needed and port.name not in table]
        drafts.append(MappingDraft(table=table, missing=missing, formation=Formation(counts)))
    return min(drafts, key=lambda draft: len(draft.missing))


def _unused_variables(
    description: Description, table: Mapping[str, SignalMapping], count: int, kinds: Sequence[Causality]
) -> list[str]:
    """Return the variables of some kinds that no entry of a table names, with arrays of up to `count` elements."""
    used = {name for entry in table.values() for name in _variables(entry, count)}
    return [name for kind in kinds for name in description.names(kind) if name not in used]


def _variables(entry: SignalMapping, count: int) -> Iterator[str]:
    for name in (entry.variables,) if isinstance(entry.variables, str) else entry.variables:
        yield from (name.replace("{i}", str(i)) for i in range(1, count + 1))


def _some(names: Sequence[str]) -> str:
    return ", ".join([*names[:_NAMED], *(["…"] if len(names) > _NAMED else [])])


def _entry(description: Description, signal: Port, variables: str | tuple[str, ...]) -> SignalMapping:
    names = (variables,) if isinstance(variables, str) else variables
    scale = -1.0 if names[0].startswith("-") else 1.0
    bare = tuple(name.removeprefix("-") for name in names)
    first = description.variables[bare[0].replace("{i}", "1")]
    unit = "" if known_unit(first) is not None or signal.unit == "1" else signal.unit
    return SignalMapping(signal, bare[0] if isinstance(variables, str) else bare, scale, unit)


Run = Callable[[Mapping[str, SignalMapping]], Trials]
"""Function that runs the FMU with a table."""


def _run(
    description: Description, formation: Formation, table: Mapping[str, SignalMapping], *, speed: float, period: float
) -> Trials:
    layout = layout_of(formation)
    inputs, outputs, start = plant_signals(layout, pneumatic=False, track_force=False)
    binding = bind(
        description,
        inputs=inputs,
        outputs=outputs,
        parameters=(start,),
        table={name: entry.plain for name, entry in table.items()},
        where="the draft of [vehicle.map]",
    )
    opening = partial(
        open_plant, description, binding, period=period, parameters=binding.translate({"start_speed": speed}),
        trusted=False, notify=lambda sentence: None, span=(0.0, LONGEST_TRIAL),
    )  # fmt: skip
    full = tuple(group.pressure_max for group in catalogue_brakes(formation.groups))
    release = (0.0,) * formation.groups
    return TrialPlant(opening=opening, layout=layout, period=period, release=release, brake=full).trials()


def _rescale(trials: Trials, factors: Mapping[str, float]) -> Trials:
    def one(trial: Trial) -> Trial:
        rows = trial.rows.copy()
        for name, factor in factors.items():
            rows[:, trial.layout.output[name]] *= factor
        return replace(trial, rows=rows)

    return one(trials[0]), one(trials[1])


def _radius(trial: Trial) -> list[float]:
    """Return speed over wheel speed of each group at the end of coasting [m]."""
    outputs, last = trial.layout.output, trial.coasting - 1
    wheels = trial.rows[last, outputs["wheelset_speed"]]
    with np.errstate(divide="ignore", invalid="ignore"):
        return (float(trial.rows[last, outputs["speed"].start]) / wheels).tolist()


def _judge_trials(trials: Trials, formation: Formation, speed: float) -> list[SignalCheck]:
    groups, measured = catalogue_brakes(formation.groups), _radius(trials[0])
    radius = [
        radius_ if _SMALLEST <= radius_ <= _LARGEST else group.wheel_radius
        for radius_, group in zip(measured, groups, strict=True)
    ]
    slowing = slowing_of(carried_mass(sum(group.load for group in groups)), is_known=False)
    pressure = tuple(group.pressure_max for group in groups)
    return list(findings(*trials, speed=speed, radius=tuple(radius), pressure=pressure, slowing=slowing))


Factors = Mapping[str, float]
"""Signal → factor on its values in the harness."""


def _correct(draft: MappingDraft, run: Run, speed: float) -> MappingDraft:
    table, corrections = dict(draft.table), list[str]()
    trials = run(table)
    found = _judge_trials(trials, draft.formation, speed)
    for _ in range(_ROUNDS):
        wrong = [finding for finding in found if not finding.good]
        best: tuple[int, Factors, Trials, list[SignalCheck]] | None = None
        for factors in _proposals(wrong, trials[0]):
            # The run is repeated only if an input is corrected.
            needs_run = not factors.keys() <= trials[0].layout.output.keys()
            changed = run(_apply_correction(table, factors)) if needs_run else _rescale(trials, factors)
            after = _judge_trials(changed, draft.formation, speed)
            count = _doubt(after)
            if count < (_doubt(found) if best is None else best[0]):
                best = count, factors, changed, after
            settled = not any(ElementName.of(f.signal).array in factors for f in after if not f.good)
            if count == 0 or (needs_run and count < _doubt(found) and settled):
                break
        if best is None:
            break
        _, factors, trials, found = best
        corrections += [_sentence(name, factor, found=wrong) for name, factor in factors.items()]
        table = _apply_correction(table, factors)
    for name in {ElementName.of(finding.signal).array for finding in found if not finding.good} & table.keys():
        if not table[name].signal.needed:
            del table[name]
            corrections.append(f"{name} is left out, for what was found does not fit")
            found = [finding for finding in found if ElementName.of(finding.signal).array != name]
    radius = [radius for radius in _radius(trials[0]) if _SMALLEST <= radius <= _LARGEST]
    nominal = {"r_wheel": radius} if len(radius) == draft.formation.groups else {}
    load = trials[0].output("wheelset_load")[trials[0].coasting - 1]
    if np.isfinite(load).all():
        nominal["wheelset_load"] = load.tolist()
    return replace(draft, table=table, nominal=nominal, corrections=corrections, findings=found)


def _doubt(found: Sequence[SignalCheck]) -> int:
    """Return a weighted number of contradictions; a train that does not brake hides other mistakes."""
    return sum(3 if finding.signal == "pressure_command" else 1 for finding in found if not finding.good)


def _apply_correction(table: Mapping[str, SignalMapping], factors: Factors) -> dict[str, SignalMapping]:
    return {**table, **{name: table[name].rescale(factor) for name, factor in factors.items()}}


def _proposals(wrong: Sequence[SignalCheck], trial: Trial) -> Iterator[Factors]:
    by_signal = {ElementName.of(finding.signal).array: finding for finding in wrong}
    outputs = [name for name in by_signal if name in trial.layout.output]
    single: dict[str, float] = {}
    for name in outputs:
        factor = mistaken_factor(by_signal[name].ratio)
        if factor is not None:
            single[name] = 1.0 / factor
    if "wheelset_speed" in by_signal:
        single |= _wheel_correction(_radius(trial))
    # Speeds in km/h at both ends are one mistake; distance, acceleration and wheels would be three.
    if len({"distance", "wheelset_speed", "acceleration"} & by_signal.keys()) > 1:
        yield {"start_speed": 1 / 3.6, "speed": 1 / 3.6}
    yield from ({name: factor} for name, factor in single.items())
    if len(single) > 1:
        yield single
    start = mistaken_factor(by_signal["speed"].ratio) if "speed" in by_signal else None
    if start is not None:
        yield {"start_speed": start}
    if "mu0" in by_signal:
        yield {"mu0": 0.01}
    if "pressure_command" in by_signal:
        yield from ({"pressure_command": factor, "cylinder_pressure": factor} for factor in _PRESSURES[:3])
        yield from ({"pressure_command": factor} for factor in _PRESSURES)
        yield {"mu0": 0.01}
        yield from ({"pressure_command": factor, "mu0": share} for factor, share in product(_PRESSURES, (0.01,)))


def _wheel_correction(measured: Sequence[float]) -> Factors:
    """Return the usual mistake of the wheel speeds that explains ratios of speed to wheel speed [m].

    The result is empty if none does.
    """
    radius = float(np.median(measured))
    for factor in (-1.0, 3.6, 1 / 3.6, 1 / (2 * np.pi), 30 / np.pi):
        if _SMALLEST <= radius * factor <= _LARGEST:
            return {"wheelset_speed": 1.0 / factor}
    return {}


def _sentence(name: str, factor: float, *, found: Sequence[SignalCheck]) -> str:
    shown = next((finding for finding in found if ElementName.of(finding.signal).array == name), found[0])
    likely = mistake(1.0 / factor) or f"{1.0 / factor:.4g} times what is meant"
    return f"{name} had {likely}; in the first run {shown.signal} {shown.sentence}"


def _round(value: float) -> float:
    return float(f"{value:.12g}")
