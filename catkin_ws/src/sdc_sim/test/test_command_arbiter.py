from sdc_sim.simulation.command_arbiter import CommandArbiter


def test_the_first_keeps_the_seat_while_it_drives():
    seat = CommandArbiter(patience_ticks=8)
    for tick in range(100):
        assert seat.admits("/first", tick)
        assert not seat.admits("/second", tick)
    assert seat.driver == "/first"


def test_silence_gives_it_to_the_next():
    seat = CommandArbiter(patience_ticks=8)
    seat.admits("/first", 10)
    assert not seat.admits("/second", 18)
    assert seat.admits("/second", 19)
    assert not seat.admits("/first", 20)


def test_a_driver_that_did_not_answer_leaves_at_once():
    seat = CommandArbiter(patience_ticks=8)
    seat.admits("/first", 10)
    seat.leave()
    assert seat.admits("/second", 10)
