"""From a file to a braking model: a train file by its calculation by hand and K_dry, or a file of curves."""

from collections.abc import Callable
from functools import cache
from pathlib import Path

from railgrip.rolling_stock.check import checked_train, fastest_stop
from railgrip.rolling_stock.dispersion import Dispersion, Failures
from railgrip.rolling_stock.schema import BrakePipe, EtcsData, Train
from railgrip.rolling_stock.stopping import by_hand
from railgrip.scenario.file import locate
from railgrip.scenario.load import read_toml, validate_table
from railgrip.scenario.table import Table
from railgrip.supervision import fixed
from railgrip.supervision.conversion import service_times
from railgrip.supervision.curve import Steps
from railgrip.supervision.dispersed import TrainBrake, speed_steps
from railgrip.supervision.k_dry import QuasiStatic, k_factors
from railgrip.supervision.model import BrakingModel, TrainData
from railgrip.supervision.national import NationalValues

_SEED, _RUNS, _SAMPLES = 2026, 4, 500


class BrakeData(Table):
    """Data for ETCS that a train file may have."""

    etcs: EtcsData
    dispersion: tuple[Dispersion, ...]
    failures: Failures


@cache
def _defaults() -> BrakeData:
    path = Path(__file__).parent / "library" / "brakes.toml"
    return validate_table(BrakeData, read_toml(path), directory=path.parent, origin=path.name)


def data_of(train: Train) -> BrakeData:
    """Return the data of a train for ETCS; what its file lacks are estimates of `library/brakes.toml`."""
    usual = _defaults()
    return BrakeData(
        etcs=train.etcs or usual.etcs,
        dispersion=train.dispersion or usual.dispersion,
        failures=train.failures or usual.failures,
    )


def brake_of(train: Train) -> TrainBrake:
    """Return the brake of a train in steps up to the highest speed that ETCS supervises.

    Raises:
        InputError: The train does not stop.
    """
    data = data_of(train)
    fastest = maximum_speed(train)
    margin = float(fixed.ceiling_margin("EBI", fastest) + fixed.under_reading(fastest))
    return TrainBrake(train, data.dispersion, (fastest + margin, *speed_steps(train, fastest)[1:]))


def maximum_speed(train: Train) -> float:
    """Return the maximum speed of a train, or that of its fastest published stop [m/s]."""
    return data_of(train).etcs.maximum_speed or fastest_stop(train)


def model_of_train(
    train: Train, national: NationalValues, notify: Callable[[str], None] = lambda what: None
) -> tuple[BrakingModel, QuasiStatic]:
    """Return the braking model of a train file (§3.13.2.2), and its K factors.

    A_brake_emergency(V) and T_brake_emergency are those of its stop by hand, which they reproduce; K_dry_rst(V) comes
    from dispersion and failures. Full service braking has the same brakes without magnets.

    Raises:
        InputError: The train does not stop.
    """
    data, brake, fastest = data_of(train), brake_of(train), maximum_speed(train)
    factors = k_factors(
        brake, data.failures, seed=_SEED, runs=_RUNS, samples=_SAMPLES, guides=[len(brake.nominal) - 1], notify=notify
    )
    starts = brake.speeds[:0:-1]
    level = national.M_NVEBCL
    k_dry = [(start, of[level].value) for start, of in zip(starts, factors.k, strict=False)]
    emergency_time, service_time = brake.equivalent_time, data.etcs.service_time
    if service_time is None and isinstance(train.command, BrakePipe):
        service_time = service_times(data.etcs.brake_position, train.length)[0]
    service_time = emergency_time if service_time is None else service_time
    model = BrakingModel(
        name=train.name,
        length=train.length,
        maximum_speed=fastest,
        position=data.etcs.brake_position,
        emergency=Steps.of(list(zip(starts, brake.nominal.tolist(), strict=False))),
        k_dry=Steps.of(k_dry),
        k_wet=Steps.constant(data.etcs.k_wet),
        service=Steps.of(list(zip(starts, brake.service_decelerations().tolist(), strict=True))),
        emergency_times=(emergency_time, emergency_time),
        service_times=(service_time, service_time),
        cut_off_time=data.etcs.traction_cut_off_time,
        without_adhesion=data.etcs.brakes_without_adhesion,
        rotating=100 * by_hand(train, fastest).rotating_mass / train.mass,
    )
    return model, factors


def read_train(file: Path) -> Train | TrainData:
    """Return a train file, a train of this package by its name, or a file of curves.

    Raises:
        InputError: The file cannot be read or is wrong; one sentence for each problem, with file and key.
    """
    path = locate(file, "trains")
    table = read_toml(path)
    if "cars" in table:
        return checked_train(path)
    return validate_table(TrainData, table, directory=path.parent, origin=path.name)
