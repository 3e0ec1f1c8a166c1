"""One publisher of commands has control at a time."""

from sdc_sim.simulation.command_mux import CommandArbiter


def test_first_publisher_keeps_control_until_it_has_been_silent_or_control_is_released():
    arbiter = CommandArbiter(timeout_ticks=8)
    for tick in range(100):
        assert arbiter.admits("/first", tick)
        assert not arbiter.admits("/second", tick)
    assert arbiter.active == "/first"
    assert not arbiter.admits("/second", 107)
    assert arbiter.admits("/second", 108)
    assert not arbiter.admits("/first", 109)
    arbiter.release()
    assert arbiter.admits("/first", 110)
