"""A train as a Modelica class of a plant, made of components of RailBraking."""

import re
from collections.abc import Iterable, Sequence
from itertools import accumulate
from typing import Any, NamedTuple

from railgrip.base.groups import gather
from railgrip.report.page import render
from railgrip.rolling_stock.schema import BogieInTrain, BrakePipe, Train
from railgrip.rolling_stock.stopping import wire_of

CELLS_OF_A_CAR = 5
"""Cells of the brake pipe in each car: an odd number, so that the branch is in the middle of the car.

Through ten coaches the front is within 0.5 % of its limit on finer grids, with accelerators within 2 %.
"""


def class_name(train: Train, *, pneumatic: bool) -> str:
    """Return the name of a train's class: an identifier from the name of the train, unique for each name."""
    return f"Train_{_identifier(train.name)}{'_pneumatic' if pneumatic else ''}"


_RELEASE = 17.0  # s, of RailBraking.Pneumatics.PartialDistributor
_RIGGING = {
    "A_piston": "piston_area",
    "i_rigging": "rigging",
    "eta_rigging": "efficiency",
    "F_spring": "spring_force",
}
_SUSPENSION = {"h_frame": "frame_height", "h_rod": "rod_height", "k_primary": "stiffness", "c_primary": "damping"}
_RESISTANCE = {
    "c_drag": "drag_coefficient",
    "A_drag": "frontal_area",
    "mu_bearing": "bearing_friction",
    "r_bearing": "bearing_radius",
    "e_rolling": "rolling_arm",
}


def nominal_data(train: Train) -> dict[str, float]:
    """Return the parameters of a train's class and their values, arrays by element, such as `J[2]`."""
    arrays: dict[str, Sequence[float]] = dict(_parameters(train, _body_of_car(train)))
    arrays |= _equipment(train)
    # With the digits of the class.
    data = {f"{name}[{i}]": float(_digits(value)) for name, each in arrays.items() for i, value in enumerate(each, 1)}
    return data | {name: getattr(train.physics, key) for name, key in _RESISTANCE.items()}


def class_text(train: Train, *, pneumatic: bool) -> str:
    """Return the Modelica text of a train's class, with brake valves or with commanded cylinder pressures."""
    body_of_car = _body_of_car(train)
    bogies = train.bogies_in_train
    carriers = [body_of_car[axle.car] for axle in train.axles]
    kinds = {_identifier(bogie.kind): bogie for bogie in bogies}
    return render(
        "rolling_stock/plant.mo.jinja",
        name=class_name(train, pneumatic=pneumatic),
        title=_text(train.description or train.name),
        train=train,
        pneumatic=pneumatic,
        groups=len(train.groups),
        wheelsets=len(train.axles),
        parameters=_parameters(train, body_of_car),
        equipment=_equipment(train),
        bogies=[_bogie(train, bogie, body_of_car) for bogie in bogies],
        kinds=[
            {"id": kind, "pads": bogie.pads, "law": bogie.law, "blocks": bogie.brake.blocks}
            for kind, bogie in kinds.items()
        ],
        linear_resistance=train.linear_resistance,
        bodies=[
            {
                # A sum of parameters: a change of m_wheelset changes the body, too.
                "mass": f"sum(m_wheelset[{carriers.index(body) + 1}:{len(carriers) - carriers[::-1].index(body)}])",
                "title": _text(
                    ", ".join(car.name for car, of in zip(train.cars, body_of_car, strict=True) if of == body)
                ),
            }
            for body in range(body_of_car[-1] + 1)
        ],
        couplers=[train.couplers[car.coupler] for car in train.cars if car.coupler],
        **_rail_brakes(train, body_of_car),
        **_blended(train, body_of_car, pneumatic=pneumatic),
        commands=_sharing(train.groups_per_valve),
        array=_array,
        lowest=_lowest,
        total=_total,
        of_groups=lambda part, member: _of_groups(train, part, member),
        **_command(train, body_of_car),
    )


def _body_of_car(train: Train) -> list[int]:
    # Cars that no coupler joins move as one body.
    return list(accumulate((int(car.coupler is not None) for car in train.cars[:-1]), initial=0))


def _equipment(train: Train) -> dict[str, list[float]]:
    """Return rigging of each group, and suspension and number of wheelsets of each bogie, by their parameters."""
    brakes, bogies = [train.bogie_of(group).brake for group in range(len(train.groups))], train.bogies_in_train
    values = {name: [float(getattr(brake, key)) for brake in brakes] for name, key in _RIGGING.items()}
    values |= {name: [getattr(bogie.data, key) for bogie in bogies] for name, key in _SUSPENSION.items()}
    wheelsets: list[float] = [len(bogie.axles) for bogie in bogies]
    return values | {"wheelsets_per_bogie": wheelsets}


def _parameters(train: Train, body_of_car: Sequence[int]) -> dict[str, Sequence[float]]:
    axles, groups, bogies = train.axles, train.groups, train.bogies_in_train
    carriers = [body_of_car[axle.car] for axle in axles]
    bogie_of_group = [train.bogie_of(number) for number in range(len(groups))]
    return {
        "wheelsets_per_group": [len(members) for members in groups],
        "wheelsets_per_car": [carriers.count(body) for body in range(body_of_car[-1] + 1)],
        "wheelset_position": [axle.position - axles[0].position for axle in axles],
        "m_wheelset": [axle.mass for axle in axles],
        "m_unsprung": [bogies[axle.bogie].data.axle_mass for axle in axles],
        "m_frame": [bogie.data.frame_mass for bogie in bogies],
        "I_frame": [bogie.data.frame_inertia for bogie in bogies],
        "wheelbase": [bogie.data.wheelbase for bogie in bogies],
        "J": [sum(axles[i].inertia for i in members) for members in groups],
        "r_wheel": [bogie.data.wheel_radius for bogie in bogie_of_group],
        "n_units": [sum(axles[i].units for i in members) for members in groups],
        "r_friction": [bogie.brake.friction_radius for bogie in bogie_of_group],
        "p_max": [bogie.brake.pressure_max for bogie in bogie_of_group],
        "mu_b_nominal": [bogie.pad_friction for bogie in bogie_of_group],
        "mu_b_start": [bogie.pad_friction for bogie in bogie_of_group],
    }


def _bogie(train: Train, bogie: BogieInTrain, body_of_car: Sequence[int]) -> dict[str, object]:
    first = bogie.axles[0]
    groups = [
        {
            "number": number,
            "n": len(members),
            "w": _places(members),
            "places": _places([axle - first for axle in members]),
        }
        for number, members in enumerate(train.groups, start=1)
        if members[0] in bogie.axles
    ]
    return {
        "title": bogie.kind,
        "kind": _identifier(bogie.kind),
        "n": len(bogie.axles),
        "groups": groups,
        "force": " + ".join(f"sum(wheels{group['number']}.F)" for group in groups),
        "torque": " + ".join(f"wheels{group['number']}.torque" for group in groups),
        "g": f"{groups[0]['number']}:{groups[-1]['number']}",
        "w": _places(bogie.axles),
        "body": body_of_car[bogie.cars[0]] + 1,
    }


def _places(axles: Sequence[int]) -> str:
    return f"{axles[0] + 1}:{axles[-1] + 1}"


def _blended(train: Train, body_of_car: Sequence[int], *, pneumatic: bool) -> dict[str, Any]:
    """Return dynamic brakes, relieved valves, and the expressions that connect them."""
    supply, blending = _command(train, body_of_car)["supply_of_group"], _blending(train)
    place_of_valve = {valve: place for place, valve in enumerate(train.blended_valves, start=1)}
    dynamics = [
        {
            "brake": each.brake,
            "law": each.brake.law(each.units),
            "force": each.brake.largest(each.units, each.load),
            "group": each.group + 1,
            "body": body_of_car[train.axles[train.groups[each.group][0]].car] + 1,
            "place": 0 if each.brake.blending == "added" else place_of_valve[each.valve],
        }
        for each in train.dynamic_groups
    ]

    def demanded(group: int, valve: range) -> str:
        if pneumatic and train.command is None:
            return f"if applied then p_max[{group}] else 0"
        limit = f"p_max[{group}]" + (f"*available[{supply[group - 1]}]" if train.command else "")
        return limit if pneumatic else f"noEvent(min({_lowest('pressure_command', valve)}, {limit}))"

    def of_place(member: str, place: int) -> str:
        return " + ".join(f"dynamic{i}.{member}" for i, d in enumerate(dynamics, 1) if d["place"] == place) or "0"

    return {
        "dynamics": dynamics,
        "blending": blending,
        "relieved": {group: place for place, valve in enumerate(blending, 1) for group in valve.groups},
        "demanded": demanded,
        "of_place": of_place,
    }


def _rail_brakes(train: Train, body_of_car: Sequence[int]) -> dict[str, Any]:
    """Return the brakes on the rail with the equations of their demands, and the power of all dynamic brakes."""
    conditions = {
        "emergency": "applied and brake_demand >= 1" if train.command else "applied",
        "magnets": "applied and magnets > 0.5",
    }
    powers = [f"motor{number}.power" for number in range(1, len(train.dynamic_groups) + 1)]
    brakes: list[dict[str, object]] = []
    for number, (bogie, _, brake) in enumerate(train.rail_brakes, start=1):
        name, body = f"{brake.instance}{number}", body_of_car[bogie.cars[0]] + 1
        demand = brake.demand(name, conditions[brake.condition])
        brakes.append({"name": name, "brake": brake, "body": body, "demand": demand})
        powers += [f"{name}.force*body{body}.v"] if brake.is_dynamic else []
    return {"rail_brakes": brakes, "dynamic_power": " + ".join(powers)}


class _RelievedValve(NamedTuple):
    """Its groups, rim force over pressure beyond the springs [N/Pa], and the pressure of the springs [Pa]."""

    groups: list[int]
    slope: float
    spring: float


def _blending(train: Train) -> list[_RelievedValve]:
    """Return the valves that dynamic brakes relieve."""
    valves: list[_RelievedValve] = []
    for valve in train.blended_valves:
        groups = [group for group, of in enumerate(train.valve_of_group) if of == valve]
        brake = train.bogie_of(groups[0]).brake
        lever = sum(
            train.axles[i].units * bogie.pad_friction * brake.friction_radius / bogie.data.wheel_radius
            for group in groups
            for bogie in [train.bogie_of(group)]
            for i in train.groups[group]
        )
        slope = lever * brake.efficiency * brake.rigging * brake.piston_area
        spring = brake.spring_force / brake.piston_area
        valves.append(_RelievedValve([group + 1 for group in groups], slope, spring))
    return valves


def _command(train: Train, body_of_car: Sequence[int]) -> dict[str, Any]:
    axles = [train.axles[members[0]] for members in train.groups]
    cars = [axle.car + 1 for axle in axles]
    values = {"command": train.command, "air": train.air, "car_of_group": cars}
    if isinstance(train.command, BrakePipe):
        # Through the pipe each car has its own pressure.
        return values | {"has_reservoirs": True, "supply_of_group": cars} | _pipe(train, train.command, body_of_car)
    # By wire all with the same build-up have the same pressure.
    of_bogie = [wire_of(train, number) for number in range(len(train.bogies_in_train))] if train.command else []
    wires = list(dict.fromkeys(of_bogie))
    supply = [wires.index(of_bogie[axle.bogie]) + 1 if wires else 1 for axle in axles]
    reservoirs = {"has_reservoirs": train.air is not None}
    return values | reservoirs | {"available": wires or [1.0], "wires": wires, "supply_of_group": supply}


def _pipe(train: Train, pipe: BrakePipe, body_of_car: Sequence[int]) -> dict[str, Any]:
    pressures = gather((axle.car, train.bogies_in_train[axle.bogie].brake.pressure_max) for axle in train.axles)
    available = [max(pressures[number]) for number in range(len(train.cars))]
    stages, distributors, filling = train.stages_of_car, train.distributor_of_car, train.filling_of_car
    single, two_stage = ([i for i, of_car in enumerate(stages) if (of_car is None) == plain] for plain in (True, False))
    # A car without times of its own has those of [command], and the default release.
    release = [_RELEASE if d is None or d.release_time is None else d.release_time for d in distributors]
    has_times = [
        d is not None and (d.fill_time is not None or d.release_time is not None or d.inshot > 0) for d in distributors
    ]
    part_of_car = {car: f"distributor[{number}]" for number, car in enumerate(single, start=1)}
    part_of_car |= {car: f"two_stage{number}" for number, car in enumerate(two_stage, start=1)}
    # Each car has one branch, at the cell in its middle.
    middle = CELLS_OF_A_CAR // 2
    branch_volumes = [0.0] * CELLS_OF_A_CAR
    branch_volumes[middle] = pipe.branch_volume
    return {
        "available": available,
        "distributor_of_car": part_of_car,
        "single_stage": [available[car] for car in single],
        "times_of_single": (
            {
                "T_fill": [filling[car][0] for car in single],
                "T_release": [release[car] for car in single],
                "inshot": [filling[car][1] for car in single],
            }
            if any(has_times[car] for car in single)
            else {}
        ),
        "two_stages": [
            {
                "distributor": stages[car],
                "pressure": available[car],
                "body": body_of_car[car] + 1,
                "fill_time": filling[car][0],
                "times": {"T_release": release[car], "inshot": filling[car][1]} if has_times[car] else {},
            }
            for car in two_stage
        ],
        "accelerators": [
            {"accelerator": vent, "car": car} for car, vent in enumerate(train.accelerator_of_car) if vent is not None
        ],
        "lengths": [car.length / CELLS_OF_A_CAR for car in train.cars for _ in range(CELLS_OF_A_CAR)],
        "branch_of_car": [CELLS_OF_A_CAR * number + middle + 1 for number in range(len(train.cars))],
        "branch_volumes": branch_volumes * len(train.cars),
    }


def _sharing(groups_per_valve: Sequence[int]) -> list[range]:
    last = list(accumulate(groups_per_valve))
    valves = zip(last, groups_per_valve, strict=True)
    return [range(end - count + 1, end + 1) for end, count in valves for _ in range(count)]


def _lowest(signal: str, groups: range) -> str:
    # A valve of several groups vents if one of them demands it.
    first, *others = (f"{signal}[{number}]" for number in groups)
    for other in others:
        first = f"noEvent(min({first}, {other}))"
    return first


def _total(member: str, part: str, parts: Sequence[object]) -> str:
    return " + ".join(f"{part}{number}.{member}" for number in range(1, len(parts) + 1))


def _of_groups(train: Train, part: str, member: str) -> str:
    # The sum over all groups, that of each bogie first.
    groups = enumerate(train.groups, start=1)
    of_bogie = gather((train.axles[members[0]].bogie, f"{part}{number}.{member}") for number, members in groups)
    return " + ".join(f"({' + '.join(members)})" for members in of_bogie.values())


def _array(values: Iterable[float]) -> str:
    return "{" + ", ".join(map(_digits, values)) + "}"


def _digits(value: float) -> str:
    return f"{value:.10g}"


def _identifier(name: str) -> str:
    # Different names must give different identifiers: an underscore is doubled, and any character other than letters
    # and digits of ASCII becomes its code between underscores.
    return re.sub(r"[^A-Za-z0-9]", lambda found: "__" if found[0] == "_" else f"_{ord(found[0]):x}_", name)


def _text(words: str) -> str:
    return words.replace("\\", "\\\\").replace('"', '\\"')
