import numpy as np
import pytest

from railgrip.estimation.judge import judge
from railgrip.estimation.run import estimate, prediction_of, units_of
from railgrip.estimation.spec import LIBRARY, load_specification, settings_for
from railgrip.trace.samples import truth_of
from railgrip.twins.plant import plant
from railgrip.twins.wagon import INPUTS, OUTPUTS, run_wagon, wagon_scenario

PRINTED = {"adhesion_share": 0.5, "resistance_transfer": 1.0, "adhesion_transfer": 0.0}


def run(name="stop", horizon=12.0):
    return run_wagon(wagon_scenario(name).model_copy(update={"horizon": horizon}))


@pytest.fixture(scope="module")
def stop():
    return run()


def believed(recorded, **parameters):
    specification = load_specification(LIBRARY / "wagon.toml")
    prediction = prediction_of("WagonPrediction", parameters)
    return estimate(
        recorded, prediction, settings_for(specification, recorded.attrs["period"]), units=units_of("WagonPrediction")
    )


def test_load_moves_to_the_front_by_inertia():
    """±m|a| h/L, once the suspension has handed it on."""
    held = np.array([1.5e5, 1.5e5, 0.3, 0.3, 0.0])
    with plant("Wagon", inputs=INPUTS, outputs=OUTPUTS, period=0.01, parameters={"speed_start": 20.0}) as wagon:
        wagon.start(held)
        rows = np.array([wagon.step(held) for _ in range(300)])
    load, speed = rows[:, 7:9], rows[:, 2]
    acceleration = (speed[-1] - speed[-11]) / 0.1
    assert load.sum(axis=1) == pytest.approx(40e3 * 9.81, rel=1e-12)
    # Friction still creeps up, so loads lag by T_pitch times their rate, and the difference quotient by 50 ms.
    assert load[-1, 0] - load[-1, 1] == pytest.approx(-2 * 1.5 / 9 * 40e3 * acceleration, rel=0.01)


def test_the_corrected_factor_finds_the_adhesion_and_the_printed_one_twice_as_much(stop):
    pressed = (stop["time"].values > 6.0) & (stop["time"].values < 9.5)
    truth = truth_of(stop, "alpha")[pressed].mean()
    corrected, printed = (believed(stop, **p)["mean"].sel(state="alpha").values[pressed].mean() for p in ({}, PRINTED))
    assert corrected == pytest.approx(truth, rel=0.01)
    assert printed == pytest.approx(2 * truth, rel=0.01)


def test_the_printed_factor_puts_the_rest_on_the_pads(stop):
    pressed = (stop["time"].values > 6.0) & (stop["time"].values < 9.5)
    for pads in ("mu_b[1]", "mu_b[2]"):
        # Better than what it started from; pads that hardly move within the window are no test of more.
        unmoved = np.sqrt(np.mean((truth_of(stop, f"{pads}")[pressed] - 0.35) ** 2))
        assert judge(stop, believed(stop), pads, pressed).rmse < 0.8 * unmoved
    assert judge(stop, believed(stop, **PRINTED), "mu_b[1]", pressed).bias > 0.3


def test_one_adhesion_for_wheelsets_that_brake_unequally_is_a_bias_of_their_pads():
    """A limit of the six-state model itself: rolling wheelsets use as much adhesion as their brakes ask for."""
    unequal = run("unequal")
    pressed = (unequal["time"].values > 6.0) & (unequal["time"].values < 9.5)
    told = believed(unequal)
    assert abs(judge(unequal, told, "alpha", pressed).bias) < 0.002
    assert judge(unequal, told, "mu_b[1]", pressed).bias < -0.03
    assert judge(unequal, told, "mu_b[2]", pressed).bias > 0.03
