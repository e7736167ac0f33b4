"""Estimates from the trace of a stop equal those in the loop; damaged traces are refused."""

import h5py
import numpy as np
import pytest
from synthetic import of_scenario
from typer.testing import CliRunner

import railgrip as rg
from railgrip.base.errors import InputError
from railgrip.cli.app import app
from railgrip.estimation.spec import LIBRARY
from railgrip.estimators.design import NOISE_SETS
from railgrip.trace.recorder import read_trace, write_trace

SPECIFICATION = LIBRARY / "stop.toml"


@pytest.fixture(scope="module")
def stop():
    """The first 2.5 s of a stop with adhesion that falls from the end of the first second."""
    return rg.run(
        rg.Scenario.load("trapezoid").changed(
            {"limits.horizon": "2.5 s", "adhesion.first_fall": "1 s", "periods.trace": "1 ms"}
        )
    )


RECORDED = {
    "speed": "speed",
    "wheelset_speed": "wheelset_speed",
    "group_adhesion": "adhesion",
    "pad_friction": "pad_friction",
}


def squares_of(noise):
    """Return a noise set as changes of an estimation, whose file has rounded squares and the loop exact ones."""
    of_process = {f"noise.process.{name}": deviation**2 for name, deviation in noise.process.items()}
    return of_process | {f"noise.readings.{name}": deviation**2 for name, deviation in noise.readings.items()}


def assert_equal_to_the_loop(estimated, trace):
    """Require that estimates of a trace have the bits that the loop recorded in it, while adhesion varies."""
    for state, name in RECORDED.items():
        loop = trace[f"estimate_{name}"].values.reshape(len(trace["time"]), -1)
        names = [each for each in estimated["state"].values if str(each).partition("[")[0] == state]
        np.testing.assert_array_equal(estimated["mean"].sel(state=names).values, loop)
    assert np.ptp(trace["estimate_adhesion"].values) > 0.05


def test_estimates_from_a_trace_equal_those_in_the_loop(stop):
    """The same filter, noises, start and readings give identical bits."""
    estimated = rg.estimate(stop.trace, changes=squares_of(NOISE_SETS["train_ideal"]))
    np.testing.assert_allclose(rg.estimate(stop.trace)["mean"], estimated["mean"], rtol=1e-9, atol=1e-12)
    assert_equal_to_the_loop(estimated, stop.trace)
    np.testing.assert_array_equal(estimated["nis"][1:], stop.trace["estimate_nis"][1:])


def test_a_trace_on_disk_gives_the_same_estimates(stop, tmp_path):
    stop.write(tmp_path / "mine")
    file = tmp_path / "mine" / "trace.nc"
    assert rg.estimate(file).drop_attrs().equals(rg.estimate(stop.trace).drop_attrs())
    result = CliRunner().invoke(
        app, ["estimate", str(SPECIFICATION), "--data", str(file), "--out", str(tmp_path / "out")]
    )
    assert result.exit_code == 0, result.output
    assert "mine: median NIS" in " ".join(result.output.split())
    assert "group_adhesion[4]" in result.output
    assert (tmp_path / "out" / "estimates.nc").exists()


def test_a_thinned_trace_is_used_up_to_its_last_even_sample(stop, tmp_path):
    thin = of_scenario(stop, stop.scenario.changed({"periods.trace": "7 ms"}))
    thin.write(tmp_path)
    trace = read_trace(tmp_path / "trace.nc")
    assert np.ptp(np.diff(trace["time"].values)) > 1e-4
    assert rg.estimate(tmp_path / "trace.nc").sizes["time"] == trace.sizes["time"] - 1


def cut(path):
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])


def rewritten(change):
    """Return a function that changes the trace in a file."""
    return lambda path: write_trace(change(read_trace(path)), path)


def retimed(change):
    """Return a function that changes the instants of the trace in a file."""
    return rewritten(lambda trace: trace.assign_coords(time=("time", change(trace["time"].values), {"units": "s"})))


def edited(change):
    """Return a function that changes the content of an HDF5 file."""

    def damage(path):
        with h5py.File(path, "r+") as file:
            change(file)

    return damage


def replaced(name, change, order=1):
    """Return a function that changes a dataset of a file; `order` -1 reverses its dimensions."""

    def replace(file):
        values, scales = file[name][()], [dimension[0].name for dimension in file[name].dims]
        del file[name]
        after = file.create_dataset(name, data=change(values))
        for axis, scale in zip(after.dims, scales[::order], strict=True):
            axis.attach_scale(file[scale])

    return edited(replace)


def without(name):
    return edited(lambda file: file.pop(name))


def attribute(name, key, value):
    return edited(lambda file: file[name].attrs.update({key: value}))


def at_sample_700(change):
    return retimed(lambda time: np.concatenate([time[:700], change(time[700:])]))


@pytest.mark.parametrize(
    ("damage", "sentence"),
    [
        (cut, "trace.nc: is not a NetCDF file"),
        (without("time"), "trace.nc: is not a NetCDF file"),
        (rewritten(lambda trace: trace.rename(time="t")), "trace.nc: is not a trace, it has no time axis"),
        (rewritten(lambda trace: trace.isel(time=slice(0, 0))), "trace.nc: time must have one dimension"),
        (rewritten(lambda trace: trace.isel(time=slice(0, 1))), "1 samples; an estimate needs at least two"),
        (retimed(lambda time: time[::-1]), "trace.nc: time does not rise"),
        (at_sample_700(lambda time: [np.nan, *time[1:]]), "trace.nc: time does not rise"),
        (at_sample_700(lambda time: time + 0.5), "the grid is uneven"),
        (attribute("time", "units", "ms"), "trace.nc: time is in 'ms', a trace has it in 's'"),
        (attribute("/", "period", "1 ms"), "trace.nc: the attribute period is '1 ms'"),
        (
            replaced("reading_wheelset_speed", np.transpose, -1),
            "'reading_wheelset_speed' has the dimensions group, time; time is the first one",
        ),
        (replaced("reading_speed", lambda v: v[:-5]), "'reading_speed' has"),
        (replaced("reading_speed", lambda v: v.astype("S8")), "variable 'reading_speed' must have numbers; it has |S8"),
        (attribute("reading_speed", "units", "furlong"), "speed is in 'furlong', the prediction needs 'm/s'"),
        (attribute("reading_speed", "units", b"m/s\xff"), "speed is in 'm/s\\udcff', the prediction needs 'm/s'"),
        (without("reading_speed"), "has no signal speed"),
    ],
)
def test_a_damaged_trace_is_refused(stop, tmp_path, damage, sentence):
    """The exit code is 2, without a traceback."""
    stop.write(tmp_path / "mine")
    file = tmp_path / "mine" / "trace.nc"
    damage(file)
    result = CliRunner().invoke(app, ["estimate", str(SPECIFICATION), "--data", str(file), "--out", str(tmp_path)])
    assert isinstance(result.exception, InputError), result.exception
    assert sentence in str(result.exception)
    assert not (tmp_path / "estimates.nc").exists()
