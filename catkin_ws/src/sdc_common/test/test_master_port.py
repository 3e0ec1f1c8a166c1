import contextlib
import socket
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

from sdc_common.ros.master_port import MasterPorts, candidate_ports, free_master_port

FIRST_OUTGOING = int(Path("/proc/sys/net/ipv4/ip_local_port_range").read_text().split()[0])
# Two blocks that no other program uses: nodes of other tests listen at the ports above them.
CANDIDATES = range(FIRST_OUTGOING - 100, FIRST_OUTGOING)


@pytest.fixture
def ports(tmp_path, monkeypatch):
    """Return a function that makes MasterPorts, whose reservations no other process sees."""
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    return lambda allowed=CANDIDATES: MasterPorts(allowed)


def listener(port):
    taken = socket.socket()
    taken.bind(("127.0.0.1", port))
    taken.listen()
    return taken


def test_port_lies_below_those_of_outgoing_connections():
    assert 1023 < free_master_port() < FIRST_OUTGOING


@pytest.mark.parametrize(
    ("outgoing", "allowed"),
    [
        ("32768\t60999\n", range(11500, 32768)),
        ("11550\t60999\n", range(11500, 11550)),
        ("11549\t60999\n", range(11500, 65535)),
        ("1024\t65535\n", range(11500, 65535)),
        (None, range(11500, 65535)),
    ],
)
def test_candidates_are_all_ports_where_too_few_are_below_the_outgoing_ones(
    tmp_path, outgoing, allowed
):
    file = tmp_path / "ip_local_port_range"
    if outgoing is not None:
        file.write_text(outgoing)
    assert candidate_ports(file) == allowed


def test_ports_of_a_process_differ(ports):
    own = ports()
    assert len({own.next() for _ in range(50)}) == 50


def test_next_port_replaces_one_that_another_program_has_taken(ports):
    own = ports()
    taken = own.next() + 1
    with listener(taken):
        assert own.next() == taken + 1


def test_next_block_replaces_one_whose_ports_are_all_taken(ports):
    own = ports()
    with contextlib.ExitStack() as taken:
        for port in CANDIDATES[:50]:
            taken.enter_context(listener(port))
        assert own.next() == CANDIDATES[50]
        for port in CANDIDATES[50:]:
            taken.enter_context(listener(port))
        with pytest.raises(OSError, match="no free block of 50 ports"):
            own.next()


def test_ports_at_the_end_that_make_no_whole_block_are_not_given(ports):
    first, second = ports(CANDIDATES[:99]), ports(CANDIDATES[:99])
    assert first.next() == CANDIDATES[0]
    with pytest.raises(OSError, match="no free block of 50 ports"):
        second.next()


def test_next_block_replaces_one_that_is_in_use(ports):
    first, second = ports(), ports()
    assert abs(second.next() - first.next()) >= 50
    with pytest.raises(OSError, match="no free block of 50 ports"):
        ports().next()


def test_each_process_has_a_block_of_its_own():
    module = "sdc_common.ros.master_port"
    program = f"import {module} as ports; print(ports.free_master_port(), flush=True); input()"
    command = [sys.executable, "-c", program]
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True}
    started = [subprocess.Popen(command, **pipes) for _ in range(3)]
    ports = [int(process.stdout.readline()) for process in started]
    for process in started:
        process.communicate("\n")
    assert len({(port - 11500) // 50 for port in ports}) == 3
