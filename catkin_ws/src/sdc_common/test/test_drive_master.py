"""Which ROS master a drive gets."""

import os
import subprocess
import sys
import threading
from xmlrpc.client import ServerProxy
from xmlrpc.server import SimpleXMLRPCServer

import pytest
from rosmaster.master import Master

from sdc_common.ros import drive_master
from sdc_common.ros.drive_master import MasterInUse, choose_master, free_master_port


@pytest.fixture
def port():
    """Return a port that is the default one in a test."""
    return free_master_port()


@pytest.fixture
def master(port):
    """Start a ROS master on this port; return a function that registers a node that runs."""
    server = Master(port=port)
    server.start()
    nodes = []

    def start_node(name):
        node = SimpleXMLRPCServer(("127.0.0.1", 0), logRequests=False)
        node.register_function(lambda caller: [1, "", 4711], "getPid")
        threading.Thread(target=node.serve_forever, args=(0.01,), daemon=True).start()
        nodes.append(node)
        uri = f"http://127.0.0.1:{node.server_address[1]}"
        ServerProxy(f"http://127.0.0.1:{port}").registerService(
            name, f"{name}/stop", "rosrpc://127.0.0.1:1", uri
        )
        return node

    yield start_node
    for node in nodes:
        node.shutdown()
        node.server_close()
    # A thread whose socket is only closed, as stop() does, computes until the end of all tests.
    server.master_node.is_shutdown = True
    server.master_node.server.shutdown()
    server.stop()


def choose(port, chosen_by_user=False, **options):
    default = 11311 if chosen_by_user else port
    return choose_master(
        {"ROS_MASTER_URI": f"http://127.0.0.1:{port}"}, default_port=default, **options
    )


def port_of(chosen):
    return int(chosen.uri.rsplit(":", 1)[1])


def test_ports_of_processes_that_start_at_once_differ():
    program = "import sdc_common.ros.drive_master as p; print(p.free_master_port(), flush=True)"
    command = [sys.executable, "-c", f"{program}; input()"]
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True}
    started = [subprocess.Popen(command, **pipes) for _ in range(3)]
    ports = [int(process.stdout.readline()) for process in started]
    for process in started:
        process.communicate("\n")
    assert len(set(ports)) == 3


def test_own_roscore_without_a_drive_is_used(port, master):
    assert choose(port).uri == f"http://127.0.0.1:{port}"


def test_second_drive_gets_another_master_before_the_first_one_has_a_roscore(port):
    first, second, third = (choose(port) for _ in range(3))
    assert port_of(first) == port
    assert len({port_of(chosen) for chosen in (first, second, third)}) == 3
    assert second.default_user == "another drive or cockpit"
    first.reservation.close()
    assert port_of(choose(port)) == port, "the first one has ended"


@pytest.mark.parametrize("name", ["/sim", "/cockpit"])
def test_master_of_a_running_node_is_left_alone(port, master, name):
    master(name)
    chosen = choose(port)
    assert port_of(chosen) != port
    assert chosen.default_user == f"{name} (host 127.0.0.1, process 4711)"


def test_node_that_was_killed_does_not_occupy_the_master(port, master):
    node = master("/sim")
    node.shutdown()
    node.server_close()
    assert port_of(choose(port)) == port


def test_master_of_another_user_is_left_alone(port, master, monkeypatch):
    monkeypatch.setattr("os.getuid", lambda: 12345)
    assert "the ROS master of another user" in choose(port).default_user


def test_other_program_at_the_default_port_is_left_alone(port):
    with SimpleXMLRPCServer(("127.0.0.1", port), logRequests=False) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        assert choose(port).default_user == "another program"
        server.shutdown()


def test_master_that_the_user_has_chosen_is_refused_when_a_drive_runs_on_it(port, master):
    assert port_of(choose(port, chosen_by_user=True)) == port
    master("/sim")
    with pytest.raises(MasterInUse, match=r"/sim \(host 127.0.0.1, process 4711\)") as error:
        choose(port, chosen_by_user=True)
    assert f"ROS_MASTER_URI=http://127.0.0.1:{port} is in use" in str(error.value)


def test_second_of_two_drives_under_a_chosen_master_is_refused(port):
    first = choose(port, chosen_by_user=True)
    with pytest.raises(MasterInUse, match="in use by another drive"):
        choose(port, chosen_by_user=True)
    first.reservation.close()


def test_car_joins_the_master_of_its_world_unless_another_car_drives_there(port, master):
    master("/sim")
    first = choose(port, joins_world=True)
    assert port_of(first) == port
    first.reservation.close()
    master("/referee")
    with pytest.raises(MasterInUse, match="/referee"):
        choose(port, joins_world=True)


def test_drive_of_a_cockpit_uses_the_master_of_the_cockpit(port, master):
    cockpit = choose(port)
    master("/cockpit")
    environment = {"ROS_MASTER_URI": cockpit.uri, "SDC_MASTER_URI": cockpit.uri}
    assert choose_master(environment, default_port=port).uri == cockpit.uri


def test_parameters_of_an_earlier_drive_are_deleted(port, master):
    server = ServerProxy(f"http://127.0.0.1:{port}")
    kept = {"rviz": {"rate": 30}, "use_sim_time": True, "roslaunch": {"uris": {"a": "b"}}}
    for name, value in {**kept, "sim": {"friction": 0.6}}.items():
        server.setParam("/test", f"/{name}", value)
    master("/rviz")
    drive_master.clear_parameters(f"http://127.0.0.1:{port}")
    found = server.getParam("/test", "/")[2]
    assert "sim" not in found
    assert {name: found.get(name) for name in kept} == kept


def test_parameters_of_a_joined_world_are_kept(port):
    server = Master(port=port)
    server.start()
    uri = f"http://127.0.0.1:{port}"
    ServerProxy(uri).setParam("/test", "/sim", {"friction": 0.6})
    program = [sys.executable, "-m", "sdc_common.ros.drive_master", "drive", "true", "sim:=false"]
    subprocess.run(program, env={**os.environ, "ROS_MASTER_URI": uri}, check=True)
    assert ServerProxy(uri).getParam("/test", "/sim")[2] == {"friction": 0.6}
    server.stop()
