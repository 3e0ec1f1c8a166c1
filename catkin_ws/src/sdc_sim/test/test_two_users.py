"""Two users of one machine, each with a drive, a roscore or a check, never meet."""

import os
import subprocess
import sys

import pytest

USERS = 23456, 23457
IMPORTS = """
import ctypes, os, socket, sys
from sdc_common import processes
from sdc_common.ros import drive_master
from sdc_sim.ros import safe_launch
user = int(sys.argv[1])
os.setgroups([])
os.setgid(user)
os.setuid(user)
ctypes.CDLL(None).prctl(4, 1)  # as after an exec: the process may write its files in /proc
"""
FREE_PORT = "print(drive_master.free_master_port())"
# A drive that has chosen its master; its launch has not started one yet.
DRIVE = """
sys.argv[1:] = ["drive", "sh", "-c", "echo $ROS_MASTER_URI; read line"]
drive_master.main()
"""
# The same, and roslaunch starts after one byte of input.
LAUNCH = """
def launch(*_):
    print(os.environ["ROS_MASTER_URI"], flush=True)
    os.read(0, 1)
    sys.argv[1:] = ["--skip-log-check", "-"]
    safe_launch.main()
os.execvp = launch
sys.argv[1:] = ["drive", "roslaunch"]
drive_master.main()
"""
ROSCORE = """
from rosmaster.master import Master
master = Master(int(sys.argv[2]))
master.start()
master.handler.setParam("/roscore", "/run_id", "the second user")
print("ready", flush=True)
os.read(0, 1)
print(master.handler.getParam("/test", "/")[2])
"""
SERVER = """
if not processes.isolate_network():
    sys.exit("not permitted")
server = socket.create_server(("127.0.0.1", 11500))
print("ready", flush=True)
os.read(0, 1)
socket.create_connection(server.getsockname())
print(os.getuid())
"""

pytestmark = pytest.mark.skipif(os.getuid() != 0, reason="root is needed to be two users")


@pytest.fixture
def start():
    """Return a function that starts a program as a user, until the end of the test."""
    started = []

    def start_as(user, program, *arguments, uri="http://127.0.0.1:11311"):
        environment = {**os.environ, "ROS_MASTER_URI": uri, "ROS_IP": "127.0.0.1"}
        environment.update(HOME="/nonexistent", ROS_LOG_DIR="/nonexistent")
        environment.pop("SDC_MASTER_URI", None)
        command = [sys.executable, "-c", IMPORTS + program, str(user), *map(str, arguments)]
        pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.STDOUT}
        started.append(subprocess.Popen(command, env=environment, text=True, cwd="/", **pipes))
        return started[-1]

    yield start_as
    for process in started:
        process.kill()
        process.communicate()


def first_line(process):
    return process.stdout.readline().strip()


@pytest.mark.slow(2)
def test_port_of_a_drive_is_given_to_nobody_before_its_master_starts(start):
    port = first_line(start(USERS[0], FREE_PORT))
    chosen = first_line(start(USERS[0], DRIVE, uri=f"http://127.0.0.1:{port}"))
    assert chosen.endswith(f":{port}")
    assert first_line(start(USERS[1], FREE_PORT)) != port
    first_line(start(USERS[0], DRIVE))
    second = first_line(start(USERS[0], DRIVE))
    assert "the default ROS master is in use" in second
    other = first_line(start(USERS[1], FREE_PORT))
    assert f"ROS_MASTER_URI=http://127.0.0.1:{other}." not in second


@pytest.mark.slow(2)
def test_drive_does_not_join_a_roscore_that_appears_while_it_starts(start):
    port = first_line(start(USERS[1], FREE_PORT))
    drive = start(USERS[0], LAUNCH, uri=f"http://127.0.0.1:{port}")
    assert first_line(drive).endswith(f":{port}")
    roscore = start(USERS[1], ROSCORE, port)
    assert first_line(roscore) == "ready"
    output = drive.communicate("\n<launch><param name='mine' value='1'/></launch>", 60)[0]
    assert "run_id on parameter server does not match" in output
    assert roscore.communicate("\n", 60)[0] == "{'run_id': 'the second user'}\n"


def test_same_address_is_another_one_in_the_network_of_each_user(start):
    servers = [start(user, SERVER) for user in USERS]
    ready = [first_line(server) for server in servers]
    if ready == ["not permitted"] * 2:
        pytest.skip("users may not make a network namespace here")
    assert ready == ["ready", "ready"]
    assert [int(server.communicate("\n", 60)[0]) for server in servers] == list(USERS)
