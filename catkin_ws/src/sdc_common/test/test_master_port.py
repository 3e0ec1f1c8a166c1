import socket
import subprocess
import sys

from sdc_common.ros.master_port import free_master_port


def test_ports_of_a_process_differ():
    assert len({free_master_port() for _ in range(20)}) == 20


def test_next_port_replaces_one_that_another_program_has_taken():
    following = free_master_port() + 1
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", following))
        taken.listen()
        assert free_master_port() != following


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
