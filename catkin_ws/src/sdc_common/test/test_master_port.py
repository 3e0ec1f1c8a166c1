import socket
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

from sdc_common.ros.master_port import MasterPorts, free_master_port

FIRST_OUTGOING = int(Path("/proc/sys/net/ipv4/ip_local_port_range").read_text().split()[0])
# Two blocks that no other program uses: nodes of other tests listen at the ports above them.
CANDIDATES = range(FIRST_OUTGOING - 100, FIRST_OUTGOING)


@pytest.fixture(autouse=True)
def reservations(tmp_path, monkeypatch):
    """Keep the reservations of these tests apart from those of other processes."""
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))


def listener(port):
    taken = socket.socket()
    taken.bind(("127.0.0.1", port))
    taken.listen()
    return taken


def test_port_lies_below_those_of_outgoing_connections():
    assert 1023 < free_master_port() < FIRST_OUTGOING


def test_ports_of_a_process_differ():
    ports = MasterPorts(CANDIDATES)
    assert len({ports.next() for _ in range(50)}) == 50


def test_next_port_replaces_one_that_another_program_has_taken():
    ports = MasterPorts(CANDIDATES)
    taken = ports.next() + 1
    with listener(taken):
        assert ports.next() == taken + 1


def test_next_block_replaces_one_that_is_in_use():
    first, second = MasterPorts(CANDIDATES), MasterPorts(CANDIDATES)
    assert abs(second.next() - first.next()) >= 50
    with pytest.raises(OSError, match="no free block of 50 ports"):
        MasterPorts(CANDIDATES).next()


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
