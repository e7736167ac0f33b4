from railgrip.bench.rig_filter import rig_filter_cost


def test_the_bench_steps_the_filter_of_the_rig():
    cost = rig_filter_cost(count=50, rounds=1)
    assert cost.states == 4
    assert cost.advance > 0.0
    assert cost.step > 0.0
