"""Every language feature gives the trajectory of rumoca's own simulator, which shares only the front end."""

import fmpy
import numpy as np
import pytest
from fmpy.validation import validate_fmu
from small_fmus import FEATURES, INTERFACES, compare, reference_run

CLASSES = sorted(f.stem for f in FEATURES.glob("*.mo") if f.stem != "package")
# rumoca's simulate requires values for inputs; Driven has separate tests.
CLOSED = [name for name in CLASSES if name != "Driven"]
STOP, STEP = 2.0, 0.01


@pytest.fixture(scope="module")
def references() -> dict[str, tuple[np.ndarray, dict[str, np.ndarray]]]:
    return {name: reference_run(FEATURES, f"Features.{name}", STOP, STEP) for name in CLOSED}


@pytest.mark.parametrize("name", CLASSES)
def test_the_fmu_is_valid(feature, name):
    assert validate_fmu(str(feature(name).path)) == []


@pytest.mark.parametrize("interface", INTERFACES)
@pytest.mark.parametrize("name", CLOSED)
def test_the_trajectory_is_that_of_rumoca(feature, references, name, interface):
    """Within 1e-5 of the largest value; the solvers have a tolerance of 1e-8 and events are located to 1e-10 s."""
    fmu = feature(name)
    time, reference = references[name]
    shared = [n for n in reference if any(v.name == n for v in fmu.description.modelVariables)]
    assert shared
    settings = {"relative_tolerance": 1e-9} if interface == "ModelExchange" else {"start_values": {"_tolerance": 1e-8}}
    found = fmpy.simulate_fmu(
        str(fmu.folder), stop_time=STOP, output=shared, output_interval=STEP, fmi_type=interface, **settings
    )
    compare(shared, found, time, reference)
