from sdc_common.ros.connection_watchdog import ClockWatch


def test_the_clock_is_told_once_when_it_stands_and_once_when_it_runs_again():
    watch = ClockWatch(5.0, wall_s=100.0)
    told = []
    for step in range(60):
        wall_s = 100.0 + 0.5 * step
        sim_time = 7.0 if step < 20 else 0.05 * step if step < 40 else 99.0
        if watch.look(wall_s, sim_time):
            told.append((wall_s, watch.stands))
    assert told == [(105.0, True), (110.0, False), (125.0, True)]


def test_a_clock_that_runs_is_nothing_to_tell():
    watch = ClockWatch(5.0, wall_s=0.0)
    assert not any(watch.look(0.5 * step, step) for step in range(1000))
