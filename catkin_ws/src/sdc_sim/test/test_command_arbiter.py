"""One publisher of commands has control at a time."""

from sdc_sim.simulation.command_arbiter import CommandArbiter


def test_first_publisher_keeps_control_while_it_sends_commands():
    arbiter = CommandArbiter(timeout_ticks=8)
    for tick in range(100):
        assert arbiter.admits("/first", tick)
        assert not arbiter.admits("/second", tick)
    assert arbiter.active == "/first"


def test_next_publisher_gets_control_after_the_timeout():
    arbiter = CommandArbiter(timeout_ticks=8)
    arbiter.admits("/first", 10)
    assert not arbiter.admits("/second", 18)
    assert arbiter.admits("/second", 19)
    assert not arbiter.admits("/first", 20)


def test_released_control_goes_to_the_next_publisher_at_once():
    arbiter = CommandArbiter(timeout_ticks=8)
    arbiter.admits("/first", 10)
    arbiter.release()
    assert arbiter.admits("/second", 10)
