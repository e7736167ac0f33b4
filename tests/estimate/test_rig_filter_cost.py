from railgrip.bench.filters import rig_step


def test_the_bench_steps_the_filter_of_the_rig():
    assert rig_step(count=50, rounds=1) > 0.0
