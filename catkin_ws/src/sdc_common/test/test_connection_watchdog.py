"""A clock that stops. Its messages, and those about a master that is gone: test_outages.py."""

from sdc_common.ros.connection_watchdog import ClockMonitor


def test_stop_and_continuation_of_the_clock_are_reported_once_each():
    clock = ClockMonitor(5.0)
    changes = []
    for step in range(60):
        wall_s = 100.0 + 0.5 * step
        sim_time = 7.0 if step < 20 else 0.05 * step if step < 40 else 99.0
        if clock.update(wall_s, sim_time):
            changes.append((wall_s, clock.stopped))
    assert changes == [(105.0, True), (110.0, False), (125.0, True)]


def test_running_clock_reports_no_change():
    clock = ClockMonitor(5.0)
    assert not any(clock.update(0.5 * step, step) for step in range(1000))
