"""What a change of a scenario keeps of the table it changes."""

from railgrip.scenario.merge import merged

FILTER = {"estimator": {"kind": "fmu", "model": "TrainPrediction", "noise": "ideal"}}


def test_another_way_to_compute_the_same_filter_keeps_its_keys():
    for kind in ("compiled", "python", "fmu"):
        assert merged(FILTER, {"estimator": {"kind": kind}})["estimator"] == FILTER["estimator"] | {"kind": kind}


def test_a_kind_that_was_left_out_is_no_other_kind():
    model = {"model": {"class": "WagonPrediction"}}
    assert merged(model, {"model": {"kind": "compiled"}})["model"] == {"class": "WagonPrediction", "kind": "compiled"}


def test_another_kind_of_part_starts_its_table_anew():
    for kind in ("none", "decentralised", "module:Class"):
        assert merged(FILTER, {"estimator": {"kind": kind}})["estimator"] == {"kind": kind}
    fmu = merged({"controller": {"kind": "slip_two_state", "tuning": "searched"}}, {"controller": {"kind": "fmu"}})
    assert fmu["controller"] == {"kind": "fmu"}
